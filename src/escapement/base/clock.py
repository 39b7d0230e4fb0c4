"""Times of a logger that are written as a time of day or as a date."""

import re
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

_OF_DAY = re.compile(r"(?:(\d{1,3}):)?(\d{1,2}):(\d{1,2}(?:[.,]\d+)?)")
_DAY = 86400.0
EXAMPLES = "19:13:03.25 or 2026-11-25T19:13:03.25"
"""Times as they are read."""


class Clock:
    """Reads times of one column, in seconds; dates count from the first one.

    used : whether any field was a time of day or a date.
    """

    def __init__(self) -> None:
        self.used = False
        self.first: datetime | None = None

    def __call__(self, field: str) -> float:
        """A time in s; ValueError if it is none."""
        text = field.strip()
        self.used = True
        if found := _OF_DAY.fullmatch(text):
            hours, minutes, seconds = found.groups()
            if hours is None and not re.search("[.,]", seconds):
                raise ValueError("12:30 may be hours and minutes, or minutes and seconds")
            return 3600.0 * int(hours or 0) + 60.0 * int(minutes) + float(seconds.replace(",", "."))
        date = datetime.fromisoformat(text)
        self.first = self.first or date
        try:
            return float((date - self.first).total_seconds())
        except TypeError:
            raise ValueError("some of the times have a time zone, and some have none") from None


def past_midnight(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Times of day that go on counting where a new day begins [s]."""
    days = np.cumsum(np.diff(times, prepend=times[:1]) < -0.5 * _DAY)
    return np.asarray(times + _DAY * days)
