"""Where the work of the drive goes over a motion."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from escapement.dynamics import LOSSES
from escapement.text import Shown


@dataclass(frozen=True, repr=False)
class Ledger(Shown):
    """Where the work of the drive went over a motion [J].

    work is that of the drive, which a spring gives of the energy that it holds. It is
    kinetic + load + all that is lost, up to `residual`, which is a share of the work or
    of the kinetic energy at the start, whichever is greater. Lost is what goes into friction in
    the slot or the mesh, into either bearing, into drag on either body and into blows.
    """

    _units = dict.fromkeys(("work", "kinetic", "load", *LOSSES, "blows"), "J")

    work: float
    kinetic: float
    load: float
    friction: float
    driver_bearing: float
    follower_bearing: float
    driver_drag: float
    follower_drag: float
    blows: float
    residual: float


def ledger_of(motion: Any) -> Ledger:
    """Energy balance of a motion from start to end."""
    escapement = motion.escapement
    if motion.trajectory.start.size == 0:
        return Ledger(**{field.name: 0.0 for field in fields(Ledger)})
    ends = motion.at([0.0, motion.end_time])
    driver, follower = escapement.inertia.driver, escapement.inertia.follower
    energies = (driver * ends.theta_dot**2 + follower * ends.phi_dot**2) / 2.0
    work = escapement.drive_work(ends.theta[1] - ends.theta[0])
    if (taken := getattr(motion.trajectory, "load_work", None)) is not None:
        load, blows = float(taken.sum()), float(motion.impacts.energy.sum())
    else:
        # at the end of the motion a handoff is still to come
        passed = motion.handoffs.time < motion.end_time
        load = escapement.load_work(ends.phi[1] - ends.phi[0] - motion.handoffs.jump[passed].sum())
        blows = float(motion.handoffs.energy[passed].sum())
    losses = dict(zip(LOSSES, motion.trajectory.losses.sum(axis=1).tolist(), strict=True))
    kinetic = float(energies[1] - energies[0])
    scale = max(work, float(energies[0]))
    missing = work - kinetic - load - sum(losses.values()) - blows
    residual = float(missing / scale) if scale > 0.0 else 0.0
    return Ledger(float(work), kinetic, float(load), **losses, blows=blows, residual=residual)
