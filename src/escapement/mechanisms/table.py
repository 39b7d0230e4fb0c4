"""A transmission as a table: for mechanisms without slots.

In such a mechanism driver and follower are always connected; the loss is a share of the power
that passes through. Kernels read piecewise Chebyshev series: the numbers of the path are

    [pieces, order, edges..., coefficients of g, piece after piece]

Of a pin in a slot they are two such tables, of g with a negative order, and of R.

A table given by a user has rows of driver and follower angles. A periodic quintic spline
interpolates them, or smooths them if they scatter. The smooth one minimises

    sum of (y_i - s(x_i))^2 + lambda integral of s'''^2

over splines whose knots are a selection of the points; lambda is chosen by generalised
cross-validation, and the residuals give the noise.

Source: P. Craven and G. Wahba, Numer. Math. 31 (1979) 377-403; for the standard
deviations G. Wahba, J. R. Stat. Soc. B 45 (1983) 133-150.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base.errors import InvalidValue
from escapement.mechanisms.path import EDGES, PIECES, TERMS, Path
from escapement.mechanisms.protocol import FloatArray
from escapement.numerics.chebyshev import Series, fit, interpolate, nodes
from escapement.numerics.jit import inner_jit

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

ORDER = 17
_DECAYED = 1e-15  # share of the largest g that rounding leaves in the last coefficients
DEGREE = 5
MOST_KNOTS = 120
_ROWS_A_KNOT = 2
_LEAST_GAP = 0.01  # share of the mean gap; closer knots make the least squares inaccurate
_GRID = np.geomspace(1e-14, 1e6, 161)  # values of lambda, in units that make both sums similar
_RIDGE = 1e-13


@inner_jit
def ratio_at(numbers, theta, start=0):
    """g and g' of a table at one driver angle; beyond its ends the last piece goes on.

    `start` is the index at which the table begins.
    """
    pieces, order = int(numbers[start + PIECES]), int(abs(numbers[start + TERMS]))
    edges, low, high = start + EDGES, 0, pieces
    while high - low > 1:
        middle = (low + high) // 2
        if theta >= numbers[edges + middle]:
            low = middle
        else:
            high = middle
    left, right = numbers[edges + low], numbers[edges + low + 1]
    scale = 2.0 / (right - left)
    x = (theta - left) * scale - 1.0
    first = edges + pieces + 1 + low * order
    # Clenshaw's recurrence, and its derivative
    b1, b2, d1, d2 = 0.0, 0.0, 0.0, 0.0
    for k in range(order - 1, 0, -1):
        d1, d2 = 2.0 * (b1 + x * d1) - d2, d1
        b1, b2 = numbers[first + k] + 2.0 * x * b1 - b2, b1
    return numbers[first] + x * b1 - b2, scale * (b1 + x * d1 - d2)


@inner_jit
def distance_at(numbers, theta):
    """R and R' of a pin in a slot, from the second table."""
    pieces = int(numbers[PIECES])
    return ratio_at(numbers, theta, EDGES + 1 + pieces - pieces * int(numbers[TERMS]))


def slot_path(ratio: Series, distance: Series) -> Path:
    """Path of a pin in a slot, from the series of g and of R, both with `ORDER` terms a piece."""
    tables = (table_path(*series).numbers for series in (ratio, distance))
    own = (t[: EDGES + 1 + int(t[PIECES]) * (ORDER + 1)] for t in tables)
    numbers = np.concatenate([*own])
    numbers[TERMS] = -ORDER
    return Path(True, numbers)


def table_path(edges: FloatArray, series: FloatArray) -> Path:
    """Path of a transmission given as Chebyshev series.

    Parameters
    ----------
    edges : ndarray, shape (pieces + 1,)
        Driver angles between which the pieces lie [rad], ascending.
    series : ndarray, shape (pieces, order)
        Coefficients of g in each piece.
    """
    # A table is not smooth at the knots of a spline; series of full order are divided only for
    # accuracy. The loss is proportional to |g|, so it has a kink where g changes its sign.
    knots = edges[1:-1] if series.shape[1] < ORDER else edges[:0]
    roots = Series(edges, series).roots()[0]
    return Path(True, np.concatenate([series.shape, edges, series.reshape(-1), knots, roots]))


