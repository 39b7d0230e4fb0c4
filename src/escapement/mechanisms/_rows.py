"""The rows of a position function: what they must be, and the function through them."""

import math
import warnings
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement import validate
from escapement.columns import read_columns
from escapement.errors import InputFileError, InvalidValue
from escapement.mechanisms._periodic_spline import PeriodicSpline, interpolating, smoothing
from escapement.model import FloatArray

FEWEST = 12
MOST_EXACT = 601
_ALLOWED = 0.02  # error that rounding may make of a ratio, and of its greatest derivative
_NEARER = 50.0  # units of the last digit by which exact rows must be apart for that
_BENT = 200.0  # the same for the derivative of the ratio: by the square of how far apart
_SAMPLES = 2001
_ROUNDING = 4.0 * np.finfo(float).eps  # of the angles: what an even ratio leaves in a table
_CLOSE = 1e-9  # of a cell: angles this near each other are the same
_GAP = 0.1  # of a cell without rows: the curve across is a guess
_MANY = {False: 5.0, True: 15.0}  # usual distances of exact, measured rows: no gap by chance
_OPEN = {False: 1e-6, True: 0.02}  # of a step: how far exact, measured rows of a cell may miss it


def read_angles(path: str | PathLike[str]) -> tuple[FloatArray, FloatArray]:
    """Driver and follower angles of a table in a text file; see `Tabulated.from_csv` [rad]."""
    found = read_columns(path, "table", by_order=True)
    if set(found.units) == {"rad", None}:
        raise InputFileError(
            f"table {path} must name the units of both columns or of neither, got radians for one; "
            "write for example theta_deg,phi_deg"
        )
    bad = np.flatnonzero(~np.isfinite(np.sum(found.angles, axis=0)))
    if bad.size:
        raise InputFileError(
            f"{path}, line {found.line[bad[0]]} must have two finite numbers; leave out the row"
        )
    return found.angles


def column(name: str, values: Any) -> FloatArray:
    """A 1-D array of finite numbers, long enough for a spline."""
    try:
        given = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise validate.fail(name, "a list of numbers", values, "give angles in rad") from None
    if given.ndim != 1:
        raise validate.fail(name, "one-dimensional", given.shape, "give a list of angles")
    if given.size < FEWEST:
        rule = f"at least {FEWEST} rows long"
        raise validate.fail(name, rule, given.size, "give more of the position function")
    if not np.isfinite(given).all():
        bad = float(given[~np.isfinite(given)][0])
        raise validate.fail(name, "finite throughout", bad, "leave out the row")
    return given


def check_rows(theta: FloatArray, phi: FloatArray, measured: bool) -> None:
    """A follower angle for each driver angle, and of an exact table not too many."""
    if theta.size != phi.size:
        raise validate.fail(
            "phi", f"as long as theta, {theta.size}", phi.size, "give one phi a theta"
        )
    if not measured and theta.size > MOST_EXACT:
        rule = f"at most {MOST_EXACT} rows of an exact table"
        remedy = "leave rows out, or say that they are measured"
        raise validate.fail("theta", rule, theta.size, remedy)


def one_cell(theta: FloatArray) -> float:
    """The cell of which the rows are the whole, from end to end."""
    rising = np.diff(theta) > 0.0
    if not rising.all():
        late = float(theta[1 + int(np.argmin(rising))])
        raise InvalidValue(
            "theta must ascend from one end of the cell to the other, got "
            f"{late!r} out of order; sort the table, or give cell_angle and follower_step"
        )
    return float(theta[-1] - theta[0])


def last_digit(angles: FloatArray) -> float:
    """Unit of the last digit that angles are rounded to, in radians or degrees [rad].

    Zero for numbers in full precision.
    """
    for decimals in range(10):
        for unit in (math.radians(1.0), 1.0):
            digit = unit * 10.0**-decimals
            whole = angles / digit
            if np.abs(whole - np.round(whole)).max() < 1e-3:
                return digit
    return 0.0


def check_spacing(gap: float, digit: float, steepest: float, mean: float, cell: float) -> None:
    """Whether exact rows are far enough apart for the digits they have.

    `gap` is their least distance in driver angle, `digit` the unit of the follower angles' last
    digit [rad]; `steepest` the greatest derivative of the ratio through them, `mean` the mean
    ratio, over the `cell` [rad].
    """
    # the derivative less what the rounding puts into it; next to none is no measure
    steepest = max(steepest - _ALLOWED * _BENT * digit / gap**2, mean / cell)
    least = max(_NEARER * digit / mean, math.sqrt(_BENT * digit / steepest))
    if gap < least:
        raise InvalidValue(
            f"theta must differ by at least {least:.2g} rad from row to row in an exact table of "
            f"phi rounded to {digit:.2g} rad, cells taken together, got {gap:.2g}; give more "
            "digits, leave rows out, or say that they are measured"
        )


def scatter(theta: FloatArray, phi: FloatArray) -> float:
    """Standard deviation of scattered rows, roughly and rather too great: from their bends."""
    bends = np.diff(phi[np.argsort(theta)], 2)
    return float(1.4826 * np.median(np.abs(bends)) / math.sqrt(6.0))


def leaps(x: FloatArray, y: FloatArray, period: float) -> float:
    """How much y leaps from point to point of a period, ascending; gaps excuse leaps."""
    gaps = np.diff(np.append(x, x[0] + period))
    # readings at one angle scatter too: no gap counts as less than the mean one
    return float((np.diff(np.append(y, y[0])) ** 2 / (gaps + period / x.size)).sum())


