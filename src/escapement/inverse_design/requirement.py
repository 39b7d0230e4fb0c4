"""A requirement: the task of a timer, the ranges of its numbers, and its bounds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from escapement.base import units, validate
from escapement.base.errors import InvalidValue
from escapement.base.files import AnyPath
from escapement.base.quantity import Quantity, declared
from escapement.base.text import Shown
from escapement.base.toml_file import read_toml
from escapement.mechanisms import Geneva
from escapement.model.escapement import Escapement
from escapement.model.inputs import Input

Range = tuple[float, float]
Values = tuple[float, ...]
_NUMBER = "give a number, or [low, high]"


def _quantity(name: str, long_name: str, unit: str = "ratio", **rule: Any) -> Quantity:
    remedy = "give a number in this range"
    return Quantity(name=name, key=name, long_name=long_name, unit=unit, remedy=remedy, **rule)


def _by_name(*entries: Quantity) -> dict[str, Quantity]:
    return {entry.name: entry for entry in entries}


NUMBERS = _by_name(
    _quantity("period", "period of one engagement", "time", exclusive=True),
    _quantity("total_time", "time of the whole run", "time", exclusive=True),
    _quantity("turns", "driver turns of the whole run", exclusive=True),
    _quantity("torque_lost", "share of its torque that the spring loses over the run",
              maximum=1.0, below=True),
    _quantity("pin", "radius of the pins over the crank radius", exclusive=True, maximum=0.5),
    _quantity("density", "density of the discs", "density", exclusive=True),
)  # fmt: skip
"""Single numbers of a requirement."""
_ESCAPEMENT = declared(Escapement)
LOSSES = {
    name: entry for name, entry in {**declared(Geneva), **_ESCAPEMENT}.items()
    if isinstance(entry, Quantity) and name in {
        "roller_radius", "driver_drag", "follower_drag", "driver_bearing_torque",
        "driver_bearing_radius", "driver_bearing_friction",
        "follower_bearing_radius", "follower_bearing_friction",
    }
}  # fmt: skip
"""Numbers besides, which no design has unless they are given."""
_THICKNESS = _by_name(
    _quantity("driver_thickness", "thickness of the driver's disc", "length"),
    _quantity("follower_thickness", "thickness of the follower's disc", "length"),
)
RANGES = (
    _by_name(
        _quantity("friction", "coefficient of friction between pin and slot"),
        _quantity("torque", "driving torque at the start", "torque", exclusive=True),
        _quantity("crank_radius", "radius on which the pins turn", "length", exclusive=True),
        _quantity("inertia_ratio", "driver inertia over follower inertia", exclusive=True),
        _quantity("slots", "slots of the follower", whole=True, minimum=3, maximum=64),
    )
    | {name: replace(entry, exclusive=True) for name, entry in _THICKNESS.items()}
    | LOSSES
)
"""Numbers that the search chooses from a range or a list."""
MATERIALS = {name: _ESCAPEMENT[name] for name in ("pin_material", "wheel_material")}
BOUNDS = _by_name(
    _quantity("scatter", "half the relative change of the period over the friction range"),
    _quantity("contact_force_max", "greatest force on a pin", "force"),
    _quantity("pressure_max", "greatest pressure between a pin and its slot", "pressure"),
    _quantity("size", "length of both discs together along the line of centres", "length"),
    _quantity("mass", "mass of driver and follower discs", "mass"),
    _quantity("rise_time_98", "time to 98 % of the terminal speed", "time"),
    _quantity("driver_inertia", "moment of inertia of the driver", "inertia"),
    _quantity("follower_inertia", "moment of inertia of the follower", "inertia"),
    *_THICKNESS.values(),
    _quantity("thinnest_wall", "thinnest wall of the discs", "length"),
    _quantity("jam_margin", "1 - friction over its Painleve limit"),
)
"""Figures of a design that can have bounds."""
THICK = 3e-4, 0.02
"""Least and greatest thickness of a disc where a requirement has no bounds on it [m]."""
OBJECTIVES = ("scatter", "contact_force_max", "size", "mass", "rise_time_98")
"""Figures that can be minimised."""


@dataclass(frozen=True, repr=False)
class Requirement(Shown):
    """The task of a Geneva timer, and the limits of its design.

    Two values of a number are the ends of a range, and three or more a list, of which the search
    chooses one.

    Parameters
    ----------
    period : float, optional
        Time of one engagement at the middle friction [s]. Give either `period`, or both
        `total_time` and `turns`.
    total_time, turns : float, optional
        Time of a whole run from rest [s], and the number of turns of the driver in it.
    torque : float, (low, high) or list
        Torque on the driver [N m]; for a spring that at the start.
    torque_lost : float
        Share of the torque that a spring loses over the run [-], in [0, 1).
    friction : float or (low, high)
        Range of the friction in the slots [-].
    crank_radius : float, (low, high) or list
        Radius on which the pins turn [m].
    slots : int, (low, high) or list
        Slots of the follower; external and internal wheels are tried.
    internal : bool, optional
        True or False for only internal or only external wheels.
    inertia_ratio : float, (low, high) or list
        Driver over follower inertia [-].
    driver_thickness, follower_thickness : float, (low, high) or list, optional
        Thickness of the discs [m]. The torque then follows from the period, or the crank radius
        where there is one torque, and from both of them the inertia ratio; each has to lie within
        its range.
    roller_radius, driver_drag, follower_drag, driver_bearing_torque, driver_bearing_radius, \
