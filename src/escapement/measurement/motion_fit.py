"""A measured run-up against a simulated motion: speeds, and the numbers of the model behind them.

Recorded is the driver angle over time from rest at pin entry. Speeds alone tell ratios of torques
and inertias, so at least one of these is held as given.
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
_SHARES = (1.0, 0.5, 2.0, 0.7, 1.4)  # of the numbers given, from which the search may begin
_CELLS = 10_000  # of longer recordings the first cells tell where to begin
_MOVING = 0.02  # before such a share of the travel noise hides the time of an angle
_STEP = 1e-4  # share of a number by which it is changed for a derivative
_EXACT = {"xtol": 1e-9, "ftol": 1e-12, "gtol": 1e-12, "max_nfev": 60}
_SINGULAR = (
    1e-4  # of directions of the unknowns, one that acts less than this share acts not at all
)
_INVOLVED = 0.1  # a number with a smaller share in such a direction is not to blame
_ALIKE = 0.05  # a smaller correlation of neighbours spoils no interval


@dataclass(frozen=True, eq=False)
class MotionFit:
    """A motion that explains a measured one.

    Attributes
    ----------
    escapement : Escapement
        What was given, with the numbers that were found.
    parameters : tuple of str
        Names of the numbers that were fitted; all others are held as given.
    values, half_widths : ndarray, shape (m,)
        What was found, and half of each interval, in SI.
    confidence : float
        Of the intervals.
    start : float
        Time of the release from rest [s].
    time, residuals : ndarray, shape (n,)
        Samples that count [s], and measured less computed driver angle [rad].
    noise : float
        Standard deviation of the residuals [rad].
    mid_time, speeds, computed_speeds : ndarray, shape (n - 1,)
        Mean driver speeds between neighbouring samples, as measured and of the motion [rad/s].
    autocorrelation : float
        Of each residual with the next one [-].
    message : str
        What a reader of these figures must know, "" where there is nothing.
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
        """Whether the residuals are noise, whose neighbours do not depend on each other."""
        return self.autocorrelation <= max(3.3 / math.sqrt(self.residuals.size), _ALIKE)

    @property
    def verdict(self) -> Verdict:
        """Whether the motion is that of the model, and what was found."""
        found = [
            f"{words(name)} {value:.4g} ({100.0 * self.confidence:g} % interval "
            f"{value - half:.4g} to {value + half:.4g}{_unit(name)})"
            for name, value, half in zip(
                self.parameters, self.values, self.half_widths, strict=True
            )
        ]
        told = f" with {' and '.join(found)}, all else held as given" if found else ""
        if self.explained:
            return Verdict(True, f"The motion is that of the model{told}.")
        return Verdict(
            False,
            f"The model does not explain the motion, even{told}."
            if found
            else "The motion is not that of the model.",
        )


