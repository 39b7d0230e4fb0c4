"""The rows of a position function: what they must be, and what their digits and scatter tell."""

import math
from typing import Any

import numpy as np

from escapement import validate
from escapement.errors import InvalidValue
from escapement.model import FloatArray

FEWEST = 12
MOST_EXACT = 601
_ALLOWED = 0.02  # error that rounding may make of a ratio, and of its greatest derivative
_NEARER = 50.0  # units of the last digit by which exact rows must be apart for that
_BENT = 200.0  # the same for the derivative of the ratio: by the square of how far apart


def column(name: str, values: Any) -> FloatArray:
    """A 1-D array of finite numbers, long enough for a spline."""
    try:
        given = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise validate.fail(name, "a list of numbers", values, "give angles in rad") from None
    if given.ndim != 1:
        raise validate.fail(name, "one-dimensional", given.shape, "give a list of angles")
    if given.size < FEWEST:
        raise validate.fail(
            name, f"at least {FEWEST} rows long", given.size, "give more of the position function"
        )
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
