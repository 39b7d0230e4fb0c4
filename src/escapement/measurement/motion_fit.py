"""Fit of a simulated motion to a measured run-up, of readings or of beats.

A motion depends on torques and inertias only through their ratios, so at least one of them must be
known.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from escapement.base.lazy import Lazy
from escapement.measurement.estimate import (
    Estimate,
    Fit,
    chance_of,
    checked_confidence,
    correlation,
    tangent_of,
)
from escapement.measurement.motion_task import MotionTask, task_of
from escapement.measurement.readings import Readings
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

optimize = Lazy("scipy.optimize")
_SEARCH = {"xtol": 1e-9, "ftol": 1e-12, "gtol": 1e-12, "max_nfev": 60, "diff_step": 1e-7}
_SLOW = 6  # slow changes that are looked for have up to so many half waves, of beats two
_FADING = 0.7, 2.5  # beats in which errors of a model fade as the motion settles
_EXACT = 1e-8  # a scatter below this share of the travel is rounding, and is no evidence
_DEGREE = 3  # of the smooth curve
_ODDS = 1000.0  # the model must be so much more likely than the smooth curve
_LEAST = 12  # samples that a smooth curve needs


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class MotionFit(Fit):
    """The simulated motion that is nearest to a measured one.

    `residuals` and `noise` are driver angles [rad], and times of beats [s].

    Attributes
    ----------
    release : Estimate
        Time of the release from rest, by the clock of the measurement [s].
    time, angle : ndarray, shape (n,)
        Times of the samples that were used, and angles that the driver has turned [s, rad].
    """

    release: Estimate
    time: FloatArray = field(repr=False)
    angle: FloatArray = field(repr=False)

    @property
    def _apart(self) -> np.ndarray:
        return np.diff(self.time) > 0.0

    @property
    def mid_time(self) -> FloatArray:
        """Middle of each interval between two samples of different times, shape (k,) [s]."""
        return np.asarray(0.5 * (self.time[1:] + self.time[:-1])[self._apart])

    @property
    def speeds(self) -> FloatArray:
        """Mean driver speed in these intervals, measured, shape (k,) [rad/s]."""
        return np.asarray(np.diff(self.angle)[self._apart] / np.diff(self.time)[self._apart])

    @property
    def computed_speeds(self) -> FloatArray:
        """The same, computed."""
        if self.of_beats:
            return np.asarray(np.diff(self.angle) / np.diff(self.time - self.residuals))
        apart = np.diff(self.residuals)[self._apart] / np.diff(self.time)[self._apart]
        return np.asarray(self.speeds - apart)


def fit_motion(
    readings: Readings, escapement: Escapement, parameters: Sequence[str] = ("friction", "torque"),
    *, confidence: float = 0.95,
) -> MotionFit:  # fmt: skip
    """Fit numbers of an escapement to a measured run-up.

    Parameters
    ----------
    readings : Readings
        Times and angles of the input; the angles of the output are not used. The driver stands at
        pin entry until it is released, at the first sample or later. Or beats, as `read_beats`
        gives them with `run_up=True`: each sounds as a pin hands over to the next one, the first
        at the first change of pin behind the release.
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
    task, share = task_of(readings, escapement, parameters), checked_confidence(confidence)
    found = optimize.least_squares(
        task.residuals, task.begin(), "3-point", bounds=task.bounds, x_scale="jac", **_SEARCH
    )
    task.check_determined(found.jac)
    # the zero of an encoder is an unknown too
    freedom = task.time.size - found.x.size - (task.beats is None)
    known = tangent_of(found.jac, 2.0 * found.cost, freedom, share)
    halves = np.linalg.norm(known.root, axis=1)
    alike, p_value, doubt = _judged(task, found.fun, found.jac, task.released(found.x))
    fit = MotionFit(
        escapement=task.changed(found.x), confidence=share, residuals=found.fun, noise=known.noise,
        numbers=tuple(
            Estimate(name, value * size, half * size, "", 0.0, most)
            for name, value, half, size, most in zip(
                task.parameters, found.x.tolist(), halves.tolist(), task.given.tolist(),
                task.most.tolist(), strict=False,
            )
        ),
        release=Estimate(
            "release_time", task.clock + task.released(found.x), float(halves[-1]) * task.span,
        ),
        time=task.clock + task.time, angle=task.angle, of_beats=task.beats is not None,
        autocorrelation=alike, p_value=p_value, doubt=doubt,
    )  # fmt: skip
    vars(fit)["message"] = "; ".join(_remarks(fit, readings))
    return fit


def _remarks(fit: MotionFit, readings: Readings) -> Iterator[str]:
    if readings.half_widths is None:  # what is said of beats does not concern a fit
        yield from readings.remarks
    for one in fit.numbers:
        if one.half_width > 0.5 * one.value:
            yield (
                f"the readings hardly determine {one.name}: its interval is wider than its value; "
                "measure longer"
            )
    yield from fit.contradictions


def _judged(
    task: MotionTask, rest: FloatArray, slopes: FloatArray, start: float
) -> tuple[float, float, str]:
    """Correlation of residuals, their p-value, and why they cannot say whether a model holds."""
    measured = task.angle if task.beats is None else task.time
    if np.abs(rest).max() <= _EXACT * np.ptp(measured):
        return 0.0, math.nan, ""
    ones = np.ones((rest.size, int(task.beats is None)))  # an encoder has a zero
    fitted = np.hstack([ones, slopes])
    waves = _waves(task, rest)[:, : max(rest.size - fitted.shape[1], 0) // 3]
    chance, doubt, moving = chance_of(rest, fitted, waves), "", task.time > start
    if math.isnan(chance):
        doubt = f"{rest.size} samples are too few to test it; take more samples"
    elif task.beats is None and _smooth_as_well(
        task.time[moving], task.angle[moving], rest[moving]
    ):
        doubt = (
            "a smooth curve explains the readings about as well, so that they do not show the "
            "engagements; take more samples, over more engagements, with less noise"
        )
    return correlation(rest), chance, doubt


def _waves(task: MotionTask, rest: FloatArray) -> FloatArray:
    """What noise does not leave: slow changes, and waves over a cell, or errors that fade."""
    halves = np.pi * (np.arange(rest.size) + 0.5) / rest.size
    slow = [np.cos(k * halves) for k in range(1, _SLOW + 1)]
    if task.beats is not None:
        return np.column_stack([*(np.exp(-np.arange(rest.size) / k) for k in _FADING), *slow[:2]])
    cells = (task.angle - rest) * (2.0 * np.pi / task.escapement.mechanism.cell_angle)
    repeated = [wave(k * cells) for k in (1, 2) for wave in (np.cos, np.sin)]
    return np.column_stack([*slow[:2], *repeated, *slow[2:]])


def _smooth_as_well(time: FloatArray, angle: FloatArray, rest: FloatArray) -> bool:
    """Whether a smooth curve explains the readings after the release about as well as the model."""
    if time.size < _LEAST:
        return True
    curve = np.polynomial.Polynomial.fit(time, angle, _DEGREE)
    left = float(np.sum((angle - curve(time)) ** 2))
    # the likelihood of normal noise falls with the n-th power of the scatter
    square = max(float(rest @ rest), 1e-30 * left)
    return left <= 0.0 or 0.5 * time.size * math.log(left / square) < math.log(_ODDS)
