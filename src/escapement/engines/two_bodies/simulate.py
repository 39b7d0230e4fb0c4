"""A motion of two bodies that touch with their outlines."""

import math

import numpy as np

from escapement.base.status import MESSAGES, Status
from escapement.dynamics.codes import Ending
from escapement.dynamics.followed import Followed, followed_motion
from escapement.dynamics.motion import Motion
from escapement.dynamics.torque import torque_after
from escapement.engines.two_bodies import march as marching
from escapement.engines.two_bodies.scene import prepared
from escapement.engines.two_bodies.trajectory import TwoBodyTrajectory
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

LONGEST = 10_000
"""Greatest number of engagements."""
_NO_ROWS = np.empty(0, marching.ROW)
_REASONS = {
    Ending.STANDS: (Status.STALL, "stops {}: the drive cannot turn the bodies on"),
    Ending.STALL: (Status.STALL, "jams {}: two contacts hold the driver"),
    Ending.JAM: (Status.PAINLEVE, "jams {}: friction leaves rigid bodies no motion there"),
    Ending.UNDRIVEN: (Status.NO_TERMINAL, "runs free {}: no contact in a whole pitch"),
    Ending.OVERLAPS: (
        Status.NOT_CONVERGED, "was followed {}, where a contact was missed: the bodies overlap"
    ),
    Ending.TOO_LONG: (
        Status.NOT_CONVERGED, f"was followed {{}}, where {marching.MOST_STEPS} steps were used up"
    ),
}  # fmt: skip


def outcome(
    escapement: Escapement, ending: Ending, theta: float, engagement: int
) -> tuple[Status, str]:
    """Status and message of a motion that ends in an engagement, counted from 0."""
    if ending in (Ending.DONE, Ending.OVER):
        return Status.OK, MESSAGES[Status.OK]
    status, reason = _REASONS[ending]
    start = prepared(escapement).start
    if ending == Ending.OVERLAPS and (engagement, theta) == (0, start[0]):
        told = " and ".join(f"{math.degrees(angle):.6g}" for angle in start)
        return Status.INVALID, (
            "driver_start and follower_start must be angles at which the bodies are apart, and at "
            f"{told} degrees they overlap; choose others, or leave driver_start out"
        )
    driver, law = theta + engagement * escapement.mechanism.cell_angle, prepared(escapement).law
    if ending == Ending.STANDS and torque_after(driver - law.begin, law)[0] <= 0.0:
        status, reason = Status.SPENT, "stops {}: the spring is spent"
    where = f"at a driver angle of {math.degrees(driver):.3f} degrees, in engagement"
    return status, f"the mechanism {reason.format(f'{where} {engagement + 1}')}"


def first_state(escapement: Escapement, initial_speed: float) -> FloatArray:
    """The start: the follower at rest, see `march.BEGIN`."""
    state = np.zeros(marching.BEGIN)
    state[marching.THETA], state[marching.PHI] = prepared(escapement).start
    state[marching.SPEED] = initial_speed * escapement.time_unit
    state[marching.PAIR] = marching.UNKNOWN
    return state


def march_from(
    escapement: Escapement, start: FloatArray, count: int, horizon: float = math.inf
) -> Followed:
    """Follow engagements from a state."""
    scene, begins, done = prepared(escapement), np.empty((count + 1, marching.BEGIN)), 0
    begins[0] = start
    while True:
        bodies, used = (scene.law, scene.pairs, scene.joints, scene.pitches), np.zeros(2, np.int64)
        inputs = horizon, done, begins[done:], _NO_ROWS
        ending, more, theta, end = marching.march(*bodies, *inputs, used)
        done += more
        if ending != Ending.RUNNING:
            return ending, begins[: done + 1], theta, end


def motion_from(
    escapement: Escapement, start: FloatArray, rtol: float, engagements: int | None,
    duration: float | None = None, longest: int = LONGEST, known: FloatArray | None = None,
) -> Motion:  # fmt: skip
    """The motion from a state at a handoff; the states at all its handoffs may be known."""

    def follow(size: int, horizon: float) -> Followed:
        if known is not None:
            return Ending.DONE, known, 0.0, known[-1, marching.TIME]
        return march_from(escapement, start, size, horizon)

    return followed_motion(
        escapement, "two_bodies", rtol, engagements, duration, longest,
        follow=follow,
        outcome=outcome,
        trajectory=lambda states, end: TwoBodyTrajectory(escapement, states, end),
    )  # fmt: skip


def simulate(
    escapement: Escapement, *, engagements: int | None, duration: float | None,
    initial_speed: float, rtol: float, longest: int = LONGEST,
) -> Motion:  # fmt: skip
    """Motion of two bodies; arguments are validated by `escapement.simulate`.

    A duration with more than `longest` engagements is refused.
    """
    start = first_state(escapement, initial_speed)
    return motion_from(escapement, start, rtol, engagements, duration, longest)
