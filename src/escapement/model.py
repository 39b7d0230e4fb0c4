"""The problem as plain values: a mechanism, two inertias, losses and a drive."""

import math
from dataclasses import dataclass
from functools import cached_property
from inspect import getattr_static
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from escapement import validate
from escapement.scene import Path, Scene, smooth_intervals, writeable

FloatArray = NDArray[np.float64]

MOST_UNEQUAL = 1e100
"""Beyond this ratio of two numbers of a model a double has no room to spare."""


def ratio_in_range(ratio: ArrayLike) -> NDArray[np.bool_]:
    """Whether ratios of numbers of a model can be computed with."""
    values = np.asarray(ratio)
    return (values > 1.0 / MOST_UNEQUAL) & (values < MOST_UNEQUAL)


@runtime_checkable
class Mechanism(Protocol):
    """What an escapement needs to know of a mechanism.

    A *cell* is the driver angle between one pin's entry and the next one's,
    dwell included. Driver angles are local to the cell and measured from dead
    centre; the follower angle is oriented so that it grows.
    """

    @property
    def cell_angle(self) -> float:
        """Driver angle of one cell [rad]."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Entry, every kink of the sliding speed, exit [rad], ascending.

        Between neighbours the transmission is analytic. From the exit to the
        end of the cell the follower is locked.
        """

    @property
    def follower_step(self) -> float:
        """Follower angle per cell [rad]."""

    @property
    def path(self) -> Path:
        """What kernels evaluate the transmission from: a pin path or a table."""

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle [rad], zero at dead centre."""


def is_mechanism(thing: object) -> bool:
    """Whether a thing has all that a mechanism has; none of it is evaluated.

    `isinstance` would ask for the path, which a mechanism that has a geometry and no
    dynamics refuses.
    """
    names = ("cell_angle", "breaks", "follower_step", "path", "follower_angle")
    # a class has the attributes that its instances have
    return not isinstance(thing, type) and all(
        getattr_static(thing, name, None) is not None for name in names
    )


def dwell_angle(mechanism: Mechanism) -> float:
    """Driver angle of a cell in which the follower is locked [rad]."""
    dwell = mechanism.cell_angle - (mechanism.breaks[-1] - mechanism.breaks[0])
    # one rounding error is none
    return float(dwell) if dwell > 1e-12 else 0.0


@dataclass(frozen=True)
class Inertia:
    """Moments of inertia about the two axes, their ratio between 1e-100 and 1e100.

    Parameters
    ----------
    driver : float
        Driver and everything that turns with it [kg m^2], > 0.
    follower : float
        Follower and everything that turns with it [kg m^2], > 0.
    """

    driver: float
    follower: float

    def __post_init__(self) -> None:
        remedy = "give the moment of inertia in kg m^2 (or in-lbf-s^2 with those units)"
        for name in ("driver", "follower"):
            value = validate.positive(f"{name}_inertia", getattr(self, name), remedy)
            object.__setattr__(self, name, value)
        _check_ratio("driver_inertia / follower_inertia", self.driver / self.follower)


def _check_ratio(name: str, value: float) -> None:
    """Refuse a ratio that a double cannot hold with room to spare."""
    if not ratio_in_range(value):
        rule = "between 1e-100 and 1e100"
        raise validate.fail(name, rule, value, "choose numbers of similar size")


@dataclass(frozen=True)
class Escapement:
    """A mechanism with inertia and losses under a constant driving torque.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry, for example `Geneva(slots=4)`.
    inertia : Inertia
        Moments of inertia [kg m^2].
    torque : float
        Constant torque on the driver [N m], > 0. Meyer's "spring rate" K.
    friction : float
        Coefficient of friction between pin and slot [-], >= 0.
    load_torque : float
        Constant torque opposing the follower while it moves [N m], >= 0.
    efficiency : float
        Share of the power that a mesh passes on, either way [-], in [0.001, 1]. It stands
        for friction in a mechanism without a slot; a slotted one has 1.

    Source: Meyer (1973), chapter I; the load torque is an extension.
    """

    mechanism: Mechanism
    inertia: Inertia
    torque: float
    friction: float = 0.0
    load_torque: float = 0.0
    efficiency: float = 1.0

    def __post_init__(self) -> None:
        if not is_mechanism(self.mechanism):
            raise validate.fail(
                "mechanism", "a mechanism", self.mechanism, "give for example Geneva(slots=4)"
            )
        if not isinstance(self.inertia, Inertia):
            raise validate.fail(
                "inertia", "an Inertia", self.inertia, "give Inertia(driver=..., follower=...)"
            )
        checked = {
            "torque": validate.positive(
                "torque", self.torque, "give the constant driving torque in N m"
            ),
            "friction": validate.non_negative(
                "friction", self.friction, "give a coefficient of friction, 0 for none"
            ),
            "load_torque": validate.non_negative(
                "load_torque", self.load_torque, "give the opposing torque in N m, 0 for none"
            ),
            "efficiency": validate.positive(
                "efficiency", self.efficiency, "give a share of 1, 1 for no loss"
            ),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        self._check_path()
        self._check_losses()
        self._check_ratios()

    def _check_path(self) -> None:
        """Refuse what kernels could not read."""
        path: Any = self.mechanism.path
        if not isinstance(path, Path):
            rule, remedy = "a Path", "make it with mechanisms.slotted or mechanisms.table"
            raise validate.fail("mechanism.path", rule, path, remedy)

    def _check_losses(self) -> None:
        """A slot loses by friction, a mesh by its efficiency."""
        if not 1e-3 <= self.efficiency <= 1.0:
            raise validate.fail(
                "efficiency", "in [0.001, 1]", self.efficiency, "give a share of 1, 1 for no loss"
            )
        if self._meshed and self.friction > 0.0:
            raise validate.fail(
                "friction", "0 for a mechanism without a slot", self.friction, "give its efficiency"
            )
        if not self._meshed and self.efficiency < 1.0:
            raise validate.fail(
                "efficiency", "1 for a slotted mechanism", self.efficiency, "give its friction"
            )

    @property
    def _meshed(self) -> bool:
        return self.mechanism.path.table

    def _check_ratios(self) -> None:
        """Refuse numbers whose ratios a double cannot hold with room to spare."""
        _check_ratio("follower_inertia / torque", self.inertia.follower / self.torque)
        if not self.load_ratio < MOST_UNEQUAL:
            raise validate.fail(
                "load_torque / torque", "below 1e100", self.load_ratio, "give a smaller load"
            )

    @cached_property
    def scene(self) -> Scene:
        """The escapement as an engine sees it."""
        path = self.mechanism.path
        return Scene(
            writeable(path),
            smooth_intervals(path, self.mechanism.breaks),
            dwell_angle(self.mechanism),
            self.inertia_ratio,
            *self.loss,
            self.load_ratio,
        )

    @cached_property
    def kept(self) -> dict[str, Any]:
        """What engines derive from the scene and keep for their next call."""
        return {}

    def __getstate__(self) -> dict[str, Any]:
        """Another process derives the scene and what hangs on it anew."""
        return {key: value for key, value in vars(self).items() if key not in ("scene", "kept")}

    @property
    def loss(self) -> tuple[float, float]:
        """Losses where the follower is driven, and where it drives [-].

        A pin's friction on both sides; of a mesh 1/efficiency - 1 and 1 - efficiency.
        """
        if self._meshed:
            return 1.0 / self.efficiency - 1.0, 1.0 - self.efficiency
        return self.friction, self.friction

    @property
    def inertia_ratio(self) -> float:
        """Driver over follower inertia [-]."""
        return self.inertia.driver / self.inertia.follower

    @property
    def load_ratio(self) -> float:
        """Load torque over driving torque [-]."""
        return self.load_torque / self.torque

    @cached_property
    def time_unit(self) -> float:
        """Natural unit of time, sqrt(I_f / torque) [s].

        In it the motion depends on the mechanism, the inertia ratio, the load
        ratio and friction alone: torque is a pure change of clock.
        """
        return math.sqrt(self.inertia.follower / self.torque)
