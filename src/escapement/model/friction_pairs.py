"""Coefficients of friction of pairs of materials, as ranges with their sources."""

from __future__ import annotations

from dataclasses import dataclass

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.text import Shown

CONDITIONS = ("dry", "oiled", "greased")

SOURCES = {
    "crc": "CRC Handbook of Chemistry and Physics, as quoted by E. Hahn, 'Coefficients of Friction "
    "for Various Horological Materials', TimeZone, 2000",
    "lust": "Lust Drivetronics, Engineering Guide CDA3000, table 7.21",
    "ko": "Kirk-Othmer Encyclopedia of Chemical Technology, as quoted at chemicalforums.com/67712",
    "ecampus": "Physics Fundamentals, eCampusOntario, appendix A, table A.1",
    "transdev": "Transdev, plastic chain guides: dynamic friction on polished steel",
    "shackelford": "Shackelford and Alexander, CRC Materials Science and Engineering Handbook, "
    "2001, table 399",
    "jewels": "Wikipedia, 'Mechanical watch', section on jewels, as stored at liquisearch.com",
}
"""Where each figure was read, by the keys of `PAIRS`."""

Ends = tuple[float, float]


@dataclass(frozen=True, repr=False)
class FrictionRange(Shown):
    """The coefficients of friction that were published for a pair of materials.

    pair : both materials and the condition, "steel on brass, dry".
    static : least and greatest coefficient of bodies at rest, None if none was found.
    sliding : least and greatest coefficient of bodies that slide, None if none was found.
    sources : where they were read.
    """

    pair: str
    static: Ends | None
    sliding: Ends | None
    sources: tuple[str, ...]

    @property
    def low(self) -> float:
        """The least of all: the model has one coefficient for rest and sliding."""
        return min(min(ends) for ends in (self.static, self.sliding) if ends)

    @property
    def high(self) -> float:
        """The greatest of all."""
        return max(max(ends) for ends in (self.static, self.sliding) if ends)


PAIRS: dict[tuple[str, str, str], tuple[Ends | None, Ends | None, str]] = {
    ("steel", "steel", "dry"): ((0.12, 0.78), (0.08, 0.50), "crc lust ko transdev"),
    ("steel", "steel", "oiled"): ((0.085, 0.23), (0.10, 0.10), "crc ko"),
    ("steel", "steel", "greased"): ((0.12, 0.35), (0.04, 0.25), "lust"),
    ("brass", "steel", "dry"): ((0.35, 0.51), (0.44, 0.44), "crc ecampus"),
    ("brass", "steel", "oiled"): ((0.11, 0.19), None, "crc ecampus"),
    ("bronze", "steel", "greased"): ((0.13, 0.16), None, "ecampus"),
    ("acetal", "steel", "dry"): ((0.10, 0.30), (0.15, 0.35), "shackelford transdev"),
    ("acetal", "steel", "oiled"): (None, (0.05, 0.10), "transdev"),
    ("nylon", "steel", "dry"): (None, (0.15, 0.40), "transdev"),
    ("nylon", "steel", "oiled"): (None, (0.02, 0.11), "transdev"),
    ("nylon", "nylon", "dry"): ((0.04, 0.13), None, "shackelford"),
    ("plastic", "steel", "dry"): ((0.20, 0.45), (0.18, 0.35), "lust"),
    ("jewel", "steel", "dry"): ((0.10, 0.15), None, "crc jewels"),
    ("jewel", "steel", "oiled"): ((0.10, 0.15), None, "crc jewels"),
}
"""Static and sliding coefficients, and the keys of their sources, by both materials and condition.

A single figure is written as a range of no width. `jewel` is synthetic sapphire or ruby; `plastic`
stands for the plastics of machine parts in general. For PLA, ABS and acrylic no range that says
against which material was found.
"""


def friction_of(first: str, second: str, condition: str = "dry") -> FrictionRange:
    """Published coefficients of friction of two materials.

    They depend on finish, pressure, speed and wear, and published figures of one pair differ by a
    factor of two and more: use a range in a budget, and measure where it decides.

    Parameters
    ----------
    first, second : str
        "acetal", "brass", "bronze", "jewel", "nylon", "plastic" or "steel", in either order.
    condition : str
        "dry", "oiled" or "greased".

    Returns
    -------
    FrictionRange
        Static and sliding coefficients, `low` and `high` of both together, and the sources.

    Raises
    ------
    InvalidValue
        For a material that is not in the table, and a pair for which no figure was found.

    Examples
    --------
    >>> friction_of("steel", "brass").high
    0.51
    """
    known = sorted({name for pair in PAIRS for name in pair[:2]})
    one, other = sorted(
        validate.choice(name, word.lower() if isinstance(word, str) else word, known)
        for name, word in (("first", first), ("second", second))
    )
    validate.choice("condition", condition, CONDITIONS)
    found = PAIRS.get((one, other, condition))
    name = f"{one} on {other}, {condition}"
    if found is None:
        there = [f"{a} on {b}, {wet}" for a, b, wet in PAIRS if {one, other} & {a, b}]
        raise InvalidValue(
            f"no published friction of {name} was found; "
            f"give numbers of your own, or one of: {'; '.join(there)}"
        )
    static, sliding, keys = found
    sources = tuple(SOURCES[key] for key in keys.split())
    return FrictionRange(pair=name, static=static, sliding=sliding, sources=sources)


def friction_range(label: str, text: str) -> FrictionRange:
    """The range that a study file names: "steel on brass", or "steel on brass, oiled"."""
    pair, _, condition = (part.strip() for part in text.partition(","))
    one, on, other = pair.partition(" on ")
    if not on:
        rule = 'two materials and a condition, as in "steel on brass, oiled"'
        raise validate.fail(label, rule, text, "or give low and high")
    try:
        found = friction_of(one.strip(), other.strip(), condition or "dry")
    except InvalidValue as error:
        raise InvalidValue(f"{label}: {error}") from None
    if not found.low < found.high:
        raise InvalidValue(
            f"{label} must have two different ends, and of {text} one figure is known, "
            f"{found.low:g}; give low and high"
        )
    return found
