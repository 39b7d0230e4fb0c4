"""A mechanism of one's own, from the function that gives its follower angle."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.text import Shown
from escapement.mechanisms.kind import ArrayLike, Engaging, np, table
from escapement.mechanisms.path import Path
from escapement.mechanisms.protocol import FloatArray
from escapement.numerics.chebyshev import Series

TOLERANCE = 1e-10
"""Greatest error of the follower angle and of g, as shares of the step and of the greatest g."""
_SAMPLES = 1009
_SAME = 1e-9  # share of a cell; a pin that turns round nearer to a break does so at the break


@dataclass(frozen=True, repr=False)
class FunctionDrive(Shown, Engaging):
    """What `from_functions` returns: a mechanism whose follower angle is a series.

    angle : follower angle over the driver angle.
    breaks : entry, kinks, where a pin turns round in its slot, and the exit from which on the
        follower is locked [rad].
    cell_angle, follower_step : of a cell [rad].
    distance : that of the pin from the follower's axis in units of `crank_radius`; None without a
        slot.
    crank_radius : greatest distance of the pin from the follower's axis [m]; None without a slot.
    """

    angle: Any
    breaks: tuple[float, ...]
    cell_angle: float
    follower_step: float
    distance: Any = None
    crank_radius: float | None = None

    without_parts = True
    plain_crank = False

    def _shown(self) -> list[tuple[str, Any, str]]:
        names = ("cell_angle", "follower_step", "breaks")
        rows = [(name, getattr(self, name), "rad") for name in names]
        return [*rows, ("slotted", not self.meshed, "")]

    @property
    def meshed(self) -> bool:
        """Whether no pin slides, and its losses are given by an efficiency."""
        return self.distance is None

    @cached_property
    def path(self) -> Path:
        """The series of g and of the pin's distance, piece by piece, as kernels evaluate them."""
        slope = self.angle.derivative()
        missing = table.ORDER - slope.rows.shape[1]
        ratio = Series(slope.edges, np.pad(slope.rows, ((0, 0), (0, missing))))
        return table.table_path(*ratio) if self.meshed else table.slot_path(ratio, self.distance)

    def radius(self, theta: ArrayLike) -> FloatArray:
        """Distance of the pin from the follower's axis at driver angles, in `crank_radius` [-]."""
        return np.asarray(self.distance(self._in_engagement(theta)[1]))

    def _angle_at(self, theta: FloatArray) -> FloatArray:
        return np.asarray(self.angle(theta) - self.angle(0.0))


def from_functions(
    follower_angle: Callable[[FloatArray], ArrayLike],
    *,
    cell_angle: float,
    breaks: Sequence[float] = (),
    pin_distance: Callable[[FloatArray], ArrayLike] | None = None,
    tolerance: float = TOLERANCE,
) -> FunctionDrive:
    """A mechanism of one's own, from the function that gives its follower angle.

    The functions are fitted once by Chebyshev series, which are checked between their points.

    Parameters
    ----------
    follower_angle : callable
        Follower angles [rad] at an array of driver angles from dead centre [rad], of its shape,
        with a derivative of one sign. Between the breaks it is analytic.
    cell_angle : float
        Driver angle after which the motion repeats itself [rad], > 0.
    breaks : sequence of float
        Entry, every kink of a derivative, and the exit [rad], ascending, at most a cell apart; from
        the exit to the end of the cell the follower is locked. By default the follower moves all
        the time, from minus half a cell to half a cell.
    pin_distance : callable, optional
        Distance R of a thin pin from the follower's axis [m], > 0, while it moves the follower in
        a radial slot, at an array of driver angles. It slides by R'/R relative to R, against
        friction. Default: a mechanism without slots, whose loss is given by an `efficiency`.
    tolerance : float
        Greatest error of each function, as a share of the follower's step and of the greatest
        distance, and of their derivatives, as a share of the greatest.

    Returns
    -------
    FunctionDrive

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, or the fit does not reach the tolerance.
    """
    cell = validate.positive("cell_angle", cell_angle, "give the angle of a cell in rad")
    given: list[float] = validate.numbers("breaks", breaks, "give angles in rad").tolist()
    edges = given or [-0.5 * cell, 0.5 * cell]
    rule, remedy = "two angles or more, ascending, at most a cell apart", "give entry and exit"
    if len(edges) < 2 or min(np.diff(edges)) <= 0.0 or edges[-1] - edges[0] > cell * (1.0 + 1e-12):
        raise validate.fail("breaks", rule, list(breaks), remedy)
    ends = np.array([edges[0], edges[-1]])
    turned = float(np.diff(_values("follower_angle", follower_angle, ends))[0])
    step, sense = abs(turned), math.copysign(1.0, turned)
    angle = _fitted("follower_angle", follower_angle, edges, sense, step or 1.0, tolerance)
    samples = np.linspace(edges[0], edges[-1], _SAMPLES)
    slopes = angle.derivative()(samples)
    if slopes.min() < -tolerance * slopes.max():
        raise validate.fail(
            "follower_angle", "a function with a derivative of one sign", float(slopes.min()),
            "a follower that turns back has no engagement",
        )  # fmt: skip
    if pin_distance is None:
        return FunctionDrive(angle, tuple(edges), cell, step)
    distances = _values("pin_distance", pin_distance, samples)
    greatest = float(distances.max())
    if distances.min() <= 0.0:
        rule, remedy = "greater than 0 from entry to exit", "a pin in the axis turns nothing"
        raise validate.fail("pin_distance", rule, float(distances.min()), remedy)
    distance = _fitted("pin_distance", pin_distance, edges, 1.0 / greatest, 1.0, tolerance)
    slide = distance.derivative()
    slide.rows[np.abs(slide.rows).max(axis=1) < tolerance] = 0.0
    every = [*edges]
    for turn in slide.roots()[0]:
        if np.abs(turn - np.array(every)).min() > _SAME * cell:
            every.append(float(turn))
    return FunctionDrive(angle, tuple(sorted(every)), cell, step, distance, greatest)


def _values(name: str, function: Callable[..., ArrayLike], theta: FloatArray) -> FloatArray:
    """Values of a user's function, or an error if they are no finite numbers."""
    values = np.asarray(function(theta), dtype=float)
    if values.shape != theta.shape or not np.isfinite(values).all():
        rule = "a function that gives a finite number for each of an array"
        raise validate.fail(name, rule, values.shape, "write it with NumPy")
    return values


def _fitted(
    name: str, function: Callable[..., ArrayLike], edges: list[float], factor: float, size: float,
    tolerance: float,
) -> Series:  # fmt: skip
    """Series of a function times a factor; its error counts as a share of `size`."""
    middles = 0.5 * (np.array(edges[1:]) + edges[:-1])
    series, again = (
        table.resolved(lambda x: factor * _values(name, function, x), points)
        for points in (edges, sorted([*edges, *middles.tolist()]))
    )
    theta = np.linspace(edges[0], edges[-1], _SAMPLES)
    slopes = series.derivative()(theta)
    missed = np.abs(series(theta) - factor * _values(name, function, theta)).max()
    bent = np.abs(slopes - again.derivative()(theta)).max()
    errors = {"it": missed / size, "its derivative": bent / (np.abs(slopes).max() or 1.0)}
    for what, error in errors.items():
        if not error <= tolerance:
            raise InvalidValue(
                f"{name} must be smooth between the breaks, so that {what} is fitted to "
                f"{tolerance:g}, got {error:.2g}; name its kinks in breaks"
            )
    return series
