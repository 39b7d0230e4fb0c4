"""Periodogram of errors over an angle: which errors come back every turn?

The generalised Lomb-Scargle periodogram: at each frequency, the share of the
variance that a sinusoid with a free mean explains, for samples at any angles.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement.measurement.readings import LEAST_SAMPLES, TURN
from escapement.model import FloatArray

MOST_TURNS = 1000.0
"""Turns looked at; later ones tell nothing new of errors that come back."""
_PER_TURN = 12.0  # this is the highest frequency unless the samples are fewer
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
        from scipy.special import poch

        height, n = np.clip(np.asarray(power, dtype=float), 0.0, 1.0), self.samples
        one = (1.0 - height) ** ((n - 3) / 2.0)
        # the Pochhammer symbol is Gamma((n - 1)/2)/Gamma((n - 2)/2), so the ratio is near 1
        ratio = math.sqrt(2.0 / (n - 1)) * float(poch((n - 2) / 2.0, 0.5))
        slopes = (1.0 - height) ** ((n - 4) / 2.0) * np.sqrt(0.5 * (n - 1) * height)
        many = self.bandwidth * ratio * slopes
        bound: FloatArray = -np.expm1(-many) + one * np.exp(-many)
        return bound

    def level(self, probability: float) -> float:
        """Power that white noise exceeds anywhere with a probability in (0, 1)."""
        from scipy.optimize import brentq

        def excess(power: ArrayLike) -> FloatArray:
            return self.false_alarm_probability(power) - probability

        if excess(1.0) > 0.0:
            return 1.0
        # the bound falls only beyond its greatest value, so the last crossing is the level
        powers = np.linspace(0.0, 1.0, 2001)
        return float(brentq(excess, powers[np.flatnonzero(excess(powers) > 0.0)[-1]], 1.0))

    @property
    def peak(self) -> int:
        """Index of the greatest power."""
        return int(np.argmax(np.nan_to_num(self.power)))


def periodogram(angle: FloatArray, errors: FloatArray) -> Periodogram:
    """Periodogram of errors over an angle that counts on.

    It reaches up to 12 cycles a turn, or half as many as there are samples a turn where
    that is less. Of many samples over more than 1000 turns those of the first 1000 are used.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        Angles in any order, not all equal [rad].
    errors : ndarray, shape (n,)
        Errors at them, not all equal.

    Returns
    -------
    Periodogram
        Powers are accurate to 0.2 % of themselves at the highest frequency, and
        better below: sums run over a fine grid of angles, in which each error is
        shared between its neighbours.

    Source: Zechmeister and Kuerster (2009), Astron. Astrophys. 496, eqs. 4 to 16.
    """
    turns, values = angle / TURN, errors
    span = float(np.ptp(turns))
    top = min(_PER_TURN, 0.5 * values.size / span)
    if span * top > _PER_TURN * MOST_TURNS:
        near = np.abs(turns - turns[0]) <= MOST_TURNS
        if np.count_nonzero(near) >= LEAST_SAMPLES:
            turns, values = turns[near], values[near]
        else:
            top = _PER_TURN * MOST_TURNS / span
    span = float(np.ptp(turns))
    top = max(top, 1.0 / span)
    frequency, power, amplitude = _spectrum(turns, values - values.mean(), top, span)
    width = top * math.sqrt(4.0 * math.pi * float(turns.var()))
    return Periodogram(frequency, power, amplitude, values.size, span, width)


def _spectrum(
    turns: FloatArray, values: FloatArray, highest: float, span: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Frequencies, share of the variance explained, and amplitude."""
    node = 1.0 / (_FINE * highest)
    length = 1 << math.ceil(math.log2((span * _OVERSAMPLING) / node + 2))
    count = math.floor(highest * length * node)
    place = (turns - turns.min()) / node
    first = np.floor(place).astype(np.int64)
    second = place - first

    def transform(weights: FloatArray, most: int) -> FloatArray:
        """Means of weights times e^{-i a}, each weight shared between the two nearest nodes."""
        nodes = np.bincount(first, weights * (1.0 - second), length)
        nodes += np.bincount(first + 1, weights * second, length)
        return np.asarray(np.fft.rfft(nodes, length)[: most + 1] / values.size)

    ones = transform(np.ones_like(values), 2 * count)
    y = transform(values, count)[1:]
    w, ww = ones[1 : count + 1], ones[2::2]
    c, s = w.real, -w.imag
    yc, ys = y.real, -y.imag
    cc = 0.5 * (1.0 + ww.real) - c * c
    ss = 0.5 * (1.0 - ww.real) - s * s
    cs = -0.5 * ww.imag - c * s
    scale = cc * ss - cs * cs
    # where it is singular all samples lie at one phase or two opposite ones
    scale = np.where(scale > _SINGULAR, scale, np.nan)
    a, b = (yc * ss - ys * cs) / scale, (ys * cc - yc * cs) / scale
    share = (a * yc + b * ys) / (float(values @ values) / values.size)
    frequency = np.arange(1, count + 1) / (length * node)
    return frequency, np.clip(share, 0.0, 1.0), np.hypot(a, b)
