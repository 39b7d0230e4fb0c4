"""Least squares for intervals between instants, with the covariance of their noise.

Some of the noise may be of each beat alone and adds up over the beats of an interval, and some may
be the jitter of the instants at its ends, which neighbouring intervals share with opposite signs:
an instant that is late makes the interval before it longer and the one after it shorter. Let s be
the share of the variance of a beat that comes from jitter. Then an interval of m beats has the
variance (1 - s) m + s, neighbours have the covariance -s/2, and others 0. Since s is not known,
results are means over s, weighted by the restricted likelihood. The covariance matrix has three
diagonals, so that the effort grows with the number of intervals only.
"""

import math
from typing import NamedTuple

import numpy as np

from escapement.base.lazy import Lazy
from escapement.mechanisms.protocol import FloatArray

linalg = Lazy("scipy.linalg")
_NEGLIGIBLE = 1e-9


class IntervalSolution(NamedTuple):
    """Unknowns by least squares, for one share of jitter or averaged over several.

    values, covariance : shapes (m,) and (m, m), the latter for noise of a beat of size 1.
    scatter : sum of the squared residuals, made independent.
    likelihood : logarithm of the restricted likelihood, except for a constant; NaN of an average.
    weights : probability of each share in an average.
    """

    values: FloatArray
    covariance: FloatArray
    scatter: float
    likelihood: float
    weights: FloatArray


class Intervals(NamedTuple):
    """Intervals that are combinations of unknowns, apart from noise.

    values : shape (n,).
    design : shape (n, m).
    numbers : beats of each, shape (n,).
    joined : whether each begins where the one before it ends, bool, shape (n - 1,).
    """

    values: FloatArray
    design: FloatArray
    numbers: np.ndarray
    joined: np.ndarray

    @property
    def freedom(self) -> int:
        """Degrees of freedom that remain."""
        return int(self.values.size - self.design.shape[1])

    def _factor(self, share: float) -> FloatArray:
        """Lower Cholesky factor of the covariance of noise of size 1, diagonal by diagonal."""
        band = np.zeros((2, self.values.size))
        band[0] = (1.0 - share) * self.numbers + share
        band[1, :-1] = -0.5 * share * self.joined
        return np.asarray(linalg.cholesky_banded(band, lower=True))

    def independent(self, rest: FloatArray, share: float) -> FloatArray:
        """Residuals, made independent."""
        return np.asarray(linalg.solve_banded((1, 0), self._factor(share), rest))

    def solution(self, share: float) -> IntervalSolution:
        """Least squares with one share of jitter."""
        factor = self._factor(share)
        columns = np.column_stack([self.design, self.values])
        white = linalg.solve_banded((1, 0), factor, columns)
        basis, upper = np.linalg.qr(white[:, :-1])
        along = basis.T @ white[:, -1]
        rest = white[:, -1] - basis @ along
        scatter, inverse = float(rest @ rest), np.linalg.inv(upper)
        size = np.log(factor[0]).sum() + np.log(np.abs(np.diag(upper))).sum()
        likelihood = -float(size) - 0.5 * self.freedom * math.log(scatter or 1e-300)
        return IntervalSolution(
            inverse @ along, inverse @ inverse.T, scatter, likelihood, np.ones(1)
        )

    def average(
        self, shares: FloatArray, before: FloatArray | float = 1.0, gain: float = 0.0
    ) -> IntervalSolution:
        """The mean of the solutions with some shares, the last of which is 0.

        before : probabilities of the shares before the measurement.
        gain : of log-likelihood, that any share has to give over 0; else that share counts alone.
        """
        each = [self.solution(share) for share in shares.tolist()]
        likelihoods = np.array([one.likelihood for one in each])
        weights = before * np.exp(likelihoods - likelihoods.max())
        if gain and likelihoods.max() - likelihoods[-1] <= gain:
            weights = np.where(shares == 0.0, 1.0, 0.0)
        weights = np.where(weights > _NEGLIGIBLE * weights.sum(), weights, 0.0)
        weights /= weights.sum()
        values = np.asarray(weights @ [one.values for one in each])
        scatter = float(weights @ [one.scatter for one in each])
        covariance = np.zeros((values.size, values.size))
        for weight, one in zip(weights.tolist(), each, strict=True):
            size = one.scatter / scatter if scatter > 0.0 else 1.0
            covariance += weight * size * one.covariance
            if scatter > 0.0:
                apart = one.values - values
                covariance += weight * self.freedom / scatter * np.outer(apart, apart)
        return IntervalSolution(values, covariance, scatter, math.nan, weights)
