"""Errors that come back with a shaft, and backlash, each with its test.

An eccentric gear or encoder disc shows once a turn of its shaft, a tilted one twice, and a free
play where a shaft turns back.
"""

import math
from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from escapement.lazy import Lazy
from escapement.measurement.backlash import Backlash, first_engaged, first_width, lag, next_width
from escapement.measurement.fit import position, slope
from escapement.measurement.readings import TURN, blocks
from escapement.mechanism import FloatArray, Mechanism

special = Lazy("scipy.special")
_ORDERS = (1, 2)  # cycles a turn: of an eccentric disc, and of a tilted or an oval one
_FITS = 4  # the width of a play moves its column, and settles in so many fits
SURE = 1e-3  # chance of taking anything for real that is not
_IN_95 = 1.96  # standard errors to either side that hold 95 % of a normal law
_TELLING = 3.0  # an amplitude of fewer standard errors is all but hidden
_LEAST = 5e-324  # it stands for a p-value that is too small for a double
_COLLINEAR = 1e-9  # a wave of which others leave less is not told from them; rounding is far below
_UNKNOWN = (math.nan, math.nan, math.nan)
_Place = tuple[int, ...]  # of the columns of a wave or a lag among all columns


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

    def told(self, certain: bool) -> str:
        """What comes back, with reserve where it is not certain."""
        where = "cell" if self.shaft == "cell" else f"turn of the {self.shaft}"
        often = ("once", "twice")[self.order - 1]
        when = f"{'comes' if certain else 'may come'} back {often} a {where}"
        size = interval(self.amplitude, self.standard_error)
        if _TELLING * self.standard_error < self.amplitude:
            return f"an error of {size} {when}"
        return f"an error {when}, its size all but hidden by phase, offset and others ({size})"


def interval(size: float, error: float) -> str:
    """A size in degrees with its interval, in words."""
    size, half = math.degrees(size), math.degrees(_IN_95 * error)
    return f"{size:.3g} degrees (95 % interval {size - half:.3g} to {size + half:.3g})"


def told_backlash(play: Backlash, certain: bool) -> str:
    """The free play of a shaft, with reserve where it is not certain."""
    size = interval(abs(play.width), play.standard_error)
    if play.width > 0.0:
        return f"the {play.shaft} {'has' if certain else 'may have'} a backlash of {size}"
    leads = "leads" if certain else "may lead"
    return f"the {play.shaft} {leads} by {size} where it turns back, as when its encoder has play"


def chance(p_value: float, correlation: float) -> float:
    """The p-value that is left where noise of a correlation may look the same."""
    # To a slow wave n errors of correlation r are worth n (1 - r)/(1 + r) independent ones.
    # In an F test with two degrees of freedom p is then raised to that share.
    worth = (1.0 - correlation) / (1.0 + correlation) if correlation > 0.0 else 1.0
    return float(max(p_value, _LEAST) ** worth)


class Found(NamedTuple):
    """What comes back, and backlash.

    shaft_errors : of each shaft and order.
    backlash : of each shaft that turns both ways far enough.
    correlation : of neighbours in what the significant ones leave, -1 to 1.
    """

    shaft_errors: tuple[ShaftError, ...]
    backlash: tuple[Backlash, ...]
    correlation: float


def find_errors(mechanism: Mechanism, driver: FloatArray, sense: int, errors: FloatArray) -> Found:
    """Sinusoidal errors once and twice a turn of the input, the output, and a cell; backlash.

    Over few turns one looks much like another. So the surest is fitted first, with a
    phase and an offset, then the surest of what is left, as long as one in a thousand
    sets of independent errors would show as much; and each is tested beside those.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    driver : ndarray, shape (n,)
        Driver angle as read, counting on [rad].
    sense : int
        1 where the output's reading counts up while the driver does, else -1.
    errors : ndarray, shape (n,)
        Measured less theory [rad].

    Notes
    -----
    Gauss and Newton's method: what acts on the input moves the place at which the transmission
    is read, and the width of a play moves its column.
    """
    cell, true, rest = mechanism.cell_angle, driver, errors
    theory = follower = sense * position(mechanism, driver)
    rate = sense * slope(mechanism, driver)
    turns = {
        "input": float(np.ptp(driver)) / TURN,
        "output": float(np.ptp(follower)) / TURN,
        "cell": float(np.ptp(driver)) / cell,
    }
    # a shaft was measured all round if one mean step after the last sample completes its turn
    least = (1.0 - 1e-9) * (errors.size - 1) / errors.size
    waves = {wave: (2 + 2 * i, 3 + 2 * i) for i, wave in enumerate(product(turns, _ORDERS))}
    judged = [pair for (name, _), pair in waves.items() if turns[name] >= least]
    plays, start = _plays(driver, follower, rate, errors)
    places = {name: (2 + 2 * len(waves) + i,) for i, name in enumerate(plays)}
    for last in range(_FITS - 1, -1, -1):
        angles = {"input": true, "output": follower, "cell": true * (TURN / cell)}
        lags = {name: lag(angles[name], width) for name, width in plays.items()}
        columns = _Columns(angles, rate, lags, rest, start)
        sums = columns.sums()
        tests, sure = sums.tests([*judged, *places.values()])
        plays = {name: next_width(tests[places[name]], width) for name, width in plays.items()}
        if not (last and sure):
            break
        moved = columns.input_error(sums.coefficients(sure))
        true = driver + moved
        follower, rate = sense * position(mechanism, true), sense * slope(mechanism, true)
        rest = errors - (follower - theory) + rate * moved
    found = (
        ShaftError(name, order, *tests.get(pair, _UNKNOWN), turns[name])
        for (name, order), pair in waves.items()
    )
    backlash = (Backlash(name, *tests[place]) for name, place in places.items())
    return Found(tuple(found), tuple(backlash), sums.correlation(sure))


