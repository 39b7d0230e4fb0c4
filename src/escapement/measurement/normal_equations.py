"""Least squares on sums of products, and the test whether some columns explain errors.

The sums of offset and phase are kept for the samples behind each of many edges. So the sums of a
column that acts only behind an edge, as that of a lost step does, are known without another pass
over the samples.
"""

import math
from typing import NamedTuple

import numpy as np

from escapement.base.lazy import Lazy
from escapement.mechanisms.protocol import FloatArray

special = Lazy("scipy.special")
ERRORS, OFFSET, PHASE = 0, 1, 2
"""The first columns: what is to be explained, and what is always fitted."""
# a column that differs from all others by a smaller share is not fitted; rounding is far below
COLLINEAR = 1e-9
_UNDERFLOW = 1e-290
Indices = tuple[int, ...]
"""The columns of one error among all columns."""


class Fitted(NamedTuple):
    """Coefficients of some columns, fitted together with others.

    values : coefficients, shape (m,).
    covariance : of the coefficients, shape (m, m).
    explained : sum of squares that these columns explain beside the others.
    freedom : degrees of freedom that remain.
    variance : of the residuals.
    """

    values: FloatArray
    covariance: FloatArray
    explained: float
    freedom: int
    variance: float

    @property
    def log_p(self) -> float:
        """Logarithm of the p-value of the F test of all columns together."""
        count = self.values.size
        ratio = self.explained / (count * self.variance)
        return log_of(float(special.fdtrc(count, self.freedom, ratio)), self)


def log_of(p_value: float, fitted: Fitted) -> float:
    """Logarithm of a p-value, also where a double cannot hold the latter."""
    if p_value > _UNDERFLOW:
        return min(math.log(p_value), 0.0)
    share = fitted.explained / (fitted.freedom * fitted.variance)
    # the tail of the F distribution; exact for two columns
    return -0.5 * fitted.freedom * math.log1p(share)


class NormalEquations(NamedTuple):
    """Sums of the products of each two columns.

    gram : sums over all samples, shape (p, p).
    behind : sums of the products of offset and phase with all columns over the samples from each
        edge on, shape (k, 2, p).
    edges : samples before which they lie, ascending, shape (k,).
    samples : number of samples.
    """

    gram: FloatArray
    behind: FloatArray
    edges: np.ndarray
    samples: int

    def beside(self, others: list[Indices]) -> tuple[list[int], FloatArray]:
        """Offset, phase and some others, and the inverse of the products of these columns."""
        base = [OFFSET, PHASE, *(column for other in others for column in other)]
        square = self.gram[np.ix_(base, base)]
        return base, np.asarray(np.linalg.pinv(square, rcond=1e-12, hermitian=True), float)

    def fitted(self, chosen: Indices, others: list[Indices]) -> Fitted | None:
        """Fit of columns together with others; None if it cannot separate them."""
        base, inverse = self.beside([it for it in others if it != chosen])
        kept = [ERRORS, *chosen]
        cross = self.gram[np.ix_(base, kept)]
        left = self.gram[np.ix_(kept, kept)] - cross.T @ inverse @ cross
        square, product = left[1:, 1:], left[1:, 0]
        whole = self.gram[chosen, chosen].sum()
        if np.linalg.eigvalsh(square)[0] <= COLLINEAR * whole:
            return None
        covariance = np.asarray(np.linalg.inv(square), float)
        values = covariance @ product
        freedom = self.samples - len(base) - len(chosen)
        explained = float(values @ product)
        variance = max(float(left[0, 0]) - explained, 0.0) / freedom
        if not (variance > 0.0 and explained > 0.0):
            return None
        return Fitted(values, variance * covariance, explained, freedom, variance)

    def coefficients(self, sure: list[Indices]) -> FloatArray:
        """Fitted factor of each column, 0 for those that are not significant, shape (p,)."""
        base, inverse = self.beside(sure)
        found = np.zeros(len(self.gram))
        found[base] = inverse @ self.gram[base, ERRORS]
        return found

    def with_change(self, edge: int, column: int) -> "NormalEquations":
        """The same with one more column, equal to offset or phase behind an edge and 0 before."""
        row = self.behind[edge, column - OFFSET]
        gram = np.block([[self.gram, row[:, None]], [row, row[column]]])
        later = self.behind[np.maximum(np.arange(len(self.edges)), edge)]
        behind = np.concatenate([self.behind, later[:, :, [column]]], axis=2)
        return self._replace(gram=gram, behind=behind)
