"""What a fit says: estimates with their intervals, or why they are not known, and a verdict.

Every fit of a model is least squares for residuals whose noise is independent, so its intervals
come from the `Tangent` at its solution, and its tests are F tests.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np

from escapement.base import spoken, validate
from escapement.base.lazy import Lazy
from escapement.base.records import in_units
from escapement.base.text import Shown, words
from escapement.base.units import factor, printed
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.study.plan import unit_kind

special = Lazy("scipy.special")
SURE = 1e-3
"""A smaller probability that noise alone causes what was found counts as certainty."""
_ALIKE = 0.05  # a smaller correlation of neighbouring residuals hardly changes an interval


class Estimate(NamedTuple):
    """A number that a fit has found.

    name : what it is.
    value, half_width : estimate, and half the width of its confidence interval; NaN where the
        measurement does not determine it.
    doubt : why it does not, "" if it does.
    least, most : its physical range, in which the interval ends.
    """

    name: str
    value: float
    half_width: float
    doubt: str = ""
    least: float = -math.inf
    most: float = math.inf

    @property
    def low(self) -> float:
        """Lower end of the interval."""
        return max(self.value - self.half_width, self.least)

    @property
    def high(self) -> float:
        """Upper end of the interval."""
        return min(self.value + self.half_width, self.most)

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


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Fit(Shown):
    """The model of an escapement that is nearest to what was measured.

    Attributes
    ----------
    escapement : Escapement
        The given escapement with the numbers that were found.
    numbers : tuple of Estimate
        Each with its interval [SI].
    confidence : float
        Confidence level of the intervals [-].
    residuals : ndarray, shape (n,)
        What was measured less what is computed.
    noise : float
        Standard deviation of one measurement.
    p_value : float
        Probability that noise alone leaves such residuals; NaN if this cannot be judged.
    autocorrelation : float
        Correlation of each residual, made independent, with the next one [-].
    of_beats : bool
        Whether beats were measured.
    doubt : str
        Why the measurement cannot say whether the model explains it, "" if it can.
    message : str
        What a user of these numbers must know, "" if there is nothing.
    """

    escapement: Escapement
    numbers: tuple[Estimate, ...]
    confidence: float
    residuals: FloatArray = field(repr=False)
    noise: float
    p_value: float
    autocorrelation: float
    of_beats: bool
    doubt: str
    message: str = ""

    _model: ClassVar[str] = "The model"
    """What explains the measurement, or does not."""

    @property
    def values(self) -> FloatArray:
        """Estimates in SI units, shape (m,)."""
        return np.array([one.value for one in self.numbers])

    @property
    def half_widths(self) -> FloatArray:
        """Half the widths of their intervals in SI units, shape (m,)."""
        return np.array([one.half_width for one in self.numbers])

    @property
    def contradictions(self) -> tuple[str, ...]:
        """What in the residuals independent noise does not cause, and what follows."""
        count, found = int(np.isfinite(self.residuals).sum()), []
        if self.p_value < SURE:
            found.append(
                f"noise does not leave such residuals (p {self.p_value:.1g}), so something besides "
                "these numbers differs from the design, for example a length or the start"
            )
        # independent noise has a greater correlation once in a thousand times
        if abs(self.autocorrelation) > max(3.3 / math.sqrt(count), _ALIKE):
            found.append(
                f"neighbouring residuals are alike (correlation {self.autocorrelation:.2f}), so "
                "the intervals are too narrow"
            )
        return tuple(found)

    @property
    def verdict(self) -> Verdict:
        """Whether the model explains what was measured, and the numbers with their intervals."""
        numbers, what = self.numbers_in_words(), "beats" if self.of_beats else "motion"
        if wrong := "; ".join(self.contradictions):
            not_even = numbers and f", not even{numbers}"
            return Verdict(False, f"{self._model} does not explain the {what}{not_even}: {wrong}.")
        if self.doubt:
            model = self._model[0].lower() + self._model[1:]
            return Verdict(None, f"Cannot say whether {model} explains the {what}: {self.doubt}.")
        return Verdict(True, f"{self._model} explains the {what}{numbers}.")

    def numbers_in_words(self) -> str:
        """The word "with" and the fitted numbers; "" if there are none."""
        parts = []
        for one in self.numbers:
            kind = unit_kind(one.name)
            unit = factor(kind, spoken.spoken())
            parts.append(
                f"{words(one.name)} {one.value / unit:.4g} ({100.0 * self.confidence:g} % interval "
                f"{one.low / unit:.4g} to {spoken.as_spoken(one.high, kind, 4)})"
            )
        return f" with {' and '.join(parts)}; all other numbers are as given" if parts else ""

    def record(self, units: str) -> dict[str, Any]:
        """Fitted numbers with their intervals, by name, in the user's units."""
        record = {}
        for one in self.numbers:
            kind = unit_kind(one.name)
            value, *ends = in_units([one.value, one.low, one.high], kind, units)
            record[one.name] = {"value": value, "interval": ends, "unit": printed(kind, units)}
        return record


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


def chance_of(rest: FloatArray, slopes: FloatArray, waves: FloatArray) -> float:
    """Probability that independent noise looks as much like some waves; NaN if unknown.

    An F test beyond what the unknowns could have fitted. `slopes` and `waves` have a column for
    each, of shapes (n, m) and (n, k).
    """
    lengths = np.linalg.norm(slopes, axis=0)
    fitted, _ = np.linalg.qr(slopes / np.where(lengths > 0.0, lengths, 1.0))
    basis, sizes, _ = np.linalg.svd(waves - fitted @ (fitted.T @ waves), full_matrices=False)
    basis = basis[:, sizes > 1e-6 * math.sqrt(rest.size)]
    rest = rest - fitted @ (fitted.T @ rest)
    explained, count = float(np.sum((basis.T @ rest) ** 2)), basis.shape[1]
    freedom = rest.size - slopes.shape[1] - count
    return f_test(explained, count, float(rest @ rest) - explained, freedom)


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
