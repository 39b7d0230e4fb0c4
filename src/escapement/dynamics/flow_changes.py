"""Where the direction of power in the trains of a motion changes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from escapement.dynamics.trajectory import Events
from escapement.mechanisms.protocol import FloatArray
from escapement.numerics import search

_SAMPLES = 129
"""Times in a piece at which the torque in a train is evaluated."""
_ROUNDING = 1e-9


@dataclass(frozen=True, repr=False)
class FlowChanges(Events):
    """Changes of the direction of power in trains.

    train : "barrel" or "load_train". forward : whether power flows on towards the load from then.
    """

    train: np.ndarray
    forward: np.ndarray


def flow_changes_of(motion: Any) -> FlowChanges:
    """Every change of sign, in the order of time, of the torque in either train.

    The torque is T - I_b theta_ddot for a barrel, less the slope of a motor times the speed, and
    M + I_l phi_ddot for a load train, with numbers referred to driver and follower. If a sign
    changes from one piece of the motion to the next, as at a pin reversal, the change is at the
    boundary. Two changes between neighbouring times of 129 in a piece are found where the torque
    has a minimum there.
    """
    found = sorted(row for train in motion.escapement.trains for row in _changes(motion, train))
    columns = [np.array(column) for column in zip(*found, strict=True)] or [np.empty(0)] * 6
    time, engagement, theta, speed, names, forward = columns
    return FlowChanges(engagement, time, theta, speed, names, forward)


def _changes(motion: Any, train: str) -> Iterator[tuple[float, int, float, float, str, bool]]:
    """Time, engagement, angle and speed of each change in one train, its name and sense."""
    trajectory = motion.trajectory
    ends = np.append(trajectory.start[1:], motion.end_time)
    before = 0.0
    for piece, (start, end) in enumerate(
        zip(trajectory.start.tolist(), ends.tolist(), strict=True)
    ):
        if not end > start:
            continue

        def between(low: float, high: float, piece: int = piece) -> Callable[[float], float]:
            return lambda t: float(_passed(motion, piece, np.array([t]), train)[0])

        times = np.linspace(start, end, _SAMPLES)
        values = _passed(motion, piece, times, train)
        # values of the size of rounding have no sign
        clear = np.abs(values) > _ROUNDING * np.abs(values).max()
        times, values = times[clear], values[clear]
        found = search.roots(between, times, values, _ROUNDING)
        if values.size and values[0] * before < 0.0:
            found.insert(0, start)
        for index, time in enumerate(found):
            state = motion.within(np.array([piece]), np.array([time]))
            pose = float(state.theta[0]), float(state.theta_dot[0])
            forward = (values[-1] > 0.0) == ((len(found) - index) % 2 == 1)
            yield time, int(trajectory.engagement[piece]), *pose, train, bool(forward)
        before = float(values[-1]) if values.size else before


def _passed(motion: Any, piece: int, times: FloatArray, train: str) -> FloatArray:
    """Torque in a train at times within a piece [N m], referred to the driver or the follower.

    It is positive where power flows on towards the load.
    """
    state = motion.within(np.full(times.size, piece), times)
    referred, train_inertia = motion.escapement.referred, motion.escapement.trains[train]
    if train == "load_train":
        # at a handoff rounding decides the sign of the follower's speed
        sense = np.where(state.phi_dot < -_ROUNDING * np.abs(state.theta_dot), -1.0, 1.0)
        return np.asarray(
            referred["load_torque"]
            + sense * train_inertia.inertia * train_inertia.ratio**2 * state.phi_ddot
        )
    curve, driver_angle = motion.escapement.curve, state.theta - motion.at(0.0).theta
    torque = referred["torque"] if curve is None else curve(driver_angle)
    if (drive := motion.escapement.drive_curve) is not None:
        torque = drive(driver_angle, np.abs(state.theta_dot))
    if "motor_viscous" in referred:
        torque = torque - referred["motor_viscous"] * state.theta_dot
    sense = np.where(state.theta_dot < 0.0, -1.0, 1.0)
    return np.asarray(
        sense * (torque - train_inertia.inertia / train_inertia.ratio**2 * state.theta_ddot)
    )