def resolved(function: Callable[[FloatArray], FloatArray], edges: Iterable[float]) -> Series:
    """Series of a transmission that is analytic between edges, to rounding of the largest g."""
    return fit(function, edges, ORDER, decayed=_DECAYED, noise=0.0)


def chebyshev_table(
    function: Callable[[FloatArray], FloatArray], edges: Sequence[float], order: int = ORDER
) -> Path:
    """Path of a transmission function g(theta).

    Parameters
    ----------
    function : callable
        g at an array of driver angles [rad], analytic between neighbouring edges.
    edges : sequence of float
        First and last driver angle, and every corner between them, ascending.
    order : int
        Coefficients of a piece. With fewer than `ORDER` the function is a spline with a knot at
        each edge, whose degree k needs k of them; otherwise a piece is halved until they suffice.

    Returns
    -------
    Path
        A table whose numbers `ratio_at` reads; accurate to rounding of the largest g.

    Raises
    ------
    InvalidValue
        Where the function is not smooth enough between two edges.
    """
    if order >= ORDER:
        return table_path(*resolved(function, edges))
    knots = np.array(edges, dtype=float)
    low, high = knots[:-1], knots[1:]
    # The pieces of a spline are almost constant. Rounding of their sums would act as a slope of
    # one sign, and add up to a step over the cell, so each is fitted to the difference from its
    # middle value.
    middle, x = function(0.5 * (low + high)), nodes(low, high, order)
    series = interpolate(function(x.reshape(-1)).reshape(x.shape) - middle[:, None])
    series[:, 0] += middle
    return table_path(knots, series)


class PeriodicSpline(NamedTuple):
    """A periodic spline, and its uncertainty.

    curve : the spline, for any x.
    noise : standard deviation of the points from the curve that they scatter about.
    doubts : splines, a column each, whose squares add up to the variance of `curve`.
    """

    curve: BSpline
    noise: float
    doubts: BSpline

    @property
    def knots(self) -> FloatArray:
        """Ascending; the last is the first, a period later."""
        return np.asarray(self.curve.t[DEGREE:-DEGREE])

    def __call__(self, x: ArrayLike, order: int = 0) -> FloatArray:
        """The spline or one of its derivatives, at any x."""
        # a separate spline: rounding of the splines' slopes would cause steps at the knots
        return np.asarray(self.curve.derivative(order)(self._folded(x)))

    def deviation(self, x: ArrayLike, order: int = 0) -> FloatArray:
        """Standard deviation of the spline or of a derivative at any x."""
        return np.asarray(np.linalg.norm(self.doubts(self._folded(x), nu=order), axis=-1))

    def _folded(self, x: ArrayLike) -> FloatArray:
        values, (first, last) = np.asarray(x, dtype=float), self.knots[[0, -1]]
        # SciPy would also fold values inside, and round them
        inside = (values >= first) & (values <= last)
        return np.where(inside, values, first + np.mod(values - first, last - first))


def interpolating(x: FloatArray, y: FloatArray) -> PeriodicSpline:
    """Spline through points; the last is the first, a period later.

    Parameters
    ----------
    x : ndarray, shape (n + 1,)
        Strictly ascending.
    y : ndarray, shape (n + 1,)
        The last equals the first.
    """
    from scipy.interpolate import BSpline, make_interp_spline

    change = y - y[0]
    curve = make_interp_spline(x, change, k=DEGREE, bc_type="periodic")
    # rounding of the coefficients is divided by the square of the spacing in g', so the residuals
    # of the spline at the points are corrected once
    missed = change - curve(x)
    missed[-1] = missed[0]
    put_right = make_interp_spline(x, missed, k=DEGREE, bc_type="periodic").c
    curve = BSpline(curve.t, y[0] + (curve.c + put_right), DEGREE)
    return PeriodicSpline(curve, 0.0, BSpline(curve.t, np.zeros((curve.c.size, 1)), DEGREE))


