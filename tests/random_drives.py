"""Escapements by their ratios or drawn at random, and what is compared of their motions.

Natural units throughout: the follower's inertia and the torque are 1 unless a property varies
them, so the driver's inertia is rho and the load torque the load ratio.
"""

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

import escapement as esc

# the first drive drawn compiles the kernels
slow_to_draw = [HealthCheck.too_slow, HealthCheck.filter_too_much]
few = settings(deadline=None, max_examples=30, suppress_health_check=slow_to_draw)
very_few = settings(few, max_examples=8)


def drive(slots=4, pins=None, rho=0.06, mu=0.35, load=0.0, torque=1.0, **wheel):
    """A Geneva wheel's escapement; rho is the driver's inertia."""
    mechanism = esc.Geneva(slots, pins, **wheel)
    return esc.Escapement(mechanism, esc.Inertia(rho, 1.0), torque, mu, load)


@st.composite
def wheels(draw, most_slots=40, internal=None, crank_radius=None):
    inside = draw(st.booleans()) if internal is None else internal
    n = draw(st.integers(3, most_slots))
    pins = draw(st.integers(1, 1 if inside else 2 * n // (n - 2)))
    return esc.Geneva(n, pins, inside, crank_radius)


def bearable(wheel, mu):
    """Load ratio up to which no engagement can stop: p_+ M_f < tau everywhere."""
    found = wheel.transmission(np.linspace(*wheel.breaks[::2], 801))
    return 0.99 / float((found.g + mu * np.abs(found.u)).max())


@st.composite
def drives(draw, share=(0.0, 0.97), load=True, rho=(-2.0, 2.0), **wheel):
    """An escapement that never stalls; `share` bounds friction over the Painleve limit."""
    mechanism = draw(wheels(**wheel))
    inertia = esc.Inertia(10.0 ** draw(st.floats(*rho)), 1.0)
    mu = draw(st.floats(*share)) * esc.critical_friction(mechanism, inertia)
    carried = draw(st.floats(0.0, 0.8)) * bearable(mechanism, mu) if load else 0.0
    return esc.Escapement(mechanism, inertia, 1.0, mu, carried)


speeds = st.one_of(st.just(0.0), st.floats(-1.0, 3.0).map(lambda x: 10.0**x))
settling = drives(share=(0.05, 0.97), load=False)  # has a terminal cycle within reach
factors = st.floats(-3.0, 3.0).map(lambda x: 10.0**x)


def close(found, expected, rtol=1e-11, scale=0.0):
    np.testing.assert_allclose(found, expected, rtol=rtol, atol=rtol * scale)


def dense(motion, count=400):
    return motion.at(np.linspace(0.0, motion.end_time, count))


def contacts(motion, count=12):
    """Side of the slot, transmission and state at points inside each piece in contact."""
    ends = [*motion.trajectory.start[1:], motion.end_time]
    cell = motion.escapement.mechanism.cell_angle
    for piece, (start, end) in enumerate(zip(motion.trajectory.start, ends, strict=True)):
        sign = motion.trajectory.sign[piece]
        if sign == 0.0 or end - start <= 1e-9 * motion.end_time:
            continue
        state = motion.within(piece, start + (end - start) * np.linspace(0.01, 0.99, count))
        local = state.theta - motion.trajectory.engagement[piece] * cell
        yield sign, motion.escapement.mechanism.transmission(local), state
