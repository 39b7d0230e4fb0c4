"""Means over engagements that do not repeat themselves, and how certain they are."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from escapement.mechanisms.protocol import FloatArray

BATCHES = 10
"""Number of batches of engagements; the scatter of their means gives the intervals."""
_STUDENT = 2.262
"""Student's distribution with BATCHES - 1 degrees of freedom is above this with 2.5 %."""


@dataclass(frozen=True)
class BatchSpread:
    """Scatter of engagements that do not repeat.

    engagements : number of engagements over which the means are taken.
    deviation, interval : standard deviation of a figure from one engagement to the next, and
        half the interval that holds its mean with 95 %, by name, in the unit of the figure.
    """

    engagements: int
    deviation: dict[str, float]
    interval: dict[str, float]


def batch_spread(columns: Mapping[str, FloatArray], size: int = 1) -> BatchSpread:
    """The scatter of figures, each of shape (n,) with n a multiple of `BATCHES`.

    size : number of engagements that each value is a mean of.
    """
    interval = {}
    for name, column in columns.items():
        batches = column.reshape(BATCHES, -1).mean(axis=1)
        interval[name] = float(_STUDENT * batches.std(ddof=1) / math.sqrt(BATCHES))
    deviation = {name: float(column.std(ddof=1)) for name, column in columns.items()}
    return BatchSpread(size * len(next(iter(columns.values()))), deviation, interval)
