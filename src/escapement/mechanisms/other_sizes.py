"""Sizes that drawings give in place of a mechanism's own numbers: diameters, a centre distance.

Each stands for one number of the mechanism. The command line and study files read them, and
convert them before the mechanism is made, so that nothing else has to know them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Quantity, Setting
from escapement.base.spoken import spoken_length

Numbers = Mapping[str, Any]


class OtherSize(NamedTuple):
    """A length in place of another.

    Attributes
    ----------
    entry : Quantity
        Its declaration.
    of : str
        Name of the number that it stands for.
    reads : tuple of str
        Names of the numbers that the conversion needs; the first must be given.
    convert : callable
        That number [m] from the length [m] and all given numbers, in SI.
    """

    entry: Quantity
    of: str
    reads: tuple[str, ...]
    convert: Callable[[float, Numbers], float]


def other_size(
    name: str,
    text: str,
    of: str,
    convert: Callable[[float, Numbers], float],
    reads: tuple[str, ...] = (),
) -> dict[str, OtherSize]:
    """The size by its name; arguments as of `OtherSize`."""
    entry = Quantity(
        name=name, key=name, section="mechanism", long_name=text, unit="length", metavar="D",
        note=f", in place of {of}", exclusive=True, axis=False, remedy="give the length",
    )  # fmt: skip
    return {name: OtherSize(entry, of, reads, convert)}


def diameters(settings: Mapping[str, Setting]) -> dict[str, OtherSize]:
    """A diameter in place of every radius that a class declares."""
    found: dict[str, OtherSize] = {}
    for name, entry in settings.items():
        if entry.unit == "length" and name.endswith("_radius"):
            diameter, half = name.replace("_radius", "_diameter"), lambda size, _: 0.5 * size
            text = entry.long_name.partition(",")[0].replace("radius", "diameter")
            found |= other_size(diameter, text, name, half)
    return found


def numbers_of_sizes(sizes: Mapping[str, OtherSize], given: Numbers) -> dict[str, Any]:
    """The given numbers in SI, with other sizes replaced by the numbers that they stand for.

    Raises
    ------
    InvalidValue
        If two of them say the same, or a number that the conversion needs is not given.
    """
    found, said = dict(given), dict[str, str]()
    for name, size in sizes.items():
        if name not in given:
            continue
        value = found.pop(name)
        if size.of in found:
            other = said.get(size.of, size.of)
            raise InvalidValue(
                f"{name} must not come with {other}, got both; leave out one of them, because "
                "each follows from the other"
            )
        for lacking in size.reads[:1]:
            if lacking not in found:
                rule = f"together with one number of {lacking}"
                raise validate.fail(name, rule, value, f"give it, or {size.of}")
        found[size.of], said[size.of] = size.convert(value, found), name
    return found


def crank_from_centre_distance(distance: float, given: Numbers) -> float:
    """Crank radius of a Geneva wheel from the distance of the axes, a sin(pi/n)."""
    return distance * math.sin(math.pi / given["slots"])


def crank_from_wheel_radius(radius: float, given: Numbers) -> float:
    """Crank radius of a Geneva wheel from the radius of its rim.

    A pin enters where its centre crosses the mouth of a slot, whose corners are on the rim.
    """
    outer = given.get("roller_radius") or given.get("pin_radius") or 0.0
    half = outer + 0.5 * (given.get("clearance") or 0.0)
    if not radius > half:
        rule = f"greater than half the width of a slot, {spoken_length(half)}"
        raise validate.fail("wheel_radius", rule, spoken_length(radius), "give a larger wheel")
    return math.sqrt(radius**2 - half**2) * math.tan(math.pi / given["slots"])


def crank_from_wheel_diameter(diameter: float, given: Numbers) -> float:
    """As `crank_from_wheel_radius`."""
    return crank_from_wheel_radius(0.5 * diameter, given)
