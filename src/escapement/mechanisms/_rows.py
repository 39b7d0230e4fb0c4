"""The rows of a position function: their rules, and the function through them."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Numbers, Truth, quantity, setting
from escapement.mechanisms.kind import Kind, np, table
from escapement.mechanisms.protocol import FloatArray

FEWEST = 12
MOST_EXACT = 601
_ALLOWED = 0.02  # error that rounding may make of a ratio, and of its greatest derivative
_NEARER = 50.0  # units of the last digit by which exact rows must be apart for that
_BENT = 200.0  # the same for the derivative of the ratio: by the square of how far apart
_SAMPLES = 2001
_ROUNDING = 2.0**-50  # share of the angles that a constant ratio leaves by rounding
_CLOSE = 1e-9  # angles that differ by a smaller share of a cell are equal
_GAP = 0.1  # greatest share of a cell that may have no rows
_MANY = {False: 5.0, True: 15.0}  # a gap is wider than this many usual distances, exact or measured
_OPEN = {False: 1e-6, True: 0.02}  # share of a step by which a cell's rows may miss it


def columns(theta: Any, phi: Any, measured: bool) -> tuple[FloatArray, FloatArray]:
    """Driver and follower angles as arrays of equal length, neither too few nor too many."""
    remedy = "give a list of angles in rad"
    x, y = validate.numbers("theta", theta, remedy), validate.numbers("phi", phi, remedy)
    if x.ndim != 1 or x.size < FEWEST:
        rule = f"at least {FEWEST} rows long"
        raise validate.fail("theta", rule, x.shape, "give more rows")
    if y.shape != x.shape:
        raise validate.fail("phi", f"as long as theta, {x.size}", y.shape, "give one phi a row")
    if not measured and x.size > MOST_EXACT:
        rule = f"at most {MOST_EXACT} rows of an exact table"
        remedy = "leave rows out, or give measured=True (--measured)"
        raise validate.fail("theta", rule, x.size, remedy)
    return x, y


def last_digit(angles: FloatArray) -> float:
    """Unit of the last digit that angles are rounded to, in radians or degrees [rad].

    Zero for numbers in full precision.
    """
    for decimals, unit in product(range(10), (math.radians(1.0), 1.0)):
        digit = unit * 10.0**-decimals
        whole = angles / digit
        if np.abs(whole - np.round(whole)).max() < 1e-3:
            return digit
    return 0.0


@dataclass(frozen=True, repr=False)
class Rows(Kind):
    """Rows of any cells, to be folded into the one that begins with the least driver angle.

    `Tabulated` explains the numbers.
    """

    theta: Sequence[float] = field(metadata=setting(
        Numbers(long_name="driver angles", unit="angle", remedy="give a list of angles in rad")
    ))  # fmt: skip
    phi: Sequence[float] = field(metadata=setting(
        Numbers(long_name="follower angles", unit="angle", remedy="give a list of angles in rad")
    ))  # fmt: skip
    measured: bool = field(default=False, metadata=setting(
        Truth(long_name="the rows scatter, and a smooth curve is fitted to them")
    ))  # fmt: skip
    cell_angle: float = field(default=0.0, metadata=quantity(
        "driver angle after which the motion repeats itself", "angle", exclusive=True, axis=False,
        metavar="DEG", remedy="give the angle, after which the motion repeats itself"
    ))  # fmt: skip
    follower_step: float = field(default=0.0, metadata=quantity(
        "angle the follower turns in a cell", "angle", exclusive=True, axis=False, metavar="DEG",
        remedy="give the angle, the follower must have turned on from cell to cell"
    ))  # fmt: skip

    def __post_init__(self) -> None:
        measured = validate.truth("measured", self.measured)
        theta, phi = columns(self.theta, self.phi, measured)
        cell, step = self.cell_angle, self.follower_step
        if cell == 0.0:
            falling = np.flatnonzero(np.diff(theta) <= 0.0)
            if falling.size:
                raise InvalidValue(
                    "theta must ascend from one end of the cell to the other, got "
                    f"{float(theta[1 + falling[0]])!r} out of order; sort the table, or give "
                    "cell_angle and follower_step"
                )
            cell, step_turned = float(theta[-1] - theta[0]), float(phi[-1] - phi[0])
            if step == 0.0 and measured:
                step_turned = table.smoothing(theta, phi, cell, rising=True)[1]
            step = step or abs(step_turned)
        elif step == 0.0:
            raise InvalidValue(
                "cell_angle must come with follower_step, got it alone; give both, or neither "
                "for a table of one whole cell"
            )
        angles = {"theta": tuple(theta.tolist()), "phi": tuple(phi.tolist())}
        vars(self).update(angles, measured=measured, cell_angle=cell, follower_step=step)
        self.check_fields()
        if self._is_one_cell:
            self._check_step()
        self._warn_of_gap()

    @cached_property
    def _angles(self) -> tuple[FloatArray, FloatArray]:
        return np.array(self.theta), np.array(self.phi)

    def _warn_of_gap(self) -> None:
        """Warn the caller if a large part of the cell has no rows."""
        angles, cell = self._folded[0], self.cell_angle
        distances = np.diff(np.append(angles, angles[0] + cell))
        widest = int(np.argmax(distances))
        usual = float(np.median(distances[distances > self._near]))
        if distances[widest] > max(_GAP * cell, _MANY[self.measured] * usual):
            gap, whole, after = np.degrees([distances[widest], cell, angles[widest]])
            rule = f"got none for {gap:.3g} of {whole:.4g} degrees after {after:.4g}"
            remedy = "the curve there is a guess; give rows there"
            warnings.warn(f"theta must have rows all over the cell, {rule}: {remedy}", stacklevel=4)

    def _check_step(self) -> None:
        """Refuse rows of a whole cell that do not turn by the given step."""
        theta, phi = self._angles
        phi, step = phi[np.argsort(theta)], self.follower_step
        follower_turn = abs(float(phi[-1] - phi[0]))
        if self.measured:  # five deviations of the scatter, rather too great, from its bends
            doubt = 5.0 * 1.4826 * float(np.median(np.abs(np.diff(phi, 2)))) / math.sqrt(6.0)
        else:
            doubt = 2.0 * last_digit(phi)
        allowed = max(_OPEN[self.measured] * step, doubt)
        # the last row may be a little before the end of the cell
        allowed += 3.0 * self._mean_ratio * abs(float(np.ptp(theta)) - self.cell_angle)
        if abs(follower_turn - step) > allowed:
            degrees = math.degrees(follower_turn)
            rule = f"what phi turns over the cell, {follower_turn:.9g} rad or {degrees:.7g} degrees"
            remedy = "correct phi, or leave cell_angle and follower_step out"
            raise validate.fail("follower_step", rule, step, remedy)

    @cached_property
    def sense(self) -> float:
        """+1 or -1: direction in which the follower turns."""
        # a follower that turns back may move backwards along most of the rows: the criterion is
        # whether the rest closes from cell to cell
        return min((1.0, -1.0), key=self._leaps)

    def _leaps(self, sense: float) -> float:
        """Sum of the squared steps of the rest between rows for this sense, each over its gap."""
        angles, order = self._folded
        rest = self._rest(sense)[order]
        gaps = np.diff(np.append(angles, angles[0] + self.cell_angle))
        # readings at the same angle scatter too, so the mean gap is added to each
        weights = 1.0 / (gaps + self.cell_angle / angles.size)
        return float(weights @ np.diff(np.append(rest, rest[0])) ** 2)

    @cached_property
    def spline(self) -> table.PeriodicSpline:
        """The position function minus its mean rise, over the cell."""
        rest, (angles, order) = self._rest(self.sense), self._folded
        if self.measured:
            return table.smoothing(angles, rest[order], self.cell_angle)[0]
        if self._is_one_cell:  # its last row is the first again
            first = order != np.argmax(self._angles[0])
            angles, order = angles[first], order[first]
        x = np.append(angles, angles[0] + self.cell_angle)
        gap = float(np.diff(x).min())
        if gap <= self._near:
            raise InvalidValue(
                "theta must differ from row to row in an exact table, cells taken together; "
                "leave out repeated rows, or give measured=True (--measured)"
            )
        spline = table.interpolating(x, rest[[*order, order[0]]])
        if np.ptp(rest) > 0.0:
            self._check_spacing(spline, gap)
        return spline

    def _check_spacing(self, spline: table.PeriodicSpline, gap: float) -> None:
        """Refuse exact rows that are too close together for the number of their digits."""
        digit, mean = last_digit(self._angles[1]), self._mean_ratio
        start = spline.knots[0]
        angles = np.linspace(start, start + self.cell_angle, _SAMPLES)
        steepest = float(np.abs(spline(angles, 2)).max())
        # the derivative without the effect of rounding; it must not be almost zero
        steepest = max(steepest - _ALLOWED * _BENT * digit / gap**2, mean / self.cell_angle)
        least = max(_NEARER * digit / mean, math.sqrt(_BENT * digit / steepest))
        if gap < least:
            raise InvalidValue(
                f"theta must differ by at least {least:.2g} rad from row to row in an exact table "
                f"of phi rounded to {digit:.2g} rad, cells taken together, got {gap:.2g}; give "
                "more digits, leave rows out, or give measured=True (--measured)"
            )

    @property
    def _mean_ratio(self) -> float:
        """Follower angle per radian of the driver [-]."""
        return self.follower_step / self.cell_angle

    @property
    def _is_one_cell(self) -> bool:
        """Whether the rows reach from one end of a cell to the other."""
        return abs(float(np.ptp(self._angles[0])) - self.cell_angle) <= self._near

    @cached_property
    def _near(self) -> float:
        """Driver angles nearer each other than this are equal except for rounding [rad]."""
        spacing = self.cell_angle / len(self.theta)
        rounding = min(2.0 * last_digit(self._angles[0]), 0.01 * spacing)
        return max(_CLOSE * self.cell_angle, rounding)

    @cached_property
    def _folded(self) -> tuple[FloatArray, Any]:
        """Driver angles in the cell that begins with the least, ascending; their order."""
        theta = self._angles[0]
        start = float(theta.min())
        end = start + self.cell_angle - self._near
        folded = np.where(theta < end, theta, start + np.mod(theta - start, self.cell_angle))
        # rounding must not separate the two ends of the cell
        folded[folded >= end] = start
        order = np.argsort(folded, kind="stable")
        return folded[order], order

    def _rest(self, sense: float) -> FloatArray:
        """Follower angles of the rows minus the mean rise, if this is their sense."""
        theta, phi = self._angles
        rest = sense * phi - self._mean_ratio * (theta - theta[0])
        if np.ptp(rest) <= _ROUNDING * (np.abs(phi).max() + self._mean_ratio * np.abs(theta).max()):
            rest[:] = rest[0]  # an even ratio: a spline through rounding would accelerate
        return np.asarray(rest)
