"""A motion with clearance between rigid bodies."""

import math

import numpy as np

from escapement.base.status import MESSAGES, Status
from escapement.dynamics.codes import Ending
from escapement.dynamics.followed import Followed, followed_motion
from escapement.dynamics.motion import Motion, no_motion, stall_message
from escapement.dynamics.painleve import friction_limits
from escapement.dynamics.torque import is_spent
from escapement.engines.contact.rigid.engagement import MOST_PIECES, MOST_STEPS
from escapement.engines.contact.rigid.march import PHI, SPEED, STATE, march
from escapement.engines.contact.rigid.trajectory import (
    NO_NUMBERS,
    NO_ROWS,
    RigidTrajectory,
    prepared,
)
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

MOST_OVERALL, MOST_EACH = 2_000_000, 1000
"""Steps of a motion, and additional ones for each of its engagements. A usual engagement takes
ten to fifty; a million take some seconds."""
_STOPS = {Ending.STALL: Status.STALL, Ending.SPENT: Status.SPENT}
_REASONS = {
    Ending.JAM: "the pin jams {}: rigid bodies have no motion there; give a stiffness",
    Ending.BACKS_OUT: "an impact drives the driver back out of the slot {}; give less clearance",
    Ending.RESTLESS: f"the pin strikes more than {MOST_PIECES} times in one engagement, so far "
    "{}; give a smaller restitution",
    Ending.TOO_LONG: f"the motion was followed {{}}, where {MOST_STEPS} steps of one engagement, "
    "or those of the whole motion, were used up",
}


def outcome(
    escapement: Escapement, ending: Ending, angle: float, engagement: int
) -> tuple[Status, str]:
    """Status and message of a motion that ends in an engagement, counted from 0."""
    if ending in (Ending.DONE, Ending.OVER):
        return Status.OK, MESSAGES[Status.OK]
    if ending in _STOPS:
        return _STOPS[ending], stall_message(angle, engagement, _STOPS[ending])
    where = f"{math.degrees(angle):.3f} degrees from dead centre of engagement {engagement + 1}"
    if ending == Ending.UNDRIVEN:
        driver_angle = engagement * escapement.mechanism.cell_angle
        spent = is_spent(angle, escapement.scene._replace(driver_angle=driver_angle))
        status = Status.SPENT if spent else Status.STALL
        reason = (
            "the spring is spent" if spent else "the drive does not exceed the bearing's torque"
        )
        return status, f"an impact turns the driver back out of the slot {where}, and {reason}"
    status = Status.PAINLEVE if ending == Ending.JAM else Status.NOT_CONVERGED
    return status, _REASONS[ending].format(where)


def first_state(escapement: Escapement, initial_speed: float) -> FloatArray:
    """The state at the start: the follower at rest, the pin in the middle of the slot."""
    state = np.zeros(STATE)
    state[SPEED], state[PHI] = initial_speed * escapement.time_unit, prepared(escapement)[2]
    return state


def simulate(
    escapement: Escapement,
    *,
    engagements: int | None,
    duration: float | None,
    initial_speed: float,
    rtol: float,
    longest: int = 1_000_000,
) -> Motion:
    """Motion with clearance; arguments are validated by `escapement.simulate`.

    A duration with more than `longest` engagements is refused.
    """
    if escapement.friction >= friction_limits(escapement)[0]:
        return no_motion(escapement, "contact", rtol)
    start = first_state(escapement, initial_speed)
    return motion_from(escapement, start, engagements, duration, rtol, longest)


def march_from(
    escapement: Escapement, start: FloatArray, count: int, rtol: float, horizon: float = math.inf
) -> Followed:
    """Follow engagements from a state; returns why they end, the states at handoffs, and the last
    angle and time.
    """
    scene, clearance, _entry = prepared(escapement)
    states, done, steps = np.empty((count + 1, STATE)), 0, 0
    states[0] = start
    while True:
        used = np.zeros(2, np.int64)
        inputs = scene, clearance, rtol, horizon, done, states[done:]
        ending, more, angle, end = march(*inputs, NO_NUMBERS, NO_ROWS, NO_NUMBERS, used)
        done, steps = done + more, steps + int(used[1])
        if ending == Ending.RUNNING and steps > MOST_OVERALL + MOST_EACH * done:
            ending, angle = Ending.TOO_LONG, float(escapement.scene.edges[0])
        if ending != Ending.RUNNING:
            return ending, states[: done + 1], angle, end


def motion_from(
    escapement: Escapement,
    start: FloatArray,
    engagements: int | None,
    duration: float | None,
    rtol: float,
    longest: int = 1_000_000,
) -> Motion:
    """The motion from a state at pin entry, see `march.STATE`."""
    return followed_motion(
        escapement, "contact", rtol, engagements, duration, longest,
        follow=lambda size, horizon: march_from(escapement, start, size, rtol, horizon),
        outcome=outcome,
        trajectory=lambda states, end: RigidTrajectory(escapement, rtol, states, end),
    )  # fmt: skip
