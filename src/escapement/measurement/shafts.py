"""Errors that belong to a shaft: an eccentric gear or encoder shows once a turn."""

import math
from typing import NamedTuple

import numpy as np

from escapement.measurement.readings import TURN, blocks
from escapement.model import FloatArray

_ORDERS = (1, 2)  # cycles a turn: of an eccentric disc, and of a tilted or an oval one
_SURE = 1e-3  # chance of taking any wave for real that is none
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
    seen = {name: angle for name, angle in angles.items() if turns[name] >= least}
    sums = _normal_equations(seen, slope, errors)
    sure = _significant(sums)
    waves = [(name, order) for name in seen for order in _ORDERS]
    found = {
        wave: sums.test(pair, [other for other in sure if other != pair])
        for wave, pair in zip(waves, sums.pairs, strict=True)
    }
    errors_of_shafts = tuple(
        ShaftError(name, order, *found.get((name, order), _UNKNOWN), turns[name])
        for name in angles
        for order in _ORDERS
    )
    return errors_of_shafts, sums.correlation(sure)


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

    def base(self, pairs: list[int]) -> tuple[list[int], FloatArray]:
        """Columns of offset, phase and some waves, and the inverse of their equations."""
        base = [0, 1, *(column for pair in pairs for column in (pair, pair + 1))]
        gram = self.gram[np.ix_(base, base)]
        return base, np.asarray(np.linalg.pinv(gram, rcond=1e-12, hermitian=True), dtype=float)

    def test(self, pair: int, others: list[int]) -> tuple[float, float, float]:
        """Amplitude of a wave, its standard error and p-value, beside other waves.

        NaN where it cannot be told from those.
        """
        from scipy.stats import f

        base, inverse = self.base(others)
        two = [pair, pair + 1]
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
        """Correlation of neighbours in what offset, phase and other waves leave."""
        base, inverse = self.base(others)
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
    while rest := [pair for pair in sums.pairs if pair not in found]:
        tests = np.array([sums.test(pair, found)[2] for pair in rest])
        best = int(np.argmin(np.where(np.isnan(tests), np.inf, tests)))
        if not tests[best] < _SURE / len(sums.pairs):
            break
        found.append(rest[best])
    return found


def _normal_equations(
    angles: dict[str, FloatArray], slope: FloatArray, errors: FloatArray
) -> _NormalEquations:
    """Sums over all samples, a block of them at a time."""
    size = 3 + 2 * len(_ORDERS) * len(angles)
    gram, following = np.zeros((size, size)), np.zeros((size, size))
    for part in blocks(errors.size):
        columns = [np.ones_like(errors[part]), slope[part]]
        for name, angle in angles.items():
            # an error of the input reaches the output through the transmission
            effect = slope[part] if name == "input" else 1.0
            for order in _ORDERS:
                wave = np.exp(1j * order * angle[part])
                columns += [effect * wave.real, effect * wave.imag]
        table = np.array([*columns, errors[part]])
        gram += table @ table.T
        # the few pairs that the end of a block separates are left out
        following += table[:, 1:] @ table[:, :-1].T
    return _NormalEquations(
        gram[:-1, :-1], gram[:-1, -1], float(gram[-1, -1]), following, errors.size
    )
