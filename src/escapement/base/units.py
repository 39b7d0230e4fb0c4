"""Units: their exact sizes, how people may write them, and how the package writes them.

The inch (0.0254 m), the pound (0.45359237 kg) and standard gravity (9.80665 m/s²) are exact by
definition, so every size below is exact, up to the pi in degrees and turns.
"""

import math
import re
import unicodedata
from fractions import Fraction
from functools import cache
from typing import Any

from escapement.base import validate

SYSTEMS = ("SI", "in-lbf-s", "mm")
"""Unit systems a user may choose: SI; inch, pound-force and second; or those of a workshop, with
millimetres, N mm, kg mm², MPa, rpm and degrees."""

# kind of unit: its name in each system, as UDUNITS spells it
_NAMES = {
    "torque": ("N m", "in lbf", "N mm"),
    "inertia": ("kg m2", "in lbf s2", "kg mm2"),
    "length": ("m", "in", "mm"),
    "force": ("N", "lbf", "N"),
    "power": ("W", "in lbf s-1", "W"),
    "drag": ("N m s2 rad-2", "in lbf s2 rad-2", "N mm s2 rad-2"),
    "viscous": ("N m s rad-1", "in lbf s rad-1", "N mm s rad-1"),
    "rate": ("N m rad-1", "in lbf rad-1", "N mm rad-1"),
    "stiffness": ("N m-1", "lbf in-1", "N mm-1"),
    "damping": ("N s m-1", "lbf s in-1", "N s mm-1"),
    "slip": ("m s-1", "in s-1", "mm s-1"),
    "density": ("kg m-3", "lbf s2 in-4", "g cm-3"),
    "impulse": ("N s", "lbf s", "N s"),
    "mass": ("kg", "lbf s2 in-1", "kg"),
    "energy": ("J", "in lbf", "mJ"),
    "pressure": ("Pa", "lbf in-2", "MPa"),
    "pressure_speed": ("Pa m s-1", "lbf in-1 s-1", "MPa m s-1"),
    "speed": ("rad s-1", "rad s-1", "rpm"),
    "angle": ("rad", "rad", "degree"),
}
_COMMON = {
    "acceleration": "rad s-2",
    "time": "s",
    "degrees": "degree",
    "ratio": "1",
    "frequency": "Hz",
}

_BASE = ("g", "m", "s", "rad")
_PREFIXES = {"M": 6, "k": 3, "": 0, "d": -1, "c": -2, "m": -3, "u": -6, "μ": -6, "n": -9}
_PI = Fraction(math.pi)
_RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹"
# unit: how many of which others it is; the first take prefixes
_METRIC: dict[str, tuple[Any, str]] = {
    "g": (1, ""), "m": (1, ""), "s": (1, ""), "rad": (1, ""),
    "N": (1, "kg m s-2"), "J": (1, "N m"), "W": (1, "J s-1"), "Pa": (1, "N m-2"), "Hz": (1, "s-1"),
    "gf": ("9.80665", "g m s-2"),
}  # fmt: skip
_OTHERS: dict[str, tuple[Any, str]] = {
    "in": ("0.0254", "m"), "lb": ("0.45359237", "kg"), "lbf": ("9.80665", "lb m s-2"),
    "oz": ("0.0625", "lb"), "ozf": ("0.0625", "lbf"), "lbs": (1, "lb"), "inch": (1, "in"),
    "ft": (12, "in"), "dyn": ("0.00001", "N"), "min": (60, "s"), "h": (60, "min"),
    "rpm": (1, "rev min-1"),
    "rev": (2 * _PI, "rad"), "deg": (_PI / 180, "rad"), "degree": (1, "deg"), "°": (1, "deg"),
    "%": ("0.01", ""),
}  # fmt: skip
_FORCES = {"g": "gf", "lb": "lbf", "lbs": "lbf", "oz": "ozf"}
"""The force that a mass weighs: in oz-in and kg cm, units of torque, masses stand for weights."""
_KNOWN = {
    prefix + unit: (Fraction(10) ** power, unit)
    for unit in _METRIC
    for prefix, power in _PREFIXES.items()
} | {unit: (Fraction(1), unit) for unit in _OTHERS}
# the longest name first: "min" is no milli-inch, and "mNm" is a millinewton and a metre
_ANY = "|".join(map(re.escape, sorted(_KNOWN, key=len, reverse=True)))
_PART = re.compile(rf"[\s*·⋅-]*(/?)\s*({_ANY})\^?(-?\d)?")
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,2})?)\s*([^\d\s.,].*?)\s*")
_COMMA = re.compile(r"\s*[-+]?\d*,\d+[^.,]*")


