"""Sobol' indices: the share of a figure's variance due to a tolerance, alone and with others.

Of n cases in A and n in B, drawn independently, A_B^i is A with number i from B. The first index
is the share of i alone, the total index the share of all effects in which i takes part. SciPy
computes them and their intervals, by resampling the cases with replacement.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from escapement.base import validate
from escapement.mechanisms.protocol import FloatArray
from escapement.tolerance.intervals import LEVEL, Estimate

RESAMPLES = 999
"""Number of resamples for an interval."""


def sobol_indices(
    evaluate: Callable[[FloatArray], FloatArray], count: int, size: int, seed: int
) -> tuple[list[Estimate], list[Estimate]]:
    """First and total indices of each number.

    Parameters
    ----------
    evaluate : callable
        A figure at shares of the numbers, shape (count, cases), between 0 and 1.
    count, size : int
        Numbers, and cases n in A; (count + 2) n cases are evaluated.
    seed : int
        For the cases and the resamples.
    """
    from scipy.stats import bootstrap

    if size & (size - 1):
        near = 1 << (size.bit_length() - 1)
        raise validate.fail("indices", "0 or a power of 2", size, f"give {near} or {2 * near}")
    if count == 1:
        return [Estimate(1.0, 1.0, 1.0)], [Estimate(1.0, 1.0, 1.0)]
    random = np.random.default_rng(seed)
    a, b = random.random((2, count, size))
    mixed = np.stack([np.where(np.arange(count)[:, None] == i, b, a) for i in range(count)])
    every = np.concatenate([a, b, *mixed], axis=1)
    values = evaluate(every).reshape(count + 2, size)
    # a common offset cancels, and would only lose digits
    values = values - values[:2].mean()
    drawn = bootstrap(
        [np.arange(size)],
        lambda cases: _indices(values[..., cases]),
        n_resamples=RESAMPLES,
        confidence_level=LEVEL,
        random_state=random,
    ).confidence_interval
    first, total = (
        [Estimate(*row) for row in np.transpose(rows).tolist()]
        for rows in zip(_indices(values), drawn.low, drawn.high, strict=True)
    )
    return first, total


def _indices(values: FloatArray) -> FloatArray:
    """First and total indices, shape (2, count), of values at A, at B and at each A_B^i.

    Source: Saltelli et al., Computer Physics Communications 181 (2010), table 2 (b) and (f).
    """
    a, b, *mixed = values
    steps = np.array(mixed) - a
    variance = values[:2].var()
    first = (b * steps).mean(axis=-1) / variance
    return np.array([first, 0.5 * (steps**2).mean(axis=-1) / variance])
