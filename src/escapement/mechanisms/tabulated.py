"""A mechanism known by its position function alone: designed elsewhere, or measured."""

import math
import warnings
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from escapement import _validate
from escapement.errors import InputFileError, InvalidValue
from escapement.mechanisms._angle_table import read_angles
from escapement.mechanisms._periodic_spline import (
    DEGREE,
    PeriodicSpline,
    interpolating,
    rise_over,
    smoothing,
)
from escapement.mechanisms._rows import (
    check_rows,
    check_spacing,
    column,
    last_digit,
    leaps,
    one_cell,
    scatter,
)
from escapement.mechanisms._slotted import Transmission
from escapement.mechanisms._table import chebyshev_table
from escapement.model import FloatArray

_BACKWARDS = 1e-3  # of the greatest g: what rounding and noise may leave of a stop
_SAMPLES = 2001
_ROUNDING = 4.0 * np.finfo(float).eps  # of the angles: what an even ratio leaves in a table
_CLOSE = 1e-9  # of a cell: angles this near each other are the same
_GAP = 0.1  # of a cell without rows: the curve across is a guess
_MANY = {False: 5.0, True: 15.0}  # usual distances of exact, measured rows: no gap by chance
_OPEN = {False: 1e-6, True: 0.02}  # of a step: how far exact, measured rows of a cell may miss it


