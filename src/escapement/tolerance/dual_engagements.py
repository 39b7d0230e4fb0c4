"""The handoffs of imperfect parts with duals: their derivatives by the errors of the parts.

`mechanisms.pattern` finds the angles of handoffs as roots. Their derivatives follow from one step
of Newton's method with duals, begun at the root: the implicit function theorem.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from escapement.mechanisms import pattern, slotted
from escapement.mechanisms.path import Path
from escapement.mechanisms.pattern import CLOSE, Handoff
from escapement.tolerance.dual import uncompiled


class Part(NamedTuple):
    """An engagement with duals.

    path : its path.
    delay : driver angle by which its angle 0 is later than the nominal one [rad].
    entry : its angle where it begins to drive.
    starts, leaves : driver angles, counted from the nominal dead centre, at which it begins to
        drive and at which it leaves the follower at rest.
    strikes : whether it begins with an impact.
    """

    path: Path
    delay: Any
    entry: Any
    starts: Any
    leaves: Any
    strikes: bool


def parts_of(mechanism: Any, values: dict[str, Any]) -> tuple[Part, ...]:
    """The engagements of a wheel with imperfect parts, of whose numbers some are duals [SI]."""
    unit = values["crank_radius"] if mechanism.crank_radius else 1.0

    def each(name: str, k: int) -> Any:
        given = mechanism.settings.get(name, ())
        return values.get(f"{name}_{k}", given[k] if given else 0.0)

    longer = values.get("centre_distance_error", mechanism.centre_distance_error) / unit
    count = mechanism.pattern.size
    found = [_engagement(mechanism, k, longer, unit, each) for k in range(count)]
    cell, step = mechanism.cell_angle, mechanism.follower_step
    starts = [_handover(found[k - 1], found[k], cell, step) for k in range(count)]
    return tuple(
        Part(b.path, b.delay, x - (cell + b.delay - a.delay), x + a.delay - cell, b.exit + b.delay,
             b.row.kind == Handoff.STRIKE)
        for a, b, x in zip([found[-1], *found[:-1]], found, starts, strict=True)
    )  # fmt: skip


def _engagement(mechanism: Any, k: int, longer: Any, unit: Any, each: Any) -> Any:
    """A row of the pattern with duals."""
    row: Any = mechanism.pattern[k]
    j, i = k % mechanism.pins, k % mechanism.slots
    first, a, second, b, forward = mechanism.path_numbers["arms"]
    # positive errors lengthen both vectors, independent of their sign
    p = first + np.sign(first) * longer
    q = second + np.sign(second) * (each("crank_radius_errors", j) / unit)
    offset = each("slot_offsets", i) / unit
    half = np.arccos(-(a * p * p + b * q * q) / (p * q * (a + b))) / abs(a - b)
    numbers = _slotted["path_numbers"](p, a, q, b, forward, half, offset)
    delay, lead = each("pin_angle_errors", j), each("slot_angle_errors", i)
    found = SimpleNamespace(path=Path(False, numbers), pin_numbers=numbers, row=row, delay=delay)
    found.lead = lead
    _pattern["_write_angle"](found, p, a, q, b, forward)
    found.entry, found.exit = (_polished(found, float(x)) for x in (row.entry, row.exit))
    return found


def _polished(engagement: Any, x: float) -> Any:
    """A root of g with its derivatives."""
    g, _u, dg, _radius = _pose(engagement.path, x)
    return x - g / dg


def _handover(a: Any, b: Any, cell: float, step: float) -> Any:
    """Driver angle of A at which B begins to drive."""
    shift = cell + b.delay - a.delay
    start = float(b.row.edges[0]) + float(shift)
    kind = b.row.kind
    if kind == Handoff.PICK_UP:
        return b.entry + shift
    if kind == Handoff.OVERLAP:
        g_a, _u, dg_a, _r = _pose(a.path, start)
        g_b, _u, dg_b, _r = _pose(b.path, start - shift)
        return start - (g_a - g_b) / (dg_a - dg_b)
    if abs(start - float(a.exit)) <= CLOSE:
        return a.exit
    rest = _follower_angle_at(a, a.exit) - step
    return start - (_follower_angle_at(b, start - shift) - rest) / _pose(b.path, start - shift)[0]


_slotted, _pattern = uncompiled(slotted), uncompiled(pattern)
_pose, _follower_angle_at = _slotted["pose_at"], _pattern["follower_angle_at"]
