"""Fit of a simulated motion to a measured run-up.

The readings give the driver angle over time, from rest at pin entry. A motion depends on torques
and inertias only through their ratios, so at least one of them must be known.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from escapement import simulation, validate
from escapement.errors import InvalidValue
from escapement.lazy import Lazy
from escapement.measurement.readings import Readings
from escapement.measurement.verdict import Verdict
from escapement.mechanism import FloatArray
from escapement.model import Escapement
from escapement.motion import Motion
from escapement.status import Status
from escapement.study.plan import unit_kind
from escapement.text import words
from escapement.tolerance.differences import with_number
from escapement.tolerance.law import numbers_of
from escapement.torque_curve import TorqueCurve
from escapement.units import SYSTEMS, printed

optimize, special = Lazy("scipy.optimize"), Lazy("scipy.special")
_SHARES = (1.0, 0.5, 2.0, 0.7, 1.4)  # the search tries to begin at these multiples of each number
_CELLS = 10_000  # where the search begins is computed from at most this many cells
_MOVING = 0.02  # below this share of the travel, noise hides the time at which an angle is reached
_STEP = 1e-4  # share of a number by which it is changed for a derivative
_EXACT = {"xtol": 1e-9, "ftol": 1e-12, "gtol": 1e-12, "max_nfev": 60}
# a combination of unknowns with a smaller effect, relative to the strongest, is not determined
_SINGULAR = 1e-4
_INVOLVED = 0.1  # numbers with a smaller share in such a combination are not named in the message
_ALIKE = 0.05  # a smaller correlation of neighbouring residuals hardly changes an interval


@dataclass(frozen=True, eq=False)
class MotionFit:
    """The simulated motion that is nearest to a measured one.

    Attributes
    ----------
    escapement : Escapement
        The given escapement with the fitted numbers.
    parameters : tuple of str
        Names of the numbers that were fitted; all others keep their given values.
    values, half_widths : ndarray, shape (m,)
        Estimates, and half the widths of their confidence intervals, in SI units.
    confidence : float
        Confidence level of the intervals [-].
    start : float
        Time of the release from rest [s].
    time, residuals : ndarray, shape (n,)
        Times of the samples that were used [s], and measured less computed driver angle [rad].
    noise : float
        Standard deviation of the residuals [rad].
    mid_time, speeds, computed_speeds : ndarray, shape (n - 1,)
        Middle of each interval between two samples [s], and the mean driver speed in it, measured
        and computed [rad/s].
    autocorrelation : float
        Correlation of each residual with the next one [-].
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
    message: str

    @property
    def explained(self) -> bool:
        """Whether neighbouring residuals are independent of each other, as noise is."""
        return self.autocorrelation <= max(3.3 / math.sqrt(self.residuals.size), _ALIKE)

    @property
    def verdict(self) -> Verdict:
        """Whether the model explains the motion, and the estimates with their intervals."""
        found = [
            f"{words(name)} {value:.4g} ({100.0 * self.confidence:g} % interval "
            f"{value - half:.4g} to {value + half:.4g}{_unit(name)})"
            for name, value, half in zip(
                self.parameters, self.values, self.half_widths, strict=True
            )
        ]
        told = f" with {' and '.join(found)}; all other numbers are as given" if found else ""
        if self.explained:
            return Verdict(True, f"The model explains the motion{told}.")
        return Verdict(
            False,
            f"The model does not explain the motion, not even{told}."
            if found
            else "The model does not explain the motion.",
        )


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
        If an argument breaks its rule, the escapement does not run, or the motion depends only on
        a combination of the numbers, as it does on the ratio of torque and inertia.

    Notes
    -----
    The fit minimises the sum of the squared residuals of the driver angle; the time of the release
    and the zero of the encoder are unknowns too. The intervals come from the fit linearised at its
    solution, for normal noise that is independent from sample to sample.
    """
    task = _task(readings, escapement, tuple(parameters))
    share = validate.number("confidence", confidence, remedy := "give a share, as 0.95")
    if not 0.0 < share < 1.0:
        raise validate.fail("confidence", "between 0 and 1", confidence, remedy)
    found = optimize.least_squares(
        task.residuals, task.begin(), "3-point", bounds=task.bounds(), x_scale="jac",
        diff_step=_STEP, **_EXACT,
    )  # fmt: skip
    task.check_told(found.jac)
    n, unknowns = task.time.size, found.x.size + 1
    noise = math.sqrt(2.0 * float(found.cost) / (n - unknowns))
    reach = float(special.stdtrit(n - unknowns, 0.5 + 0.5 * share))
    spread = np.linalg.norm(np.linalg.pinv(found.jac), axis=1)
    scale = np.array([task.numbers[name] for name in task.parameters])
    angle = task.angles(found.x)
    rest = task.centred(task.angle - angle)
    speeds, computed = (np.diff(one) / np.diff(task.time) for one in (task.angle, angle))
    alike = float(rest[1:] @ rest[:-1] / (rest @ rest)) if rest.any() else 0.0
    fit = MotionFit(
        task.changed(found.x), task.parameters, found.x[:-1] * scale,
        reach * noise * spread[:-1] * scale, share, float(found.x[-1]), task.time, rest, noise,
        0.5 * (task.time[1:] + task.time[:-1]), speeds, computed, alike, "",
    )  # fmt: skip
    vars(fit)["message"] = "; ".join(_remarks(fit, readings))
    return fit


@dataclass(frozen=True)
class _Task:
    """The problem of least squares.

    Its unknowns are the fitted numbers, divided by their given values, and the time of the release
    [s].

    time, angle : of the samples that are used, shape (n,) [s, rad].
    """

    escapement: Escapement
    parameters: tuple[str, ...]
    numbers: dict[str, float]
    time: FloatArray
    angle: FloatArray

    def changed(self, unknowns: FloatArray) -> Escapement:
        """The escapement that belongs to the unknowns."""
        found = self.escapement
        for name, share in zip(self.parameters, unknowns, strict=False):
            found = with_number(found, name, float(share) * self.numbers[name])
        return found

    def motion(self, unknowns: FloatArray) -> Motion:
        """The motion from the release to the last sample."""
        duration = max(float(self.time[-1] - unknowns[-1]), 1e-3 * float(np.ptp(self.time)))
        return simulation.simulate(self.changed(unknowns), duration=duration)

    def angles(self, unknowns: FloatArray) -> FloatArray:
        """Driver angle at each sample, counted from pin entry; before the release it is 0 [rad]."""
        motion = self.motion(unknowns)
        since = np.clip(self.time - unknowns[-1], 0.0, motion.end_time)
        return np.asarray(motion.at(since).theta)

    def residuals(self, unknowns: FloatArray) -> FloatArray:
        """Measured less computed angle, with the encoder's zero that makes their mean 0 [rad]."""
        try:
            return self.centred(self.angle - self.angles(unknowns))
        except InvalidValue:
            # without a motion for these numbers, the computed angle counts as constant
            return self.centred(self.angle)

    @staticmethod
    def centred(values: FloatArray) -> FloatArray:
        return np.asarray(values - values.mean())

    def begin(self) -> FloatArray:
        """Unknowns at which the search begins: the best of several near the given numbers.

        The torque only changes the scale of time. A straight line through the measured times,
        plotted over the computed times of the same angles, therefore gives torque and release.
        """
        cells = math.ceil(float(self.angle[-1]) / self.escapement.mechanism.cell_angle) + 1
        moving = self.angle > _MOVING * self.angle[-1]
        times, clock = self.time[moving], "torque" in self.parameters
        free = len(self.parameters) - clock
        tries, message = [], ""
        for shares in product(_SHARES[: 5 if free < 3 else 3], repeat=free):
            others = iter(shares)
            trial = np.array([1.0 if it == "torque" else next(others) for it in self.parameters])
            motion = simulation.simulate(self.changed(trial), min(cells, _CELLS))
            if motion.status is not Status.OK:
                message = message or motion.message
                continue
            grid = np.linspace(0.0, motion.end_time, 50 * cells)
            turned = motion.at(grid).theta
            own = np.interp(self.angle[moving], turned - turned[0], grid)
            rate, start = np.polyfit(own, times, 1) if clock else (1.0, float(np.mean(times - own)))
            trial = np.array(
                [
                    rate**-2.0 if it == "torque" else x
                    for it, x in zip(self.parameters, trial, strict=True)
                ]
            )
            miss = float(np.square(times - start - rate * own).sum())
            if rate > 0.0:
                tries.append((miss, *trial, start))
        if not tries:
            raise InvalidValue(
                f"escapement must run to be fitted, got one that does not: {message}; change the "
                "values of parameters, at which the search begins"
            )
        return np.array(min(tries)[1:])

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest unknowns: positive numbers, and a release during the recording.

        The release may also come before it, by at most the length of the recording.
        """
        count, span = len(self.parameters), float(np.ptp(self.time))
        low = np.array([*np.full(count, 1e-6), self.time[0] - span])
        return low, np.array([*np.full(count, np.inf), self.time[-1]])

    def check_told(self, slopes: FloatArray) -> None:
        """Raise an error if these readings do not determine each of the numbers."""
        lengths = np.linalg.norm(slopes, axis=0)
        for name, length in zip(self.parameters, lengths, strict=False):
            if not length > _SINGULAR * _STEP:
                raise InvalidValue(
                    f"parameters must affect the motion, got {name!r}, which does not; leave it out"
                )
        _, sizes, directions = np.linalg.svd(slopes / lengths, full_matrices=False)
        if sizes[-1] < _SINGULAR * sizes[0]:
            shares = np.abs(directions[-1] / lengths)[: len(self.parameters)]
            named = zip(self.parameters, shares / shares.max(), strict=True)
            names = [name for name, part in named if part > _INVOLVED]
            raise InvalidValue(
                "parameters must each be determined by the motion, got "
                f"{', '.join(names)}, of which it shows only a combination; leave one of them out "
                "and give its value in escapement"
            )


def _task(readings: Readings, escapement: Escapement, parameters: tuple[str, ...]) -> _Task:
    if not isinstance(readings, Readings) or readings.time is None:
        remedy = "give read_readings(path, time='time')"
        raise validate.fail("readings", "Readings with times", readings, remedy)
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    numbers = numbers_of(escapement)
    if isinstance(escapement.torque, TorqueCurve):
        del numbers["torque"]
    for name in parameters:
        if name not in numbers:
            remedy = validate.nearest(name, numbers, f"for example {', '.join([*numbers][:4])}")
            raise validate.fail("parameters", "numbers of the escapement", name, remedy)
        if not numbers[name] > 0.0:
            remedy = "give an estimate, at which the search begins"
            raise validate.fail(name, "above 0 to be fitted", numbers[name], remedy)
    if len({*parameters}) < len(parameters):
        raise validate.fail("parameters", "different numbers", parameters, "name each once")
    known = np.isfinite(readings.input)
    time, angle = readings.time[known], readings.counted_input[known]
    # an encoder may count against the driver, which never turns back
    angle = (angle - angle[0]) * (1.0 if angle[-1] > angle[0] else -1.0)
    # the last of the samples at rest says as much as all of them
    first = max(int(np.argmax(angle != 0.0)) - 1, 0)
    return _Task(escapement, parameters, numbers, time[first:], angle[first:])


def _unit(name: str) -> str:
    unit = printed(unit_kind(name), SYSTEMS[0])
    return "" if unit in ("", "1") else f" {unit}"


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
    if not fit.explained:
        yield (
            f"neighbouring residuals are alike (correlation {fit.autocorrelation:.2f}): the model "
            "does not explain the motion, and the intervals are too narrow"
        )
