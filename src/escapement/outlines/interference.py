"""The motion check: the smallest distances of bodies in a turn, and where they are."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from escapement.outlines.bodies import Body, Disc
from escapement.outlines.gaps import Segments, gap, outside, segments_of

_FLAT = 1e-9  # differences of gaps that are rounding, in the outline's unit of length


class Outline(Protocol):
    """Input of the check: bodies in any position, and the pairs that may meet."""

    @property
    def mechanism(self) -> Any:
        """Their mechanism."""

    @property
    def plane(self) -> tuple[str, tuple[str, ...]]:
        """A body's name, and those of the bodies that move in its plane, without numbers."""

    @property
    def meshing(self) -> bool:
        """Whether teeth mesh, between which the gap is the same everywhere."""

    def bodies(self, theta: float) -> Sequence[Body | Disc]:
        """All bodies in their positions at a driver angle."""


class Nearest(NamedTuple):
    """The smallest distance of two bodies.

    Attributes
    ----------
    names : tuple of str
        The two bodies.
    gap : float
        Least distance, in the outline's unit; negative if they overlap.
    theta : float
        Driver angle at which it occurs [rad].
    point : complex
        Its position, with the follower's axis as origin, and the driver's on the positive real
        axis.
    """

    names: tuple[str, str]
    gap: float
    theta: float
    point: complex


def least_gaps(outline: Outline, samples: int = 361) -> list[Nearest]:
    """The least gap of each pair of bodies that move in one plane, over a turn of the driver.

    Parameters
    ----------
    outline : Outline
        A mechanism whose parts are perfect and have their nominal positions: the pin in the
        middle of its slot, the locked wheel in the middle of its clearance.
    samples : int
        Driver angles at which every gap is computed; around the least ones it is minimised,
        except between meshing teeth, of which a third of the angles over a cell are enough.

    Returns
    -------
    list of Nearest
        One for each pair, the smallest gap first.
    """
    start, mechanism = outline.mechanism.breaks[0], outline.mechanism
    # between meshing teeth the gap is the same everywhere but for the arcs that stand for them
    even = outline.meshing
    whole = mechanism.cell_angle if even else max(2.0 * math.pi, mechanism.cell_angle)
    samples = samples // 3 if even else samples
    angles = np.linspace(start, start + whole, samples)
    rows = [_gaps(outline, float(theta)) for theta in angles]
    found = []
    for name in rows[0]:
        values = np.array([row[name][0] for row in rows])
        theta = angles[np.argmin(values)] if even else _least(outline, name, angles, values)
        size, point = _gaps(outline, float(theta), name)[name]
        found.append(Nearest((name, outline.plane[0]), size, float(theta), point))
    return sorted(found, key=lambda pair: pair.gap)


def _least(outline: Outline, name: str, angles: np.ndarray, values: np.ndarray) -> float:
    """Driver angle at which a gap is least, from its values at some angles."""
    from scipy.optimize import minimize_scalar

    best, theta = float(values.min()), float(angles[np.argmin(values)])
    # between two angles a gap decreases by at most the change from angle to angle
    steps = np.abs(np.diff(values))
    before, after = (np.append(np.inf, -np.diff(values)), np.append(np.diff(values), np.inf))
    valley = (before >= 0.0) & (after >= 0.0) & (np.maximum(before, after) > _FLAT)
    for k in np.flatnonzero(valley)[np.argsort(values[valley])]:
        if values[k] - steps.max() > best:
            break
        ends = angles[max(k - 1, 0)], angles[min(k + 1, angles.size - 1)]
        least = minimize_scalar(
            lambda angle: _gaps(outline, angle, name)[name][0],
            bounds=ends,
            method="bounded",
            options={"xatol": 1e-9},
        )
        if least.fun < best:
            best, theta = float(least.fun), float(least.x)
    return theta


def _gaps(outline: Outline, theta: float, only: str = "") -> dict[str, tuple[float, complex]]:
    """Gap and point of each body, or only of one, at a driver angle."""
    against, moving = outline.plane
    bodies = {body.name: body for body in outline.bodies(theta)}
    wheel = segments_of(bodies[against].edges)  # type: ignore[union-attr]
    chosen = [only] if only else [n for n in bodies if n.rstrip("-0123456789") in moving]
    return {name: _gap(bodies[name], wheel) for name in chosen}


def _gap(body: Body | Disc, wheel: Segments) -> tuple[float, complex]:
    if isinstance(body, Disc):
        distance, point = outside(wheel, np.array([body.centre]))
        return float(distance[0]) - body.radius, complex(point[0])
    return gap(segments_of(body.edges), wheel)
