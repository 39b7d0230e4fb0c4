"""What times of beats say of a clock: rate, beat error, drift, scatter and stability.

An interval between two beats that were heard is m T + o_j - o_i plus noise: m beats of the mean
time T, and the offsets o of the positions in a pattern at which the beats stand, such as tick and
tock. T may change linearly. `interval_fit` tells what the noise may be.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.measurement.beat_times import HOUR
from escapement.measurement.estimate import Estimate, checked_confidence, reach_of
from escapement.measurement.readings import Readings
from escapement.measurement.rounds import Intervals
from escapement.mechanisms.protocol import FloatArray

special = Lazy("scipy.special")
DAY = 86400.0
_LEAST = 6  # intervals for each unknown
_SHARES = 1.0 - np.logspace(-6.0, 0.0, 25)
"""Shares of the jitter, alike in the logarithm of what is left for the beats themselves."""


class Stability(NamedTuple):
    """Allan deviation of the rate over some time.

    time : over which the rate is averaged [s].
    deviation : Allan deviation [-].
    low, high : ends of its confidence interval [-].
    """

    time: float
    deviation: float
    low: float
    high: float


@dataclass(frozen=True, eq=False, repr=False)
class Timekeeping(Shown):
    """How a mechanism keeps time.

    Attributes
    ----------
    beats_per_hour : Estimate
        Beats an hour [-].
    rate : Estimate
        What it gains a day against the nominal rate [s/d]; not known without a nominal rate.
    beat_error : Estimate
        With a pattern of two, the first beat minus the second one [s].
    offsets : tuple of Estimate
        How late each position of the pattern comes, relative to their mean [s].
    drift : Estimate
        Change of the rate [s/d in an hour].
    scatter : float
        Standard deviation of the noise of one interval [s].
    jitter : float
        Share of its variance that comes from the instants, as of the microphone [-].
    stability : tuple of Stability
        Allan deviation over times that double.
    residuals : ndarray, shape (n,)
        How late each beat that was heard is, against a mean rate and the offsets [s].
    confidence : float
        Confidence level of the intervals [-].
    """

    beats_per_hour: Estimate
    rate: Estimate
    beat_error: Estimate
    offsets: tuple[Estimate, ...]
    drift: Estimate
    scatter: float
    jitter: float
    stability: tuple[Stability, ...]
    residuals: FloatArray
    confidence: float


def timekeeping(
    beats: Readings, *, nominal: float | None = None, pattern: int = 2, confidence: float = 0.95
) -> Timekeeping:
    """Rate, beat error, drift and stability of times of beats, with their intervals.

    Parameters
    ----------
    beats : Readings
        As `read_beats` gives them.
    nominal : float, optional
        Beats an hour that are right, > 0.
    pattern : int
        Beats after which errors repeat: 2 for tick and tock, or the pins of a wheel.
    confidence : float
        Confidence level of the intervals, in (0, 1).

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, or there are fewer than six beats for each unknown.
    """
    share = checked_confidence(confidence)
    size = validate.integer("pattern", pattern, 1, "give the beats after which errors repeat")
    right = None
    if nominal is not None:
        right = validate.positive("nominal", nominal, "give the beats an hour")
    heard = beats.beats
    if heard.size < _LEAST * (size + 1):
        raise InvalidValue(
            f"beats must be {_LEAST * (size + 1)} or more for a pattern of {size}, got "
            f"{heard.size}; record longer"
        )
    times = beats.heard
    # an interval by T, its change in a beat, and the offsets of all positions but the first
    numbers, middle = np.diff(heard), 0.5 * (heard[0] + heard[-1])
    columns = [numbers, 0.5 * np.diff((heard - middle) ** 2)]
    columns += [np.diff((heard % size == k).astype(float)) for k in range(1, size)]
    design, joined = np.column_stack(columns).astype(float), np.ones(numbers.size - 1, bool)
    intervals = Intervals(np.diff(times), design, numbers, joined)
    fit = intervals.average(_SHARES)
    variance = fit.scatter / intervals.freedom
    reach = reach_of(share, intervals.freedom) * math.sqrt(variance)

    def estimate(name: str, scale: float, weights: FloatArray) -> Estimate:
        """A number whose change is proportional to that of a sum of the unknowns."""
        half = math.sqrt(max(float(weights @ fit.covariance @ weights), 0.0))
        return Estimate(name, scale * float(weights @ fit.values), abs(scale) * reach * half)

    unit = np.eye(size + 1)
    period = float(fit.values[0])
    hourly = estimate("beats_per_hour", HOUR / period**2, unit[0])
    rate = Estimate("rate", math.nan, math.nan, "no nominal rate is given")
    if right is not None:
        gain = DAY * (hourly.value / right - 1.0)
        rate = Estimate("rate", gain, DAY * hourly.half_width / right)
    error = Estimate("beat_error", math.nan, math.nan, "the pattern is not of two beats")
    if size == 2:
        error = estimate("beat_error", 2.0, unit[2])
    # relative to the mean of all positions
    centred = np.hstack([np.zeros((size, 2)), np.eye(size)[:, 1:] - 1.0 / size])
    offsets = tuple(estimate(f"position {k}", 1.0, row) for k, row in enumerate(centred))
    late = (centred @ fit.values)[heard % size]
    rest = times - times.mean() - period * (heard - heard.mean()) - late
    return Timekeeping(
        beats_per_hour=hourly, rate=rate, beat_error=error, offsets=offsets,
        # a beat of T that changes by d a beat: the rate changes by -d/T of itself in a beat
        drift=estimate("drift", -DAY / period**2 * HOUR, unit[1]), scatter=math.sqrt(variance),
        jitter=float(fit.weights @ _SHARES), stability=_stability(rest, heard, period, share),
        residuals=rest - rest.mean(), confidence=share,
    )  # fmt: skip


def _stability(
    rest: FloatArray, index: np.ndarray, period: float, share: float
) -> tuple[Stability, ...]:
    """Overlapping Allan deviation; its interval counts only differences that do not overlap."""
    phase = np.full(int(index[-1] - index[0]) + 1, np.nan)
    phase[index - index[0]] = rest
    found, length = [], 1
    while 4 * length < phase.size:
        second = phase[2 * length :] - 2.0 * phase[length:-length] + phase[: -2 * length]
        known = second[np.isfinite(second)]
        freedom = known.size / (2.0 * length)
        if freedom >= 1.0:
            time = length * period
            size = math.sqrt(float(np.mean(known**2)) / 2.0) / time
            tails = special.chdtri(freedom, [0.5 - 0.5 * share, 0.5 + 0.5 * share]).tolist()
            ends = (size * math.sqrt(freedom / tail) for tail in tails)
            found.append(Stability(time, size, *ends))
        length *= 2
    return tuple(found)