def _plays(
    driver: FloatArray, follower: FloatArray, slope: FloatArray, errors: FloatArray
) -> tuple[dict[str, float], int]:
    """A width to begin with of each shaft that turns both ways [rad], and the first sample."""
    found, start = {}, 0
    through = math.sqrt(float(np.mean(slope**2)))
    for name, angle, rate in (("input", driver, through), ("output", follower, 1.0)):
        width = first_width(angle, errors, rate)
        first = first_engaged(lag(angle, width)) if width > 0.0 else None
        if first is not None:
            found[name], start = width, max(start, first)
    return found, start


class _NormalEquations(NamedTuple):
    """Normal equations of all columns: offset, phase, waves and lags, and the errors last.

    gram : products of the columns, summed over the samples.
    following : the same of each column and the next sample of each.
    """

    gram: FloatArray
    following: FloatArray
    samples: int

    def without(self, others: list[_Place]) -> FloatArray:
        """What times the columns leaves of each beside offset, phase and some others."""
        base = [0, 1, *(column for other in others for column in other)]
        left = np.eye(len(self.gram))
        inverse = np.linalg.pinv(self.gram[np.ix_(base, base)], rcond=1e-12, hermitian=True)
        left[base] -= inverse @ self.gram[base]
        return left

    def tests(
        self, wanted: list[_Place]
    ) -> tuple[dict[_Place, tuple[float, float, float]], list[_Place]]:
        """The test of each beside those that are significant, and these."""
        sure: list[_Place] = []
        # the most significant first, each tested beside those before
        while rest := [one for one in wanted if one not in sure]:
            chances = np.nan_to_num([self.test(one, sure)[2] for one in rest], nan=np.inf)
            if not chances.min() < SURE / len(wanted):
                break
            sure.append(rest[int(chances.argmin())])
        tests = {one: self.test(one, [it for it in sure if it != one]) for one in wanted}
        return tests, sure

    def test(self, own: _Place, others: list[_Place]) -> tuple[float, float, float]:
        """Amplitude, its standard error and p-value, beside others; a lag has a sign.

        NaN where it cannot be told from those.
        """
        left = self.gram @ self.without(others)
        square, product, whole = left[np.ix_(own, own)], left[own, -1], self.gram[own, own]
        if np.linalg.eigvalsh(square)[0] <= _COLLINEAR * whole.sum():
            return _UNKNOWN
        value, count = np.linalg.solve(square, product), len(own)
        freedom = self.samples - sum(map(len, others)) - count - 2
        explained = float(value @ product)
        variance = max(float(left[-1, -1]) - explained, 0.0) / freedom
        amplitude = float(np.hypot(*value)) if count == 2 else float(value[0])
        if not (variance > 0.0 and amplitude != 0.0):
            return _UNKNOWN
        along = value / amplitude
        error = math.sqrt(variance * float(along @ np.linalg.solve(square, along)))
        ratio = explained / (count * variance)
        return amplitude, error, float(special.fdtrc(count, freedom, ratio))

    def coefficients(self, sure: list[_Place]) -> FloatArray:
        """Of all columns, 0 for those that are not significant."""
        return np.asarray(-self.without(sure)[:, -1])

    def correlation(self, others: list[_Place]) -> float:
        """Correlation of neighbours in what offset, phase and others leave."""
        rest = self.without(others)[:, -1]
        left = float(self.gram[-1] @ rest)
        if left <= _COLLINEAR * self.gram[-1, -1]:
            return 0.0
        return float(rest @ self.following @ rest) / left


class _Columns(NamedTuple):
    """What errors are fitted by: offset, phase, a pair for each wave, and lags, as in `ShaftError`.

    angles : of input, output and cell, each of shape (n,) [rad].
    slope : transmission, shape (n,) [-].
    lags : of the shafts with play, shape (n,) [-].
    errors : measured less theory, shape (n,) [rad].
    start : the first sample that is counted.
    """

    angles: dict[str, FloatArray]
    slope: FloatArray
    lags: dict[str, FloatArray]
    errors: FloatArray
    start: int

    def of(self, part: slice) -> Iterator[tuple[str, FloatArray]]:
        """Each column but the offset at some samples, and the shaft on which it acts."""
        yield "input", np.ones_like(self.errors[part])
        for name, angle in self.angles.items():
            for order in _ORDERS:
                wave = np.exp(1j * order * angle[part])
                yield from ((name, wave.real), (name, wave.imag))
        for name, share in self.lags.items():
            yield name, share[part]

    def sums(self) -> _NormalEquations:
        """Normal equations over all samples, a block of them at a time."""
        gram = following = np.zeros(())
        for block in blocks(self.errors.size - self.start):
            part = slice(self.start + block.start, self.start + block.stop)
            # an error of the input reaches the output through the transmission
            rate = self.slope[part]
            acting = [column * (rate if name == "input" else 1.0) for name, column in self.of(part)]
            table = np.array([np.ones_like(rate), *acting, self.errors[part]])
            gram = gram + table @ table.T
            # the few pairs that the end of a block separates are left out
            following = following + table[:, 1:] @ table[:, :-1].T
        return _NormalEquations(gram, following, self.errors.size - self.start)

    def input_error(self, coefficients: FloatArray) -> FloatArray:
        """By how much the driver is ahead of its reading, shape (n,) [rad]."""
        found = np.empty_like(self.errors)
        for part in blocks(self.errors.size):
            named = zip(coefficients[1:-1], self.of(part), strict=True)
            found[part] = sum(value * column for value, (name, column) in named if name == "input")
        return found
