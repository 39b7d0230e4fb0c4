"""The spectrum of beats: which lines pins make, and which slots."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.lazy import Lazy
from escapement.measurement.rounds import Rounds, checked_wheel, rounds_of
from escapement.mechanism import Mechanism

special = Lazy("scipy.special")


class BeatLine(NamedTuple):
    """A sinusoidal change of beats that comes back with the pattern of pins and slots.

    frequency : cycles a turn of the driver [-].
    culprit : "pins" where it comes back every turn of the driver, "slots" where it does every
        turn of the follower, "pins or slots" where both, and "pairs" where neither.
    amplitude : of the sinusoid, or half of what two sides differ by, where it only alternates [s].
    standard_error : of the amplitude, NaN without a second round to tell the noise [s].
    p_value : probability that noise alone makes as much; NaN likewise.
    """

    frequency: float
    culprit: str
    amplitude: float
    standard_error: float
    p_value: float


@dataclass(frozen=True, eq=False)
class BeatSpectrum:
    """Lines of beats, by their frequency.

    lines : all that the pattern can have but the mean.
    mean : beat [s].
    rounds : the beats.
    """

    lines: tuple[BeatLine, ...]
    mean: float
    rounds: Rounds


def beat_spectrum(beats: ArrayLike, mechanism: Mechanism) -> BeatSpectrum:
    """Lines in the spectrum of measured beats, each with the part that makes it.

    Errors of pins come back with every turn of the driver, those of slots with every turn of the
    follower. So in cycles a turn of the driver the lines of m pins are at 1, 2, .., those of n
    slots at m/n, 2 m/n, ..; where m and n have a factor in common, some of them are the same.

    Parameters
    ----------
    beats : array_like, shape (N,)
        Times of the engagements in turn [s], NaN or masked where one is missing, as for
        `fit_beats`.
    mechanism : Geneva
        The wheel.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    wheel = checked_wheel(mechanism)
    rounds, pins = rounds_of(beats, wheel), wheel.pins or 1
    size, mean = rounds.pattern, float(rounds.means.mean())
    within = rounds.samples - size
    # of the amplitudes along and across, for independent noise of each beat
    noise = math.sqrt(rounds.scatter / within) if within > 0 else math.nan
    lines = []
    for k in range(1, size // 2 + 1):
        alternates = 2 * k == size
        weights = np.exp(-2j * np.pi * k / size * np.arange(size)) * (1 if alternates else 2) / size
        value = complex(weights @ rounds.means)
        amplitude, freedom = abs(value), 1 if alternates else 2
        along = (weights * np.exp(-1j * np.angle(value))).real / np.sqrt(rounds.counts)
        error = noise * float(np.linalg.norm(along))
        share = (amplitude / error) ** 2 / freedom if error > 0.0 else math.nan
        culprits = [
            name for name, n in (("pins", pins), ("slots", wheel.slots)) if k * n % size == 0
        ]
        lines.append(
            BeatLine(
                k * pins / size, " or ".join(culprits) or "pairs", amplitude, error,
                float(special.fdtrc(freedom, within, share)) if within > 0 else math.nan,
            )
        )  # fmt: skip
    return BeatSpectrum(tuple(lines), mean, rounds)
