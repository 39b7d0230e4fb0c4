"""Kinds of mechanism in a study file: who builds each, from what.

A new kind of mechanism is one more entry.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from escapement import units, validate
from escapement.curves import CURVES, MOST_LOBES
from escapement.study.parameters import MODEL, Parameter


@dataclass(frozen=True)
class Option:
    """A setting of a mechanism that cannot be an axis.

    check : the value that a user gave, or InvalidValue.
    quantity : key in `escapement.units`, None for what is no number.
    required : whether the mechanism has no default of its own.
    """

    check: Callable[[str, Any], Any]
    quantity: str | None = None
    required: bool = False

    def to_si(self, value: Any, system: str) -> Any:
        """A value in units of `system` in SI."""
        return value if self.quantity is None else value * units.factor(self.quantity, system)


@dataclass(frozen=True)
class Kind:
    """A kind of mechanism: who builds it, from what.

    factory : "module:class", imported when the first mechanism is built.
    parameters : numbers that may be axes. options : everything else.
    meshed : whether it loses by an efficiency rather than by friction in a slot.
    """

    factory: str
    parameters: Mapping[str, Parameter]
    options: Mapping[str, Option] = field(default_factory=dict)
    meshed: bool = False

    @property
    def all_parameters(self) -> dict[str, Parameter]:
        """Every number of an escapement with such a mechanism, by name."""
        model = {name: entry for name, entry in MODEL.items() if name != self.other_loss}
        return {**self.parameters, **model}

    @property
    def loss(self) -> str:
        """Name of the loss that such a mechanism has."""
        return "efficiency" if self.meshed else "friction"

    @property
    def other_loss(self) -> str:
        """Name of the loss that it does not have."""
        return "friction" if self.meshed else "efficiency"


def _length(label: str, value: Any) -> float:
    return validate.positive(label, value, "give a length")


def _curve(label: str, value: Any) -> str:
    return validate.choice(label, value, CURVES)


def _angles(label: str, value: Any) -> tuple[float, ...]:
    remedy = "give a list of angles in rad"
    if isinstance(value, str | Mapping) or not hasattr(value, "__iter__"):
        raise validate.fail(label, "a list of numbers", value, remedy)
    return tuple(validate.number(f"{label}[{i}]", x, remedy) for i, x in enumerate(value))


def _angle(label: str, value: Any) -> float:
    return validate.positive(label, value, "give an angle in rad")


def _number(key: str, long_name: str, remedy: str, **rule: Any) -> dict[str, Parameter]:
    """A parameter whose fixed value stands in [mechanism], by its name."""
    rule.setdefault("quantity", "ratio")
    return {key: Parameter(long_name, remedy=remedy, key=key, section="mechanism", **rule)}


KINDS = {
    "geneva": Kind(
        factory="escapement.mechanisms.geneva:Geneva",
        parameters=_number(
            "slots",
            "slots of the follower",
            "a Geneva wheel needs 3 slots or more",
            minimum=3,
            maximum=1_000_000,  # Geneva's own rule
            whole=True,
            required=True,
        )
        | _number(
            "pins", "pins of the driver", "give the number of crank pins", minimum=1, whole=True
        ),
        options={"internal": Option(validate.truth), "crank_radius": Option(_length, "length")},
    ),
    "gear-driven": Kind(
        factory="escapement.mechanisms.gear_driven:GearDriven",
        parameters=_number(
            "stations",
            "stations of the follower",
            "the wheel needs 3 stations or more",
            minimum=3,
            whole=True,
            required=True,
        )
        | _number(
            "lobes",
            "unreal lobes between two lobes of the pin's path",
            "give a whole number or a fraction such as '1/2'",
            maximum=MOST_LOBES,
            fraction=True,
            required=True,
        )
        | _number(
            "pins",
            "pins on the planet",
            "give the number of pins",
            minimum=1,
            whole=True,
            default=1,
        )
        | _number(
            "unused_lobes",
            "lobes without a slot between two that have one",
            "give 0 to use every lobe",
            maximum=MOST_LOBES,
            whole=True,
            default=0,
        )
        | _number(
            "solution",
            "place of the mechanism in order of alpha",
            "they count from 1",
            minimum=1,
            whole=True,
            default=1,
        ),
        options={"curve": Option(_curve, required=True), "fixed_radius": Option(_length, "length")},
    ),
    "elliptical-planetary": Kind(
        factory="escapement.mechanisms.elliptical_planetary:EllipticalPlanetary",
        parameters=_number(
            "sun_radius",
            "pitch radius of the fixed sun gear",
            "give the radius R1",
            quantity="length",
            exclusive=True,
            required=True,
        )
        | _number(
            "planet_radius",
            "pitch radius of the spur planet",
            "give the radius R2, less than the sun's",
            quantity="length",
            exclusive=True,
            required=True,
        ),
        meshed=True,
    ),
    "tabulated": Kind(
        factory="escapement.mechanisms.tabulated:Tabulated",
        parameters={},
        options={
            "theta": Option(_angles, required=True),
            "phi": Option(_angles, required=True),
            "measured": Option(validate.truth),
            "cell_angle": Option(_angle),
            "follower_step": Option(_angle),
        },
        meshed=True,
    ),
}
"""Kinds of mechanism by the name a file gives them."""


def other_keys(kind: Kind) -> dict[str, str]:
    """Keys of [mechanism] that `kind` lacks and others have, each with where it belongs."""
    owners: dict[str, list[str]] = {}
    for name, other in KINDS.items():
        for key in (*(p.key for p in other.parameters.values()), *other.options):
            owners.setdefault(key, []).append(name)
    own = {*(p.key for p in kind.parameters.values()), *kind.options}
    return {
        key: "[mechanism] of kind " + " or ".join(map(repr, kinds))
        for key, kinds in owners.items()
        if key not in own
    }
