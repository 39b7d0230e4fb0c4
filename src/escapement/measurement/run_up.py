"""The fit of a simulated motion from rest to the times of its beats.

A beat sounds as a pin hands over to the next one, so that the times of beats are those of handoffs,
later by the time of the release. Times vary smoothly with the numbers of the model, while the
angle at a given time does not: the driver is many times as fast at a handoff as in between.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.spoken import as_spoken
from escapement.base.text import Shown, words
from escapement.engines import simulate as simulation
from escapement.measurement.beat_times import BeatTimes
from escapement.measurement.estimate import (
    SURE,
    Estimate,
    Verdict,
    checked_confidence,
    correlation,
    f_test,
    tangent_of,
)
from escapement.measurement.loggers import check_unit
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.model.numbers import numbers_of, with_number
from escapement.study.plan import unit_kind

optimize = Lazy("scipy.optimize")
_STARTS = (1.0, 0.6, 1.5)  # multiples of the given numbers from which the search begins
_BOUNDS = 0.02, 50.0  # least and greatest multiple of a given number
_STEP = 1e-5  # share of a number by which it is changed for a derivative
_SINGULAR = 1e-4  # a combination of numbers with a smaller effect is not determined
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
    """

    escapement: Escapement
    numbers: tuple[Estimate, ...]
    release: Estimate
    residuals: FloatArray
    noise: float
    p_value: float
    autocorrelation: float

    @property
    def verdict(self) -> Verdict:
        """Whether the model explains the beats, and with which numbers."""
        parts = []
        for one in self.numbers:
            kind = unit_kind(one.name)
            ends = f"{as_spoken(one.low, kind, 4)} to {as_spoken(one.high, kind, 4)}"
            parts.append(f"{words(one.name)} {as_spoken(one.value, kind, 4)} ({ends})")
        text = f" with {' and '.join(parts)}; all other numbers are as given" if parts else ""
        alike = self.autocorrelation > max(3.3 / math.sqrt(self.residuals.size), 0.1)
        if self.p_value < SURE or alike:
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
    known = numbers_of(escapement)
    for name in names:
        validate.choice("parameters", name, tuple(known))
        validate.positive(name, known[name], "give a value at which the search begins")
    heard, given = beats.heard, np.array([known[name] for name in names])
    if heard.size < max(_FEWEST, 3 * (len(names) + 1)):
        raise InvalidValue(
            f"beats must be {_FEWEST} or more in a run-up, got {heard.size}; record longer"
        )
    times, count = beats.times[heard], int(heard[-1]) + 1
    _check_times(escapement, times, heard)

    def built(unknowns: FloatArray) -> Escapement:
        changed = escapement
        for name, value in zip(names, (unknowns[:-1] * given).tolist(), strict=True):
            changed = with_number(changed, name, value)
        return changed

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
    _check_determined(found.jac, names)
    known_fit = tangent_of(found.jac, 2.0 * float(found.cost), heard.size - len(names) - 1, share)
    scale = np.array([*given, beats.period])
    values, halves = found.x * scale, np.linalg.norm(known_fit.root, axis=1) * scale
    each = zip((*names, "release_time"), values.tolist(), halves.tolist(), strict=True)
    *fitted, release = (Estimate(*one) for one in each)
    return RunUp(
        escapement=built(found.x), numbers=tuple(fitted),
        release=release._replace(value=release.value + float(times[0])), residuals=found.fun,
        noise=known_fit.noise, p_value=_chance(found.fun, found.jac),
        autocorrelation=correlation(found.fun),
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


def _check_determined(slopes: FloatArray, names: tuple[str, ...]) -> None:
    """Raise InvalidValue where the beats determine only a combination of the numbers."""
    sizes = np.linalg.svd(slopes, compute_uv=False)
    if not sizes[-1] > _SINGULAR * sizes[0]:
        raise InvalidValue(
            f"parameters must each be determined by the beats, got {', '.join(names)}, of which "
            "they show only a combination; leave one of them out"
        )


def _chance(residuals: FloatArray, slopes: FloatArray) -> float:
    """Probability that independent noise looks as much like the error of a model.

    Such an error fades as the motion settles, or changes slowly. NaN of too few beats.
    """
    size, index = residuals.size, np.arange(residuals.size)
    fading = [np.exp(-index / beats) for beats in _FADING]
    halves = [np.cos(np.pi * k * (index + 0.5) / size) for k in range(1, _HALVES + 1)]
    waves = np.column_stack([*fading, *halves])
    fitted, _ = np.linalg.qr(slopes)
    basis, _ = np.linalg.qr(waves - fitted @ (fitted.T @ waves))
    explained = float(np.sum((basis.T @ residuals) ** 2))
    count = basis.shape[1]
    freedom = size - fitted.shape[1] - count
    return f_test(explained, count, float(residuals @ residuals) - explained, freedom)
