"""What a fit says of a number: its value, its interval, and why it may not be known."""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from escapement.base import validate
from escapement.base.lazy import Lazy
from escapement.mechanisms.protocol import FloatArray

special = Lazy("scipy.special")
SURE = 1e-3
"""A smaller probability that noise alone causes what was found counts as certainty."""


class Estimate(NamedTuple):
    """A number that a fit has found.

    name : what it is.
    value, half_width : estimate, and half the width of its confidence interval; NaN where the
        measurement does not determine it.
    doubt : why it does not, "" if it does.
    """

    name: str
    value: float
    half_width: float
    doubt: str = ""

    @property
    def low(self) -> float:
        """Lower end of the interval."""
        return self.value - self.half_width

    @property
    def high(self) -> float:
        """Upper end of the interval."""
        return self.value + self.half_width

    def doubted(self, doubt: str) -> "Estimate":
        """The same without a value, for one more reason."""
        reasons = "; ".join(filter(None, (self.doubt, doubt)))
        return Estimate(self.name, math.nan, math.nan, reasons)


def between(name: str, low: float, high: float) -> Estimate:
    """The middle of an interval and half its width."""
    return Estimate(name, 0.5 * (low + high), 0.5 * (high - low))


def spanned(same: Iterable[Estimate]) -> Estimate:
    """The smallest interval that contains those of several estimates of one number."""
    every = [*same]
    doubts = dict.fromkeys(one.doubt for one in every if one.doubt)
    low, high = min(one.low for one in every), max(one.high for one in every)
    found = between(every[0].name, low, high)
    return found.doubted("; ".join(doubts)) if doubts else found


def reach_of(confidence: float, freedom: float) -> float:
    """Half the width of an interval, in standard deviations, by Student's distribution [-].

    With infinite degrees of freedom, where the noise is known, it is the normal one.
    """
    return float(special.stdtrit(freedom, 0.5 + 0.5 * confidence))


def interval_root(slopes: FloatArray, noise: float, reach: float) -> FloatArray:
    """Matrix A such that the interval of c . unknowns has the half width |c A|.

    Parameters
    ----------
    slopes : ndarray, shape (n, m)
        Derivatives of the residuals, whose noise is independent, by the unknowns at the solution.
    noise : float
        Standard deviation of a residual.
    reach : float
        Half the width of an interval, in standard deviations.
    """
    return np.asarray(reach * noise * np.linalg.pinv(slopes))


def correlation(residuals: FloatArray) -> float:
    """Correlation of each residual with the next one, 0 where there are none [-]."""
    square = float(residuals @ residuals)
    return float(residuals[1:] @ residuals[:-1]) / square if square > 0.0 else 0.0


def checked_confidence(confidence: float) -> float:
    """The level of intervals, or InvalidValue."""
    share = validate.number("confidence", confidence, remedy := "give a share, as 0.95")
    if not 0.0 < share < 1.0:
        raise validate.fail("confidence", "between 0 and 1", confidence, remedy)
    return share