driver_bearing_friction, follower_bearing_radius, follower_bearing_friction : optional
        Rollers, vanes and bearings as of `Geneva` and `Escapement`, each a float, (low, high) or
        list.
    pin : float
        Radius of the pins over the crank radius [-].
    density : float
        Density of the discs [kg/m^3], which have the outlines of `parts_of`.
    pin_material, wheel_material : str or Material
        Of pins and wheel, for the pressure: a name, or modulus [Pa] and Poisson's ratio. A pin is
        as long as the follower's disc is thick.
    bounds : Mapping
        (least, greatest) value of figures, by names in `BOUNDS`. A single number is the greatest
        value, but the least for the jam margin and the thinnest wall. Without bounds of their
        own, or without a least one, discs are as thick as `THICK` says.
    objectives : sequence of str
        Names in `OBJECTIVES`, the figures to minimise.
    """

    period: float | None = None
    total_time: float | None = None
    turns: float | None = None
    torque: Any = None
    torque_lost: float = 0.0
    friction: Any = (0.25, 0.35)
    crank_radius: Any = (0.005, 0.05)
    slots: Any = (3, 12)
    internal: bool | None = None
    inertia_ratio: Any = (0.01, 10.0)
    driver_thickness: Any = None
    follower_thickness: Any = None
    roller_radius: Any = None
    driver_drag: Any = None
    follower_drag: Any = None
    driver_bearing_torque: Any = None
    driver_bearing_radius: Any = None
    driver_bearing_friction: Any = None
    follower_bearing_radius: Any = None
    follower_bearing_friction: Any = None
    pin: float = 0.05
    density: float = 7850.0
    pin_material: Any = "steel"
    wheel_material: Any = "steel"
    bounds: Mapping[str, Any] = field(default_factory=dict)
    objectives: tuple[str, ...] = ("scatter", "contact_force_max", "size")

    def __post_init__(self) -> None:
        values = vars(self)
        for name, entry in NUMBERS.items():
            if values[name] is not None:
                values[name] = entry.check(name, values[name])
        for name, setting in MATERIALS.items():
            values[name] = setting.check(name, values[name])
        if self.torque is None:
            raise validate.fail("torque", "given", None, _NUMBER)
        for name, entry in RANGES.items():
            if values[name] is not None:
                values[name] = _ends(entry, name, values[name], listed=name != "friction")
        for name, entry in LOSSES.items():
            if values[name] is not None and entry.needs and values.get(entry.needs, ()) is None:
                remedy = f"give {entry.needs}, too"
                raise validate.fail(name, f"left out without {entry.needs}", values[name], remedy)
        if (self.period is None) == (self.total_time is None):
            rule, remedy = "given, or total_time with turns in its place", "give one of the two"
            raise validate.fail("period", rule, self.period, remedy)
        if (self.total_time is None) != (self.turns is None):
            remedy = "give total_time and turns, or the period"
            raise validate.fail(
                "turns", "given if total_time is, and only then", self.turns, remedy
            )
        if self.torque_lost and self.turns is None:
            remedy = "give total_time and turns"
            raise validate.fail("torque_lost", "0 without total_time", self.torque_lost, remedy)
        if self.internal is not None:
            validate.truth("internal", self.internal)
        validate.known_keys(self.bounds, BOUNDS, "in bounds")
        given = {name: _bound(BOUNDS[name], x) for name, x in self.bounds.items()}
        usual = {name: THICK for name in _THICKNESS if values[name] is None}
        values["bounds"] = usual | given
        if isinstance(self.objectives, str) or not self.objectives:
            rule = "a list of names"
            raise validate.fail("objectives", rule, self.objectives, 'for example ["scatter"]')
        values["objectives"] = tuple(
            validate.choice("objectives", name, OBJECTIVES) for name in self.objectives
        )

    @property
    def losses(self) -> dict[str, Values]:
        """The rollers, vanes and bearings that are searched."""
        return {name: x for name in LOSSES if (x := getattr(self, name)) is not None}

    @property
    def thick(self) -> dict[str, Values]:
        """The thicknesses that are searched."""
        return {name: x for name in _THICKNESS if (x := getattr(self, name)) is not None}

    @property
    def follows(self) -> str:
        """The number that follows from the period."""
        if not self.thick:
            return "follower_inertia"
        return "torque" if self.torque[0] < self.torque[-1] else "crank_radius"

    @property
    def searched(self) -> dict[str, Values]:
        """Ranges and lists in which the search is free to choose."""
        names = ("inertia_ratio",) * (len(self.thick) < 2) + ("crank_radius", "torque")
        plain = {name: getattr(self, name) for name in names if name != self.follows}
        return plain | self.thick | self.losses

    @property
    def limits(self) -> dict[str, Range]:
        """The bounds, and the ranges of numbers that follow from others."""
        followed = {"inertia_ratio", "crank_radius", "torque"} - self.searched.keys()
        ends = ((name, getattr(self, name)) for name in sorted(followed))
        return dict(self.bounds) | {name: (x[0], x[-1]) for name, x in ends}

    def inputs(self) -> Iterator[Input]:
        """Its numbers and its bounds, of which None is no bound."""
        for name, entry in (NUMBERS | RANGES).items():
            if (value := getattr(self, name)) is not None:
                single = isinstance(value, tuple) and value[0] == value[-1]
                yield name, value[0] if single else value, entry.unit
        yield "internal", "any" if self.internal is None else self.internal, "ratio"
        yield "objectives", ", ".join(self.objectives), "ratio"
        for name, ends in self.bounds.items():
            shown = [x if math.isfinite(x) else None for x in ends]
            yield f"{name}_bounds", shown, BOUNDS[name].unit


def _ends(entry: Quantity, label: str, given: Any, listed: bool = False) -> Values:
    """The two ends of a range, a single number twice; or the values of a list, if `listed`."""
    pair = given if isinstance(given, list | tuple) else (given, given)
    if len(pair) < 2 or not (len(pair) == 2 or listed):
        rule = "a number, two ends or a longer list" if listed else "a number or two ends"
        raise validate.fail(label, rule, given, _NUMBER)
    low, high, *others = (float(entry.read(label, x)) for x in pair)
    if others:
        return tuple(sorted((low, high, *others)))
    if low > high:
        raise validate.fail(label, "[low, high] with low at most high", given, "swap them")
    return low, high


def _bound(entry: Quantity, given: Any) -> Range:
    """The least and the greatest value that a bound allows."""
    if isinstance(given, list | tuple):
        low, high = _ends(entry, entry.name, given)
        return low, high
    number = float(entry.check(entry.name, given))
    if entry.name in ("jam_margin", "thinnest_wall"):
        return number, math.inf
    least = THICK[0] if entry.name.endswith("_thickness") and number > THICK[0] else -math.inf
    return least, number


def load_requirement(path: AnyPath) -> tuple[Requirement, str]:
    """Read a requirement from TOML, and the unit system of its numbers.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it is not TOML.
    InvalidValue
        When a key is unknown or its value breaks a rule.
    """
    content = read_toml(path, "wish")
    try:
        return requirement_of(content)
    except InvalidValue as error:
        raise InvalidValue(f"{path}: {error}") from None


def requirement_of(content: dict[str, Any]) -> tuple[Requirement, str]:
    """A requirement from the content of its file, and its unit system; errors as in
    `load_requirement`."""
    system = validate.choice("units", content.pop("units", units.SYSTEMS[0]), units.SYSTEMS)
    keys = ("units", *NUMBERS, *RANGES, *MATERIALS, "internal", "objectives", "bounds")
    validate.known_keys(content, keys, "in a wish")
    bounds = content.pop("bounds", {})
    if not isinstance(bounds, dict):
        raise validate.fail("bounds", "a table", bounds, "write [bounds] on a line of its own")
    validate.known_keys(bounds, BOUNDS, "in [bounds]")
    given = {name: _in_si(NUMBERS | RANGES, name, x, system) for name, x in content.items()}
    found = {name: _in_si(BOUNDS, name, x, system) for name, x in bounds.items()}
    return Requirement(**given, bounds=found), system


def _in_si(entries: Mapping[str, Quantity], name: str, value: Any, system: str) -> Any:
    """A value of a file, or the ends of a range, in SI; checked as the user wrote it."""
    if name not in entries:
        return value
    entry = replace(entries[name], system=system)
    if isinstance(value, list) and name not in NUMBERS:
        listed = name in RANGES and name != "friction"
        return [entry.to_si(x) for x in _ends(entry, name, value, listed)]
    return entry.to_si(entry.read(name, value))
