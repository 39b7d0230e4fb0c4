"""Forces, bounces, impacts and jams of a motion with clearance or compliant contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from escapement.base import validate
from escapement.base.text import Shown
from escapement.dynamics.motion import Motion
from escapement.dynamics.trajectory import Impacts
from escapement.mechanisms.protocol import FloatArray

_NEARLY_DEAD = 0.01
"""A driver slower than this share of its mean speed has nearly stopped [-]."""
_SAME_ANGLE = 0.01
"""Stops this close together [rad] are one jam, in which the driver trembles."""
_SAMPLES = 4000
"""Times in an engagement at which jams are searched for; a jam lasts much longer than a step."""


@dataclass(frozen=True, repr=False)
class ContactSummary(Shown):
    """Peak force, bounces and impacts of a motion, from `contact_summary`.

    force_max, force_max_time : greatest contact force [N], and when it acts [s].
    bounces : number of times, in each engagement, that a pin returns to the wall that it left,
        without touching the other one in between.
    impulses : impulse of each impact [N s], the greatest first.
    edges, counts : how many impacts have an impulse between neighbouring edges [N s].
    energy : energy lost in all impacts [J].
    """

    _units: ClassVar[dict[str, str]] = {
        **{"force_max": "N", "force_max_time": "s", "impulses": "N s", "edges": "N s"},
        "energy": "J",
    }

    force_max: float
    force_max_time: float
    bounces: np.ndarray
    impulses: FloatArray
    edges: FloatArray
    counts: np.ndarray
    energy: float


def contact_summary(motion: Motion, intervals: int = 20) -> ContactSummary:
    """Peak force, bounces and the spectrum of the impacts of a motion with clearance or stiffness.

    The force over time is `motion.at(t).contact_force`, of any times.

    Parameters
    ----------
    motion : Motion
        A motion of engine "contact".
    intervals : int
        Intervals of the spectrum, of equal ratio from the least impulse to the greatest.

    Raises
    ------
    InvalidValue
        If the motion has neither clearance nor stiffness.
    """
    found = motion.impacts
    if not isinstance(found, Impacts):
        remedy = "simulate one with clearance or stiffness"
        raise validate.fail("motion", "one of engine 'contact'", motion.engine, remedy)
    intervals = validate.integer("intervals", intervals, 1, "20 is a good choice", 10_000)
    force = np.abs(np.asarray(motion.contact_force))
    top, when = float(force.max(initial=0.0)), float("nan")
    if force.size:
        when = float(motion.t[int(force.argmax())])
    hardest = motion.trajectory.hardest
    if hardest is not None and force.size:
        # an impact is shorter than the times of a motion lie apart
        top, when = hardest
    struck = found.wall != 0.0
    wall, engagement = found.wall[struck], found.engagement[struck]
    again = (wall[1:] == wall[:-1]) & (engagement[1:] == engagement[:-1])
    count = max(motion.handoff_times.size, 1)
    bounces = np.bincount(engagement[1:][again], minlength=count)
    impulses = np.sort(found.impulse[struck])[::-1]
    some = impulses[impulses > 0.0]
    edges = np.geomspace(some[-1], some[0], intervals + 1) if some.size else np.zeros(2)
    if some.size:
        # rounding must not exclude either end
        edges[0], edges[-1] = some[-1], some[0]
    counts = np.histogram(some, edges)[0] if some.size and some[0] > some[-1] else np.array([])
    return ContactSummary(
        force_max=top,
        force_max_time=when,
        bounces=bounces,
        impulses=impulses,
        edges=edges,
        counts=counts,
        energy=float(found.energy.sum()),
    )


@dataclass(frozen=True, repr=False)
class Jams(Shown):
    """Where a mechanism jams: arrays of one length.

    engagement : index of the engagement, from 0.
    time, duration : when the driver has nearly stopped, and for how long [s].
    angle : driver angle from the dead centre of the engagement [rad].
    """

    _units: ClassVar[dict[str, str]] = {"time": "s", "duration": "s", "angle": "rad"}

    engagement: np.ndarray
    time: FloatArray
    duration: FloatArray
    angle: FloatArray


def jams(motion: Motion) -> Jams:
    """Where, and for how long, a pin wedges in its slot and the driver nearly stops.

    The driver counts as stopped while it is slower than a hundredth of its mean speed. A motion
    that starts from rest does not jam at its start. Times are exact to a 4000th of an engagement.
    """
    cells = np.concatenate([[0.0], motion.handoff_times, [motion.end_time]])
    cells = np.unique(cells)
    if cells.size < 2:
        nothing = np.empty(0)
        return Jams(nothing.astype(int), nothing, nothing, nothing)
    grids = np.linspace(cells[:-1], cells[1:], _SAMPLES)
    times = np.union1d(grids.reshape(-1), motion.extrema.time)
    state = motion.at(times)
    cell = motion.escapement.mechanism.cell_angle
    mean = (state.theta[-1] - state.theta[0]) / (times[-1] - times[0])
    slow = state.theta_dot < _NEARLY_DEAD * mean
    edges = np.diff(np.concatenate([[False], slow, [False]]).astype(int))
    # the first time of each stretch, and the last one
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    reached = state.theta
    if starts.size:
        apart = reached[starts[1:]] - reached[ends[:-1]] > _SAME_ANGLE
        starts, ends = starts[np.append(True, apart)], ends[np.append(apart, True)]
        kept = starts > 0
        starts, ends = starts[kept], ends[kept]
    driver_angle = state.theta[starts] - motion.escapement.mechanism.breaks[0]
    engagement = np.floor(driver_angle / cell + 1e-12).astype(int)
    angle = state.theta[starts] - engagement * cell
    return Jams(engagement, times[starts], times[ends] - times[starts], angle)