@dataclass(frozen=True)
class Tabulated:
    """Any mechanism whose follower keeps to its driver, from a table.

    A periodic quintic spline goes through the table, or, where the table is
    measured, smoothly between its rows. The mechanism has no slot: its losses are
    those of a mesh.

    Parameters
    ----------
    theta : sequence of float
        Driver angles [rad]: one cell, both ends included, ascending. With
        `cell_angle` and `follower_step`: any angles in any order, at least 12.
    phi : sequence of float
        Follower angles there [rad].
    measured : bool
        Whether the rows scatter. Else they are exact, at most 601.
    cell_angle : float, optional
        Driver angle after which the motion repeats itself [rad], > 0. Default: that
        of the table.
    follower_step : float, optional
        What the follower turns in it [rad], > 0 in either sense. Default: likewise; of
        measured rows fitted, for two of them would scatter too much.

    Raises
    ------
    InvalidValue
        When the table breaks a rule.

    Warns
    -----
    UserWarning
        Where more than a tenth of the cell has no rows: five times their usual
        distance or more, fifteen times where they are measured.

    Notes
    -----
    The spline has four continuous derivatives. Where the follower's acceleration
    jumps, as at the ends of a Geneva wheel's engagement, it is rounded off over a
    few rows.
    """

    theta: Sequence[float]
    phi: Sequence[float]
    measured: bool = False
    cell_angle: float = 0.0
    follower_step: float = 0.0

    def __post_init__(self) -> None:
        theta, phi = (column(name, getattr(self, name)) for name in ("theta", "phi"))
        measured = _validate.truth("measured", self.measured)
        check_rows(theta, phi, measured)
        cell, step = self.cell_angle, self.follower_step
        if cell == 0.0:
            cell = one_cell(theta)
            step = step or abs(rise_over(theta, phi, cell) if measured else float(phi[-1] - phi[0]))
        elif step == 0.0:
            raise InvalidValue(
                "cell_angle must come with follower_step, got it alone; give both, or neither "
                "for a table of one whole cell"
            )
        remedy = "give the angle after which the motion repeats itself"
        checked: dict[str, Any] = {
            "theta": tuple(theta.tolist()),
            "phi": tuple(phi.tolist()),
            "measured": measured,
            "cell_angle": _validate.positive("cell_angle", cell, remedy),
            "follower_step": _validate.positive(
                "follower_step", step, "the follower must have turned on from cell to cell"
            ),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        if self._is_one_cell:
            self._check_step(theta, phi)
        self._warn_of_gap(theta)

    def _warn_of_gap(self, theta: FloatArray) -> None:
        places = self._folded(theta)[0]
        distances = np.diff(np.append(places, places[0] + self.cell_angle))
        widest = int(np.argmax(distances))
        usual = float(np.median(distances[distances > self._near]))
        if distances[widest] > max(_GAP * self.cell_angle, _MANY[self.measured] * usual):
            gap, cell, after = map(
                math.degrees, (distances[widest], self.cell_angle, places[widest])
            )
            warnings.warn(
                f"theta must have rows all over the cell, and has none for {gap:.3g} of {cell:.4g} "
                f"degrees after {after:.4g}: the curve across is a guess; give rows there",
                stacklevel=4,
            )

    def _check_step(self, theta: FloatArray, phi: FloatArray) -> None:
        """Whether the rows of a whole cell turn by what they are said to."""
        step, turned = self.follower_step, abs(float(phi[np.argmax(theta)] - phi[np.argmin(theta)]))
        doubt = 5.0 * scatter(theta, phi) if self.measured else 2.0 * last_digit(phi)
        allowed = max(_OPEN[self.measured] * step, doubt)
        # a last row beside the end of the cell is short of it
        allowed += 3.0 * self._mean * abs(float(np.ptp(theta)) - self.cell_angle)
        if abs(turned - step) > allowed:
            degrees = math.degrees(turned)
            rule = f"what phi turns over the cell, {turned:.9g} rad or {degrees:.7g} degrees"
            remedy = "correct phi, or leave cell_angle and follower_step out"
            raise _validate.fail("follower_step", rule, step, remedy)

    def __repr__(self) -> str:
        # a study file knows a mechanism of one's own by its repr, so tables that differ
        # must not look alike
        checksum = zlib.crc32(np.array([self.theta, self.phi]).tobytes())
        return (
            f"{type(self).__name__}(<{len(self.theta)} rows, checksum {checksum:08x}>, "
            f"measured={self.measured}, cell_angle={self.cell_angle}, "
            f"follower_step={self.follower_step})"
        )

    @classmethod
    def from_csv(cls, path: str | PathLike[str], **options: Any) -> "Tabulated":
        """Read a table of driver and follower angles.

        Parameters
        ----------
        path : path
            Two columns, apart by commas, semicolons, tabs or blanks: driver and follower
            in degrees. A line of headings may come first, without any number, and tell
            otherwise: phi_rad,theta_rad say. Lines that start with # are passed over.
        **options
            `measured`; `cell_angle` and `follower_step` in radians.

        Raises
        ------
        MissingInput, InputFileError
            When the file is not there, or is no such table.
        InvalidValue
            When an option breaks a rule.
        """
        angles = read_angles(path)
        try:
            table = cls(*angles, **options)
            _ = table.spline
        except InvalidValue as error:
            if str(error).startswith(("theta ", "phi ")):
                raise InputFileError(f"table {path}: {error}") from None
            raise
        return table

    @cached_property
    def sense(self) -> float:
        """+1 or -1: how the table's follower turns; here it counts so that it grows."""
        theta, phi = np.array(self.theta), np.array(self.phi)
        if self._is_one_cell:
            return math.copysign(1.0, phi[np.argmax(theta)] - phi[np.argmin(theta)])
        # a follower that turns back may fall along most of the rows: what tells is
        # whether the rest closes from cell to cell
        folded, order = self._folded(theta)
        senses = (1.0, -1.0)
        return min(senses, key=lambda s: leaps(folded, self._rest(s)[order], self.cell_angle))

    @cached_property
    def spline(self) -> PeriodicSpline:
        """The position function less its mean rise, over the cell."""
        theta, rest = np.array(self.theta), self._rest(self.sense)
        if not self.measured and self._is_one_cell:
            last = int(np.argmax(theta))  # the first again
            theta, rest = np.delete(theta, last), np.delete(rest, last)
        folded, order = self._folded(theta)
        if self.measured:
            return smoothing(folded, rest[order], self.cell_angle)
        x = np.append(folded, folded[0] + self.cell_angle)
        gap, digit = float(np.diff(x).min()), last_digit(np.array(self.phi))
        if gap <= self._near:
            raise InvalidValue(
                "theta must differ from row to row in an exact table, cells taken together; "
                "leave out what repeats itself, or say that the rows are measured"
            )
        spline = interpolating(x, np.append(rest[order], rest[order[0]]))
        if np.ptp(rest) > 0.0 and digit > 0.0:
            steepest = np.abs(spline(np.linspace(x[0], x[-1], _SAMPLES), 2)).max()
            check_spacing(gap, digit, float(steepest), self._mean, self.cell_angle)
        return spline

    def _rest(self, sense: float) -> FloatArray:
        """Follower angles of the rows less the mean rise, were this their sense."""
        theta, phi = np.array(self.theta), sense * np.array(self.phi)
        rest = phi - self._mean * (theta - theta[0])
        if np.ptp(rest) <= _ROUNDING * (np.abs(phi).max() + self._mean * np.abs(theta).max()):
            rest[:] = rest[0]  # an even ratio: a spline through rounding would accelerate
        return rest

    def _folded(self, theta: FloatArray) -> tuple[FloatArray, NDArray[np.intp]]:
        """Driver angles in the cell that begins with the least, ascending; their order."""
        start = float(theta.min())
        end = start + self.cell_angle - self._near
        folded = np.where(theta < end, theta, start + np.mod(theta - start, self.cell_angle))
        # rounding must not part the two ends of the cell
        folded[folded >= end] = start
        order = np.argsort(folded, kind="stable")
        return folded[order], order

    @property
    def _mean(self) -> float:
        return self.follower_step / self.cell_angle

    @cached_property
    def breaks(self) -> tuple[float, float]:
        """Both ends of the cell [rad].

        Those of the table; where its rows are of any cells, the cell about zero that
        begins where the follower is slowest. Between them the fourth derivative of g
        has a step at each knot; both engines go from knot to knot.
        """
        first = float(self.spline.knots[0])
        if self._is_one_cell:
            return first, float(self.spline.knots[-1])
        theta = np.linspace(first, first + self.cell_angle, _SAMPLES)
        slowest = float(theta[np.argmin(self.transmission(theta).g)])
        start = slowest - self.cell_angle * math.ceil(slowest / self.cell_angle)
        return start, start + self.cell_angle

    @property
    def _is_one_cell(self) -> bool:
        length = max(self.theta) - min(self.theta)
        return abs(length - self.cell_angle) <= self._near

    @cached_property
    def _near(self) -> float:
        """Driver angles nearer each other than this are the same but for their rounding [rad]."""
        spacing = self.cell_angle / len(self.theta)
        rounding = min(2.0 * last_digit(np.array(self.theta)), 0.01 * spacing)
        return max(_CLOSE * self.cell_angle, rounding)

    @property
    def motion_ratio(self) -> float:
        """Moving share of the cell, 1: the table knows no locked follower."""
        return 1.0

    @property
    def noise(self) -> float:
        """Standard deviation of the measured follower angles [rad]; 0 for an exact table."""
        return self.spline.noise

    def deviation(self, theta: ArrayLike) -> Transmission:
        """Standard deviations of g and g' at 1-D driver angles [rad], from the noise.

        Rounding off of sharp corners is not among them.
        """
        angles = np.atleast_1d(np.asarray(theta, dtype=float))
        g, dg = (self.spline.deviation(angles, order) for order in (1, 2))
        return Transmission(g, np.zeros_like(g), dg)

    def transmission(self, theta: ArrayLike) -> Transmission:
        """Transmission at driver angles of any size [rad]; u is 0, nothing slides."""
        g = self._mean + self.spline(theta, 1)
        return Transmission(g, np.zeros_like(g), self.spline(theta, 2))

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle at driver angles of any size [rad], in the sense that grows."""
        angles = np.asarray(theta, dtype=float)
        return self.spline(angles) + self._mean * (angles - self.theta[0])

    @cached_property
    def path(self) -> FloatArray:
        """Flat numbers of the transmission for the kernels: the spline, piece by piece.

        Raises
        ------
        InvalidValue
            Where the follower turns back: by more than a thousandth of its greatest
            speed and three standard deviations. No motion can be computed then.
        """
        theta = np.linspace(*self.breaks, _SAMPLES)
        g = self.transmission(theta).g
        worst = int(np.argmin(g))
        doubt = 3.0 * float(self.deviation(theta[worst]).g[0])
        if g[worst] < -max(_BACKWARDS * g.max(), doubt):
            raise InvalidValue(
                f"phi must rise (or fall) throughout for a motion, got a slope of {g[worst]:.3g} "
                f"against its sense at theta = {theta[worst]:.6g} rad; correct the table, or "
                "measure more of it"
            )
        start, end = self.breaks
        # the last knot is the first again
        knots = np.sort(start + np.mod(self.spline.knots[:-1] - start, self.cell_angle))
        inside = knots[(knots > start + self._near) & (knots < end - self._near)].tolist()
        return chebyshev_table(lambda x: self.transmission(x).g, [start, *inside, end], DEGREE)
