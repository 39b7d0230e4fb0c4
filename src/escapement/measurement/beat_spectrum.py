"""The spectrum of beats: which lines are caused by pins, and which by slots."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.measurement.rounds import Rounds, rounds_of
from escapement.mechanisms.protocol import Mechanism

special = Lazy("scipy.special")


class BeatLine(NamedTuple):
    """A sinusoidal change of beats that repeats with the pattern of pins and slots.

    frequency : cycles a turn of the driver [-].
    culprit : "pins" if it repeats every turn of the driver, "slots" if it repeats every turn of
        the follower, "pins or slots" if both, and "pairs" if neither.
    amplitude : amplitude of the sinusoid; half the difference of the two values if beats only
        alternate [s].
    standard_error : standard error of the amplitude, NaN if no pair of pin and slot was measured
        twice, so that the noise is unknown [s].
    p_value : probability that noise alone causes this amplitude or more; NaN in the same case.
    """

    frequency: float
    culprit: str
    amplitude: float
    standard_error: float
    p_value: float


@dataclass(frozen=True, eq=False, repr=False)
class BeatSpectrum(Shown):
    """Spectrum of beats.

    lines : all lines that the pattern can have, except the mean, by their frequency.
    mean : mean beat [s].
    rounds : the measured beats; its `faults` name ticks that were missed, doubled or out of place.
    """

    lines: tuple[BeatLine, ...]
    mean: float
    rounds: Rounds


def beat_spectrum(beats: ArrayLike, mechanism: Mechanism, *, times: bool = False) -> BeatSpectrum:
    """Lines in the spectrum of measured beats, each with the parts that cause it.

    Errors of pins repeat with every turn of the driver, those of slots with every turn of the
    follower. So in cycles per turn of the driver the lines of m pins are at 1, 2, .., those of n
    slots at m/n, 2 m/n, ..; if m and n have a common factor, some of them coincide.

    Parameters
    ----------
    beats : array_like, shape (N,)
        Times of the engagements in turn [s], NaN or masked where one is missing, or time stamps,
        as for `fit_beats`, which also says what is mended.
    mechanism : Geneva
        The wheel.
    times : bool
        Whether they are time stamps.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    rounds = rounds_of(beats, mechanism, times)
    wheel: Any = mechanism
    pins, size, within = wheel.pins or 1, rounds.pattern, rounds.intervals.freedom
    # standard deviation of a beat's noise
    noise = math.sqrt(rounds.scatter / within) if within > 0 else math.nan
    inverse, lines = np.linalg.inv(rounds.root), []
    for k in range(1, size // 2 + 1):
        freedom = 1 if 2 * k == size else 2
        weights = np.exp(-2j * np.pi * k / size * np.arange(size)) * freedom / size
        value = complex(weights @ rounds.means)
        along = (weights * np.exp(-1j * np.angle(value))).real
        error = noise * float(np.linalg.norm(along @ inverse))
        share = (abs(value) / error) ** 2 / freedom if error > 0.0 else math.nan
        p_value = float(special.fdtrc(freedom, within, share)) if within > 0 else math.nan
        shafts = ("pins", pins), ("slots", wheel.slots)
        culprit = " or ".join(name for name, count in shafts if k * count % size == 0) or "pairs"
        lines.append(BeatLine(k * pins / size, culprit, abs(value), error, p_value))
    return BeatSpectrum(tuple(lines), float(rounds.means.mean()), rounds)
