"""What happens once: a change for good, as a lost step leaves it behind, and a reading far out.

A change may have happened behind any sample, and the one that explains most is tested. Let Z_k be
the standardised size of a change behind sample k. Where the greatest |Z_k| is above u, either the
first one is, or the row crosses u upwards somewhere, so

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
from escapement.measurement.normal_equations import (
    ERRORS,
    OFFSET,
    PHASE,
    Fitted,
    Indices,
    NormalEquations,
    log_of,
)
from escapement.mechanisms.protocol import FloatArray

special = Lazy("scipy.special")
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
    best = int(same[same.size // 2])
    freedom, gain = sums.samples - len(base) - 1, float(explained[best])
    left = float(sums.gram[ERRORS, ERRORS] - against @ inverse @ against) - gain
    if not (left > 0.0 and gain > 0.0):
        return None
    size, variance = square[tried[best]], left / freedom
    fitted = Fitted(product[[best]] / size, np.array([[variance / size]]), gain, freedom, variance)
    pairs = whole[tried[1:]] - np.einsum("ij,ij->i", shared[tried[:-1]], beside[tried[1:]])
    alike = pairs / np.sqrt(square[tried[:-1]] * square[tried[1:]])
    chance = len(_ACTS) * _chance_of_greatest(math.sqrt(gain / variance), freedom, alike)
    return Candidate(shaft, int(tried[best]), column, fitted, log_of(chance, fitted))


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
