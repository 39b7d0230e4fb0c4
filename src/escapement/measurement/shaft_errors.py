"""Errors that repeat with a shaft, their words, and what counts as certain.

An eccentric gear or encoder disc causes an error that repeats once a turn of its shaft, a tilted
one an error that repeats twice.
"""

import math
from typing import NamedTuple

import numpy as np

from escapement.measurement.backlash import Backlash
from escapement.measurement.normal_equations import Fitted

ORDERS = (1, 2)
"""Cycles a turn: of an eccentric disc, and of a tilted or an oval one."""
SURE = 1e-3
"""A smaller probability that noise alone causes an error counts as certainty."""
DOUBT = 1.5e-2
"""Below this probability for its whole search, a change for good or a reading far out keeps a drive
from being called good: nothing else shows them."""
DOUBT_PARTS = 2e-3
"""The same for slots and pins, whose errors show as waves too. With six waves, each at `SURE`, the
probabilities add up to 4 %: so many good drives may be doubted (benchmarks/planted_errors.py)."""
IN_95 = 1.96  # standard errors to either side of the mean, for 95 % of a normal distribution
_TELLING = 3.0  # the size of an error with fewer standard errors than this is called hidden
_LEAST = 5e-324  # it stands for a p-value that is too small for a double
UNKNOWN = (math.nan, math.nan, math.nan)
"""Size, standard error and p-value of an error that cannot be judged."""


class ShaftError(NamedTuple):
    """A sinusoidal error of one shaft, fitted together with all others that are significant.

    shaft : "input", "output", or "cell" for an error that repeats with each cell.
    order : how often the error repeats in one turn of the shaft, or in one cell.
    amplitude : amplitude of the error of that shaft's angle [rad]. An error of the input
        reaches the output multiplied by the transmission.
    standard_error : standard error of the amplitude [rad].
    p_value : probability that independent normal errors cause this amplitude or more (F test).
    turns : turns of the shaft, or cells, from the first sample to the last. If they and one mean
        step are less than 1, and there are less than two cells, the error is not judged: the
        three numbers above are NaN. A size beyond half a step of its shaft is NaN too.
    """

    shaft: str
    order: int
    amplitude: float
    standard_error: float
    p_value: float
    turns: float

    def text(self, certain: bool) -> str:
        """A sentence about this error, with "may" if it is not certain."""
        where = "cell" if self.shaft == "cell" else f"turn of the {self.shaft}"
        often = ("once", "twice")[self.order - 1]
        when = f"{'repeats' if certain else 'may repeat'} {often} a {where}"
        if math.isnan(self.amplitude):
            return f"an error {when}, of a size that cannot be told"
        size = interval(self.amplitude, self.standard_error)
        if _TELLING * self.standard_error < self.amplitude:
            return f"an error of {size} {when}"
        return f"an error {when}, but phase, offset and other errors hide its size ({size})"


def interval(size: float, error: float) -> str:
    """A size in degrees with its interval, in words."""
    size, half = math.degrees(size), math.degrees(IN_95 * error)
    return f"{size:.3g} degrees (95 % interval {size - half:.3g} to {size + half:.3g})"


def backlash_text(backlash: Backlash, certain: bool) -> str:
    """A sentence about the backlash of a shaft, with "may" if it is not certain."""
    size = interval(abs(backlash.width), backlash.standard_error)
    if backlash.width > 0.0:
        return f"the {backlash.shaft} {'has' if certain else 'may have'} a backlash of {size}"
    leads = "leads" if certain else "may lead"
    return (
        f"the {backlash.shaft} {leads} by {size} where it turns back, as if its encoder were loose"
    )


def chance(p_value: float, correlation: float) -> float:
    """The p-value of an F test, corrected for correlated noise."""
    # In the fit of a slow wave, n errors with correlation r count as n (1 - r)/(1 + r) independent
    # ones. In an F test with two degrees of freedom p is then raised to that share.
    worth = (1.0 - correlation) / (1.0 + correlation) if correlation > 0.0 else 1.0
    return float(max(p_value, _LEAST) ** worth)


def sized(fitted: Fitted, limit: float) -> tuple[float, float, float]:
    """Amplitude of a wave or width of a backlash, its standard error, and its p-value.

    A size beyond its limit is none that a shaft can have: the fit does not determine it.
    """
    size = float(np.hypot(*fitted.values)) if fitted.values.size == 2 else float(fitted.values[0])
    along = fitted.values / size
    error, p_value = math.sqrt(float(along @ fitted.covariance @ along)), math.exp(fitted.log_p)
    return (size, error, p_value) if abs(size) < limit else (math.nan, math.nan, p_value)
