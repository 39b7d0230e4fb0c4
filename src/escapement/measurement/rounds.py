"""Measured beats, sorted by their pin and slot, and their mean for each pair of these."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.measurement.interval_fit import Intervals, IntervalSolution, weights_of
from escapement.measurement.ticks import ticks_of
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray

linalg = Lazy("scipy.linalg")
_ROOTS = np.linspace(0.0, 1.0, 21)
SHARES = 1.0 - _ROOTS**2
"""Shares of the variance that may come from time stamps, closest where their effect is greatest."""
_ALONE = np.where(SHARES == 0.0, 1.0, 0.0)
_SURE = 5.4  # a gain of log-likelihood that chance exceeds once in a thousand times
_NEGLIGIBLE = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Rounds(Shown):
    """Beats in rows; each row contains all pairs of pins and slots once.

    table : ndarray, shape (rounds, pattern)
        Beats [s], NaN where one is missing.
    weights : ndarray, shape (21,)
        Probability of each of `SHARES`, all of which are likely alike before the measurement.
    faults : tuple of str
        Ticks that were missed, doubled or out of place, in words.
    """

    table: FloatArray
    weights: FloatArray
    faults: tuple[str, ...] = ()

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
        return int(self.known.size)

    @cached_property
    def known(self) -> np.ndarray:
        """Indices of the measured beats in turn, shape (samples,)."""
        return np.flatnonzero(np.isfinite(self.table.ravel()))

    @cached_property
    def intervals(self) -> Intervals:
        """The measured beats as combinations of the means."""
        design = np.eye(self.pattern)[self.known % self.pattern]
        joined = np.diff(self.known) == 1
        return Intervals(self.table.ravel()[self.known], design, np.ones(self.samples), joined)

    @cached_property
    def _average(self) -> IntervalSolution:
        some = np.flatnonzero(self.weights > _NEGLIGIBLE)
        each = [self.intervals.solution(share) for share in SHARES[some].tolist()]
        return self.intervals.average(each, self.weights[some] / self.weights[some].sum())

    @property
    def means(self) -> FloatArray:
        """Best estimate of the beat of each engagement of the pattern, shape (pattern,) [s]."""
        return self._average.values

    @cached_property
    def root(self) -> FloatArray:
        """R such that R (means - true means) is independent noise of one beat's size."""
        return np.asarray(linalg.cholesky(np.linalg.inv(self._average.covariance)))

    @cached_property
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
        return self._average.scatter

    def independent(self, computed: FloatArray) -> FloatArray:
        """Measured beats less computed ones of one pattern, made independent, shape (samples,)."""
        rest = (self.table - computed).ravel()[self.known]
        return self.intervals.independent(rest, self.jitter)


def rounds_of(given: ArrayLike, wheel: Geneva, times: bool = False) -> Rounds:
    """Beats or time stamps as rounds, the last of which may end early; see `fit_beats`.

    Durations count as differences of time stamps only where they show it with certainty.
    """
    size = math.lcm(wheel.pins or 1, wheel.slots)
    values, faults = ticks_of(given, times, size)
    padded = np.full(-(-max(values.size, 1) // size) * size, np.nan)
    padded[: values.size] = values
    found = Rounds(padded.reshape(-1, size), _ALONE, faults)
    counts = np.isfinite(found.table).sum(axis=0)
    if counts.min() == 0:
        k = int(counts.argmin())
        amiss = f" ({'; '.join(faults)})" if faults else ""
        raise InvalidValue(
            f"beats must tell of all {size} engagements of the pattern, got none of pin "
            f"{k % (wheel.pins or 1)} in slot {k % wheel.slots}{amiss}; measure longer"
        )
    each = [found.intervals.solution(share) for share in SHARES.tolist()]
    gain = max(one.likelihood for one in each) - each[-1].likelihood
    if times or gain > _SURE:
        # the shares are closer to each other by their square root near 1
        return replace(found, weights=weights_of(each, _ROOTS))
    return found


def checked_wheel(mechanism: Any) -> Geneva:
    """A mechanism whose pins and slots may have errors, or InvalidValue."""
    if isinstance(mechanism, Geneva):
        return mechanism
    raise validate.fail("mechanism", "a Geneva wheel", mechanism, "see escapement.Geneva")
