"""A motion with compliant contact that is continued engagement by engagement."""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any, ClassVar

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.base.spoken import as_spoken
from escapement.base.status import MESSAGES, Status
from escapement.dynamics.codes import Ending
from escapement.dynamics.compliance import DRIVER_SPEED, STATE
from escapement.dynamics.compliant_steps import CompliantTrajectory, Steps
from escapement.dynamics.figures_of_merit import cycle_figures
from escapement.dynamics.motion import Motion
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.model.scene import Joint
from escapement.numerics.interpreted import compile_from_now_on

LONGEST = 2000
"""Greatest number of engagements in one motion: each takes up to a megabyte."""
MOST_TRIES = 1_000_000
"""Steps that a motion may try, in addition to some for each of its engagements. They take about
four seconds; a usual engagement takes one to some hundreds."""
SOFTEST = 1e3
"""Least stiffness [torque/r^2]."""
SLIP = 1e-4
"""Slip speed if none is given, in crank radii over sqrt(I_f/torque)."""
_BLOCK = 32_768
"""Rows of one call, which takes some hundredths of a second."""
_NUMBERS = "period", "velocity_max", "velocity_min", "handoff_velocity"


def joint_of(escapement: Escapement) -> Joint:
    """The joint of an escapement, with a slip speed."""
    joint = escapement.joint
    if joint.stiffness < SOFTEST:
        least = SOFTEST * escapement.stiffness / joint.stiffness
        raise InvalidValue(
            f"stiffness must be at least {as_spoken(least, 'stiffness')} here, got "
            f"{as_spoken(escapement.stiffness, 'stiffness')}; give more, for a softer wall yields "
            "by more than a thousandth of the crank or wheel radius"
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


class CompliantMarch:
    """Base of the marches of all engines with compliant contact, in natural units.

    engine : name of the engine. marching : its module with `CLOCK`, `STEP_END` and the kernel
        `march`, which takes `marched` of the bodies. tabulate : its kernel that `Steps` needs,
        which takes `tabulated` of them.
    state, clock : as the engine's kernel changes them.
    before : engagements passed and time spent before the clock was set back.
    """

    engine: ClassVar[str]
    marching: ModuleType
    tabulate: ClassVar[Any]
    marched: tuple[Any, ...]
    tabulated: tuple[Any, ...]

    def __init__(self, escapement: Escapement, speed: float, rtol: float) -> None:
        compile_from_now_on()  # even a short motion takes a million steps of a stiff equation
        self.escapement, self.rtol, self.joint = escapement, rtol, joint_of(escapement)
        self.state, self.clock = np.zeros(STATE), np.zeros(1, self.marching.CLOCK)
        self.state[DRIVER_SPEED] = speed * escapement.time_unit
        self.clock["step"], self.before = 1.0, np.zeros(2)

    def outcome(self, why: Ending) -> tuple[Status, str]:
        """Status and message of a motion that ends so before its goal."""
        raise NotImplementedError

    def go(self, engagements: int, end: float = math.inf) -> tuple[np.ndarray, Ending]:
        """Rows up to a number of engagements or a time, and why the march ended."""
        blocks, why, buffer = [], Ending.RUNNING, np.empty(_BLOCK, self.marching.STEP_END)
        given = *self.marched, self.rtol, engagements, end, MOST_TRIES
        while why == Ending.RUNNING:
            count, why = self.marching.march(self.state, self.clock, *given, buffer)
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
        done = why == Ending.ARRIVED
        status, message = (Status.OK, MESSAGES[Status.OK]) if done else self.outcome(why)

        def fill(which: np.ndarray, times: FloatArray, found: FloatArray) -> None:
            self.tabulate(rows, which, times, *self.tabulated, found)

        trajectory: Any = CompliantTrajectory(Steps(rows, timer, fill))
        return Motion(
            timer, engine=self.engine, rtol=asked, trajectory=trajectory,
            end_time=float(rows["time"][-1] * clock), handoff_times=rows["time"][cells] * clock,
            handoff_velocities=rows["state"][cells, DRIVER_SPEED] / clock, status=status,
            message=message,
        )  # fmt: skip

    def engage(self, count: int, asked: float) -> tuple[Motion, dict[str, float]]:
        """Pass engagements: their motion, and the numbers by which such rounds are compared."""
        self.set_back()
        motion = self.motion(*self.go(count), asked)
        if motion.outcome is not Status.OK:
            return motion, {}
        found = cycle_figures(motion)
        return motion, {name: found[name] for name in _NUMBERS}

    def hurry(self, factor: float) -> None:
        """Multiply both speeds."""
        self.state[2:4] *= factor


def simulated(
    march: CompliantMarch, engagements: int | None, duration: float | None, rtol: float
) -> Motion:
    """The motion of a march over engagements or a time [s]."""
    if engagements is not None and engagements > LONGEST:
        raise InvalidValue(
            f"engagements must be at most {LONGEST} with stiffness, got {engagements!r}; "
            "the figures of merit need no long motion"
        )
    end = math.inf if duration is None else duration / march.escapement.time_unit
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
