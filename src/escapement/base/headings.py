"""Headings of columns: names by which their role is known, and units as people write them."""

import math
import re

UNITS = {"deg": 2.0 * math.pi / 360.0, "rad": 1.0, "turn": 2.0 * math.pi}
"""Units of angles, in rad."""
COUNTS = "counts"
"""Unit of angles that are counts of an encoder; its resolution converts them."""
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
"""Units of times, in s."""
NAMES = {
    "input": ("input", "in", "driver", "theta", "phi1"),
    "output": ("output", "out", "follower", "phi", "phi3"),
}
"""Headings that identify the columns of input and output."""
TIME_NAMES = ("time", "t", "timestamp", "")
"""Headings that identify the column of times; the last one stands for a unit alone."""
_SPELLINGS = {
    **dict.fromkeys(("deg", "degree", "degrees", "°", "º"), "deg"),
    **dict.fromkeys(("rad", "radian", "radians"), "rad"),
    **dict.fromkeys(("turn", "turns", "rev", "revs", "revolution", "revolutions"), "turn"),
    **dict.fromkeys(("count", "counts", "ticks"), COUNTS),
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisecond", "milliseconds"), "ms"),
    # the micro sign and the Greek letter
    **dict.fromkeys(("us", "µs", "μs", "usec", "micros", "microsecond", "microseconds"), "us"),
    **dict.fromkeys(("ns", "nsec", "nanos", "nanosecond", "nanoseconds"), "ns"),
    **dict.fromkeys(("min", "mins", "minute", "minutes"), "min"),
    **dict.fromkeys(("h", "hr", "hrs", "hour", "hours"), "h"),
}
# these units are refused, for they would otherwise be taken as degrees or seconds
_FOREIGN = re.compile(r"(?:[mµμu]rad|grad|gon|arcmin|arcsec|day|week|[cd]s)s?|jiffies")


def name_and_unit(field: str) -> tuple[str, str | None]:
    """Name of a column in small letters, and its unit, which may be a foreign one."""
    *words, last = re.findall(r"[^\W_]+|°|º", field.lower()) or [""]
    unit = _SPELLINGS.get(last) or (last if _FOREIGN.fullmatch(last) else None)
    return "".join(words if unit else [*words, last]), unit


def is_row_of_units(fields: list[str]) -> bool:
    """Whether a row below the names holds units: no numbers, and some word is a unit."""
    units = [field.strip(" ()[]").lower() for field in fields]
    known = any(unit in _SPELLINGS or _FOREIGN.fullmatch(unit) for unit in units)
    return known and not any(re.search(r"\d", unit) for unit in units)
