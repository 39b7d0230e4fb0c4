"""Errors that come back: of a shaft, once or twice a turn, and at any frequency.

An eccentric gear or encoder disc shows once a turn of its shaft. The generalised Lomb-Scargle
periodogram looks for anything else: at each frequency, the share of the variance that a
sinusoid with a free mean explains, for samples at any angles.
"""

import math
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.lazy import Lazy
from escapement.measurement.readings import LEAST_SAMPLES, TURN, blocks
from escapement.mechanism import FloatArray

optimize, special = Lazy("scipy.optimize"), Lazy("scipy.special")
MOST_TURNS = 1000.0
"""Turns that a periodogram looks at; later ones tell nothing new of errors that come back."""
_ORDERS = (1, 2)  # cycles a turn: of an eccentric disc, and of a tilted or an oval one
_SURE = 1e-3  # chance of taking any wave for real that is none
_TELLING = 3.0  # an amplitude of fewer standard errors is all but hidden
_LEAST = 5e-324  # it stands for a p-value that is too small for a double
_COLLINEAR = 1e-9  # a wave of which others leave less is not told from them; rounding is far below
_UNKNOWN = (math.nan, math.nan, math.nan)
_PER_TURN = 12.0  # this is the highest frequency unless the samples are fewer
_FINE = 64  # a period of the highest frequency has so many nodes
_OVERSAMPLING = 6
_SINGULAR = 4e-3  # the determinant is at most 1, and its error far below this


class ShaftError(NamedTuple):
    """A sinusoidal error of one shaft, fitted beside all others that are significant.

    shaft : "input", "output" or "cell", which comes back with the mechanism.
    order : cycles a turn of the shaft, or a cell.
    amplitude : of the error of that shaft's angle [rad]. Of the input's, what
        reaches the output is multiplied by the transmission.
    standard_error : of the amplitude [rad].
    p_value : probability that independent normal errors show as much (F test).
    turns : of the shaft, or cells, from the first sample to the last; if less than 1
        with one mean step more, the rest is NaN.
    """

    shaft: str
    order: int
    amplitude: float
    standard_error: float
    p_value: float
    turns: float

    def told(self, correlation: float) -> str:
        """What comes back, with reserve where noise of a correlation may look the same.

        Nothing where independent noise may look the same too.
        """
        if not self.p_value < _SURE:
            return ""
        # To a slow wave n errors of correlation r are worth n (1 - r)/(1 + r) independent ones.
        # In an F test with two degrees of freedom p is then raised to that share.
        worth = (1.0 - correlation) / (1.0 + correlation) if correlation > 0.0 else 1.0
        sure = max(self.p_value, _LEAST) ** worth < _SURE
        where = "cell" if self.shaft == "cell" else f"turn of the {self.shaft}"
        often, comes = ("once", "twice")[self.order - 1], "comes" if sure else "may come"
        when = f"{comes} back {often} a {where}"
        amplitude, doubt = math.degrees(self.amplitude), math.degrees(self.standard_error)
        size = f"{amplitude:.3g} +- {doubt:.2g} degrees"
        hidden = f"an error {when}, its size all but hidden by phase, offset and others ({size})"
        text = f"an error of {size} {when}" if _TELLING * doubt < amplitude else hidden
        return text if sure else f"{text}, or is noise whose neighbours are alike"


def shaft_errors(
    driver: FloatArray, follower: FloatArray, slope: FloatArray, cell: float, errors: FloatArray
) -> tuple[tuple[ShaftError, ...], float]:
    """Sinusoidal errors once and twice a turn of the input, the output, and a cell.

    The second result is the correlation of neighbours in what the significant ones leave, -1 to 1.

    Over few turns one looks much like another. So the surest is fitted first, with a
    phase and an offset, then the surest of what is left, as long as one in a thousand
    sets of independent errors would show as much; and each is tested beside those.

    Parameters
    ----------
    driver, follower : ndarray, shape (n,)
        Angles of the shafts, counting on [rad].
    slope : ndarray, shape (n,)
        Transmission, of the output's reading over the input's [-].
    cell : float
        Driver angle of a cell [rad].
    errors : ndarray, shape (n,)
        Measured less theory [rad].
    """
    angles = {"input": driver, "output": follower, "cell": driver * (TURN / cell)}
    turns = {name: float(np.ptp(angle)) / TURN for name, angle in angles.items()}
    # a shaft was measured all round if one mean step after the last sample completes its turn
    least = (1.0 - 1e-9) * (errors.size - 1) / errors.size
    waves = {wave: 2 + 2 * i for i, wave in enumerate(product(angles, _ORDERS))}
    judged = [pair for (name, _), pair in waves.items() if turns[name] >= least]
    sums = _normal_equations(angles, slope, errors)
    sure: list[int] = []
    # the most significant first, each tested beside those before
    while rest := [pair for pair in judged if pair not in sure]:
        chances = np.nan_to_num([sums.test(pair, sure)[2] for pair in rest], nan=np.inf)
        if not chances.min() < _SURE / len(judged):
            break
        sure.append(rest[int(chances.argmin())])
    tests = {pair: sums.test(pair, [it for it in sure if it != pair]) for pair in judged}
    found = (
        ShaftError(name, order, *tests.get(pair, _UNKNOWN), turns[name])
        for (name, order), pair in waves.items()
    )
    return tuple(found), sums.correlation(sure)


