"""Measured beats, sorted by their pin and slot, and their mean for each pair of these."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.measurement.interval_fit import Intervals, IntervalSolution
from escapement.measurement.ticks import ticks_of
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray, Mechanism

linalg = Lazy("scipy.linalg")
_ROOTS = np.linspace(0.0, 1.0, 21)
SHARES = 1.0 - _ROOTS**2
"""Shares of the variance that may come from time stamps, closest where their effect is greatest."""
_SURE = 5.4  # a gain of log-likelihood that chance exceeds once in a thousand times


@dataclass(frozen=True, eq=False, repr=False)
class Rounds(Shown):
    """Beats in rows; each row contains all pairs of pins and slots once.

    table : ndarray, shape (rounds, pattern)
        Beats [s], NaN where one is missing.
    faults : tuple of str
        Ticks that were missed, doubled or out of place, in words.
    intervals, solution :
        The measured beats as combinations of the means, and these.
    """

    table: FloatArray
    faults: tuple[str, ...]
    intervals: Intervals = field(repr=False)
    solution: IntervalSolution = field(repr=False)

    @property
    def weights(self) -> FloatArray:
        """Probability of each of `SHARES`, shape (21,)."""
        return self.solution.weights

    @property
    def jitter(self) -> float:
        """Share of the variance of a beat's noise that comes from the jitter of time stamps [-].

        The correlation of neighbouring beats is -jitter/2.
        """
        return float(self.weights @ SHARES)

    @property
    def pattern(self) -> int:
        """Engagements after which pins and slots meet again."""
        return int(self.table.shape[1])

    @property
    def samples(self) -> int:
        """Number of measured beats."""
        return int(self.intervals.values.size)

    @property
    def known(self) -> np.ndarray:
        """Indices of the measured beats in turn, shape (samples,)."""
        return np.flatnonzero(np.isfinite(self.table.ravel()))

    @property
    def means(self) -> FloatArray:
        """Best estimate of the beat of each engagement of the pattern, shape (pattern,) [s]."""
        return self.solution.values

    @cached_property
    def root(self) -> FloatArray:
        """R such that R (means - true means) is independent noise of one beat's size."""
        return np.asarray(linalg.cholesky(np.linalg.inv(self.solution.covariance)))

    @property
    def spread(self) -> FloatArray:
        """Standard deviation of each mean less the mean of all, for noise of one beat of 1 [-].

        Shape (pattern,). Time stamps make it smaller than with independent beats, because a stamp
        that comes late makes one beat longer and the next one shorter.
        """
        weights = np.eye(self.pattern) - 1.0 / self.pattern
        return np.asarray(np.linalg.norm(weights @ np.linalg.inv(self.root), axis=1))

    @property
    def scatter(self) -> float:
        """Sum of the squared deviations from the means, made independent [s^2]."""
        return self.solution.scatter

    def independent(self, computed: FloatArray) -> FloatArray:
        """Measured beats less computed ones of one pattern, made independent, shape (samples,)."""
        rest = (self.table - computed).ravel()[self.known]
        return self.intervals.independent(rest, self.jitter)


def rounds_of(given: ArrayLike, mechanism: Mechanism, times: bool = False) -> Rounds:
    """Beats or time stamps as rounds, the last of which may end early; see `fit_beats`.

    Durations count as differences of time stamps only where they show it with certainty.
    """
    if not isinstance(mechanism, Geneva):
        raise validate.fail("mechanism", "a Geneva wheel", mechanism, "see escapement.Geneva")
    pins, slots = mechanism.pins or 1, mechanism.slots
    size = math.lcm(pins, slots)
    values, faults = ticks_of(given, times, size)
    table = np.full(-(-max(values.size, 1) // size) * size, np.nan)
    table[: values.size] = values
    known = np.flatnonzero(np.isfinite(table))
    counts = np.bincount(known % size, minlength=size)
    if counts.min() == 0:
        k = int(counts.argmin())
        amiss = f" ({'; '.join(faults)})" if faults else ""
        raise InvalidValue(
            f"beats must tell of all {size} engagements of the pattern, got none of pin "
            f"{k % pins} in slot {k % slots}{amiss}; measure longer"
        )
    design, joined = np.eye(size)[known % size], np.diff(known) == 1
    intervals = Intervals(table[known], design, np.ones(known.size), joined)
    # the shares are closer to each other by their square root near 1
    solution = intervals.average(SHARES, _ROOTS, 0.0 if times else _SURE)
    return Rounds(table.reshape(-1, size), faults, intervals, solution)
