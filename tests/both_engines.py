"""One motion by both engines, which share no numerical method."""

import numpy as np
import pytest

import escapement as esc

each_engine = pytest.mark.parametrize(
    "engine", ["energy", pytest.param("ivp", marks=pytest.mark.slow)]
)
"""For a law of motions on which `agree` compares the engines as well."""


def agree(real, engagements, rtol=1e-10, *, events=True, speed=0.0, **judged):
    """Both engines find one motion, and the energy of the fast one balances; returns theirs.

    The settings `judged` are those of the judge, `ivp`. Without `events` only handoffs and the
    end are compared: beside a stop rounding decides on reversals.
    """
    fast = esc.simulate(real, engagements, initial_speed=speed)
    judge = esc.simulate(real, engagements, initial_speed=speed, engine="ivp", **judged)
    assert fast.status is judge.status, (fast.message, judge.message)
    np.testing.assert_allclose(fast.handoff_times, judge.handoff_times, rtol=rtol)
    np.testing.assert_allclose(fast.handoff_velocities, judge.handoff_velocities, rtol=rtol)
    assert fast.end_time == pytest.approx(judge.end_time, rel=100.0 * rtol)
    if events:
        assert fast.extrema.maximum.tolist() == judge.extrema.maximum.tolist()
        extrema = fast.extrema.theta_dot, judge.extrema.theta_dot
        np.testing.assert_allclose(*extrema, rtol=100.0 * rtol)
        assert fast.reversals.engagement.tolist() == judge.reversals.engagement.tolist()
    assert abs(fast.ledger.residual) < 1e-12
    return fast, judge