class _NormalEquations(NamedTuple):
    """Normal equations of all columns: offset, phase, a pair for each wave, and the errors last.

    gram : products of the columns, summed over the samples.
    following : the same of each column and the next sample of each.
    """

    gram: FloatArray
    following: FloatArray
    samples: int

    def without(self, pairs: list[int]) -> FloatArray:
        """What times the columns leaves of each beside offset, phase and some waves."""
        base = [0, 1, *(column for pair in pairs for column in (pair, pair + 1))]
        own = self.gram[np.ix_(base, base)]
        left = np.eye(len(self.gram))
        left[base] -= np.linalg.pinv(own, rcond=1e-12, hermitian=True) @ self.gram[base]
        return left

    def test(self, pair: int, others: list[int]) -> tuple[float, float, float]:
        """Amplitude of a wave, its standard error and p-value, beside other waves.

        NaN where it cannot be told from those.
        """
        left, two = self.gram @ self.without(others), slice(pair, pair + 2)
        own, product = left[two, two], left[two, -1]
        if np.linalg.eigvalsh(own)[0] <= _COLLINEAR * np.trace(self.gram[two, two]):
            return _UNKNOWN
        value = np.linalg.solve(own, product)
        explained, freedom = float(value @ product), self.samples - 2 * len(others) - 4
        variance = max(float(left[-1, -1]) - explained, 0.0) / freedom
        amplitude = float(np.hypot(*value))
        if not (variance > 0.0 and amplitude > 0.0):
            return _UNKNOWN
        along = value / amplitude
        error = math.sqrt(variance * float(along @ np.linalg.solve(own, along)))
        return amplitude, error, float(special.fdtrc(2, freedom, explained / (2.0 * variance)))

    def correlation(self, others: list[int]) -> float:
        """Correlation of neighbours in what offset, phase and other waves leave."""
        rest = self.without(others)[:, -1]
        left = float(self.gram[-1] @ rest)
        if left <= _COLLINEAR * self.gram[-1, -1]:
            return 0.0
        return float(rest @ self.following @ rest) / left


def _normal_equations(
    angles: dict[str, FloatArray], slope: FloatArray, errors: FloatArray
) -> _NormalEquations:
    """Sums over all samples, a block of them at a time."""
    gram = following = np.zeros(())
    for part in blocks(errors.size):
        columns = [np.ones_like(errors[part]), slope[part]]
        for name, angle in angles.items():
            # an error of the input reaches the output through the transmission
            effect = slope[part] if name == "input" else 1.0
            for order in _ORDERS:
                wave = np.exp(1j * order * angle[part])
                columns += [effect * wave.real, effect * wave.imag]
        table = np.array([*columns, errors[part]])
        gram = gram + table @ table.T
        # the few pairs that the end of a block separates are left out
        following = following + table[:, 1:] @ table[:, :-1].T
    return _NormalEquations(gram, following, errors.size)


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
        height, n = np.clip(np.asarray(power, dtype=float), 0.0, 1.0), self.samples
        one = (1.0 - height) ** ((n - 3) / 2.0)
        # the Pochhammer symbol is Gamma((n - 1)/2)/Gamma((n - 2)/2), so the ratio is near 1
        ratio = math.sqrt(2.0 / (n - 1)) * float(special.poch((n - 2) / 2.0, 0.5))
        slopes = (1.0 - height) ** ((n - 4) / 2.0) * np.sqrt(0.5 * (n - 1) * height)
        many = self.bandwidth * ratio * slopes
        return np.asarray(-np.expm1(-many) + one * np.exp(-many))

    def level(self, probability: float) -> float:
        """Power that white noise exceeds anywhere with a probability in (0, 1)."""

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