def smoothing(
    x: FloatArray, y: FloatArray, period: float, rising: bool = False
) -> tuple[PeriodicSpline, float]:
    """Smooth spline near scattered points of one period, and their rise over a period.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Ascending, all within a period.
    y : ndarray, shape (n,)
        Values there.
    period : float
        Length after which the spline repeats itself.
    rising : bool
        Whether y has a constant rise in addition to the periodic part; otherwise the rise over a
        period is 0.

    Raises
    ------
    InvalidValue
        When the points have fewer angles than a spline needs.
    """
    from scipy.interpolate import BSpline
    from scipy.linalg import eigh

    knots = _knots(x, period)
    size = knots.size - 1
    # the knots go on beyond both ends, and the splines there have the first coefficients again
    before, behind = knots[-1 - DEGREE : -1] - period, knots[1 : DEGREE + 1] + period
    continued = np.concatenate([before, knots, behind])
    wrap = np.eye(size)[np.arange(size + DEGREE) % size]
    # a row of this sparse matrix has six numbers, however many knots there are
    rows = BSpline.design_matrix(x, continued, DEGREE)
    normal = wrap.T @ (rows.T @ rows).toarray() @ wrap
    rough = _roughness(knots, BSpline(continued, wrap, DEGREE))
    rough *= np.trace(normal) / np.trace(rough)
    normal += _RIDGE * np.trace(normal) / knots.size * np.eye(size)
    # each mode is of size 1 over the points, and its roughness is the eigenvalue; the smooth
    # spline keeps the less of it the rougher it is, for each lambda of the grid
    sizes, back = eigh(rough, normal)
    kept = 1.0 / (1.0 + np.outer(_GRID, np.maximum(sizes, 0.0)))
    y, start = y - y[0], y[0]  # this keeps more digits of the differences
    ramp = (x - x[0]) / period
    wave, even = (back.T @ (wrap.T @ (rows.T @ np.column_stack([y, ramp])))).T
    rise = np.zeros(_GRID.size)
    if rising:  # for each lambda the rise with the least sum of residuals and roughness
        rise = (y @ ramp - kept @ (wave * even)) / (ramp @ ramp - kept @ even**2)
    left = wave - rise[:, None] * even
    squares = y @ y - 2.0 * rise * (y @ ramp) + rise**2 * (ramp @ ramp)
    rest = squares - (left**2).sum(axis=1) + (((1.0 - kept) * left) ** 2).sum(axis=1)
    rest, others = np.maximum(rest, 0.0), x.size - rising - kept.sum(axis=1)
    best = int(np.argmin(rest / others**2))
    noise = float(np.sqrt(rest[best] / others[best]))
    curve = BSpline(continued, wrap @ (start + back @ (kept[best] * left[best])), DEGREE)
    doubts = BSpline(continued, wrap @ (noise * back * np.sqrt(kept[best])), DEGREE)
    return PeriodicSpline(curve, noise, doubts), float(rise[best])


def _knots(x: FloatArray, period: float) -> FloatArray:
    """A selection of the angles of points, far enough apart; the last is the first again."""
    count = min(MOST_KNOTS, x.size // _ROWS_A_KNOT)
    angles = x[np.linspace(0, x.size, count, endpoint=False).astype(int)]
    end, gap, kept = angles[0] + period, _LEAST_GAP * period / count, [angles[0]]
    for angle in angles[1:]:
        if angle - kept[-1] > gap and end - angle > gap:
            kept.append(angle)
    if len(kept) < DEGREE:
        raise InvalidValue(
            f"theta must be spread over the cell, got rows at {len(kept)} places of it; "
            f"measure at {DEGREE} at least"
        )
    return np.array([*kept, end])


def _roughness(knots: FloatArray, basis: BSpline) -> FloatArray:
    """Integrals of products of third derivatives, exact for quintic splines."""
    points, weights = np.polynomial.legendre.leggauss(3)
    half = 0.5 * np.diff(knots)
    x = knots[:-1, None] + half[:, None] * (1.0 + points)
    rows = basis(x.ravel(), nu=3)
    return np.asarray(rows.T @ ((half[:, None] * weights).ravel()[:, None] * rows))
