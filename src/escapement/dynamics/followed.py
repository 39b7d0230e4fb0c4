"""The motion that consists of engagements which an engine follows one after the other."""

import math
from collections.abc import Callable
from typing import Any

from escapement.base.status import MESSAGES, Status
from escapement.base.validate import fail
from escapement.dynamics.codes import Ending
from escapement.dynamics.motion import Motion
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

TIME, SPEED = range(2)
"""The first columns of the states at handoffs: time and driver speed, in natural units."""
Followed = tuple[Ending, FloatArray, float, float]
"""Why engagements end, the states at the start and at handoffs, and the last angle and time."""


def followed_motion(
    escapement: Escapement, engine: str, rtol: float,
    engagements: int | None, duration: float | None, longest: int,
    follow: Callable[[int, float], Followed],
    outcome: Callable[[Escapement, Ending, float, int], tuple[Status, str]],
    trajectory: Callable[[FloatArray, float], Any],
) -> Motion:  # fmt: skip
    """The motion over a number of engagements, or over a time [s].

    Parameters
    ----------
    follow : follows at most so many engagements, up to a time in natural units.
    outcome : status and message of a motion that ends with an angle in an engagement.
    trajectory : the trajectory of the states at handoffs and the end [s].
    longest : greatest number of engagements; a duration of more is refused.
    """
    clock = escapement.time_unit
    horizon, size = math.inf if duration is None else duration / clock, engagements or 64
    while True:
        ending, states, angle, end = follow(size, horizon)
        if ending != Ending.DONE or duration is None:
            break
        if size >= longest:
            rule = f"at most {end * clock:.6g} s, in which {longest} engagements pass"
            raise fail("duration", rule, duration, "the figures of merit need no long motion")
        size = min(8 * size, longest)
    status, message = outcome(escapement, ending, angle, len(states) - 1)
    end_time, times = float(end * clock), states[1:, TIME] * clock
    if duration is not None and (status is Status.OK or end_time >= duration):
        status, message, end_time = Status.OK, MESSAGES[Status.OK], duration
        times = times[times <= duration]
    return Motion(
        escapement,
        engine=engine,
        rtol=rtol,
        trajectory=trajectory(states, end_time),
        end_time=end_time,
        handoff_times=times,
        handoff_velocities=states[1 : times.size + 1, SPEED] / clock,
        status=status,
        message=message,
    )
