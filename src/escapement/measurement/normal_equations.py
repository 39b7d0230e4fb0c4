"""Least squares on sums of products: some columns, a change for good, or a reading far out.

The sums of offset and phase are kept for the samples behind each of many edges. So the sums of a
column that acts only behind an edge, as that of a lost step does, are known without another pass
over the samples.

Such a change may have happened behind any sample, and the one that explains most is tested. Let Z_k
be the standardised size of a change behind sample k. Where the greatest |Z_k| is above u, either
the first one is, or the row crosses u upwards somewhere, so

    P(max |Z_k| > u) <= 2 Q(u) + 2 sum P(Z_k <= u < Z_k+1),   P(..) = 2 T(u, sqrt((1 - r)/(1 + r))),

with the upper tail Q of the normal distribution, Owen's function T and the correlation r of
neighbours, which follows from the fit.

A single reading is judged by its error over the standard deviation of the others (Rosner 1983): the
greatest is tested, then the greatest of the rest, and so on, so that some do not hide others.
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


_ACTS = {"input": PHASE, "output": OFFSET}  # a change of a shaft acts as this column does
_LEAST = 5  # samples on either side; fewer of them are single readings far out
_OPPOSITE = -0.999  # beyond it T hardly depends on the correlation
_MOST = 0.01  # if more readings than this share are far out, the errors are just not normal
_FEWEST = 3  # but so many are always tried
_SEPARATE = 1e-6  # a change that others explain except for such a share is not tried


class Candidate(NamedTuple):
    """The change that explains most.

    shaft : "input" or "output", whose slip would cause it.
    edge : index of the edge behind which it acts.
    column : the column that it repeats behind this edge.
    fitted : its size, and what it explains.
    log_p : logarithm of the p-value of the greatest of all changes.
    """

    shaft: str
    edge: int
    column: int
    fitted: Fitted
    log_p: float


def best_change(sums: NormalEquations, others: list[Indices]) -> Candidate | None:
    """The most significant change beside others, None where none can be separated from them."""
    known = [one for shaft in _ACTS if (one := _best_of(sums, others, shaft)) is not None]
    return min(known, key=lambda one: one.log_p, default=None)


def _best_of(sums: NormalEquations, others: list[Indices], shaft: str) -> Candidate | None:
    """The most significant change of one shaft."""
    column = _ACTS[shaft]
    base, inverse = sums.beside(others)
    rows = sums.behind[:, column - OFFSET]
    whole, beside = rows[:, column], rows[:, base]
    shared = beside @ inverse
    square = whole - (shared * beside).sum(axis=1)
    inside = (sums.edges >= _LEAST) & (sums.edges <= sums.samples - _LEAST)
    tried = np.flatnonzero(inside & (square > _SEPARATE * whole[0]))
    if not tried.size:
        return None
    against = sums.gram[base, ERRORS]
    product = rows[tried, ERRORS] - shared[tried] @ against
    explained = product**2 / square[tried]
    # a slip of the input does not show in the dwell, so there it may have happened anywhere
    same = np.flatnonzero(explained >= (1.0 - _SEPARATE) * explained.max())
    edge = int(tried[same[same.size // 2]])
    fitted = sums.with_change(edge, column).fitted((len(sums.gram),), others)
    if fitted is None:
        return None
    pairs = whole[tried[1:]] - np.einsum("ij,ij->i", shared[tried[:-1]], beside[tried[1:]])
    alike = pairs / np.sqrt(square[tried[:-1]] * square[tried[1:]])
    height = math.sqrt(fitted.explained / fitted.variance)
    chance = len(_ACTS) * _chance_of_greatest(height, fitted.freedom, alike)
    return Candidate(shaft, edge, column, fitted, log_of(chance, fitted))


def _chance_of_greatest(height: float, freedom: int, alike: FloatArray) -> float:
    """Probability that the greatest |Z| is above a value of Student's t."""
    tail = float(special.stdtr(freedom, -height))
    level = -float(special.ndtri(tail)) if tail > 0.0 else math.inf
    if math.isinf(level):
        return 0.0
    near = np.clip(alike, _OPPOSITE, 1.0)  # rounding may lead a little beyond 1
    apart = np.sqrt((1.0 - near) / (1.0 + near))
    return 2.0 * (tail + 2.0 * float(special.owens_t(level, apart).sum()))


def far_out(errors: FloatArray, level: float) -> tuple[np.ndarray, FloatArray]:
    """Samples that are far out, and the p-value of each.

    Parameters
    ----------
    errors : ndarray, shape (n,)
        Independent errors of equal variance about zero.
    level : float
        Samples with a p-value below this are far out.

    Source: B. Rosner, Percentage points for a generalized ESD many-outlier procedure, 1983.
    """
    n = errors.size
    most = max(_FEWEST, int(_MOST * n))
    order = np.argpartition(np.abs(errors), n - most)[n - most :]
    order = order[np.argsort(-np.abs(errors[order]))]
    squares = errors[order] ** 2
    # the squares of the others, with ever more of the greatest left out
    inner = float(errors @ errors) - np.cumsum(squares)
    left = n - 1 - np.arange(most)
    known = inner > 0.0
    ratio = np.sqrt(squares[known] * left[known] / inner[known])
    p_values = np.minimum(2.0 * (left[known] + 1) * special.stdtr(left[known], -ratio), 1.0)
    last = np.flatnonzero(p_values < level)
    count = int(last[-1]) + 1 if last.size else 0
    return order[:count], p_values[:count]
