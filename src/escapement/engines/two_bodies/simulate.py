"""A motion of two bodies that touch with their outlines."""

import math

import numpy as np

from escapement.base import validate
from escapement.base.status import MESSAGES, Status
from escapement.dynamics.codes import Ending
from escapement.dynamics.motion import Motion
from escapement.dynamics.torque import torque_after
from escapement.engines.two_bodies.march import BEGIN, MOST_STEPS, ROW, march
from escapement.engines.two_bodies.scene import prepared
from escapement.engines.two_bodies.trajectory import TwoBodyTrajectory
from escapement.model.escapement import Escapement
from escapement.numerics.jit import as_python

_REASONS = {
    Ending.STANDS: (Status.STALL, "the mechanism stops {}: the drive cannot turn the bodies on"),
    Ending.STALL: (Status.STALL, "the mechanism jams {}: two contacts hold the driver"),
    Ending.JAM: (
        Status.PAINLEVE,
        "the contact jams {}: friction leaves rigid bodies no motion there; give less friction",
    ),
    Ending.UNDRIVEN: (
        Status.NO_TERMINAL,
        "the driver runs free {}: it has turned by a pitch without touching the follower",
    ),
    Ending.TOO_LONG: (
        Status.NOT_CONVERGED,
        f"the motion was followed {{}}, where {MOST_STEPS} steps of one engagement were used up; "
        "a restitution of 0 needs fewer",
    ),
}


def outcome(
    escapement: Escapement, ending: Ending, theta: float, engagement: int
) -> tuple[Status, str]:
    """Status and message of a motion that ends in an engagement, counted from 0."""
    if ending in (Ending.DONE, Ending.OVER):
        return Status.OK, MESSAGES[Status.OK]
    status, reason = _REASONS[ending]
    driver = theta + engagement * escapement.mechanism.cell_angle
    if ending == Ending.STANDS:
        law = prepared(escapement).law
        if as_python(torque_after)(driver - law.begin, law)[0] <= 0.0:
            status, reason = Status.SPENT, "the mechanism stops {}: the spring is spent"
    where = (
        f"at a driver angle of {math.degrees(driver):.3f} degrees, in engagement {engagement + 1}"
    )
    return status, reason.format(where)


def begin_of(escapement: Escapement, initial_speed: float) -> np.ndarray:
    """The start: the follower at rest, between the contacts or at one."""
    begin = prepared(escapement).begin.copy()
    begin["speed"] = initial_speed * escapement.time_unit
    return begin


def march_from(
    escapement: Escapement, begin: np.ndarray, count: int, horizon: float = math.inf
) -> tuple[Ending, np.ndarray, float, float]:
    """Follow engagements from a state; returns why they end, the states at handoffs, and the last
    angle and time.
    """
    scene, none = prepared(escapement), np.empty(0, ROW)
    begins, done = np.zeros(count + 1, BEGIN), 0
    begins[0] = begin[0]
    while True:
        used = np.zeros(2, np.int64)
        ending, more, theta, end = march(*scene[:4], horizon, begins[done:], none, used)
        done += more
        if ending != Ending.RUNNING:
            return ending, begins[: done + 1], theta, end


def motion_from(
    escapement: Escapement,
    begin: np.ndarray,
    engagements: int | None,
    duration: float | None,
    rtol: float,
    longest: int,
) -> Motion:
    """The motion from a state, see `march.BEGIN`."""
    clock = escapement.time_unit
    horizon, size = math.inf if duration is None else duration / clock, engagements or 64
    while True:
        ending, begins, theta, end = march_from(escapement, begin, size, horizon)
        if ending != Ending.DONE or duration is None:
            break
        if size >= longest:
            rule = f"at most {end * clock:.6g} s, in which {longest} engagements pass"
            raise validate.fail(
                "duration", rule, duration, "the figures of merit need no long motion"
            )
        size = min(8 * size, longest)
    status, message = outcome(escapement, ending, theta, len(begins) - 1)
    end_time, times = float(end * clock), begins["time"][1:] * clock
    if duration is not None and (status is Status.OK or end_time >= duration):
        status, message, end_time = Status.OK, MESSAGES[Status.OK], duration
        times = times[times <= duration]
    return Motion(
        escapement,
        engine="two_bodies",
        rtol=rtol,
        trajectory=TwoBodyTrajectory(escapement, begins[: times.size + 1], end_time),
        end_time=end_time,
        handoff_times=times,
        handoff_velocities=begins["speed"][1 : times.size + 1] / clock,
        status=status,
        message=message,
    )


def simulate(
    escapement: Escapement,
    *,
    engagements: int | None,
    duration: float | None,
    initial_speed: float,
    rtol: float,
    longest: int = 10_000,
) -> Motion:
    """Motion of two bodies; arguments are validated by `escapement.simulate`.

    A duration with more than `longest` engagements is refused.
    """
    begin = begin_of(escapement, initial_speed)
    return motion_from(escapement, begin, engagements, duration, rtol, longest)