def fit_motion(
    readings: Readings,
    escapement: Escapement,
    parameters: Sequence[str] = ("friction", "torque"),
    *,
    confidence: float = 0.95,
) -> MotionFit:
    """Find numbers of an escapement from a measured run-up, with confidence intervals.

    Parameters
    ----------
    readings : Readings
        With times; of the angles the input's count alone. The driver stands at pin entry until
        it is released, in the first sample or later.
    escapement : Escapement
        The design. Its numbers are held, those to be found being where the search begins, > 0.
    parameters : sequence of str
        Names of what is to be found, as studies have them: "friction", "torque",
        "driver_inertia", .. Those that cannot be told apart are refused. None: the motion is
        compared as it is.
    confidence : float
        Of the intervals, in (0, 1).

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, the escapement does not run, or the motion cannot tell
        the numbers apart.

    Notes
    -----
    Least squares of the driver angle, with the time of the release and the zero of the encoder
    unknown. The noise of each sample is taken to be normal and independent of the others.
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
    """What is to be fitted; unknowns are the numbers as shares of those given, and the start [s].

    time, angle : of the samples that count, shape (n,) [s, rad].
    """

    escapement: Escapement
    parameters: tuple[str, ...]
    numbers: dict[str, float]
    time: FloatArray
    angle: FloatArray

    def changed(self, unknowns: FloatArray) -> Escapement:
        """The escapement with other numbers."""
        found = self.escapement
        for name, share in zip(self.parameters, unknowns, strict=False):
            found = with_number(found, name, float(share) * self.numbers[name])
        return found

    def motion(self, unknowns: FloatArray) -> Motion:
        """From the release to the last sample."""
        duration = max(float(self.time[-1] - unknowns[-1]), 1e-3 * float(np.ptp(self.time)))
        return simulation.simulate(self.changed(unknowns), duration=duration)

    def angles(self, unknowns: FloatArray) -> FloatArray:
        """Driver angle at each sample, from pin entry on; before the release it stands."""
        motion = self.motion(unknowns)
        since = np.clip(self.time - unknowns[-1], 0.0, motion.end_time)
        return np.asarray(motion.at(since).theta)

    def residuals(self, unknowns: FloatArray) -> FloatArray:
        """Measured less computed angle, with the zero that makes their mean zero [rad]."""
        try:
            return self.centred(self.angle - self.angles(unknowns))
        except InvalidValue:
            # numbers without a motion explain none
            return self.centred(self.angle)

    @staticmethod
    def centred(values: FloatArray) -> FloatArray:
        return np.asarray(values - values.mean())

    def begin(self) -> FloatArray:
        """Where the search begins: the best of some numbers about those given.

        A torque is a clock: of each motion a straight line through the measured times over its
        own at the same angles tells the torque and the release.
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
            raise InvalidValue(f"escapement must run, to be fitted: {message}")
        return np.array(min(tries)[1:])

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Numbers are above zero, and the release is within the recording, or as long before."""
        count, span = len(self.parameters), float(np.ptp(self.time))
        low = np.array([*np.full(count, 1e-6), self.time[0] - span])
        return low, np.array([*np.full(count, np.inf), self.time[-1]])

    def check_told(self, slopes: FloatArray) -> None:
        """Refuse numbers that this motion cannot tell apart."""
        lengths = np.linalg.norm(slopes, axis=0)
        for name, length in zip(self.parameters, lengths, strict=False):
            if not length > _SINGULAR * _STEP:
                raise InvalidValue(
                    f"parameters must change the motion, got {name!r}, which does not; leave it out"
                )
        _, sizes, directions = np.linalg.svd(slopes / lengths, full_matrices=False)
        if sizes[-1] < _SINGULAR * sizes[0]:
            shares = np.abs(directions[-1] / lengths)[: len(self.parameters)]
            named = zip(self.parameters, shares / shares.max(), strict=True)
            names = [name for name, part in named if part > _INVOLVED]
            raise InvalidValue(
                f"parameters must be told apart by the motion, got {', '.join(names)}, of which it "
                "tells ratios only; hold one of them as given"
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
            remedy = "give a guess to begin with"
            raise validate.fail(name, "above 0 to be fitted", numbers[name], remedy)
    if len({*parameters}) < len(parameters):
        raise validate.fail("parameters", "different numbers", parameters, "name each once")
    known = np.isfinite(readings.input)
    time, angle = readings.time[known], readings.counted_input[known]
    # an encoder may count against the driver, which never turns back
    angle = (angle - angle[0]) * (1.0 if angle[-1] > angle[0] else -1.0)
    # of the samples at rest the last one tells all
    first = max(int(np.argmax(angle != 0.0)) - 1, 0)
    return _Task(escapement, parameters, numbers, time[first:], angle[first:])


def _unit(name: str) -> str:
    unit = printed(unit_kind(name), SYSTEMS[0])
    return "" if unit in ("", "1") else f" {unit}"


def _remarks(fit: MotionFit, readings: Readings) -> Iterator[str]:
    if readings.synthetic:
        yield "synthetic data, computed and not measured"
    if readings.remark:
        yield readings.remark
    for name, value, half in zip(fit.parameters, fit.values, fit.half_widths, strict=True):
        if half > 0.5 * value:
            yield f"{name} is hardly told: its interval is as wide as itself; measure longer"
    if not fit.explained:
        yield (
            f"neighbouring residuals are alike (correlation {fit.autocorrelation:.2f}): the model "
            "does not explain the motion, and intervals are too narrow"
        )
