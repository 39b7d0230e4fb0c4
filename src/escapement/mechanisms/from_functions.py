"""A mechanism of one's own, from the function that gives its follower angle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.mechanisms.kind import ArrayLike, np, table
from escapement.mechanisms.path import Path
from escapement.mechanisms.protocol import FloatArray, Mechanism

TOLERANCE = 1e-10
"""Greatest error of the follower angle and of g, as shares of the step and of the greatest g."""
_SAMPLES = 1009


@dataclass(frozen=True, repr=False)
class FunctionDrive(Mechanism):
    """What `from_functions` returns: a mechanism without slots, whose follower angle is a series.

    angle : follower angle over the driver angle.
    breaks : entry, and the exit from which on the follower is locked [rad].
    cell_angle, follower_step : of a cell [rad].
    """

    angle: Any
    breaks: tuple[float, ...]
    cell_angle: float
    follower_step: float

    meshed = True
    without_parts = True

    @cached_property
    def path(self) -> Path:
        """The series of g, piece by piece, as kernels evaluate it."""
        slope = self.angle.derivative()
        missing = table.ORDER - slope.rows.shape[1]
        return table.table_path(slope.edges, np.pad(slope.rows, ((0, 0), (0, missing))))

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle at driver angles from dead centre [rad], zero at dead centre."""
        return np.asarray(self.angle(theta) - self.angle(0.0))


def from_functions(
    follower_angle: Callable[[FloatArray], ArrayLike],
    *,
    cell_angle: float,
    breaks: Sequence[float] = (),
    tolerance: float = TOLERANCE,
) -> FunctionDrive:
    """A mechanism of one's own, from the function that gives its follower angle.

    The function is fitted once by Chebyshev series, which are checked between their points.

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
    tolerance : float
        Greatest error of the follower angle, as a share of its step, and of its derivative, as a
        share of the greatest.

    Returns
    -------
    FunctionDrive
        Without slots: its loss is given by an `efficiency`.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, or the fit does not reach the tolerance.
    """
    cell = validate.positive("cell_angle", cell_angle, "give the angle of a cell in rad")
    edges = [*validate.numbers("breaks", breaks, "give angles in rad")] or [-0.5 * cell, 0.5 * cell]
    rule, remedy = "two angles or more, ascending, at most a cell apart", "give entry and exit"
    if len(edges) < 2 or min(np.diff(edges)) <= 0.0 or edges[-1] - edges[0] > cell * (1.0 + 1e-12):
        raise validate.fail("breaks", rule, list(breaks), remedy)

    def angles(theta: FloatArray) -> FloatArray:
        values = np.asarray(follower_angle(theta), dtype=float)
        if values.shape != theta.shape or not np.isfinite(values).all():
            rule = "a function that gives a finite angle for each of an array"
            raise validate.fail("follower_angle", rule, values.shape, "write it with NumPy")
        return values

    sense = np.sign(np.diff(angles(np.array([edges[0], edges[-1]]))))[0] or 1.0
    middles = 0.5 * (np.array(edges[1:]) + edges[:-1])
    series, again = (
        table.resolved(lambda x: sense * angles(x), points)
        for points in (edges, sorted([*edges, *middles.tolist()]))
    )
    theta = np.linspace(edges[0], edges[-1], _SAMPLES)
    step = float(np.ptp(series(np.array([edges[0], edges[-1]]))))
    slopes = series.derivative()(theta)
    errors = {
        "the angle": np.abs(series(theta) - sense * angles(theta)).max() / (step or 1.0),
        "its derivative": np.abs(slopes - again.derivative()(theta)).max() / slopes.max(),
    }
    for what, error in errors.items():
        if not error <= tolerance:
            raise InvalidValue(
                f"follower_angle must be smooth between the breaks, so that {what} is fitted to "
                f"{tolerance:g}, got {error:.2g}; name its kinks in breaks"
            )
    if slopes.min() < -tolerance * slopes.max():
        raise validate.fail(
            "follower_angle", "a function with a derivative of one sign", float(slopes.min()),
            "a follower that turns back has no engagement",
        )  # fmt: skip
    return FunctionDrive(series, tuple(map(float, edges)), cell, step)
