"""Where power turns back through the trains of a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from escapement.mechanism import FloatArray
from escapement.trajectory import Events

_SAMPLES = 129
"""Places of a piece at which the torque in a train is looked at."""


@dataclass(frozen=True, repr=False)
class FlowChanges(Events):
    """Changes of sign of what a train passes on.

    train : "barrel" or "load_train". forward : whether power flows on towards the load from then.
    """

    train: np.ndarray
    forward: np.ndarray


def flow_changes_of(motion: Any) -> FlowChanges:
    """Every change of sign, in the order of time, of the torque in either train.

    Of a barrel it is T - I_b theta_ddot, of a load train M + I_l phi_ddot, with the numbers that
    driver and follower see. Two changes between neighbours of 129 places of a piece are missed.
    """
    escapement, trajectory, found = motion.escapement, motion.trajectory, []
    trains = [name for name in ("barrel", "load_train") if getattr(escapement, name) is not None]
    ends = np.append(trajectory.start[1:], motion.end_time)
    for piece in range(trajectory.start.size) if trains else ():
        start, end = float(trajectory.start[piece]), float(ends[piece])
        if not end > start:
            continue
        times = np.linspace(start, end, _SAMPLES)
        for train in trains:
            values = _passed(motion, piece, times, train)
            # what is rounding beside the greatest has no sign
            values[np.abs(values) <= 1e-12 * np.abs(values).max(initial=0.0)] = 0.0
            for i in np.flatnonzero(values[:-1] * values[1:] < 0.0):
                own = motion, piece, train
                time = brentq(lambda t, own=own: _at(t, *own), times[i], times[i + 1], xtol=1e-300)
                state = motion.within(np.array([piece]), np.array([time]))
                place = float(state.theta[0]), float(state.theta_dot[0])
                forward = bool(values[i + 1] > 0.0)
                found.append((int(trajectory.engagement[piece]), time, *place, train, forward))
    found.sort(key=lambda row: row[1])
    columns = [np.array(column) for column in zip(*found, strict=True)] or [np.empty(0)] * 6
    return FlowChanges(*columns)


def _passed(motion: Any, piece: int, times: FloatArray, train: str) -> FloatArray:
    """Torque in a train at times within a piece [N m], as the driver or the follower sees it."""
    state = motion.within(np.full(times.size, piece), times)
    seen, own = motion.escapement.seen, getattr(motion.escapement, train)
    if train == "load_train":
        return np.asarray(seen["load_torque"] + own.inertia * own.ratio**2 * state.phi_ddot)
    curve, turned = motion.escapement.curve, state.theta - motion.at(0.0).theta
    torque = seen["torque"] if curve is None else curve(turned)
    return np.asarray(torque - own.inertia / own.ratio**2 * state.theta_ddot)


def _at(time: float, motion: Any, piece: int, train: str) -> float:
    return float(_passed(motion, piece, np.array([time]), train)[0])
