"""Where the work of the drive goes over a motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from escapement.base.status import MESSAGES, Status
from escapement.base.text import Shown
from escapement.dynamics.law import LOSSES
from escapement.dynamics.trajectory import NoTrajectory

TOLERATED = 1e-6
"""A motion whose energy balance misses more than this share of the work is not a result [-]."""


class Judged:
    """A status or a message on which the energy balance decides when it is first read.

    The class of the result has a method `judge`, which does so. `outcome` below is what an engine
    said, for those who go on computing.
    """

    def __init__(self, *default: Any) -> None:
        self.default = default

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, result: Any, owner: type | None = None) -> Any:
        if result is None:
            # a dataclass asks for the default of the field
            if not self.default:
                raise AttributeError(self.name)
            return self.default[0]
        result.judge()
        return result.__dict__[self.name]

    def __set__(self, result: Any, value: Any) -> None:
        result.__dict__[self.name] = value


class JudgedResult:
    """Base of results whose status and message are `Judged`."""

    judged = False
    """Whether the energy balance has decided on the status."""

    @property
    def outcome(self) -> Status:
        """The status by the engine alone, before the energy balance decides on it."""
        status: Status = self.__dict__["status"]
        return status

    def add_notes(self, *notes: str | None) -> None:
        """Add what a user should know to the message."""
        if any(notes):
            stated = vars(self)["message"]
            said = (stated if stated != MESSAGES[Status.OK] else None, *notes)
            vars(self)["message"] = "; ".join(filter(None, said))

    def judge(self) -> None:
        """Decide on the status by the energy balance, once."""
        if self.judged:
            return
        vars(self)["judged"] = True
        if not self.outcome.failed and (residual := self._residual()) != 0.0:
            self.judge_by(residual)

    def judge_by(self, residual: float) -> None:
        """Change the status if this residual of the energy balance shows a wrong motion.

        A result whose balance does not close within `TOLERATED`, or within a coarser rtol that was
        asked for, has not converged; NaN does not close.
        """
        result: Any = self
        if self.outcome.failed or abs(residual) <= max(TOLERATED, result._rtol):
            return
        missing = f"{abs(residual):.2g} of the work is not accounted for"
        if residual != residual:
            missing = "no balance of energy exists"
        message = f"the result is not reliable: {missing}; try the other engine"
        vars(self).update(status=Status.NOT_CONVERGED, message=message)

    def _residual(self) -> float:
        """Residual of the energy balance that decides."""
        raise NotImplementedError


@dataclass(frozen=True, repr=False)
class Ledger(Shown):
    """Where the work of the drive went over a motion [J].

    work is the work of the drive; with a spring it is taken from the energy of the spring. It
    equals kinetic + load + elastic + all losses, up to `residual`, which is relative to the
    greatest of these and of the kinetic energy at the start. Losses are friction in the slot
    or the gears, friction in both bearings, drag on both bodies, and the losses of trains and
    blows. elastic is the increase of the energy stored in compliant walls.
    """

    _units = dict.fromkeys(("work", "kinetic", "load", *LOSSES, "blows", "elastic"), "J")

    work: float
    kinetic: float
    load: float
    friction: float
    driver_bearing: float
    follower_bearing: float
    driver_drag: float
    follower_drag: float
    barrel: float
    load_train: float
    blows: float
    residual: float
    elastic: float = 0.0


def ledger_of(motion: Any, progress: Callable[[int, int, int], None] | None = None) -> Ledger:
    """Energy balance of a motion from start to end; `progress` is as in `write_motion`."""
    escapement = motion.escapement
    if isinstance(motion.trajectory, NoTrajectory):
        return Ledger(**{field.name: 0.0 for field in fields(Ledger)})
    ends = motion.at([0.0, motion.end_time])
    driver, follower = (escapement.referred[f"{body}_inertia"] for body in ("driver", "follower"))
    taken = motion.trajectory.load_work
    # an impact at the very start is part of the motion, which begins in front of it
    first = ends if taken is None else motion.within(0, [0.0])
    one, two = (
        (driver * state.theta_dot**2 + follower * state.phi_dot**2) / 2.0 for state in (first, ends)
    )
    energies = np.array([one[0], two[1]])
    work = escapement.drive_work(ends.theta[1] - ends.theta[0])
    jumped = blows = 0.0
    if len(escapement.pairs) > 1:
        # a handoff at the end of the motion does not count, unless the motion stops after it
        last = motion.trajectory.around(np.array([motion.end_time])).engagement[-1]
        passed = motion.handoffs.engagement <= last
        to = motion.handoffs.engagement[passed] % len(escapement.pairs)
        jumped = float(escapement.jump_works[to].sum())
        blows = float(motion.handoffs.energy[passed].sum())
    load = escapement.load_work(ends.phi[1] - ends.phi[0], ends.phi[0]) - jumped
    if taken is not None:
        load, blows = float(taken.sum()), float(motion.impacts.energy.sum())
    lost, done = np.zeros(len(LOSSES)), 0
    for part in motion.parts():
        lost += part.trajectory.losses.sum(axis=1)
        done += part.handoff_times.size
        if progress is not None:
            progress(done, motion.handoff_times.size, 0)
    losses = dict(zip(LOSSES, lost.tolist(), strict=True))
    kinetic = float(energies[1] - energies[0])
    elastic = float(motion.trajectory.elastic)
    missing = work - kinetic - elastic - load - sum(losses.values()) - blows
    parts = {**losses, "blows": blows, "elastic": elastic}
    scale = max(abs(x) for x in (work, energies[0], kinetic, load, *parts.values()))
    residual = float(missing / scale) if scale > 0.0 else 0.0
    return Ledger(float(work), kinetic, float(load), **parts, residual=residual)
