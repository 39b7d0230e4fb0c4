"""A motion by the fast engine, whose equation is linear in w over the driver angle.

Only the handoffs are computed; `trajectory` has the rest when it is asked for.
"""

import numpy as np

from escapement.base.status import MESSAGES, Status
from escapement.base.validate import fail
from escapement.dynamics.motion import Motion, no_motion, stall_message
from escapement.dynamics.painleve import friction_limits
from escapement.engines.energy.calls import prepared
from escapement.engines.energy.handoffs import handoffs
from escapement.engines.energy.march import OK, SPENT, STALL
from escapement.engines.energy.trajectory import EnergyTrajectory
from escapement.model.escapement import Escapement

_OK, _DONE = Status.OK, MESSAGES[Status.OK]


def simulate(
    escapement: Escapement,
    *,
    engagements: int | None,
    duration: float | None,
    initial_speed: float,
    rtol: float,
    longest: int = 10_000_000,
) -> Motion:
    """Motion in the driver-angle domain; arguments are validated by `escapement.simulate`.

    A duration of more than `longest` engagements is refused.
    """
    if escapement.friction >= friction_limits(escapement)[0]:
        return no_motion(escapement, "energy", rtol)
    clock, given = escapement.time_unit, prepared(escapement)
    horizon = np.inf if duration is None else duration / clock
    w = (initial_speed * clock) ** 2
    size = engagements or 64
    # how many engagements a duration takes is unknown: the arrays grow until they hold it
    while True:
        times, speeds = np.empty(size), np.empty(size)
        code, done, angle = handoffs(*given, w, horizon, rtol, clock, times, speeds)
        if code != OK or duration is None or done < size or times[-1] >= duration:
            break
        if size >= longest:
            rule = f"at most {times[-1]:.6g} s, in which {longest} engagements pass"
            raise fail("duration", rule, duration, "the figures of merit need no long motion")
        size = min(8 * size, longest)
    # after a stall times[done] is the time of the stall, and otherwise times[done - 1] the end
    last = done - 1 if code == OK else done
    end = float(times[last])
    status, message = _OK, _DONE
    if code != OK:
        status = Status(code)
        stopped = code in (STALL, SPENT)
        message = stall_message(angle, done, status) if stopped else MESSAGES[status]
    if duration is not None and (code == OK or end >= duration):
        done = done if end <= duration else last
        end, status, message = duration, Status.OK, _DONE
    # every argument with a name takes as long as a tenth of an engagement
    trajectory = EnergyTrajectory(
        escapement, rtol, initial_speed, times, speeds, last, end_time=end
    )
    if done < size:
        times, speeds = times[:done], speeds[:done]
    return Motion(
        escapement, "energy", rtol, trajectory, end, times, handoff_velocities=speeds,
        status=status, message=message,
    )  # fmt: skip


def steady_engagement(escapement: Escapement, rtol: float, speed: float, period: float) -> Motion:
    """Motion over an engagement that ends, after a period [s], with its first speed [rad/s]."""
    times, speeds = np.array([[period], [speed]])
    trajectory = EnergyTrajectory(
        escapement, rtol, speed, times=times, speeds=speeds, turns=0, end_time=period
    )
    return Motion(
        escapement, "energy", rtol, trajectory, end_time=period, handoff_times=times,
        handoff_velocities=speeds, status=_OK, message=_DONE,
    )  # fmt: skip
