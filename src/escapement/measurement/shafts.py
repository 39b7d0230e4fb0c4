"""Errors that belong to a shaft: an eccentric gear or encoder shows once a turn."""

import math
from typing import NamedTuple

import numpy as np

from escapement.measurement.fit import blocks
from escapement.measurement.readings import TURN
from escapement.model import FloatArray

ORDERS = (1, 2)
"""Cycles a turn: 1 an eccentric disc, 2 a tilted or an oval one."""
_SURE = 1e-3
"""Chance of taking any wave for real that is none."""
_COLLINEAR = 1e-9  # a wave of which others leave less is not told from them; rounding is far below
_UNKNOWN = (math.nan, math.nan, math.nan)


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


class _Shaft(NamedTuple):
    """A shaft's angle at each sample, and what an error of it does to the output."""

    name: str
    angle: FloatArray
    effect: FloatArray | float

    @property
    def turns(self) -> float:
        return float(np.ptp(self.angle)) / TURN

    @property
    def all_round(self) -> bool:
        """Whether it was measured all round, one mean step after the last sample counted."""
        return self.turns * self.angle.size >= (1.0 - 1e-9) * (self.angle.size - 1)


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
    shafts = [
        _Shaft("input", driver, slope),
        _Shaft("output", follower, 1.0),
        _Shaft("cell", driver * (TURN / cell), 1.0),
    ]
    seen = [shaft for shaft in shafts if shaft.all_round]
    sums = _normal_equations(seen, slope, errors)
    sure = _significant(sums)
    names = [(shaft.name, order) for shaft in seen for order in ORDERS]
    found = {
        name: sums.test(pair, _columns([other for other in sure if other != pair]))
        for name, pair in zip(names, sums.pairs, strict=True)
    }
    errors_of_shafts = tuple(
        ShaftError(shaft.name, order, *found.get((shaft.name, order), _UNKNOWN), shaft.turns)
        for shaft in shafts
        for order in ORDERS
    )
    return errors_of_shafts, sums.correlation(_columns(sure))


class _NormalEquations(NamedTuple):
    """Normal equations of all columns: offset, phase, then a pair for each wave.

    gram, products, total : of the columns, with the errors, of the errors.
    following : of each of the columns and the errors, last, with the next sample's.
    """

    gram: FloatArray
    products: FloatArray
    total: float
    following: FloatArray
    samples: int

    @property
    def pairs(self) -> range:
        """First column of each wave."""
        return range(2, len(self.products), 2)

    def test(self, pair: int, others: list[int]) -> tuple[float, float, float]:
        """Amplitude of a wave, its standard error and p-value, beside other columns.

        NaN where it cannot be told from those.
        """
        from scipy.stats import f

        base, two = [0, 1, *others], [pair, pair + 1]
        inverse = np.linalg.pinv(self.gram[np.ix_(base, base)], rcond=1e-12, hermitian=True)
        across = self.gram[np.ix_(two, base)] @ inverse
        own = self.gram[np.ix_(two, two)]
        left = own - across @ self.gram[np.ix_(base, two)]
        if np.linalg.eigvalsh(left)[0] <= _COLLINEAR * np.trace(own):
            return _UNKNOWN
        value = np.linalg.solve(left, self.products[two] - across @ self.products[base])
        explained = float(value @ left @ value)
        before = self.total - float(self.products[base] @ inverse @ self.products[base])
        freedom = self.samples - len(base) - 2
        variance = max(before - explained, 0.0) / freedom
        amplitude = float(np.hypot(*value))
        if not (variance > 0.0 and amplitude > 0.0):
            return _UNKNOWN
        along = value / amplitude
        error = math.sqrt(variance * float(along @ np.linalg.solve(left, along)))
        return amplitude, error, float(f.sf(explained / (2.0 * variance), 2, freedom))

    def correlation(self, others: list[int]) -> float:
        """Correlation of neighbours in what offset, phase and other columns leave."""
        base = [0, 1, *others]
        inverse = np.linalg.pinv(self.gram[np.ix_(base, base)], rcond=1e-12, hermitian=True)
        fitted = inverse @ self.products[base]
        left = self.total - float(self.products[base] @ fitted)
        if left <= _COLLINEAR * self.total:
            return 0.0
        rest = np.zeros(len(self.products) + 1)
        rest[base], rest[-1] = -fitted, 1.0
        return float(rest @ self.following @ rest) / left


def _significant(sums: _NormalEquations) -> list[int]:
    """Significant waves, the most significant first, each tested beside those before."""
    found: list[int] = []
    while len(found) < len(sums.pairs):
        tests = {
            pair: sums.test(pair, _columns(found))[2] for pair in sums.pairs if pair not in found
        }
        best = min(tests, key=lambda pair: math.inf if math.isnan(tests[pair]) else tests[pair])
        if not tests[best] < _SURE / len(sums.pairs):
            break
        found.append(best)
    return found


def _columns(pairs: list[int]) -> list[int]:
    return [column for pair in pairs for column in (pair, pair + 1)]


def _normal_equations(
    shafts: list[_Shaft], slope: FloatArray, errors: FloatArray
) -> _NormalEquations:
    """Sums over all samples, a block of them at a time."""
    size = 2 + 2 * len(ORDERS) * len(shafts)
    gram, following = (np.zeros((size + 1, size + 1)) for _ in range(2))
    for part in blocks(errors.size):
        columns = [np.ones_like(errors[part]), slope[part]]
        for shaft in shafts:
            effect = shaft.effect if isinstance(shaft.effect, float) else shaft.effect[part]
            for order in ORDERS:
                wave = np.exp(1j * order * shaft.angle[part])
                columns += [effect * wave.real, effect * wave.imag]
        table = np.array([*columns, errors[part]])
        gram += table @ table.T
        # the few pairs that the end of a block separates are left out
        following += table[:, 1:] @ table[:, :-1].T
    return _NormalEquations(
        gram[:-1, :-1], gram[:-1, -1], float(gram[-1, -1]), following, errors.size
    )
