"""Periodic quintic splines: through given points, or smooth between scattered ones.

The smooth one minimises

    sum of (y_i - s(x_i))^2 + lambda integral of s'''^2

over splines whose knots are a selection of the points; lambda is chosen by
generalised cross-validation, and the residuals tell the noise.

Source: P. Craven and G. Wahba, Numer. Math. 31 (1979) 377-403; for the standard
deviations G. Wahba, J. R. Stat. Soc. B 45 (1983) 133-150.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from escapement.errors import InvalidValue
from escapement.model import FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

DEGREE = 5
MOST_KNOTS = 120
_ROWS_A_KNOT = 2
_LEAST_GAP = 0.01  # of the mean one: knots nearer each other spoil the least squares
_GRID = np.geomspace(1e-14, 1e6, 161)  # of lambda, in units that make both sums alike
_RIDGE = 1e-13


@dataclass(frozen=True)
class PeriodicSpline:
    """A spline of period `knots[-1] - knots[0]`, and how well it is known.

    knots : ndarray, shape (n + 1,)
        Ascending; the last is the first, a period later.
    coefficients : ndarray, shape (n,)
        Of the periodic B-splines.
    noise : float
        Standard deviation of the points from the curve that they scatter about.
    spread : ndarray, shape (n, n)
        Covariance of the coefficients; zeros for a spline through its points.
    """

    knots: FloatArray
    coefficients: FloatArray
    noise: float
    spread: FloatArray

    @cached_property
    def period(self) -> float:
        """Length after which the spline repeats itself."""
        return float(self.knots[-1] - self.knots[0])

    def __call__(self, x: ArrayLike, order: int = 0) -> FloatArray:
        """The spline or one of its derivatives, at any x."""
        from scipy.interpolate import BSpline

        knots, places = _extended(self.knots)
        spline = BSpline(knots, self.coefficients[places], DEGREE)
        # a spline of its own: from the splines' slopes rounding would make steps at the knots
        return np.asarray(spline.derivative(order)(self._folded(x)), dtype=float)

    def deviation(self, x: ArrayLike, order: int = 0) -> FloatArray:
        """Standard deviation of the spline or of a derivative at 1-D x."""
        rows = _basis(self.knots)(self._folded(x), nu=order)
        variances: FloatArray = ((rows @ self.spread) * rows).sum(axis=1)
        return np.sqrt(np.maximum(variances, 0.0))

    def _folded(self, x: ArrayLike) -> FloatArray:
        values = np.asarray(x, dtype=float)
        first = self.knots[0]
        inside = (values >= first) & (values <= self.knots[-1])
        return np.where(inside, values, first + np.mod(values - first, self.period))


def interpolating(x: FloatArray, y: FloatArray) -> PeriodicSpline:
    """Spline through points; the last is the first, a period later.

    Parameters
    ----------
    x : ndarray, shape (n + 1,)
        Strictly ascending.
    y : ndarray, shape (n + 1,)
        The last equals the first.
    """
    from scipy.interpolate import make_interp_spline

    size, change = x.size - 1, y - y[0]
    spline = make_interp_spline(x, change, k=DEGREE, bc_type="periodic")
    # rounding of the coefficients is divided by the square of the spacing in g', so what the
    # spline misses of the points is put right once
    missed = change - spline(x)
    missed[-1] = missed[0]
    spline.c += make_interp_spline(x, missed, k=DEGREE, bc_type="periodic").c
    return PeriodicSpline(x, y[0] + spline.c[:size], 0.0, np.zeros((size, size)))


def smoothing(x: FloatArray, y: FloatArray, period: float) -> PeriodicSpline:
    """Smooth spline near scattered points of one period.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Ascending, all within a period.
    y : ndarray, shape (n,)
        Values there.

    Raises
    ------
    InvalidValue
        When the points are at fewer places than a spline needs.
    """
    start, y = y[0], y - y[0]  # the digits are for what it changes
    knots, sizes, along, back = _modes(x, y[:, None], period)
    kept, left = _kept(sizes), along[:, 0]
    best, noise = _validated(y @ y, left, kept, x.size)
    return PeriodicSpline(
        knots,
        start + back @ (kept[best] * left),
        noise,
        noise**2 * (back * kept[best]) @ back.T,
    )


def rise_over(x: FloatArray, y: FloatArray, period: float) -> float:
    """What scattered points rise over a period, beside a smooth spline of that period.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        As for `smoothing`; y rises evenly beside what repeats itself.
    """
    y, ramp = y - y[0], (x - x[0]) / period
    _, sizes, along, _ = _modes(x, np.column_stack([y, ramp]), period)
    kept = _kept(sizes)
    wave, even = along.T
    # for each lambda the rise that leaves least, the bending counted
    rise = (y @ ramp - kept @ (wave * even)) / (ramp @ ramp - kept @ even**2)
    left = wave - rise[:, None] * even
    squares = y @ y - 2.0 * rise * (y @ ramp) + rise**2 * (ramp @ ramp)
    return float(rise[_validated(squares, left, kept, x.size - 1)[0]])


def _kept(sizes: FloatArray) -> FloatArray:
    """What is kept of each mode for each lambda of the grid."""
    return np.asarray(1.0 / (1.0 + np.outer(_GRID, sizes)))


def _validated(
    squares: ArrayLike, left: FloatArray, kept: FloatArray, free: int
) -> tuple[int, float]:
    """Which lambda of the grid cross-validation prefers, and the noise that it leaves.

    Parameters
    ----------
    squares : float or ndarray, shape (lambdas,)
        Sum of squares of the points.
    left : ndarray, shape (m,) or (lambdas, m)
        What of them each mode has.
    kept : ndarray, shape (lambdas, m)
        As `_kept` gives it.
    free : int
        Points less the numbers fitted beside the spline.
    """
    rest = squares - (left**2).sum(axis=-1) + (((1.0 - kept) * left) ** 2).sum(axis=1)
    rest, others = np.maximum(rest, 0.0), free - kept.sum(axis=1)
    best = int(np.argmin(rest / others**2))
    return best, float(np.sqrt(rest[best] / others[best]))


def _modes(
    x: FloatArray, y: FloatArray, period: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Knots, and columns y in the modes that a smooth spline keeps the less the rougher they are.

    Returns
    -------
    knots : ndarray, shape (m + 1,)
    sizes : ndarray, shape (m,)
        Roughness of each mode.
    along : ndarray, shape (m, columns)
        How much of it the points have.
    back : ndarray, shape (m, m)
        Modes to coefficients.
    """
    from scipy.interpolate import BSpline
    from scipy.linalg import eigh

    count = min(MOST_KNOTS, x.size // _ROWS_A_KNOT)
    places = x[np.linspace(0, x.size, count, endpoint=False).astype(int)]
    knots = _apart(np.append(places, places[0] + period), _LEAST_GAP * period / count)
    if knots.size <= DEGREE:
        raise InvalidValue(
            f"theta must be spread over the cell, got rows at {knots.size - 1} places of it; "
            f"measure at {DEGREE} at least"
        )
    # a row of this sparse matrix has six numbers, however many knots there are
    rows = BSpline.design_matrix(x, _extended(knots)[0], DEGREE)
    fold = _basis(knots).c
    normal = fold.T @ (rows.T @ rows).toarray() @ fold
    rough = _roughness(knots)
    rough *= np.trace(normal) / np.trace(rough)
    normal += _RIDGE * np.trace(normal) / knots.size * np.eye(knots.size - 1)
    # each mode is of size 1 over the points, and its roughness is the eigenvalue
    sizes, back = eigh(rough, normal)
    return knots, np.maximum(sizes, 0.0), back.T @ (fold.T @ (rows.T @ y)), back


def _apart(knots: FloatArray, gap: float) -> FloatArray:
    """Both ends, and the knots between that are farther than a gap from those kept."""
    kept = [knots[0]]
    for knot in knots[1:-1]:
        if knot - kept[-1] > gap and knots[-1] - knot > gap:
            kept.append(knot)
    return np.array([*kept, knots[-1]])


def _extended(knots: FloatArray) -> tuple[FloatArray, NDArray[np.intp]]:
    """Knots continued beyond both ends, and which coefficient each of the B-splines has."""
    size = knots.size - 1
    places = np.arange(-DEGREE, size + DEGREE + 1)
    turns, first = np.divmod(places, size)
    continued = knots[first] + turns * (knots[-1] - knots[0])
    continued[places == size] = knots[-1]
    return continued, np.arange(size + DEGREE) % size


def _basis(knots: FloatArray) -> BSpline:
    """The periodic B-splines, a column each."""
    from scipy.interpolate import BSpline

    continued, places = _extended(knots)
    return BSpline(continued, np.eye(knots.size - 1)[places], DEGREE)


def _roughness(knots: FloatArray) -> FloatArray:
    """Integrals of products of third derivatives, exact for quintic splines."""
    points, weights = np.polynomial.legendre.leggauss(3)
    half = 0.5 * np.diff(knots)
    x = knots[:-1, None] + half[:, None] * (1.0 + points)
    rows = _basis(knots)(x.ravel(), nu=3)
    return np.asarray(rows.T @ ((half[:, None] * weights).ravel()[:, None] * rows))
