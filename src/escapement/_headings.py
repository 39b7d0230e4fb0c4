"""Headings of columns of angles: which shaft's they are, and in which unit."""

import math
import re

UNITS = {"deg": 2.0 * math.pi / 360.0, "rad": 1.0}
"""Units of angles, in rad."""
NAMES = {
    "input": ("input", "in", "driver", "theta", "phi1"),
    "output": ("output", "out", "follower", "phi", "phi3"),
}
"""What the columns of driver and follower are called."""
_SPELLINGS = {
    "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg",
    "rad": "rad", "radian": "rad", "radians": "rad",
}  # fmt: skip
FOREIGN = re.compile(r"(?:[mµμu]rad|grad|gon|turn|rev|revolution|arcmin|arcsec)s?", re.IGNORECASE)
"""Units of angles that are not read."""


def name_and_unit(field: str) -> tuple[str, str | None]:
    """A column's name in small letters, and the unit it ends in, one of `UNITS` or foreign."""
    *words, last = re.findall(r"[^\W_]+|°", field.lower()) or [""]
    unit = _SPELLINGS.get(last) or (last if FOREIGN.fullmatch(last) else None)
    return "".join(words if unit else [*words, last]), unit
