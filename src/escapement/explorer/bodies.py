"""The bodies of a mechanism as the page draws them: paths that turn with driver and follower.

Each body is a path of SVG about its own origin, y upwards, in the mechanism's unit of length. With
the driver angle theta and the follower angle phi its origin is at the sum of the vectors
z exp(i rate theta), and the body is turned by a theta + b phi.
"""

import math
from collections.abc import Iterable
from functools import singledispatch
from typing import Any

import numpy as np

from escapement.mechanisms import EllipticalPlanetary, GearDriven, Geneva
from escapement.mechanisms.escape_wheel import EscapeWheel
from escapement.mechanisms.two_bodies import TwoBodies
from escapement.outlines.curves import Curve, svg_point
from escapement.outlines.gears import EllipticalOutline, GearDrivenOutline, pitch_curve
from escapement.outlines.geneva import GenevaOutline
from escapement.outlines.touching import PLATE, edges_of, plate

Vector = tuple[complex, float]
"""A vector, and the number of its turns in one turn of the driver."""
_STILL = (0.0, 0.0)
_MOST_POINTS = 4000
_DIGITS = ".5g"  # of coordinates


@singledispatch
def bodies_of(mechanism: Any) -> dict[str, Any] | None:
    """Bodies, the point where the pin touches, and the extent of the picture.

    Parameters
    ----------
    mechanism : Mechanism
        What to draw.

    Returns
    -------
    dict or None
        `bodies` with `name`, `path`, `at` (rows of x, y and rate) and `turn` (a, b); `contact`,
        rows like those of `at` for the point of contact, or None; `step`, the angle by which
        that point turns from engagement to engagement, 0 without it; `box`, the left, right, lower
        and upper limit. None if a mechanism has no bodies.
    """
    return None


@bodies_of.register
def _(mechanism: Geneva) -> dict[str, Any]:
    outline = GenevaOutline(mechanism)
    side, axis = outline.side, [(complex(outline.centre), 0.0)]
    disc = Curve.circle(outline.crank_disc_radius)
    found = [_body("crank-disc", [disc], axis)]
    found += [_body("follower", outline.follower_edges, turn=(0.0, 1.0))]
    inner = outline.slot_end - outline.half_slot
    mark = outline.slot_end + outline.half_slot + 0.09 if mechanism.internal else 0.78 * inner
    found += [_body("mark", [Curve.circle(min(0.045, 0.25 * mark), mark)], turn=(0.0, 1.0))]
    if outline.follower_shaft:
        found += [_body("shaft", [Curve.circle(outline.follower_shaft)])]
    found += [_body("hidden", [disc], axis)]
    if edge := outline.locking_edge:
        found += [_body("locking-disc", [edge], axis, (side, 0.0))]
    found += [_body("shaft", [Curve.circle(outline.driver_shaft)], axis)]
    arms = outline.pin_centres(0.0) - outline.centre
    found += [_line("arm", [0.0, complex(arms[0])], axis, (side, 0.0))]
    found += _pins(mechanism, outline.pin_radius, [[*axis, (complex(arm), side)] for arm in arms])
    contact = [*axis, (side * (1.0 + 0.0j), side)]
    return _picture(found, contact)


@bodies_of.register
def _(mechanism: GearDriven) -> dict[str, Any]:
    outline = GearDrivenOutline(mechanism)
    first, _, second, rate = mechanism.arms
    forward = 0.0, 1.0 if mechanism.turns_with_driver else -1.0
    carrier = [(complex(first), 1.0)]
    found = [_body("follower", outline.wheel_edges(), turn=forward)]
    for relief in outline.reliefs(0.0):
        found += [_body("relief", relief.edges, turn=forward)]
    found += [_body("pitch", [Curve.circle(1.0)])]
    found += [_body("planet", [Curve.circle(outline.planet_radius)], carrier)]
    points = outline.path()
    found += [_line("trace", points.tolist())] if points.size <= _MOST_POINTS else []
    found += [_line("carrier", [0.0, complex(first)], turn=(1.0, 0.0))]
    phases = 2.0 * np.pi * np.arange(mechanism.pins) / mechanism.pins * np.sign(1.0 - rate)
    arms = [complex(arm) for arm in second * np.exp(1j * phases)]
    found += [_line("arm", [0.0, arm], carrier, (rate, 0.0)) for arm in arms]
    # pins without a given radius are drawn large enough to be seen
    least = 0.0 if mechanism.contact_radius else 0.018 * outline.reach
    radius = max(outline.pin_radius, least)
    found += _pins(mechanism, radius, [[*carrier, (arm, rate)] for arm in arms])
    contact = [*carrier, (complex(second), rate)]
    return _picture(found, contact) | {"step": mechanism.cell_angle}


