"""Measured beats, sorted by their pin and slot."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.errors import InvalidValue
from escapement.mechanism import FloatArray
from escapement.mechanisms import Geneva


@dataclass(frozen=True, eq=False)
class Rounds:
    """Beats in rows; each row contains all pairs of pins and slots once.

    table : ndarray, shape (rounds, pattern)
        Beats [s], NaN where one is missing.
    """

    table: FloatArray

    @property
    def pattern(self) -> int:
        """Engagements after which pins and slots meet again."""
        return int(self.table.shape[1])

    @property
    def samples(self) -> int:
        """Number of measured beats."""
        return int(self.counts.sum())

    @cached_property
    def counts(self) -> np.ndarray:
        """How often each engagement of the pattern was measured, shape (pattern,)."""
        return np.asarray(np.isfinite(self.table).sum(axis=0))

    @cached_property
    def means(self) -> FloatArray:
        """Mean beat of each engagement of the pattern, shape (pattern,) [s]."""
        return np.asarray(np.nansum(self.table, axis=0) / self.counts)

    @cached_property
    def scatter(self) -> float:
        """Sum of the squared deviations from the means [s^2]."""
        return float(np.nansum((self.table - self.means) ** 2))


def rounds_of(beats: ArrayLike, wheel: Geneva) -> Rounds:
    """Beats in turn as rounds, the last of which may end early; see `fit_beats`."""
    remedy = "give the times of the engagements in s, NaN for a missing one"
    try:
        given = np.ma.asanyarray(beats).astype(float, copy=False)
    except (TypeError, ValueError):
        given = np.empty((0, 0))
    if given.ndim != 1:
        raise validate.fail("beats", "a row of real numbers", beats, remedy)
    values = np.asarray(np.ma.filled(given, np.nan))
    wrong = np.flatnonzero(~np.isnan(values) & ~((values > 0.0) & np.isfinite(values)))
    if wrong.size:
        place = int(wrong[0])
        raise validate.fail(f"beat {place}", "finite and greater than 0", values[place], remedy)
    size = math.lcm(wheel.pins or 1, wheel.slots)
    padded = np.full(-(-max(values.size, 1) // size) * size, np.nan)
    padded[: values.size] = values
    found = Rounds(padded.reshape(-1, size))
    if found.counts.min() == 0:
        k = int(found.counts.argmin())
        raise InvalidValue(
            f"beats must tell of all {size} engagements of the pattern, got none of pin "
            f"{k % (wheel.pins or 1)} in slot {k % wheel.slots}; measure longer"
        )
    return found


def checked_wheel(mechanism: Any) -> Geneva:
    """A mechanism whose pins and slots may have errors, or InvalidValue."""
    if isinstance(mechanism, Geneva):
        return mechanism
    raise validate.fail("mechanism", "a Geneva wheel", mechanism, "see escapement.Geneva")
