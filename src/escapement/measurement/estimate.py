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

    def doubted(self, *doubts: str) -> "Estimate":
        """The same without a value, for more reasons; unchanged if there are none."""
        reasons = "; ".join(dict.fromkeys(filter(None, (self.doubt, *doubts))))
        return Estimate(self.name, math.nan, math.nan, reasons) if reasons else self


def spanned(same: Iterable[Estimate]) -> Estimate:
    """The smallest interval that contains those of several estimates of one number."""
    every = [*same]
    low, high = min(one.low for one in every), max(one.high for one in every)
    found = Estimate(every[0].name, 0.5 * (low + high), 0.5 * (high - low))
    return found.doubted(*(one.doubt for one in every))


class Verdict(NamedTuple):
    """Whether a mechanism is good, or a model is right, as far as a measurement shows.

    good : True if the tests that would contradict it were possible and passed, False if the
        measurement contradicts it, None if it cannot say.
    text : one or two sentences that say what is wrong, and where, or why it cannot be said.
    """

    good: bool | None
    text: str


def reach_of(confidence: float, freedom: float) -> float:
    """Half the width of an interval, in standard deviations, by Student's distribution [-].

    With infinite degrees of freedom, where the noise is known, it is the normal one.
    """
    return float(special.stdtrit(freedom, 0.5 + 0.5 * confidence))


class Tangent(NamedTuple):
    """A fit linearised at its solution.

    noise : standard deviation of a residual.
    unit : half the width of an interval of a number of that noise.
    root : matrix A such that the interval of c . unknowns has the half width |c A|.
    """

    noise: float
    unit: float
    root: FloatArray


def tangent_of(
    slopes: FloatArray, squares: float, freedom: float, confidence: float, noise: float = 0.0
) -> Tangent:
    """The tangent of a fit.

    Parameters
    ----------
    slopes : ndarray, shape (n, m)
        Derivatives of the residuals, whose noise is independent, by the unknowns at the solution.
    squares, freedom : float
        Sum of the squared residuals, and their degrees of freedom.
    confidence : float
        Confidence level of intervals.
    noise : float
        Standard deviation of a residual if it is known, else 0.
    """
    sigma = noise or math.sqrt(squares / freedom)
    unit = reach_of(confidence, math.inf if noise else freedom) * sigma
    return Tangent(sigma, unit, np.asarray(unit * np.linalg.pinv(slopes)))


def f_test(explained: float, count: int, left: float, freedom: int) -> float:
    """p-value of a sum of squares beside what is left, NaN where there is no noise [-]."""
    if not (count > 0 and freedom > 0 and left > 0.0):
        return math.nan
    return float(special.fdtrc(count, freedom, explained / count * freedom / left))


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