@bodies_of.register
def _(mechanism: EllipticalPlanetary) -> dict[str, Any]:
    outline = EllipticalOutline(mechanism)
    sun, planet, *_ = outline.bodies(0.0)
    shaft = [(complex(outline.line_of_centres(0.0)[1]), 1.0)]
    driving, driven = (
        pitch_curve(1e3 * oval.semi_major_axis, oval.eccentricity)
        for oval in mechanism.pitch_ellipses
    )
    found = [_body("pitch", [Curve.circle(sun.radius)])]
    found += [_body("planet", [Curve.circle(planet.radius)], shaft)]
    # an ellipse begins at an end of its long axis, and half its segments further is the other end
    axes: Any = ("follower", driven, [], (0.0, -1.0)), (
        "driving", driving.moved(-1.0), shaft, (mechanism.ratio + 1.0, 0.0)
    )  # fmt: skip
    for name, oval, at, turn in axes:
        ends = oval.corners[[0, oval.corners.size // 2]].tolist()
        found += [_body(name, [oval], at, turn), _line("axis", ends, at, turn)]
    found += [_line("carrier", [0.0, shaft[0][0]], turn=(1.0, 0.0))]
    return _picture(found, None)


@bodies_of.register
def _(mechanism: TwoBodies) -> dict[str, Any]:
    axis, found = [(complex(mechanism.axes_distance), 0.0)], []
    if isinstance(mechanism, EscapeWheel):
        found.append(_body("carrier", [plate(mechanism)], axis, (0.0, 1.0)))
    driver = edges_of(mechanism.driver_chains, mechanism.driver_fold)
    follower = edges_of(mechanism.follower_chains, mechanism.follower_fold)
    found.append(_body("driving", driver, turn=(1.0, 0.0)))
    found.append(_body("follower", follower, axis, (0.0, 1.0)))
    found += [_body("shaft", [Curve.circle(0.5 * PLATE)], at) for at in ([], axis)]
    return _picture(found, None)


def _pins(mechanism: Any, radius: float, centres: Iterable[list[Vector]]) -> list[dict[str, Any]]:
    """Pins, within their rollers where they have some."""
    rollers = mechanism.roller_radius
    inner = radius * mechanism.pin_radius / rollers if rollers else radius
    sizes = [("roller", radius)] * bool(rollers) + [("pin", inner)]
    return [
        _body(f"{name}-{k}", [Curve.circle(size)], at)
        for k, at in enumerate(centres)
        for name, size in sizes
    ]


def _body(
    name: str,
    edges: Iterable[Curve],
    at: list[Vector] | None = None,
    turn: tuple[float, float] = _STILL,
) -> dict[str, Any]:
    curves = list(edges)
    reach = max(float(np.abs(curve.drawn()).max()) for curve in curves)
    path = " ".join(curve.svg(_DIGITS) for curve in curves)
    return {"name": name, "path": path, "at": _rows(at or []), "turn": turn, "reach": reach}


def _line(
    name: str,
    points: list[complex],
    at: list[Vector] | None = None,
    turn: tuple[float, float] = _STILL,
) -> dict[str, Any]:
    path = "M" + "L".join(svg_point(point, _DIGITS) for point in points)
    reach = max(map(abs, points))
    return {"name": name, "path": path, "at": _rows(at or []), "turn": turn, "reach": reach}


def _rows(at: list[Vector]) -> list[list[float]]:
    return [[complex(z).real, complex(z).imag, rate] for z, rate in at]


def _picture(bodies: list[dict[str, Any]], contact: list[Vector] | None) -> dict[str, Any]:
    """The bodies with the box that they stay within, however they turn."""
    corners = []
    for body in bodies:
        centre = sum((complex(x, y) for x, y, rate in body["at"] if rate == 0.0), 0.0j)
        room = body.pop("reach") + sum(math.hypot(x, y) for x, y, rate in body["at"] if rate)
        corners += [centre - room * (1 + 1j), centre + room * (1 + 1j)]
    x, y = [z.real for z in corners], [z.imag for z in corners]
    contacts = None if contact is None else _rows(contact)
    return {"bodies": bodies, "contact": contacts, "box": [min(x), max(x), min(y), max(y)]}
