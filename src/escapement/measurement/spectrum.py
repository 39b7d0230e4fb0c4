"""Periodogram of errors over an angle: which errors come back every turn?

The generalised Lomb-Scargle periodogram: at each frequency, the share of the
variance that a sinusoid with a free mean explains, for samples at any angles.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.errors import InvalidValue
from escapement.measurement.readings import LEAST_SAMPLES, TURN
from escapement.model import FloatArray

MOST_TURNS = 1000.0
"""Turns looked at; later ones tell nothing new of errors that come back."""
_PER_TURN = 12.0  # this is the highest frequency unless the caller or the samples set another
_FINE = 64  # a period of the highest frequency has so many nodes
_OVERSAMPLING = 6
_SINGULAR = 1e-3  # the determinant is at most 1/4, and its error far below this


@dataclass(frozen=True, eq=False)
class Periodogram:
    """Share of the variance of errors that comes back at a frequency.

    frequency : cycles a turn of the angle, ascending, shape (m,) [-].
    power : share of the variance that a sinusoid explains, 0 to 1, shape (m,); NaN
        where the samples cannot tell a sinusoid from its mean: below about a fifth of
        a cycle over all of them, or where they lie at one phase or two opposite ones.
    amplitude : of that sinusoid, shape (m,), in the unit of the errors; NaN likewise.
    samples : number of errors.
    turns : of the angle from the first of them to the last.
    bandwidth : frequencies that can be told apart, W of Baluev (2008) [-].
    """

    frequency: FloatArray
    power: FloatArray
    amplitude: FloatArray
    samples: int
    turns: float
    bandwidth: float

    def false_alarm_probability(self, power: ArrayLike) -> FloatArray:
        """Probability that white noise has a peak of at least `power` somewhere.

        An upper bound, and close where it is small.

        Source: Baluev (2008), Mon. Not. R. Astron. Soc. 385, eqs. 5 and 6.
        """
        height = np.clip(np.asarray(power, dtype=float), 0.0, 1.0)
        one = (1.0 - height) ** ((self.samples - 3) / 2.0)
        many = (
            self.bandwidth * _gamma_ratio(self.samples - 1)
            * (1.0 - height) ** ((self.samples - 4) / 2.0)
            * np.sqrt(0.5 * (self.samples - 1) * height)
        )  # fmt: skip
        bound: FloatArray = -np.expm1(-many) + one * np.exp(-many)
        return bound

    def level(self, probability: float) -> float:
        """Power that white noise exceeds anywhere with a probability in (0, 1)."""
        from scipy.optimize import brentq

        chance = validate.number("probability", probability, "give a share, as 0.01")
        if not 0.0 < chance < 1.0:
            raise validate.fail("probability", "between 0 and 1", chance, "give for example 0.01")
        if self.false_alarm_probability(1.0) > chance:
            return 1.0

        def excess(power: float) -> float:
            return float(self.false_alarm_probability(power)) - chance

        # the bound falls only beyond its greatest value, so the last crossing is the level
        powers = np.linspace(0.0, 1.0, 2001)
        above = np.flatnonzero(self.false_alarm_probability(powers) > chance)
        return float(brentq(excess, powers[above[-1]], 1.0))

    @property
    def peak(self) -> int:
        """Index of the greatest power."""
        return int(np.argmax(np.nan_to_num(self.power)))


def periodogram(angle: ArrayLike, errors: ArrayLike, highest: float | None = None) -> Periodogram:
    """Periodogram of errors over an angle that counts on.

    Parameters
    ----------
    angle : array_like, shape (n,)
        Angles in any order [rad]. Of many samples over more than 1000 turns those of
        the first 1000 are used, of fewer turns where `highest` is above 12.
    errors : array_like, shape (n,)
        Errors at them, finite and not all equal.
    highest : float, optional
        Highest frequency [cycles a turn]. Default: 12, or half as many as there are
        samples a turn where that is less.

    Returns
    -------
    Periodogram
        Powers are accurate to 0.2 % of themselves at the highest frequency, and
        better below: sums run over a fine grid of angles, in which each error is
        shared between its neighbours.

    Raises
    ------
    InvalidValue
        When the columns do not match, hold anything but finite numbers or the same
        number throughout, or `highest` is more than the grid can hold over so many turns.

    Source: Zechmeister and Kuerster (2009), Astron. Astrophys. 496, eqs. 4 to 16.
    """
    turns, values = _row("angle", angle) / TURN, _row("errors", errors)
    if turns.size != values.size:
        raise InvalidValue(
            f"angle and errors must be of one length, got {turns.size} and {values.size}; "
            "give the angle of each error"
        )
    if highest is not None:
        highest = validate.positive("highest", highest, "give cycles a turn")
    if not (values.size and np.ptp(values) > 0.0 and np.ptp(turns) > 0.0):
        raise InvalidValue("errors and angles must differ for a periodogram, got one value only")
    turns, values, top = _bounded(turns, values, highest)
    span = float(np.ptp(turns))
    top = max(top, 1.0 / span)
    sums = _FourierSums(turns, values - values.mean(), top, span)
    power, amplitude = sums.power()
    width = top * math.sqrt(4.0 * math.pi * float(turns.var()))
    return Periodogram(sums.frequency, power, amplitude, values.size, span, width)


def _row(name: str, values: ArrayLike) -> FloatArray:
    array = np.asarray(values)
    if array.dtype.kind not in "iuf" or array.ndim != 1 or np.ma.is_masked(values):
        raise validate.fail(name, "a row of real numbers", values, "leave out what is missing")
    row: FloatArray = array.astype(float)
    if not np.isfinite(row).all():
        place = int(np.argmin(np.isfinite(row)))
        raise InvalidValue(
            f"{name} must be finite, got {float(row[place])!r} in sample {place + 1}; "
            "leave out what is missing"
        )
    return row


class _FourierSums:
    """Means of w, w e^{i a}, y e^{i a} and e^{2 i a} at all frequencies, by FFT."""

    def __init__(self, turns: FloatArray, values: FloatArray, highest: float, span: float) -> None:
        node = 1.0 / (_FINE * highest)
        length = 1 << math.ceil(math.log2((span * _OVERSAMPLING) / node + 2))
        count = math.floor(highest * length * node)
        self.frequency = np.arange(1, count + 1) / (length * node)
        place = (turns - turns.min()) / node
        first = np.floor(place).astype(np.int64)
        second = place - first
        ones = _shared(first, second, np.ones_like(values), length)
        weights = np.fft.rfft(ones, length)[: 2 * count + 1] / values.size
        self.w, self.ww = weights[1 : count + 1], weights[2 : 2 * count + 1 : 2]
        self.y = np.fft.rfft(_shared(first, second, values, length), length)[1 : count + 1]
        self.y /= values.size
        self.variance = float(values @ values) / values.size

    def power(self) -> tuple[FloatArray, FloatArray]:
        """Share of the variance explained, and amplitude."""
        c, s = self.w.real, -self.w.imag
        yc, ys = self.y.real, -self.y.imag
        cc = 0.5 * (1.0 + self.ww.real) - c * c
        ss = 0.5 * (1.0 - self.ww.real) - s * s
        cs = -0.5 * self.ww.imag - c * s
        scale = cc * ss - cs * cs
        told = scale > _SINGULAR  # otherwise all samples lie at one phase or two opposite ones
        scale = np.where(told, scale, np.nan)
        a, b = (yc * ss - ys * cs) / scale, (ys * cc - yc * cs) / scale
        return np.clip((a * yc + b * ys) / self.variance, 0.0, 1.0), np.hypot(a, b)


def _shared(first: np.ndarray, second: FloatArray, values: FloatArray, length: int) -> FloatArray:
    """Values on the nodes of a grid, each shared between the two nearest."""
    nodes = np.zeros(length)
    nodes += np.bincount(first, values * (1.0 - second), length)
    nodes += np.bincount(first + 1, values * second, length)
    return nodes


def _bounded(
    turns: FloatArray, values: FloatArray, highest: float | None
) -> tuple[FloatArray, FloatArray, float]:
    """Samples and highest frequency that a grid of bounded length can hold."""
    span, asked = float(np.ptp(turns)), highest
    if highest is None:
        highest = min(_PER_TURN, 0.5 * values.size / span)
    if span * highest <= _PER_TURN * MOST_TURNS:
        return turns, values, highest
    near = np.abs(turns - turns[0]) <= MOST_TURNS * min(1.0, _PER_TURN / highest)
    told = np.count_nonzero(near) >= LEAST_SAMPLES and np.ptp(turns[near]) > 0.0
    if told and np.ptp(values[near]) > 0.0:
        return turns[near], values[near], highest
    most = _PER_TURN * MOST_TURNS / span
    if asked is not None:
        rule = f"at most {most:.6g} for {values.size} samples over {span:.6g} turns"
        raise validate.fail("highest", rule, asked, "ask for less, or give samples of fewer turns")
    return turns, values, most


def _gamma_ratio(n: int) -> float:
    """sqrt(2/n) Gamma(n/2)/Gamma((n - 1)/2), near 1."""
    return math.sqrt(2.0 / n) * math.exp(math.lgamma(n / 2.0) - math.lgamma((n - 1) / 2.0))
