"""The runaway escapement: an escape wheel that pushes a verge without a spring to and fro."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from escapement.base import validate
from escapement.base.lazy import Lazy
from escapement.base.quantity import Choice, quantity, setting
from escapement.base.spoken import as_spoken
from escapement.mechanisms.escape_wheel import EscapeWheel, length
from escapement.mechanisms.kind import np
from escapement.mechanisms.two_bodies import angle

if TYPE_CHECKING:
    from escapement.mechanisms import chains
else:
    chains = Lazy("escapement.mechanisms.chains")

PALLETS = ("pins", "flat")
_POSES = 101


@dataclass(frozen=True, repr=False)
class Runaway(EscapeWheel):
    """Runaway escapement: escape wheel and verge, whose period depends on their inertia.

    Parameters
    ----------
    teeth : int
        Teeth of the wheel.
    wheel_radius, tooth_depth, tip_radius : float
        Radius of the tips, depth of the teeth, and radius of the tips' rounding [m].
    lead, back : float
        Angles of the leading and the trailing face to the radius [rad]: > 0 where the root is
        ahead of the tip, and behind it.
    pallets : str
        "pins" (the default) or "flat".
    span : float
        Teeth between the pallets, a whole number and a half.
    pallet_radius : float
        Distance from the wheel's axis of the centres of the pins, or of the inner corners of
        the flat pallets, when the verge stands at 0 [m].
    pin_radius : float
        Radius of the pins [m].
    pallet_angle : float
        Angle of the face of a flat pallet to the radius, against the wheel's sense [rad].
    pallet_length, pallet_thickness, corner_radius : float
        Length of the face, thickness of a flat pallet, and rounding of its corners [m].
    centre_distance : float, optional
        Distance of the axes [m]. By default the pallets move radially when the verge is at 0.
    driver_start, follower_start : float, optional
        Angles from which a motion starts [rad].

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """

    kind: ClassVar[str] = "runaway"
    summary: ClassVar[str] = "escape wheel and verge with two pins or flat pallets, no spring"

    pallets: str = field(default=PALLETS[0], kw_only=True, metadata=setting(Choice(
        long_name=f"pallets: {' or '.join(PALLETS)}", allowed=PALLETS, metavar="NAME",
        typical=PALLETS[0], default=PALLETS[0],
    )))  # fmt: skip
    span: float = field(metadata=quantity(
        "teeth that the verge spans", metavar="S", exclusive=True, half=True,
        remedy="give a whole number and a half, such as 2.5"
    ))  # fmt: skip
    pallet_radius: float = field(metadata=length(
        "distance of pins or inner corners of pallets from the wheel's axis", exclusive=True
    ))  # fmt: skip
    pin_radius: float = field(default=0.0, metadata=length("radius of the pins"))
    pallet_angle: float = field(default=0.0, metadata=angle(
        "angle of a flat pallet's face to the radius", minimum=-math.inf
    ))  # fmt: skip
    pallet_length: float = field(default=0.0, metadata=length("length of a flat pallet's face"))
    pallet_thickness: float = field(default=0.0, metadata=length("thickness of a flat pallet"))
    corner_radius: float = field(
        default=0.0, metadata=length("rounding of a flat pallet's corners")
    )
    centre_distance: float | None = field(default=None, metadata=length(
        "distance of the axes", exclusive=True, note=" (default: the pallets move radially at 0)"
    ))  # fmt: skip

    def __post_init__(self) -> None:
        self.check_fields()
        self.check_teeth()
        self.check_span(self.span)
        self._check_pallets()
        _ = self.alternation

    def _check_pallets(self) -> None:
        """Refuse numbers of the other pallets, and rounded corners that meet."""
        pins = self.pallets == PALLETS[0]
        flat = {"pallet_angle", "pallet_length", "pallet_thickness", "corner_radius"}
        needed = ["pin_radius"] if pins else ["pallet_length", "pallet_thickness"]
        for name in sorted(flat if pins else {"pin_radius"}):
            if value := getattr(self, name):
                other = PALLETS[1] if pins else PALLETS[0]
                raise validate.fail(
                    name, f"0 with {self.pallets} pallets", value, f"choose {other}"
                )
        for name in needed:
            if not (value := getattr(self, name)) > 0.0:
                raise validate.fail(name, f"given with {self.pallets} pallets", value, "give it")
        most = 0.5 * min(self.pallet_length, self.pallet_thickness)
        if not pins and not self.corner_radius < most:
            rule = (
                f"less than half of the pallet's thickness and length, {as_spoken(most, 'length')}"
            )
            raise validate.fail(
                "corner_radius", rule, as_spoken(self.corner_radius, "length"), "give less"
            )

    @property
    def half_span(self) -> float:
        """Half of the angle between the pallets, seen from the wheel [rad]."""
        return 0.5 * self.span * self.pitch

    @property
    def axes_distance(self) -> float:
        """Distance of the axes over the wheel's radius."""
        given = self.centre_distance
        apart = self.pallet_radius / math.cos(self.half_span) if given is None else given
        return apart / self.wheel_radius

    @cached_property
    def wedge_friction(self) -> float:
        """Coefficient of friction with which the force of a tooth no longer moves the verge [-]:
        it then passes the verge's axis on the other side.
        """
        ends, found = self.alternation, []
        swing = np.linspace(*ends[1::-1], _POSES + 2)[1:-1]
        for pallet in (0, 1):
            place, normal = self.pushed(pallet, swing)
            arm = (place - self.axes_distance) * normal.conj()
            found.append(np.abs(arm.imag / arm.real).min())
        return float(min(found))

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI; angles in degrees."""
        return super().report() | {"wedge_friction": self.wedge_friction}

    @cached_property
    def follower_chains(self) -> list[chains.Chain]:
        """The entry pallet and the exit pallet."""
        size, found = self.wheel_radius, []
        for side in (-1.0, 1.0):
            radial = cmath.exp(1j * side * self.half_span)
            inner = self.pallet_radius * radial / size - self.axes_distance
            if self.pallets == PALLETS[0]:
                found.append(chains.circle(inner, self.pin_radius / size))
                continue
            face = radial * cmath.exp(-1j * self.pallet_angle)
            along, across = (
                self.pallet_length / size * face,
                1j * self.pallet_thickness / size * face,
            )
            corners = [inner, inner + along, inner + along + across, inner + across]
            found.append(chains.polygon(corners, self.corner_radius / size))
        return found
