"""A change for good, as a lost step or a slipped coupling leaves it behind.

A change may have happened behind any sample, and the one that explains most is tested. Let Z_k be
the standardised size of a change behind sample k. Where the greatest |Z_k| is above u, either the
first one is, or the row crosses u upwards somewhere, so

    P(max |Z_k| > u) <= 2 Q(u) + 2 sum P(Z_k <= u < Z_k+1),   P(..) = 2 T(u, sqrt((1 - r)/(1 + r))),

with the upper tail Q of the normal distribution, Owen's function T and the correlation r of
neighbours, which follows from the fit.
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
_SEPARATE = 1e-6  # a change that others explain except for such a share is not tried


class Change(NamedTuple):
    """A change of the errors that lasts to the last sample.

    shaft : "input" or "output", whose slip would cause it.
    line : line of the last sample before it.
    size : angle by which this shaft seems to have slipped [rad].
    standard_error : standard error of the size [rad].
    p_value : probability that independent normal errors show such a change behind any sample.
    """

    shaft: str
    line: int
    size: float
    standard_error: float
    p_value: float


class Candidate(NamedTuple):
    """The change that explains most.

    edge : index of the edge behind which it acts.
    column : the column that it repeats behind this edge.
    log_p : logarithm of its p-value.
    size, standard_error : as those of a `Change` [rad].
    explained : sum of squares that it explains.
    variance : of what it leaves.
    """

    shaft: str
    edge: int
    column: int
    log_p: float
    size: float
    standard_error: float
    explained: float
    variance: float


def best_change(sums: NormalEquations, others: list[Indices]) -> Candidate | None:
    """The most significant change beside others, None where none can be separated from them."""
    found = [_best_of(sums, others, shaft) for shaft in _ACTS]
    known = [one for one in found if one is not None]
    return min(known, key=lambda one: one.log_p, default=None)


def _best_of(sums: NormalEquations, others: list[Indices], shaft: str) -> Candidate | None:
    """The most significant change of one shaft."""
    factors = _ACTS[shaft]
    base, inverse = sums.beside(others)
    rows, whole = sums.behind[:, factors, :], sums.behind[:, factors, factors]
    shared = rows[:, base] @ inverse
    square = whole - (shared * rows[:, base]).sum(axis=1)
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
    freedom = sums.samples - len(base) - 1
    left = float(sums.gram[ERRORS, ERRORS] - against @ inverse @ against) - explained[best]
    if not (left > 0.0 and explained[best] > 0.0):
        return None
    behind = rows[tried[1:]][:, base]
    pairs = whole[tried[1:]] - np.einsum("ij,ij->i", shared[tried[:-1]], behind)
    alike = pairs / np.sqrt(square[tried[:-1]] * square[tried[1:]])
    fitted = Fitted(np.zeros(1), np.zeros((1, 1)), float(explained[best]), freedom, left / freedom)
    height = math.sqrt(explained[best] * freedom / left)
    log_p = log_of(len(_ACTS) * _chance_of_greatest(height, freedom, alike), fitted)
    at, log_p = int(tried[best]), min(log_p, 0.0)
    size, error = float(product[best] / square[at]), math.sqrt(fitted.variance / square[at])
    return Candidate(
        shaft=shaft, edge=at, column=factors, log_p=log_p, size=size, standard_error=error,
        explained=fitted.explained, variance=fitted.variance,
    )  # fmt: skip


def _chance_of_greatest(height: float, freedom: int, alike: FloatArray) -> float:
    """Probability that the greatest |Z| is above a value of Student's t."""
    tail = float(special.stdtr(freedom, -height))
    level = -float(special.ndtri(tail)) if tail > 0.0 else math.inf
    if math.isinf(level):
        return 0.0
    near = np.clip(alike, _OPPOSITE, 1.0)  # rounding may lead a little beyond 1
    apart = np.sqrt((1.0 - near) / (1.0 + near))
    return 2.0 * (tail + 2.0 * float(special.owens_t(level, apart).sum()))