@dataclass(frozen=True, eq=False)
class FoldedRows:
    """Rows of any cells, to be folded into the one that begins with the least driver angle.

    The attributes are those of `Tabulated`, checked one by one.
    """

    theta: FloatArray
    phi: FloatArray
    measured: bool
    cell_angle: float
    follower_step: float

    def warn_of_gap(self) -> None:
        """Warn the caller of the mechanism where much of the cell has no rows."""
        places = self._folded(self.theta)[0]
        distances = np.diff(np.append(places, places[0] + self.cell_angle))
        widest = int(np.argmax(distances))
        usual = float(np.median(distances[distances > self.near]))
        if distances[widest] > max(_GAP * self.cell_angle, _MANY[self.measured] * usual):
            gap, cell, after = map(
                math.degrees, (distances[widest], self.cell_angle, places[widest])
            )
            warnings.warn(
                f"theta must have rows all over the cell, and has none for {gap:.3g} of {cell:.4g} "
                f"degrees after {after:.4g}: the curve across is a guess; give rows there",
                stacklevel=4,
            )

    def check_step(self) -> None:
        """Refuse rows of a whole cell that do not turn by what they are said to."""
        step, turned = self.follower_step, abs(self._turned)
        doubt = 5.0 * scatter(self.theta, self.phi) if self.measured else 2.0 * last_digit(self.phi)
        allowed = max(_OPEN[self.measured] * step, doubt)
        # a last row beside the end of the cell is short of it
        allowed += 3.0 * self.mean_ratio * abs(float(np.ptp(self.theta)) - self.cell_angle)
        if abs(turned - step) > allowed:
            degrees = math.degrees(turned)
            rule = f"what phi turns over the cell, {turned:.9g} rad or {degrees:.7g} degrees"
            remedy = "correct phi, or leave cell_angle and follower_step out"
            raise validate.fail("follower_step", rule, step, remedy)

    @cached_property
    def sense(self) -> float:
        """+1 or -1: how the follower turns."""
        if self.is_one_cell:
            return math.copysign(1.0, self._turned)
        # a follower that turns back may fall along most of the rows: what tells is
        # whether the rest closes from cell to cell
        folded, order = self._folded(self.theta)
        senses = (1.0, -1.0)
        return min(senses, key=lambda s: leaps(folded, self._rest(s)[order], self.cell_angle))

    @cached_property
    def spline(self) -> PeriodicSpline:
        """The position function less its mean rise, over the cell."""
        theta, rest = self.theta, self._rest(self.sense)
        if not self.measured and self.is_one_cell:
            last = int(np.argmax(theta))  # the first again
            theta, rest = np.delete(theta, last), np.delete(rest, last)
        folded, order = self._folded(theta)
        if self.measured:
            return smoothing(folded, rest[order], self.cell_angle)
        x = np.append(folded, folded[0] + self.cell_angle)
        gap, digit = float(np.diff(x).min()), last_digit(self.phi)
        if gap <= self.near:
            raise InvalidValue(
                "theta must differ from row to row in an exact table, cells taken together; "
                "leave out what repeats itself, or say that the rows are measured"
            )
        spline = interpolating(x, np.append(rest[order], rest[order[0]]))
        if np.ptp(rest) > 0.0 and digit > 0.0:
            steepest = np.abs(spline(np.linspace(x[0], x[-1], _SAMPLES), 2)).max()
            check_spacing(gap, digit, float(steepest), self.mean_ratio, self.cell_angle)
        return spline

    @property
    def mean_ratio(self) -> float:
        """What the follower turns for each radian of the driver [-]."""
        return self.follower_step / self.cell_angle

    @property
    def is_one_cell(self) -> bool:
        """Whether the rows reach from one end of a cell to the other."""
        length = float(np.ptp(self.theta))
        return abs(length - self.cell_angle) <= self.near

    @cached_property
    def near(self) -> float:
        """Driver angles nearer each other than this are the same but for their rounding [rad]."""
        spacing = self.cell_angle / len(self.theta)
        rounding = min(2.0 * last_digit(self.theta), 0.01 * spacing)
        return max(_CLOSE * self.cell_angle, rounding)

    @property
    def _turned(self) -> float:
        """From the least driver angle to the greatest [rad]."""
        return float(self.phi[np.argmax(self.theta)] - self.phi[np.argmin(self.theta)])

    def _folded(self, theta: FloatArray) -> tuple[FloatArray, NDArray[np.intp]]:
        """Driver angles in the cell that begins with the least, ascending; their order."""
        start = float(theta.min())
        end = start + self.cell_angle - self.near
        folded = np.where(theta < end, theta, start + np.mod(theta - start, self.cell_angle))
        # rounding must not part the two ends of the cell
        folded[folded >= end] = start
        order = np.argsort(folded, kind="stable")
        return folded[order], order

    def _rest(self, sense: float) -> FloatArray:
        """Follower angles of the rows less the mean rise, were this their sense."""
        theta, phi = self.theta, sense * self.phi
        rest = phi - self.mean_ratio * (theta - theta[0])
        if np.ptp(rest) <= _ROUNDING * (np.abs(phi).max() + self.mean_ratio * np.abs(theta).max()):
            rest[:] = rest[0]  # an even ratio: a spline through rounding would accelerate
        result: FloatArray = rest
        return result
