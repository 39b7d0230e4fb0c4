"""Fit of a simulated motion to a measured run-up.

The readings give the driver angle over time, from rest at pin entry. A motion depends on torques
and inertias only through their ratios, so at least one of them must be known.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.measurement.estimate import (
    Verdict,
    checked_confidence,
    correlation,
    tangent_of,
)
from escapement.measurement.fitted_numbers import (
    Told,
    chance_of,
    check_determined,
    contradicted,
    numbers_in_words,
)
from escapement.measurement.motion_task import INEFFECTIVE, MotionTask, is_share, task_of
from escapement.measurement.readings import Readings
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

optimize = Lazy("scipy.optimize")
_TOLERANCES = {"xtol": 1e-9, "ftol": 1e-12, "gtol": 1e-12, "max_nfev": 60}
_SLOW = 6  # slow changes that are looked for have up to so many half waves
_EXACT = 1e-8  # a scatter below this share of the travel is rounding, and is no evidence
_DEGREE = 3  # of the smooth curve
_ODDS = 1000.0  # the model must be so much more likely than the smooth curve
_LEAST = 12  # degrees of freedom that the tests need


@dataclass(frozen=True, eq=False, repr=False)
class MotionFit(Shown):
    """The simulated motion that is nearest to a measured one.

    Attributes
    ----------
    escapement : Escapement
        The given escapement with the fitted numbers.
    parameters : tuple of str
        Names of the numbers that were fitted; all others keep their given values.
    values, half_widths : ndarray, shape (m,)
        Estimates, and half the widths of their confidence intervals, in SI units. `intervals`
        end where a number would leave its physical range.
    confidence : float
        Confidence level of the intervals [-].
    start : float
        Time of the release from rest [s].
    time, residuals : ndarray, shape (n,)
        Times of the samples that were used [s], and measured less computed driver angle [rad].
    noise : float
        Standard deviation of the residuals [rad].
    mid_time, speeds, computed_speeds : ndarray, shape (k,)
        Middle of each interval between two samples of different times [s], and the mean driver
        speed in it, measured and computed [rad/s].
    autocorrelation : float
        Correlation of each residual with the next one [-].
    p_value : float
        Probability that independent noise alone leaves residuals with as much slow change, or
        change that repeats with the engagements; NaN if this cannot be judged.
    doubt : str
        Why the readings cannot say whether the model explains them, "" if they can.
    message : str
        What a user of these numbers must know, "" if there is nothing.
    """

    escapement: Escapement
    parameters: tuple[str, ...]
    values: FloatArray
    half_widths: FloatArray
    confidence: float
    start: float
    time: FloatArray = field(repr=False)
    residuals: FloatArray = field(repr=False)
    noise: float
    mid_time: FloatArray = field(repr=False)
    speeds: FloatArray = field(repr=False)
    computed_speeds: FloatArray = field(repr=False)
    autocorrelation: float
    p_value: float
    doubt: str
    message: str

    @property
    def intervals(self) -> FloatArray:
        """Ends of the confidence intervals within the physical range, shape (m, 2)."""
        ends = np.column_stack([self.values - self.half_widths, self.values + self.half_widths])
        most = [1.0 if is_share(name) else math.inf for name in self.parameters]
        return np.clip(ends, 0.0, np.array(most)[:, None])

    @property
    def told(self) -> list[Told]:
        """The fitted numbers with their intervals."""
        return [*map(Told, self.parameters, self.values.tolist(), *self.intervals.T.tolist())]

    @property
    def contradicted(self) -> bool:
        """Whether the residuals have what independent noise does not have."""
        return contradicted(self.p_value, self.autocorrelation, self.residuals.size)

    @property
    def explained(self) -> bool:
        """Whether the model explains the motion: the readings could contradict it and do not."""
        return not (self.contradicted or self.doubt)

    @property
    def verdict(self) -> Verdict:
        """Whether the model explains the motion, and the estimates with their intervals."""
        text = numbers_in_words(self.told, self.confidence)
        if self.contradicted:
            text = text and f", not even{text}"
            return Verdict(False, f"The model does not explain the motion{text}.")
        if self.doubt:
            return Verdict(None, f"Cannot say whether the model explains the motion: {self.doubt}.")
        return Verdict(True, f"The model explains the motion{text}.")


def fit_motion(
    readings: Readings,
    escapement: Escapement,
    parameters: Sequence[str] = ("friction", "torque"),
    *,
    confidence: float = 0.95,
) -> MotionFit:
    """Fit numbers of an escapement to a measured run-up.

    Parameters
    ----------
    readings : Readings
        Times and angles of the input; the angles of the output are not used. The driver stands at
        pin entry until it is released, at the first sample or later.
    escapement : Escapement
        The design. The search begins at its values of `parameters`, which must be above 0, and
        keeps all its other numbers.
    parameters : sequence of str
        Names of the numbers to be fitted, as in a study: "friction", "torque", "driver_inertia",
        .. If it is empty, the given escapement is compared with the readings.
    confidence : float
        Confidence level of the intervals, in (0, 1) [-].

    Returns
    -------
    MotionFit
        The estimates, their intervals and the residuals.

    Raises
    ------
    InvalidValue
        If an argument breaks its rule, the escapement does not run, its motion takes more than
        ten times or less than a tenth of the measured time, or the motion depends only on a
        combination of the numbers, as it does on the ratio of torque and inertia.

    Notes
    -----
    The fit minimises the sum of the squared residuals of the driver angle; the time of the release
    and the zero of the encoder are unknowns too. The intervals come from the fit linearised at its
    solution, for normal noise that is independent from sample to sample.

    The model does not explain the motion if neighbouring residuals are alike, or if they change
    slowly or with the engagements by more than noise does in one of a thousand recordings. The
    readings cannot say so, and nor the contrary, if a cubic curve explains them about as well.
    """
    task = task_of(readings, escapement, tuple(parameters))
    share = checked_confidence(confidence)
    found = optimize.least_squares(
        task.residuals, task.begin(), task.slopes, bounds=task.bounds, x_scale="jac", **_TOLERANCES
    )
    check_determined(found.jac, task.parameters, INEFFECTIVE)
    angle, start = np.asarray(task.state(found.x).theta), float(found.x[-1]) * task.span
    known = tangent_of(found.jac, 2.0 * found.cost, task.time.size - found.x.size - 1, share)
    apart = np.diff(task.time) > 0.0
    speeds, computed = (
        np.diff(one)[apart] / np.diff(task.time)[apart] for one in (task.angle, angle)
    )
    alike, p_value, doubt = _judged(task, found.fun, found.jac, angle, start)
    fit = MotionFit(
        escapement=task.changed(found.x), parameters=task.parameters,
        values=found.x[:-1] * task.given,
        half_widths=np.linalg.norm(known.root[:-1], axis=1) * task.given, confidence=share,
        start=task.clock + start, time=task.clock + task.time, residuals=found.fun,
        noise=known.noise,
        mid_time=task.clock + 0.5 * (task.time[1:] + task.time[:-1])[apart],
        speeds=speeds, computed_speeds=computed,
        autocorrelation=alike, p_value=p_value, doubt=doubt, message="",
    )  # fmt: skip
    vars(fit)["message"] = "; ".join(_remarks(fit, readings))
    return fit


def _remarks(fit: MotionFit, readings: Readings) -> Iterator[str]:
    if readings.synthetic:
        yield "these are synthetic data, computed and not measured"
    if readings.remark:
        yield readings.remark
    for name, value, half in zip(fit.parameters, fit.values, fit.half_widths, strict=True):
        if half > 0.5 * value:
            yield (
                f"the readings hardly determine {name}: its interval is wider than its value; "
                "measure longer"
            )
    if fit.contradicted:
        yield (
            f"the residuals are not independent noise (correlation of neighbours "
            f"{fit.autocorrelation:.2f}, p of slow or repeated changes {fit.p_value:.1g}): the "
            "model does not explain the motion, and the intervals are too narrow"
        )


def _judged(
    task: MotionTask, rest: FloatArray, slopes: FloatArray, angle: FloatArray, start: float
) -> tuple[float, float, str]:
    """Correlation of residuals, their p-value, and why they cannot say whether a model holds."""
    if np.abs(rest).max() <= _EXACT * np.ptp(task.angle):
        return 0.0, math.nan, ""
    moving, doubt = task.time > start, ""
    chance = _chance(rest, slopes, angle / task.escapement.mechanism.cell_angle)
    if math.isnan(chance):
        doubt = f"{rest.size} samples are too few to test it; take more samples"
    elif _smooth_as_well(task.time[moving], task.angle[moving], rest[moving]):
        doubt = (
            "a smooth curve explains the readings about as well, so that they do not show the "
            "engagements; take more samples, over more engagements, with less noise"
        )
    return correlation(rest), chance, doubt


def _chance(rest: FloatArray, slopes: FloatArray, cells: FloatArray) -> float:
    """Probability that independent noise leaves as much slow or repeated change; NaN if unknown.

    An F test of half waves over the recording, and of one and two waves over a cell, beyond what
    the unknowns and the zero of the encoder could have fitted. `cells` is the driver angle in cells
    of the mechanism.
    """
    size, unknowns = rest.size, slopes.shape[1] + 1
    if size - unknowns < _LEAST:
        return math.nan
    halves = np.pi * (np.arange(size) + 0.5) / size
    slow = [np.cos(k * halves) for k in range(1, _SLOW + 1)]
    repeated = [wave(2.0 * np.pi * k * cells) for k in (1, 2) for wave in (np.cos, np.sin)]
    waves = np.column_stack([*slow[:2], *repeated, *slow[2:]])[:, : (size - unknowns) // 3]
    return chance_of(rest, np.column_stack([np.ones(size), slopes]), waves)


def _smooth_as_well(time: FloatArray, angle: FloatArray, rest: FloatArray) -> bool:
    """Whether a smooth curve explains the readings after the release about as well as the model."""
    if time.size < _LEAST:
        return True
    curve = np.polynomial.Polynomial.fit(time, angle, _DEGREE)
    left = float(np.sum((angle - curve(time)) ** 2))
    # the likelihood of normal noise falls with the n-th power of the scatter
    square = max(float(rest @ rest), 1e-30 * left)
    return left <= 0.0 or 0.5 * time.size * math.log(left / square) < math.log(_ODDS)