@cache
def _size(unit: str, weights: bool = False) -> tuple[Fraction, tuple[int, ...]]:
    """Size of a unit in the base units, and their powers in it; ValueError for no such unit.

    weights : whether masses stand for what they weigh.
    """
    size, powers, end = Fraction(1), [0, 0, 0, 0], 0
    unit = unicodedata.normalize("NFKC", unit).replace("−", "-").strip().removeprefix("1")
    while end < len(unit):
        if (found := _PART.match(unit, end)) is None:
            raise ValueError(f"{unit[end:]!r} is no unit")
        end, power = found.end(), int(found[3] or 1) * (-1 if found[1] else 1)
        scale, name = _KNOWN[found[2]]
        name = _FORCES.get(name, name) if weights else name
        many, others = (_METRIC | _OTHERS)[name]
        inner, inside = _size(others)
        size *= (scale * Fraction(many) * inner) ** power
        inside = tuple(int(name == base) for base in _BASE) if name in _BASE else inside
        powers = [total + power * exponent for total, exponent in zip(powers, inside, strict=True)]
    return size, tuple(powers)


def measured(label: str, value: Any, kind: str, system: str, remedy: str) -> Any:
    """A number in its unit, "5 mN m", in the unit that `system` has for its kind.

    Parameters
    ----------
    label : str
        Name of the number, for messages.
    value : str or any
        A number with its unit. A value that is not a text is returned unchanged.
    kind, system : str
        As for `factor`.
    remedy : str
        For messages.

    Raises
    ------
    InvalidValue
        If the text is not a number with a unit, or the unit is unknown or of another kind.
    """
    if not isinstance(value, str):
        return value
    text = value.replace("−", "-")
    found = _NUMBER.fullmatch(text)
    if _COMMA.fullmatch(text):
        point = f"write {text.strip().replace(',', '.')!r}"
        raise validate.fail(label, "a number with a decimal point", value, point)
    if found is None:
        raise validate.fail(label, "a finite number", value, remedy)
    expected, powers = _size(unit_name(kind, system))
    try:
        size, exponents = _size(found[2])
        if exponents != powers:
            size, exponents = _size(found[2], weights=True)
    except ValueError as error:
        raise validate.fail(label, f"in a known unit ({error})", value, remedy) from None
    if exponents != powers:
        wanted = printed(kind, system)
        rule = f"in {wanted} or a unit of the same kind" if wanted else "without a unit"
        raise validate.fail(label, rule, value, remedy)
    # exact up to here: 35 g cm2 is 35e-7 kg m2, and no other double
    return float(Fraction(found[1]) * size / expected)


@cache
def factor(quantity: str, system: str) -> float:
    """SI value of one unit of `quantity` in `system`.

    Parameters
    ----------
    quantity : str
        "torque", "power", "inertia", "length", "force", "drag", "viscous", "rate", "stiffness",
        "damping", "slip", "impulse", "speed", "acceleration", "time", "angle", "degrees",
        "energy" or "ratio".
    system : str
        One of `SYSTEMS`.
    """
    metric = "rad" if quantity == "degrees" else unit_name(quantity, SYSTEMS[0])
    return float(_size(unit_name(quantity, system))[0] / _size(metric)[0])


@cache
def ratio_of(unit: str, other: str) -> float:
    """How many of another unit one unit is, both in UDUNITS spelling; 1 for the same unit."""
    return float(_size(unit)[0] / _size(other)[0])


def unit_name(quantity: str, system: str) -> str:
    """UDUNITS spelling of the unit of `quantity` in `system`."""
    return _COMMON.get(quantity) or _NAMES[quantity][SYSTEMS.index(system)]


def spelt(unit: str) -> str:
    """A unit in UDUNITS spelling as people read it: "kg m²", "in-lbf-s²", "rad/s"; "" for "1"."""
    name = re.sub(r" ?\b([a-z]+)-", r"/\1", unit).replace("degree", "deg").removesuffix("1")
    name = re.sub(r"(?<=[a-z])\d", lambda power: _RAISED[int(power[0])], name)
    name = "1" + name if name.startswith("/") else name
    return name.replace(" ", "-") if "lbf" in name else name


def printed(quantity: str, system: str) -> str:
    """The unit of `quantity` in `system` as people read it; "" for a ratio."""
    return spelt(unit_name(quantity, system))


INCH = factor("length", SYSTEMS[1])
"""One inch [m]."""
POUND_FORCE = factor("force", SYSTEMS[1])
"""One pound-force [N]."""
INCH_POUND = factor("torque", SYSTEMS[1])
"""One in-lbf [N m]; also one in-lbf-s² [kg m²], the inertia unit of Meyer (1973)."""
DEGREE = factor("degrees", SYSTEMS[0])
"""One degree [rad]."""


def degrees(angle: float) -> float:
    """An angle in degrees to twelve decimals: sixty should read as sixty."""
    return round(math.degrees(angle), 12)
