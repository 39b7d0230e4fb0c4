"""Measured beats, sorted by their pin and slot: means of each pair of these, and their spectrum.

Some of the noise of an interval between beats may be of each beat alone and adds up over the beats
of an interval, and some may be the jitter of the instants at its ends, which neighbouring intervals
share with opposite signs: an instant that is late makes the interval before it longer and the one
after it shorter. Let s be the share of the variance of a beat that comes from jitter. Then an
interval of m beats has the variance (1 - s) m + s, neighbours have the covariance -s/2, and others
0. Since s is not known, results are means over s, weighted by the restricted likelihood. The
covariance matrix has three diagonals, so that the effort grows with the number of intervals only.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.measurement.loggers import row_of
from escapement.measurement.readings import Readings
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray, Mechanism

linalg = Lazy("scipy.linalg")
special = Lazy("scipy.special")


class IntervalSolution(NamedTuple):
    """Unknowns by least squares, for one share of jitter or averaged over several.

    values, covariance : shapes (m,) and (m, m), the latter for noise of a beat of size 1.
    scatter : sum of the squared residuals, made independent.
    likelihood : logarithm of the restricted likelihood, except for a constant; NaN of an average.
    weights : probability of each share in an average.
    """

    values: FloatArray
    covariance: FloatArray
    scatter: float
    likelihood: float
    weights: FloatArray


class Intervals(NamedTuple):
    """Intervals that are combinations of unknowns, apart from noise.

    values : shape (n,).
    design : shape (n, m).
    numbers : beats of each, shape (n,).
    joined : whether each begins where the one before it ends, bool, shape (n - 1,).
    """

    values: FloatArray
    design: FloatArray
    numbers: np.ndarray
    joined: np.ndarray

    @property
    def freedom(self) -> int:
        """Degrees of freedom that remain."""
        return int(self.values.size - self.design.shape[1])

    def _factor(self, share: float) -> FloatArray:
        """Lower Cholesky factor of the covariance of noise of size 1, diagonal by diagonal."""
        band = np.zeros((2, self.values.size))
        band[0] = (1.0 - share) * self.numbers + share
        band[1, :-1] = -0.5 * share * self.joined
        return np.asarray(linalg.cholesky_banded(band, lower=True))

    def independent(self, rest: FloatArray, share: float) -> FloatArray:
        """Residuals, made independent."""
        return np.asarray(linalg.solve_banded((1, 0), self._factor(share), rest))

    def solution(self, share: float) -> IntervalSolution:
        """Least squares with one share of jitter."""
        factor = self._factor(share)
        columns = np.column_stack([self.design, self.values])
        white = linalg.solve_banded((1, 0), factor, columns)
        basis, upper = np.linalg.qr(white[:, :-1])
        along = basis.T @ white[:, -1]
        rest = white[:, -1] - basis @ along
        scatter, inverse = float(rest @ rest), np.linalg.inv(upper)
        size = np.log(factor[0]).sum() + np.log(np.abs(np.diag(upper))).sum()
        likelihood = -float(size) - 0.5 * self.freedom * math.log(scatter or 1e-300)
        return IntervalSolution(
            inverse @ along, inverse @ inverse.T, scatter, likelihood, np.ones(1)
        )

    def average(
        self, shares: FloatArray, before: FloatArray | float = 1.0, gain: float = 0.0
    ) -> IntervalSolution:
        """The mean of the solutions with some shares, the last of which is 0.

        before : probabilities of the shares before the measurement.
        gain : of log-likelihood, that any share has to give over 0; else that share counts alone.
        """
        each = [self.solution(share) for share in shares.tolist()]
        likelihoods = np.array([one.likelihood for one in each])
        weights = before * np.exp(likelihoods - likelihoods.max())
        if gain and likelihoods.max() - likelihoods[-1] <= gain:
            weights = np.where(shares == 0.0, 1.0, 0.0)
        weights /= weights.sum()
        values = np.asarray(weights @ [one.values for one in each])
        scatter = float(weights @ [one.scatter for one in each])
        covariance = np.zeros((values.size, values.size))
        for weight, one in zip(weights.tolist(), each, strict=True):
            size = one.scatter / scatter if scatter > 0.0 else 1.0
            covariance += weight * size * one.covariance
            if scatter > 0.0:
                apart = one.values - values
                covariance += weight * self.freedom / scatter * np.outer(apart, apart)
        return IntervalSolution(values, covariance, scatter, math.nan, weights)


_ROOTS = np.linspace(0.0, 1.0, 21)
SHARES = 1.0 - _ROOTS**2
"""Shares of the variance that may come from time stamps, closest where their effect is greatest."""
_SURE = 5.4  # a gain of log-likelihood that chance exceeds once in a thousand times


@dataclass(frozen=True, eq=False, repr=False)
class Rounds(Shown):
    """Beats in rows; each row contains all pairs of pins and slots once.

    table : ndarray, shape (rounds, pattern)
        Beats [s], NaN where one is missing.
    faults : tuple of str
        Ticks that are out of place, in words.
    intervals : Intervals
        The measured beats as combinations of the means.
    means : ndarray, shape (pattern,)
        Best estimate of the beat of each engagement of the pattern [s].
    covariance : ndarray, shape (pattern, pattern)
        That of the means, for noise of a beat of size 1.
    scatter : float
        Sum of the squared deviations from the means, made independent [s^2].
    weights : ndarray, shape (21,)
        Probability of each of `SHARES`.
    """

    table: FloatArray
    faults: tuple[str, ...]
    intervals: Intervals = field(repr=False)
    means: FloatArray = field(repr=False)
    covariance: FloatArray = field(repr=False)
    scatter: float = field(repr=False)
    weights: FloatArray = field(repr=False)

    @property
    def jitter(self) -> float:
        """Share of the variance of a beat's noise that comes from the jitter of time stamps [-].

        The correlation of neighbouring beats is -jitter/2.
        """
        return float(self.weights @ SHARES)

    @property
    def pattern(self) -> int:
        """Engagements after which pins and slots meet again."""
        return int(self.table.shape[1])

    @property
    def samples(self) -> int:
        """Number of measured beats."""
        return int(self.intervals.values.size)

    @property
    def known(self) -> np.ndarray:
        """Indices of the measured beats in turn, shape (samples,)."""
        return np.flatnonzero(np.isfinite(self.table.ravel()))

    @cached_property
    def root(self) -> FloatArray:
        """R such that R (means - true means) is independent noise of one beat's size."""
        return np.asarray(linalg.cholesky(np.linalg.inv(self.covariance)))

    @property
    def spread(self) -> FloatArray:
        """Standard deviation of each mean less the mean of all, for noise of one beat of 1 [-].

        Shape (pattern,). Time stamps make it smaller than with independent beats, because a stamp
        that comes late makes one beat longer and the next one shorter.
        """
        weights = np.eye(self.pattern) - 1.0 / self.pattern
        return np.asarray(np.linalg.norm(weights @ np.linalg.inv(self.root), axis=1))

    def independent(self, computed: FloatArray) -> FloatArray:
        """Measured beats less computed ones of one pattern, made independent, shape (samples,)."""
        rest = (self.table - computed).ravel()[self.known]
        return self.intervals.independent(rest, self.jitter)


