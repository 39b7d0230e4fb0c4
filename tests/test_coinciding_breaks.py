"""Knots of the torque and ends of a spring that coincide with breaks of the mechanism.

Behind a spring that is spent at dead centre the force vanishes there together with the
acceleration, so that rounding would decide on reversals and extrema. `ivp` is the judge.
"""

from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from both_engines import agree
from escapement.base.status import Status
from escapement.dynamics.energy_balance import JudgedResult

CELL, TORQUE = np.pi / 2.0, 0.0113
GENEVA, INERTIA = esc.Geneva(4), esc.Inertia(3.39e-7, 5.65e-6)


def no_torque_from(place):
    """A torque that is zero from a place in the cell on, for .3 rad."""
    curve = esc.TorqueCurve([0.0, place, place + 0.3, CELL], [TORQUE, 0, 0, TORQUE], periodic=True)
    return esc.Escapement(GENEVA, INERTIA, torque=curve, friction=0.35)


@pytest.mark.parametrize("beside", [0.0, 1e-12, -1e-10])
def test_the_torque_becomes_zero_at_dead_centre(beside):
    motion, _ = agree(no_torque_from(CELL / 2.0 + beside), 4)
    assert motion.reversals.time.size == 12
    # one of the three reversals of each engagement is at dead centre, where the contact point
    # reverses its direction of sliding as well
    from_centre = motion.reversals.theta - motion.reversals.engagement * CELL
    assert np.sum(np.abs(from_centre) < 1e-9) == 4
    assert motion.slide_changes.time.size == 4


@pytest.mark.parametrize("cells", [0.5, 1.0, 2.5])
def test_a_spring_is_spent_at_a_break(cells):
    spring = esc.Escapement(
        GENEVA, INERTIA, torque=TORQUE, spring_rate=TORQUE / (cells * CELL), friction=0.3
    )
    agree(spring, 4)


def test_events_that_lead_elsewhere_than_their_handoff_give_no_states():
    motion = esc.simulate(no_torque_from(CELL / 2.0), 4)
    motion.trajectory.speeds[1] *= 1.001
    assert motion.outcome is Status.OK
    within = motion.at((motion.handoff_times[0] + motion.handoff_times[1]) / 2.0)
    assert np.isnan(within.theta_dot)
    assert motion.status is Status.NOT_CONVERGED
    assert "not reliable" in motion.message


@pytest.mark.parametrize("engine", ["energy", "ivp"])
def test_a_motion_whose_balance_does_not_close_is_not_ok(engine):
    motion = esc.simulate(esc.Escapement(GENEVA, INERTIA, TORQUE, 0.3), 3, engine=engine)
    wrong = replace(motion, escapement=esc.Escapement(GENEVA, INERTIA, 1.001 * TORQUE, 0.3))
    wrong.trajectory = motion.trajectory
    assert motion.ledger.residual < 1e-12
    assert motion.status is Status.OK
    assert abs(wrong.ledger.residual) > 1e-6
    assert wrong.status is Status.NOT_CONVERGED
    assert "not accounted for" in wrong.message


class Told(JudgedResult):
    def __init__(self, status, rtol):
        vars(self).update(status=status, message="", _rtol=rtol)


@pytest.mark.parametrize(("residual", "rtol", "closes"), [
    (2e-11, 1e-12, True), (-2e-6, 1e-4, True),
    *((residual, 1e-12, False) for residual in (2e-6, -2e-6, np.nan, np.inf)),
])  # fmt: skip
def test_what_closes(residual, rtol, closes):
    for status in (Status.OK, Status.SPENT, Status.STALL):
        result = Told(status, rtol)
        result.judge_by(residual)
        assert (result.outcome is status) == (closes or status is Status.STALL)
        assert result.outcome in (status, Status.NOT_CONVERGED)
