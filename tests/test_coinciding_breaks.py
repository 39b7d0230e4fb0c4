"""Knots of the torque and ends of a spring that coincide with breaks of the mechanism.

Behind a spring that is spent at dead centre the force vanishes there together with the
acceleration, so that rounding would decide on reversals and extrema. `ivp` is the judge.
"""

import numpy as np
import pytest

import escapement as esc
from both_engines import agree
from escapement.base.status import Status
from escapement.dynamics.energy_balance import judged

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


def test_what_closes():
    ok, stall = (Status.OK, "done"), (Status.STALL, "it stops")
    assert judged(*ok, 2e-11, 1e-12) == ok
    assert judged(*ok, -2e-6, 1e-4) == ok
    assert judged(*stall, 1.0, 1e-12) == stall
    for residual in (2e-6, -2e-6, np.nan, np.inf):
        assert judged(*ok, residual, 1e-12)[0] is Status.NOT_CONVERGED
        assert judged(Status.SPENT, "", residual, 1e-12)[0] is Status.NOT_CONVERGED
