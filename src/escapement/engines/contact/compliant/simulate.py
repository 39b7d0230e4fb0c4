"""`simulate` with compliant contact: integration from handoff to handoff, and its results."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.base.spoken import as_spoken
from escapement.base.status import MESSAGES, Status
from escapement.dynamics.codes import Ending
from escapement.dynamics.motion import Motion, stall_message
from escapement.dynamics.torque import is_spent
from escapement.engines.contact.compliant import march as marching
from escapement.engines.contact.compliant.law import DRIVER_SPEED, STATE
from escapement.engines.contact.compliant.trajectory import CompliantTrajectory, Steps
from escapement.model.escapement import Escapement
from escapement.model.scene import Joint
from escapement.numerics.interpreted import compile_from_now_on

LONGEST = 2000
"""Greatest number of engagements in one motion: each takes up to a megabyte."""
MOST_TRIES = 1_000_000
"""Steps that a motion may try, in addition to `march.MOST_EACH` for each of its engagements. They
take about four seconds; a usual engagement takes one to some hundreds."""
SOFTEST = 1e3
"""Least stiffness [torque/r^2]."""
SLIP = 1e-4
"""Slip speed if none is given, in crank radii over sqrt(I_f/torque)."""
_BLOCK = 32_768
"""Rows of one call, which takes some hundredths of a second."""


def joint_of(escapement: Escapement) -> Joint:
    """The joint of an escapement, with a slip speed."""
    joint = escapement.joint
    if joint.stiffness < SOFTEST:
        least = SOFTEST * escapement.stiffness / joint.stiffness
        raise InvalidValue(
            f"stiffness must be at least {as_spoken(least, 'stiffness')} here, got "
            f"{as_spoken(escapement.stiffness, 'stiffness')}; a pin "
            "would sink into a softer wall by more than a thousandth of the crank radius"
        )
    if escapement.restitution > 0.0 and not joint.hertz:
        raise InvalidValue(
            f"restitution must be 0 with linear walls, got {escapement.restitution!r}; "
            "give damping, or contact_law='hunt-crossley'"
        )
    if joint.hertz and joint.damping == 0.0 and joint.restitution == 0.0:
        raise InvalidValue(
            "restitution must be greater than 0 with contact_law='hunt-crossley' and no damping, "
            "got 0; give for example restitution=0.3"
        )
    return joint if joint.slip > 0.0 else joint._replace(slip=SLIP)


class March:
    """A motion in natural units that is continued engagement by engagement.

    state, clock : as `march.march` changes them.
    before : engagements passed and time spent before the clock was set back.
    """

    def __init__(self, escapement: Escapement, speed: float, rtol: float) -> None:
        compile_from_now_on()  # even a short motion takes a million steps of a stiff equation
        self.escapement, self.rtol = escapement, rtol
        self.joint, scene = joint_of(escapement), escapement.scene
        self.state = np.zeros(STATE)
        follower_angle = escapement.pairs[0].follower_angle(scene.edges[:1])[0]
        # the follower rests with the pin in the middle of its slot
        self.state[:3] = scene.edges[0], follower_angle, speed * escapement.time_unit
        self.clock = np.zeros(1, marching.CLOCK)
        self.clock["step"], self.before = 1.0, np.zeros(2)

    def go(self, engagements: int, end: float = math.inf) -> tuple[np.ndarray, Ending]:
        """Rows up to a number of engagements or a time, and why the march ended."""
        timer, blocks, why = self.escapement, [], Ending.RUNNING
        buffer = np.empty(_BLOCK, marching.STEP_END)
        while why == Ending.RUNNING:
            count, why = marching.march(
                self.state, self.clock, timer.scene, self.joint, timer.mechanism.follower_step,
                self.rtol, engagements, end, MOST_TRIES, buffer,
            )  # fmt: skip
            blocks.append(buffer[:count].copy())
        return np.concatenate(blocks), why

    def set_back(self) -> None:
        """Count time, engagements, work and losses from here on."""
        self.before += float(self.clock["engagement"][0]), float(self.clock["time"][0])
        self.state[4:], self.clock["time"], self.clock["moved"] = 0.0, 0.0, 0.0
        self.clock["engagement"] = 0

    def motion(self, rows: np.ndarray, why: Ending, asked: float) -> Motion:
        """The motion that consists of these rows; `asked` is the tolerance."""
        timer, clock = self.escapement, self.escapement.time_unit
        cells = np.flatnonzero(np.diff(rows["engagement"])) + 1
        speeds = rows["state"][cells, DRIVER_SPEED] / clock
        status, message = self._outcome(why)
        times, end = rows["time"][cells] * clock, float(rows["time"][-1] * clock)
        trajectory: Any = CompliantTrajectory(Steps(rows, timer, self.joint))
        return Motion(
            timer,
            engine="contact",
            rtol=asked,
            trajectory=trajectory,
            end_time=end,
            handoff_times=times,
            handoff_velocities=speeds,
            status=status,
            message=message,
        )

    def _outcome(self, why: Ending) -> tuple[Status, str]:
        if why == Ending.TOO_LONG:
            return Status.NOT_CONVERGED, self._given_up()
        if why != Ending.STANDS:
            return Status.OK, MESSAGES[Status.OK]
        scene, engagement = self.escapement.scene, int(self.clock["engagement"][0])
        driver_angle = engagement * self.escapement.mechanism.cell_angle
        spent = is_spent(self.state[0], scene._replace(driver_angle=driver_angle))
        status = Status.SPENT if spent else Status.STALL
        return status, stall_message(self.state[0], engagement, status)

    def _given_up(self) -> str:
        """How far a motion got whose steps are used up, and a remedy that is known to help."""
        timer, clock = self.escapement, self.clock[0]
        passed, time = self.before[0] + clock["engagement"], self.before[1] + clock["time"]
        where = f"{math.degrees(self.state[0]):.3f} degrees from dead centre of engagement "
        where += f"{int(passed) + 1}, after {time * timer.time_unit:.6g} s"
        least = timer.critical_damping
        weak = timer.damping is not None and timer.damping < least and not self.joint.hertz
        remedy = (
            f"; leave out damping, and critical damping, {as_spoken(least, 'damping')}, is taken"
        )
        followed = f"the motion was followed {where}, where {clock['tries']} steps were used up"
        return followed + (remedy if weak else "")


def simulate(
    escapement: Escapement,
    *,
    engagements: int | None,
    duration: float | None,
    initial_speed: float,
    rtol: float,
) -> Motion:
    """Motion with compliant contact; arguments are validated by `escapement.simulate`."""
    if engagements is not None and engagements > LONGEST:
        raise InvalidValue(
            f"engagements must be at most {LONGEST} with stiffness, got {engagements!r}; "
            "the figures of merit need no long motion"
        )
    march = March(escapement, initial_speed, rtol)
    end = math.inf if duration is None else duration / escapement.time_unit
    rows, why = march.go(LONGEST if engagements is None else engagements, end)
    motion = march.motion(rows, why, rtol)
    if duration is not None and motion.outcome is Status.OK:
        if march.clock["time"][0] < end:
            raise InvalidValue(
                f"duration must be of at most {LONGEST} engagements with stiffness, got "
                f"{duration!r}; the figures of merit need no long motion"
            )
        motion.end_time = duration
    return motion
