"""Errors that repeat with a shaft, and backlash, each with its test.

An eccentric gear or encoder disc causes an error that repeats once a turn of its shaft, a tilted
one an error that repeats twice. Backlash shows where a shaft turns back.
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
_FITS = 4  # the width of a backlash changes its column in the fit; it converges in so many fits
SURE = 1e-3  # a smaller probability that noise alone causes an error counts as certainty
IN_95 = 1.96  # standard errors to either side of the mean, for 95 % of a normal distribution
_TELLING = 3.0  # the size of an error with fewer standard errors than this is called hidden
_LEAST = 5e-324  # it stands for a p-value that is too small for a double
# a wave that differs from all others by a smaller share is not fitted; rounding is far below
_COLLINEAR = 1e-9
_UNKNOWN = (math.nan, math.nan, math.nan)
_Place = tuple[int, ...]  # of the columns of a wave or a lag among all columns


class ShaftError(NamedTuple):
    """A sinusoidal error of one shaft, fitted together with all others that are significant.

    shaft : "input", "output", or "cell" for an error that repeats with each cell.
    order : how often the error repeats in one turn of the shaft, or in one cell.
    amplitude : amplitude of the error of that shaft's angle [rad]. An error of the input
        reaches the output multiplied by the transmission.
    standard_error : standard error of the amplitude [rad].
    p_value : probability that independent normal errors cause this amplitude or more (F test).
    turns : turns of the shaft, or cells, from the first sample to the last. If they and one mean
        step are less than 1, the error is not judged: the three numbers above are NaN.
    """

    shaft: str
    order: int
    amplitude: float
    standard_error: float
    p_value: float
    turns: float

    def told(self, certain: bool) -> str:
        """A sentence about this error, with "may" if it is not certain."""
        where = "cell" if self.shaft == "cell" else f"turn of the {self.shaft}"
        often = ("once", "twice")[self.order - 1]
        when = f"{'repeats' if certain else 'may repeat'} {often} a {where}"
        size = interval(self.amplitude, self.standard_error)
        if _TELLING * self.standard_error < self.amplitude:
            return f"an error of {size} {when}"
        return f"an error {when}, but phase, offset and other errors hide its size ({size})"


def interval(size: float, error: float) -> str:
    """A size in degrees with its interval, in words."""
    size, half = math.degrees(size), math.degrees(IN_95 * error)
    return f"{size:.3g} degrees (95 % interval {size - half:.3g} to {size + half:.3g})"


def told_backlash(play: Backlash, certain: bool) -> str:
    """A sentence about the backlash of a shaft, with "may" if it is not certain."""
    size = interval(abs(play.width), play.standard_error)
    if play.width > 0.0:
        return f"the {play.shaft} {'has' if certain else 'may have'} a backlash of {size}"
    leads = "leads" if certain else "may lead"
    return f"the {play.shaft} {leads} by {size} where it turns back, as if its encoder were loose"


def chance(p_value: float, correlation: float) -> float:
    """The p-value of an F test, corrected for correlated noise."""
    # In the fit of a slow wave, n errors with correlation r count as n (1 - r)/(1 + r) independent
    # ones. In an F test with two degrees of freedom p is then raised to that share.
    worth = (1.0 - correlation) / (1.0 + correlation) if correlation > 0.0 else 1.0
    return float(max(p_value, _LEAST) ** worth)


class Found(NamedTuple):
    """Errors that repeat, and backlash.

    shaft_errors : one for each shaft and order.
    backlash : one for each shaft that turns both ways far enough.
    correlation : correlation of neighbouring errors after the significant ones are removed [-].
    """

    shaft_errors: tuple[ShaftError, ...]
    backlash: tuple[Backlash, ...]
    correlation: float


def find_errors(mechanism: Mechanism, driver: FloatArray, sense: int, errors: FloatArray) -> Found:
    """Find errors that repeat once or twice a turn of a shaft or a cell, and backlash.

    Over few turns these errors look similar. The most significant one is therefore fitted first,
    with a phase and an offset, then the most significant of the rest, and so on, while noise alone
    would cause an error of this size in less than one of a thousand sets of readings. Each error
    is tested together with those that were found.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    driver : ndarray, shape (n,)
        Driver angle as read, growing over the turns [rad].
    sense : int
        1 if the readings of both encoders grow together, -1 if one grows while the other falls.
    errors : ndarray, shape (n,)
        Measured less theory [rad].

    Notes
    -----
    The problem is not linear: an error of the input changes the angle at which the transmission
    is read, and the width of a backlash changes where it is crossed. The method is Gauss-Newton.
    """
    cell, true, rest = mechanism.cell_angle, driver, errors
    theory = follower = sense * position(mechanism, driver)
    rate = sense * slope(mechanism, driver)
    turns = {
        "input": float(np.ptp(driver)) / TURN,
        "output": float(np.ptp(follower)) / TURN,
        "cell": float(np.ptp(driver)) / cell,
    }
    # a shaft made a full turn if one mean step after the last sample completes it
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
    """For each shaft that turns both ways, a first estimate of its backlash [rad].

    Also returned is the first sample at which the side of each backlash is known.
    """
    found, start = {}, 0
    through = math.sqrt(float(np.mean(slope**2)))
    for name, angle, rate in (("input", driver, through), ("output", follower, 1.0)):
        width = first_width(angle, errors, rate)
        first = first_engaged(lag(angle, width)) if width > 0.0 else None
        if first is not None:
            found[name], start = width, max(start, first)
    return found, start


class _NormalEquations(NamedTuple):
    """Normal equations of all columns: offset, phase, waves, lags, and the errors last.

    gram : products of each two columns, summed over the samples.
    following : products of each column with each column one sample later, summed likewise.
    """

    gram: FloatArray
    following: FloatArray
    samples: int

    def without(self, others: list[_Place]) -> FloatArray:
        """Matrix that makes each column orthogonal to offset, phase and some others."""
        base = [0, 1, *(column for other in others for column in other)]
        left = np.eye(len(self.gram))
        inverse = np.linalg.pinv(self.gram[np.ix_(base, base)], rcond=1e-12, hermitian=True)
        left[base] -= inverse @ self.gram[base]
        return left

    def tests(
        self, wanted: list[_Place]
    ) -> tuple[dict[_Place, tuple[float, float, float]], list[_Place]]:
        """The test of each wanted error together with the significant ones, and the latter."""
        sure: list[_Place] = []
        # the most significant first, each tested together with those before
        while rest := [one for one in wanted if one not in sure]:
            chances = np.nan_to_num([self.test(one, sure)[2] for one in rest], nan=np.inf)
            if not chances.min() < SURE / len(wanted):
                break
            sure.append(rest[int(chances.argmin())])
        tests = {one: self.test(one, [it for it in sure if it != one]) for one in wanted}
        return tests, sure

    def test(self, own: _Place, others: list[_Place]) -> tuple[float, float, float]:
        """Amplitude, its standard error and p-value, fitted together with others.

        The amplitude of a lag has a sign. All three are NaN if the fit cannot separate this error
        from the others.
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
        """Fitted factor of each column, 0 for those that are not significant."""
        return np.asarray(-self.without(sure)[:, -1])

    def correlation(self, others: list[_Place]) -> float:
        """Correlation of neighbouring errors after offset, phase and others are removed."""
        rest = self.without(others)[:, -1]
        left = float(self.gram[-1] @ rest)
        if left <= _COLLINEAR * self.gram[-1, -1]:
            return 0.0
        return float(rest @ self.following @ rest) / left


class _Columns(NamedTuple):
    """Columns of the fit: offset, phase, two for each wave, and one for each lag.

    angles : of input, output and cell, each of shape (n,) [rad].
    slope : transmission, shape (n,) [-].
    lags : of the shafts with backlash, shape (n,) [-].
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
