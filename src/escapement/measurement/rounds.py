"""Measured beats, sorted by their pin and slot, with the covariance of their noise.

Some of the noise may be of each beat alone, and some from the jitter of time stamps: a stamp that
comes late makes the beat before it longer and the one after it shorter. Let s be the share of the
variance of a beat that comes from the stamps at its ends. Then the correlation of neighbouring
beats is -s/2, and that of others is 0.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.text import Shown
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


class _Solution(NamedTuple):
    """Means of the beats of a pattern by least squares, for one share of jitter.

    means, covariance : shapes (pattern,) and (pattern, pattern), the latter for noise of size 1.
    scatter : sum of the squared deviations from the means, made independent.
    likelihood : logarithm of the restricted likelihood, except for a constant.
    """

    means: FloatArray
    covariance: FloatArray
    scatter: float
    likelihood: float


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
    def _solved(self) -> tuple[FloatArray, FloatArray, float]:
        """Means, the root of their information, and what is left, averaged over the shares."""
        some = np.flatnonzero(self.weights > _NEGLIGIBLE)
        weights = self.weights[some] / self.weights[some].sum()
        each = [self.solution(share) for share in SHARES[some].tolist()]
        means = np.asarray(weights @ [one.means for one in each])
        sizes = np.array([one.scatter for one in each])
        scatter, left = float(weights @ sizes), self.samples - self.pattern
        covariance = np.zeros((self.pattern, self.pattern))
        for weight, one in zip(weights.tolist(), each, strict=True):
            if scatter > 0.0:
                apart = one.means - means
                weight *= one.scatter / scatter
                covariance += weight * left / one.scatter * np.outer(apart, apart)
            covariance += weight * one.covariance
        return means, np.asarray(linalg.cholesky(np.linalg.inv(covariance))), scatter

    @property
    def means(self) -> FloatArray:
        """Best estimate of the beat of each engagement of the pattern, shape (pattern,) [s]."""
        return self._solved[0]

    @property
    def root(self) -> FloatArray:
        """R such that R (means - true means) is independent noise of one beat's size."""
        return self._solved[1]

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
        return self._solved[2]

    def _band(self, share: float) -> FloatArray:
        """Lower Cholesky factor of the covariance of noise of size 1, diagonal by diagonal."""
        band = np.ones((2, self.samples))
        band[1, :-1] = np.where(np.diff(self.known) == 1, -0.5 * share, 0.0)
        band[1, -1] = 0.0
        return np.asarray(linalg.cholesky_banded(band, lower=True))

    def solution(self, share: float) -> _Solution:
        """Least squares with one share of jitter."""
        factor = self._band(share)
        white = linalg.solve_banded((1, 0), factor, np.eye(self.pattern)[self.known % self.pattern])
        values = linalg.solve_banded((1, 0), factor, self.table.ravel()[self.known])
        basis, upper = np.linalg.qr(white)
        rest = values - basis @ (basis.T @ values)
        scatter, inverse = float(rest @ rest), np.linalg.inv(upper)
        size = np.log(factor[0]).sum() + np.log(np.abs(np.diag(upper))).sum()
        left = self.samples - self.pattern
        likelihood = -float(size) - 0.5 * left * math.log(scatter or 1e-300)
        return _Solution(inverse @ (basis.T @ values), inverse @ inverse.T, scatter, likelihood)

    def independent(self, computed: FloatArray) -> FloatArray:
        """Measured beats less computed ones of one pattern, made independent, shape (samples,)."""
        rest = (self.table - computed).ravel()[self.known]
        return np.asarray(linalg.solve_banded((1, 0), self._band(self.jitter), rest))


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
    likelihoods = np.array([found.solution(share).likelihood for share in SHARES.tolist()])
    if times or likelihoods.max() - likelihoods[-1] > _SURE:
        # the shares are closer to each other by their square root near 1
        weights = _ROOTS * np.exp(likelihoods - likelihoods.max())
        return replace(found, weights=weights / weights.sum())
    return found


def checked_wheel(mechanism: Any) -> Geneva:
    """A mechanism whose pins and slots may have errors, or InvalidValue."""
    if isinstance(mechanism, Geneva):
        return mechanism
    raise validate.fail("mechanism", "a Geneva wheel", mechanism, "see escapement.Geneva")
