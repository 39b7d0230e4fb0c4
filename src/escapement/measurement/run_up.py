"""The fit of a simulated motion from rest to the times of its beats.

A beat sounds as a pin hands over to the next one, so that the times of beats are those of handoffs,
later by the time of the release. Times vary smoothly with the numbers of the model, while the
angle at a given time does not: the driver is many times as fast at a handoff as in between.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.engines import simulate as simulation
from escapement.measurement.beat_times import BeatTimes
from escapement.measurement.estimate import (
    Estimate,
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
    given_numbers,
    numbers_in_words,
    with_numbers,
)
from escapement.measurement.loggers import check_unit
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

optimize = Lazy("scipy.optimize")
_STARTS = (1.0, 0.6, 1.5)  # multiples of the given numbers from which the search begins
_BOUNDS = 0.02, 50.0  # least and greatest multiple of a given number
_STEP = 1e-5  # share of a number by which it is changed for a derivative
_INEFFECTIVE = 1e-6  # share of a beat by which a number without effect moves one
_FADING = 0.7, 2.5  # beats in which errors of a model fade as the motion settles
_HALVES = 2  # half waves over the recording that noise does not have
_FAR = 1e3  # residual where there is no motion, in mean beats
_FEWEST = 12


@dataclass(frozen=True, eq=False, repr=False)
class RunUp(Shown):
    """Numbers of an escapement that explain the beats of a motion from rest.

    Attributes
    ----------
    escapement : Escapement
        The given design with the fitted numbers.
    numbers : tuple of Estimate
        The fitted numbers, each with its interval [SI].
    release : Estimate
        When the driver was released, by the clock of the beats [s].
    residuals : ndarray, shape (n,)
        Measured less computed time of each beat that was heard [s].
    noise : float
        Their standard deviation [s].
    p_value : float
        Probability that independent noise alone looks as much like the error of a model [-].
    autocorrelation : float
        Correlation of each residual with the next one [-].
    confidence : float
        Confidence level of the intervals [-].
    """

    escapement: Escapement
    numbers: tuple[Estimate, ...]
    release: Estimate
    residuals: FloatArray
    noise: float
    p_value: float
    autocorrelation: float
    confidence: float

    @property
    def told(self) -> list[Told]:
        """The fitted numbers with their intervals."""
        return [Told(one.name, one.value, one.low, one.high) for one in self.numbers]

    @property
    def verdict(self) -> Verdict:
        """Whether the model explains the beats, and with which numbers."""
        text = numbers_in_words(self.told, self.confidence)
        if contradicted(self.p_value, self.autocorrelation, self.residuals.size):
            return Verdict(False, f"The model does not explain the beats{text}.")
        if math.isnan(self.p_value):
            return Verdict(None, "Cannot say whether the model explains the beats: they are few.")
        return Verdict(True, f"The model explains the beats{text}.")


def fit_run_up(
    beats: BeatTimes,
    escapement: Escapement,
    parameters: Sequence[str] = ("friction",),
    *,
    confidence: float = 0.95,
) -> RunUp:
    """Fit numbers of an escapement to the times of beats of a motion from rest.

    Parameters
    ----------
    beats : BeatTimes
        What `read_beats` gives with `run_up=True`; the first is the first change of pin behind the
        release.
    escapement : Escapement
        The design. The search begins near its values of `parameters`, which must be above 0.
    parameters : sequence of str
        Names of the numbers to be fitted, as in a study: "friction", "torque", ..
    confidence : float
        Confidence level of the intervals, in (0, 1) [-].

    Raises
    ------
    InvalidValue
        If an argument breaks its rule, the escapement does not run, its times are far from the
        measured ones, or the beats determine only a combination of the numbers.
    """
    share, names = checked_confidence(confidence), tuple(parameters)
    heard, given = beats.heard, given_numbers(escapement, names)
    if heard.size < max(_FEWEST, 3 * (len(names) + 1)):
        raise InvalidValue(
            f"beats must be {_FEWEST} or more in a run-up, got {heard.size}; record longer"
        )
    times, count = beats.times[heard], int(heard[-1]) + 1
    _check_times(escapement, times, heard)

    def built(unknowns: FloatArray) -> Escapement:
        return with_numbers(escapement, names, unknowns[:-1] * given)

    def rest(unknowns: FloatArray) -> FloatArray:
        motion = simulation.simulate(built(unknowns), count)
        if motion.handoff_times.size < count:
            return np.full(heard.size, _FAR * beats.period)
        since = times - times[0] - float(unknowns[-1]) * beats.period
        return np.asarray(since - motion.handoff_times[heard])

    bounds = np.array([*[_BOUNDS] * len(names), (-np.inf, np.inf)]).T
    every = [
        optimize.least_squares(
            rest, [*np.full(len(names), start), -1.0], bounds=bounds, diff_step=_STEP,
            xtol=1e-12, ftol=1e-12, gtol=1e-15,
        )
        for start in (_STARTS if names else (1.0,))
    ]  # fmt: skip
    found = min(every, key=lambda one: float(one.cost))
    check_determined(found.jac, names, _INEFFECTIVE * beats.period * math.sqrt(heard.size))
    known_fit = tangent_of(found.jac, 2.0 * float(found.cost), heard.size - len(names) - 1, share)
    scale = np.array([*given, beats.period])
    values, halves = found.x * scale, np.linalg.norm(known_fit.root, axis=1) * scale
    each = zip((*names, "release_time"), values.tolist(), halves.tolist(), strict=True)
    *fitted, release = (Estimate(*one) for one in each)
    return RunUp(
        escapement=built(found.x), numbers=tuple(fitted),
        release=release._replace(value=release.value + float(times[0])), residuals=found.fun,
        noise=known_fit.noise, p_value=_chance(found.fun, found.jac),
        autocorrelation=correlation(found.fun), confidence=share,
    )  # fmt: skip


def _check_times(escapement: Escapement, times: FloatArray, heard: np.ndarray) -> None:
    """Raise InvalidValue if the design does not run, or in times of another order."""
    motion = simulation.simulate(escapement, int(heard[-1]) + 1)
    if motion.handoff_times.size <= heard[-1]:
        raise InvalidValue(
            f"escapement must run for {heard[-1] + 1} beats, got: {motion.message}; change its "
            "numbers"
        )
    design = float(np.ptp(motion.handoff_times[heard]))
    took = f"{np.ptp(times):.3g} s, where the design takes {design:.3g} s"
    check_unit("beats", float(np.ptp(times)) / design, took)


def _chance(residuals: FloatArray, slopes: FloatArray) -> float:
    """Probability that independent noise looks as much like the error of a model.

    Such an error fades as the motion settles, or changes slowly. NaN of too few beats.
    """
    size, index = residuals.size, np.arange(residuals.size)
    fading = [np.exp(-index / beats) for beats in _FADING]
    halves = [np.cos(np.pi * k * (index + 0.5) / size) for k in range(1, _HALVES + 1)]
    return chance_of(residuals, slopes, np.column_stack([*fading, *halves]))
