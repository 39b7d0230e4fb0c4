"""The generalised Lomb-Scargle periodogram, which looks for errors at any frequency.

At each frequency it gives the share of the variance that a sinusoid with a free mean explains. The
samples may be at any angles.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.measurement.readings import LEAST_SAMPLES, TURN
from escapement.mechanisms.protocol import FloatArray

optimize, special = Lazy("scipy.optimize"), Lazy("scipy.special")
MOST_TURNS = 1000.0
"""Greatest number of turns in a periodogram; more of them change an error that repeats little."""
_PER_TURN = 12.0  # the highest frequency, unless there are too few samples
_FINE = 64  # nodes of the grid in a period of the highest frequency
_OVERSAMPLING = 6
_SINGULAR = 4e-3  # the determinant is at most 1, and its error far below this


@dataclass(frozen=True, eq=False, repr=False)
class Periodogram(Shown):
    """Share of the variance of errors that a sinusoid explains, at each frequency.

    frequency : cycles in one turn of the angle, ascending, shape (m,) [-].
    power : share of the variance that a sinusoid explains, 0 to 1, shape (m,). It is NaN
        where the samples cannot separate a sinusoid from its mean: if they cover less than
        about a fifth of its period, or lie at one phase or at two opposite ones.
    amplitude : amplitude of that sinusoid, shape (m,), in the unit of the errors, or NaN.
    samples : number of errors.
    turns : turns of the angle from the first error to the last.
    bandwidth : number of independent frequencies, W of Baluev (2008) [-].
    """

    frequency: FloatArray
    power: FloatArray
    amplitude: FloatArray
    samples: int
    turns: float
    bandwidth: float

    def false_alarm_probability(self, power: ArrayLike) -> FloatArray:
        """Probability that white noise has a peak of at least `power` somewhere.

        This is an upper bound; where it is small, it is close to the probability.

        Source: Baluev (2008), Mon. Not. R. Astron. Soc. 385, eqs. 5 and 6.
        """
        height, n = np.clip(np.asarray(power, dtype=float), 0.0, 1.0), self.samples
        one = (1.0 - height) ** ((n - 3) / 2.0)
        # the Pochhammer symbol is Gamma((n - 1)/2)/Gamma((n - 2)/2), so the ratio is near 1
        ratio = math.sqrt(2.0 / (n - 1)) * float(special.poch((n - 2) / 2.0, 0.5))
        slopes = (1.0 - height) ** ((n - 4) / 2.0) * np.sqrt(0.5 * (n - 1) * height)
        many = self.bandwidth * ratio * slopes
        return np.asarray(-np.expm1(-many) + one * np.exp(-many))

    def level(self, probability: float) -> float:
        """Power that the greatest peak of white noise exceeds with a given probability."""

        def excess(power: ArrayLike) -> FloatArray:
            return self.false_alarm_probability(power) - probability

        if excess(1.0) > 0.0:
            return 1.0
        # the bound falls only beyond its greatest value, so the last crossing is the level
        powers = np.linspace(0.0, 1.0, 2001)
        return float(optimize.brentq(excess, powers[np.flatnonzero(excess(powers) > 0.0)[-1]], 1.0))

    @property
    def peak(self) -> int:
        """Index of the greatest power."""
        return int(np.argmax(np.nan_to_num(self.power)))


def periodogram(angle: FloatArray, errors: FloatArray) -> Periodogram:
    """Periodogram of errors over an angle.

    It reaches up to 12 cycles a turn, or up to half the number of samples a turn if that is
    less. Of many samples over more than 1000 turns only those of the first 1000 are used.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        Angles in any order, not all equal [rad].
    errors : ndarray, shape (n,)
        Errors at them, not all equal.

    Returns
    -------
    Periodogram
        Powers have a relative error of 0.2 % at the highest frequency and less at lower
        ones, because each error is divided between two neighbours in a fine grid of angles.

    Source: Zechmeister and Kuerster (2009), Astron. Astrophys. 496, eqs. 4 to 16.
    """
    turns, values = angle / TURN, errors
    most, span = _PER_TURN * MOST_TURNS, float(np.ptp(turns))
    top = min(_PER_TURN, 0.5 * values.size / span)
    near = np.abs(turns - turns[0]) <= MOST_TURNS
    if span * top > most and np.count_nonzero(near) >= LEAST_SAMPLES:
        turns, values = turns[near], values[near]
    elif span * top > most:
        top = most / span
    span = float(np.ptp(turns))
    top = max(top, 1.0 / span)
    values = values - values.mean()
    node = 1.0 / (_FINE * top)
    length = 1 << math.ceil(math.log2((span * _OVERSAMPLING) / node + 2))
    count = math.floor(top * length * node)
    second, whole = np.modf((turns - turns.min()) / node)
    first = whole.astype(np.int64)

    def transform(weights: FloatArray, most: int) -> FloatArray:
        """Means of weights times e^{-i a}, each weight shared between the two nearest nodes."""
        nodes = np.bincount(first, weights * (1.0 - second), length)
        nodes += np.bincount(first + 1, weights * second, length)
        return np.asarray(np.fft.rfft(nodes, length)[: most + 1] / values.size)

    ones = transform(np.ones_like(values), 2 * count)
    y = transform(values, count)[1:]
    # a wave w e^{ia} of means m, mm has the normal equation even w + double w* = 2 y
    m, mm = ones[1 : count + 1], ones[2::2]
    even, double = 1.0 - np.abs(m) ** 2, mm - m * m
    scale = even**2 - np.abs(double) ** 2
    # where it is singular all samples lie at one phase or two opposite ones
    scale = np.where(scale > _SINGULAR, scale, np.nan)
    wave = (even * y - double * y.conj()) * (2.0 / scale)
    power = np.clip((wave * y.conj()).real / (float(values @ values) / values.size), 0.0, 1.0)
    width = top * math.sqrt(4.0 * math.pi * float(turns.var()))
    frequency = np.arange(1, count + 1) / (length * node)
    return Periodogram(frequency, power, np.abs(wave), values.size, span, width)