def rounds_of(given: ArrayLike | Readings, mechanism: Mechanism) -> Rounds:
    """Durations or instants of beats as rounds, the last of which may end early; see `fit_beats`.

    Durations count as differences of instants only where they show it with certainty.
    """
    if not isinstance(mechanism, Geneva):
        remedy = "other beats tell only rate and beat error, without a mechanism"
        raise validate.fail("mechanism", "a Geneva wheel", mechanism, remedy)
    pins, slots = mechanism.pins or 1, mechanism.slots
    size = math.lcm(pins, slots)
    instants = isinstance(given, Readings)
    if isinstance(given, Readings):
        if given.half_widths is None:
            raise validate.fail("beats", "Readings of beats", given, "see escapement.read_beats")
        given = np.diff(np.asarray(given.time))
    values = _durations(given)
    faults = [*_displaced(values, size)]
    table = np.full(-(-max(values.size, 1) // size) * size, np.nan)
    table[: values.size] = values
    known = np.flatnonzero(np.isfinite(table))
    counts = np.bincount(known % size, minlength=size)
    if counts.min() == 0:
        k = int(counts.argmin())
        amiss = f" ({'; '.join(faults)})" if faults else ""
        raise InvalidValue(
            f"beats must tell of all {size} engagements of the pattern, got none of pin "
            f"{k % pins} in slot {k % slots}{amiss}; measure longer"
        )
    design, joined = np.eye(size)[known % size], np.diff(known) == 1
    intervals = Intervals(table[known], design, np.ones(known.size), joined)
    # the shares are closer to each other by their square root near 1
    found = intervals.average(SHARES, _ROOTS, 0.0 if instants else _SURE)
    means = found.values, found.covariance, found.scatter, found.weights
    return Rounds(table.reshape(-1, size), tuple(faults), intervals, *means)


_SHORT, _LONG = 0.5, 1.5  # shares of the median beat beyond which a tick was missed or doubled
_REMEDY = (
    "give NaN for each beat near a tick that was missed or doubled, instants as Readings.of_beats, "
    "or a file to escapement.read_beats, which counts the beats"
)


def _durations(given: ArrayLike) -> FloatArray:
    """Durations of beats in turn [s], of which none is far from the median."""
    beats = row_of("beats", given, _REMEDY)
    known = np.isfinite(beats)
    typical = float(np.median(beats[known])) if known.any() else 1.0
    alike = (beats > max(_SHORT * typical, 0.0)) & (beats < _LONG * typical)
    if (wrong := np.flatnonzero(~np.isnan(beats) & ~alike)).size:
        rule = f"about as long as the others, {typical:.3g} s"
        raise validate.fail(f"beat {wrong[0]}", rule, float(beats[wrong[0]]), _REMEDY)
    return np.array(beats)


_OUT, _ROUNDS = 6.0, 4  # standard deviations that no noise has, and rounds that show it


def _displaced(beats: FloatArray, pattern: int) -> Iterator[str]:
    """Leave out beats that are far from those of the same pin and slot in other rounds."""
    padded = np.full(-(-beats.size // pattern) * pattern, np.nan)
    padded[: beats.size] = beats
    table = padded.reshape(-1, pattern)
    if np.isfinite(table).sum(axis=0).min(initial=_ROUNDS) < _ROUNDS or not beats.size:
        return
    apart = (table - np.nanmedian(table, axis=0)).ravel()[: beats.size]
    known = np.sort(np.abs(apart[np.isfinite(apart)]))
    # of normal noise one in ten is beyond 1.645 standard deviations
    scatter = known[int(0.9 * (known.size - 1))] / 1.645
    steps = np.diff(np.unique(beats[np.isfinite(beats)]))
    # a coarse clock may show a difference of two steps of its own
    least = 2.0 * float(steps.min()) if steps.size else 0.0
    out = np.flatnonzero(np.nan_to_num(np.abs(apart)) > _OUT * scatter + least)
    if out.size > 0.1 * beats.size:
        return
    for index in out.tolist():
        yield (
            f"engagement {index} takes {beats[index] / (beats[index] - apart[index]):.3f} times as "
            "long as with the same pin and slot in other rounds: a tick is out of place, and the "
            "beat is left out"
        )
        beats[index] = np.nan


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
    rounds : the measured beats; its `faults` name ticks that are out of place.
    """

    lines: tuple[BeatLine, ...]
    mean: float
    rounds: Rounds


def beat_spectrum(beats: ArrayLike | Readings, mechanism: Mechanism) -> BeatSpectrum:
    """Lines in the spectrum of measured beats, each with the parts that cause it.

    Errors of pins repeat with every turn of the driver, those of slots with every turn of the
    follower. So in cycles per turn of the driver the lines of m pins are at 1, 2, .., those of n
    slots at m/n, 2 m/n, ..; if m and n have a common factor, some of them coincide.

    Parameters
    ----------
    beats : array_like, shape (N,), or Readings
        Times of the engagements in turn [s], NaN or masked where one is missing, or instants, as
        for `fit_beats`.
    mechanism : Geneva
        The wheel.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    rounds = rounds_of(beats, mechanism)
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
