"""Estimates from a sample, each with its 95 % interval.

The interval of a moment comes from the scatter of its influence values: for a statistic T they
are the first-order contributions of each case, so that their standard deviation over sqrt(n) is
the standard error of T for every distribution. That of a share is Clopper and Pearson's, that of
a quantile counts the cases below it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from escapement.mechanisms.protocol import FloatArray

LEVEL = 0.95
"""Confidence of every interval."""
Influence = tuple[float, FloatArray]
"""A statistic of a sample, and the influence of each case."""


class Estimate(NamedTuple):
    """A value with its 95 % interval."""

    value: float
    low: float
    high: float


def per_cent(share: Estimate) -> str:
    """The interval of a share in per cent: "67.6 to 69.0"."""
    return f"{100.0 * share.low:.1f} to {100.0 * share.high:.1f}"


def mean(values: FloatArray) -> Influence:
    """The mean."""
    return float(values.mean()), values - values.mean()


def deviation(values: FloatArray) -> Influence:
    """The standard deviation."""
    deviations = values - values.mean()
    size = float(np.sqrt((deviations**2).mean()))
    return size, (deviations**2 - size**2) / (2.0 * size) if size else 0.0 * deviations


def capability(values: FloatArray, low: float, high: float) -> Influence:
    """C_pk: distance of the mean from the nearer limit over three standard deviations."""
    (middle, middle_gradient), (size, spread) = mean(values), deviation(values)
    if not size:
        return math.nan, middle_gradient
    room, sense = min((middle - low, 1.0), (high - middle, -1.0))
    value = room / (3.0 * size)
    return value, (sense * middle_gradient - 3.0 * value * spread) / (3.0 * size)


def estimate(statistic: Callable[[FloatArray], Influence], values: FloatArray) -> Estimate:
    """A statistic of a sample of independent cases."""
    from scipy.special import ndtri

    value, influence = statistic(values)
    half = float(ndtri(0.5 + 0.5 * LEVEL) * influence.std() / math.sqrt(values.size))
    return Estimate(value, value - half, value + half)


def share(inside: Any) -> Estimate:
    """The share of cases for which something is true."""
    from scipy.stats import binomtest

    found = np.asarray(inside)
    test = binomtest(int(found.sum()), found.size)
    interval = test.proportion_ci(LEVEL, method="exact")
    return Estimate(float(found.mean()), float(interval.low), float(interval.high))


def quantile(values: FloatArray, level: float) -> Estimate:
    """The value below which a share of the cases lies."""
    from scipy.stats import binom

    ordered, n = np.sort(values), values.size
    value = float(np.quantile(values, level))
    tail = 0.5 * (1.0 - LEVEL)
    low, high = (int(binom.ppf(p, n, level)) for p in (tail, 1.0 - tail))
    ends = ordered[max(low - 1, 0)], ordered[min(high, n - 1)]
    return Estimate(value, float(ends[0]), float(ends[1]))
