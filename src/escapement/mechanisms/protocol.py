"""What is asked of a mechanism, by an escapement and by everything that computes with it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from escapement.base import validate
from escapement.base.lazy import ArrayLike, Lazy
from escapement.base.lazy import FloatArray as FloatArray
from escapement.base.units import degrees
from escapement.mechanisms.path import Pair, smooth_intervals, writeable
from escapement.mechanisms.wheel_checks import LENGTHS

if TYPE_CHECKING:
    from escapement.mechanisms import slotted
else:
    slotted = Lazy("escapement.mechanisms.slotted")

CELL = ("motion_ratio", "cell_angle_deg", "follower_step_deg")
"""Keys that every mechanism reports about the angles of driver and follower in a cell."""


class Mechanism:
    """Base of all mechanisms: the first five attributes must be given, all others have defaults.

    The defaults are those of a mechanism with thin pins, without a size, and with perfect parts.
    A subclass replaces an attribute by a field, a property or a method.

    A *cell* is the driver angle between one pin's entry and the next one's, dwell included. Driver
    angles are local to the cell and measured from dead centre; the follower angle is oriented so
    that it grows.
    """

    cell_angle: Any
    """Driver angle of one cell [rad]."""
    breaks: Any
    """Entry, every kink of the sliding speed of a thin pin, exit [rad], ascending: a tuple.

    Between neighbours the transmission is analytic. From the exit to the end of the cell the
    follower is locked."""
    follower_step: Any
    """Follower angle per cell [rad]."""
    path: Any
    """The `Path` from which kernels evaluate the transmission: a pin path or a table."""

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle at driver angles [rad], zero at dead centre."""
        raise NotImplementedError

    @property
    def kind(self) -> str:
        """Its name in messages, files and on the command line."""
        return type(self).__name__

    # what it loses
    @property
    def meshed(self) -> bool:
        """Whether it has no slots: its losses are given by an efficiency, not by friction."""
        return bool(self.path.meshed)

    plain_crank: ClassVar[bool] = True
    """Whether the driver's bearing carries only the contact force, and so may have friction."""

    without_parts: ClassVar[bool] = False
    """Whether only its transmission is known, and there are no bodies to draw."""

    # its size
    crank_radius: Any = None
    """Unit of length of its path [m]; None where it has no size."""
    pin_radius: Any = 0.0
    """Radius of the pins [m]."""
    roller_radius: Any = 0.0
    """Outer radius of rollers on the pins [m], 0 for none."""
    clearance: Any = 0.0
    """Slot width minus pin diameter [m]."""
    takes_clearance: ClassVar[bool] = False
    """Whether the engines with clearance and with walls that yield can compute it."""
    contact_radius: Any = 0.0
    """Radius of the pin or roller that touches the slot, in crank radii [-]."""
    widest_pin: Any = math.inf
    """Radius of a pin or roller at which no wall is left between two slots [-]."""

    @property
    def lengths(self) -> dict[str, float]:
        """Its lengths by the names in `checks.LENGTHS` [m], 0 where it has none."""
        found = self.crank_radius, self.pin_radius, self.roller_radius, self.clearance
        return dict(zip(LENGTHS, (length or 0.0 for length in found), strict=True))

    # its pins and slots, and the errors of its parts
    slots: Any = 0
    """Slots of the follower; 0 where there are none."""
    pins: Any = 1
    """Pins of the driver."""
    perfect: Any = True
    """Whether its parts have no errors."""
    misfit: Any = ""
    """Why a pin cannot drive a slot, because of the errors of its parts; "" if all can."""

    @property
    def error_counts(self) -> dict[str, int]:
        """How many errors of each kind its parts may have, by the name of the list."""
        return {}

    @classmethod
    def counts(cls, given: Mapping[str, Any]) -> dict[str, int]:
        """The `error_counts` of the mechanism with these numbers; empty where there is none."""
        return {}

    @property
    def errors(self) -> dict[str, float]:
        """The errors of its parts by the names that studies use [SI]; empty if it is perfect."""
        return {}

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """The engagements after which it repeats itself: one if its parts are perfect."""
        path, dwell = writeable(self.path), dwell_angle(self)
        edges = smooth_intervals(path, self.breaks)
        kind = "pick-up" if dwell > 0.0 else "overlap"
        return (
            Pair(
                path=path, edges=edges, dwell=dwell, delay=0.0, follower_angle=self.follower_angle,
                kind=kind, jump=0.0, radius=math.nan,
            ),
        )  # fmt: skip

    # its transmission
    def transmission(self, theta: ArrayLike) -> slotted.Transmission:
        """Transmission at driver angles from dead centre within an engagement."""
        return slotted.transmission(self.path, theta)

    jerk: Any = None
    """Method that gives g'' at driver angles in closed form [-]; None where there is none."""
    noise: Any = 0.0
    """Standard deviation of measured follower angles [rad]; 0 for exact ones."""

    def deviation(self, theta: ArrayLike) -> slotted.Transmission:
        """Standard deviations of the transmission at driver angles where there is `noise`."""
        raise NotImplementedError

    # the outlines of two bodies that touch anywhere, instead of a transmission
    driver_features: Any = None
    """The `Features` of the driver, in units of `crank_radius`; None for other mechanisms."""
    follower_features: Any = None
    """Those of the follower."""
    axes_distance: Any = None
    """Distance of the axes in crank radii [-]."""
    pitch: Any = None
    """Driver angle after which the driver looks the same [rad]."""
    start: Any = None
    """Angles of driver and follower from which a motion starts [rad], counterclockwise; the
    follower's axis lies on the driver's x axis."""
    wedge_friction: Any = math.inf
    """Coefficient of friction from which on the bodies wedge each other [-]."""

    # what is reported, and what a study may vary
    reported: ClassVar[tuple[str, ...]] = CELL
    """Keys of the report: names of attributes, with "_deg" at the end for angles in degrees."""
    report_units: ClassVar[Mapping[str, str]] = {}
    """Kind of unit of reported numbers, if it differs from that of their name."""

    @property
    def motion_ratio(self) -> float:
        """Share of the cell during which the follower moves: 1 without a dwell [-]."""
        return 1.0 - dwell_angle(self) / float(self.cell_angle)

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI; angles in degrees where the key says so."""
        return {key: self._figure(key) for key in self.reported}

    def _figure(self, key: str) -> Any:
        name = key.removesuffix("_deg")
        return getattr(self, key) if name == key else degrees(getattr(self, name))

    @property
    def settings(self) -> dict[str, Any]:
        """Its declared settings by name; a class without declarations has none."""
        return {}


def checked(mechanism: Any, perfect: bool = True) -> Any:
    """`mechanism`, or an error if it is not one; errors of parts must not be ignored silently."""
    if not isinstance(mechanism, Mechanism):
        remedy = "give for example Geneva(4); a class of your own is derived from Mechanism"
        raise validate.fail("mechanism", "a mechanism", mechanism, remedy)
    if perfect and not mechanism.perfect:
        remedy = "leave out its errors, which simulate and terminal take into account"
        raise validate.fail("mechanism", "without errors of its parts here", mechanism, remedy)
    return mechanism


def dwell_angle(mechanism: Mechanism) -> float:
    """Driver angle of a cell in which the follower is locked [rad]."""
    dwell = mechanism.cell_angle - (mechanism.breaks[-1] - mechanism.breaks[0])
    # angles in radians are rounded, so a dwell of 0 may come out as one or two units of rounding
    return float(dwell) if dwell > 1e-12 else 0.0
