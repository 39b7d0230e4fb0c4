"""Laws that hold for every contact: Newton's, the ledger's, and Painleve's limit."""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import escapement as esc
from escapement.base.status import Status
from escapement.dynamics.painleve import first_beyond
from escapement.mechanisms.gear_equation import CURVES
from random_drives import close, contacts, dense, drives, few, speeds, wheels


# contact
@few
@given(drives(), speeds)
def test_both_members_obey_newton(drive, speed):
    """N R - M_f = I_f phi_ddot, tau - I_d theta_ddot = p_s N R, and s is the sign of N R."""
    motion = esc.simulate(drive, 3, initial_speed=speed)
    largest = np.abs(motion.contact_moment).max()
    for sign, found, state in contacts(motion):
        assert np.all(sign * state.contact_moment >= -1e-9 * largest)
        p = found.g + sign * drive.friction * np.abs(found.u)
        scale = np.abs(state.contact_moment).max() * (1.0 + np.abs(p).max())
        follower = state.phi_ddot + drive.load_torque
        close(follower, state.contact_moment, 1e-9, scale)
        drawn = 1.0 - drive.inertia.driver * state.theta_ddot
        close(drawn, p * state.contact_moment, 1e-9, scale + 1.0)


@few
@given(drives(), speeds)
def test_a_reversal_lies_on_its_locus(drive, speed):
    """Within 1e-8 of a radian of where rho (g' w + load) + g vanishes; there the driver is free."""
    motion = esc.simulate(drive, 3, initial_speed=speed)
    turns, rho = motion.reversals, drive.inertia.driver
    angle = turns.theta - turns.engagement * drive.mechanism.cell_angle
    found, w = drive.mechanism.transmission(angle), turns.theta_dot**2
    beside = [drive.mechanism.transmission(angle + h).dg for h in (-1e-5, 1e-5)]
    slope = rho * w * (beside[1] - beside[0]) / 2e-5 + 3.0 * found.dg  # w' = 2/rho
    nothing = rho * (found.dg * w + drive.load_torque) + found.g
    terms = found.g + rho * (np.abs(found.dg) * w + drive.load_torque)
    assert np.all(np.abs(nothing) <= 1e-8 * np.abs(slope) + 1e-12 * terms)
    close(motion.at(turns.time).theta_ddot * rho, np.ones(turns.time.size), 1e-6)


@few
@given(drives(load=False), speeds)
def test_without_a_load_the_force_turns_once_after_dead_centre(drive, speed):
    motion = esc.simulate(drive, 4, initial_speed=speed)
    assert motion.reversals.engagement.tolist() == [0, 1, 2, 3]
    place = motion.reversals.theta - np.arange(4) * drive.mechanism.cell_angle
    assert np.all((place > 0.0) & (place < drive.mechanism.breaks[-1]))


@few
@given(drives(), speeds)
def test_extrema_alternate_and_nothing_goes_beyond_them_or_backwards(drive, speed):
    motion = esc.simulate(drive, 3, initial_speed=speed)
    state = dense(motion)
    assert np.all(np.diff(state.theta) > 0.0)
    assert np.all(np.diff(state.phi) >= -1e-15)
    assert np.all(state.phi_dot >= -1e-12 * state.theta_dot.max())
    extrema = motion.extrema
    assert np.all(extrema.maximum[1:] != extrema.maximum[:-1])
    assert np.all(np.diff(extrema.time) > 0.0)
    marks = np.concatenate([[0.0], extrema.time, [motion.end_time]])
    for start, end in pairwise(marks):
        between = np.diff(motion.at(np.linspace(start, end, 40)).theta_dot)
        slack = 1e-11 * motion.theta_dot.max()
        assert np.all(between >= -slack) or np.all(between <= slack)


# the Painleve limit
@few
@given(wheels(), st.floats(-6.0, 6.0), st.floats(1.0, 3.0), st.floats(0.0, 1e3))
def test_at_the_limit_and_beyond_nothing_is_integrated(wheel, exponent, factor, load):
    inertia = esc.Inertia(10.0**exponent, 1.0)
    mu = factor * esc.critical_friction(wheel, inertia)
    drive = esc.Escapement(wheel, inertia, 1.0, mu, load)
    outcomes = [esc.simulate(drive, engine=engine) for engine in ("energy", "ivp")]
    for outcome in [*outcomes, esc.terminal(drive), esc.terminal(drive, engine="ivp")]:
        assert outcome.status is Status.PAINLEVE
        assert f"{esc.critical_friction(wheel, inertia):.6g}" in outcome.message


@few
@given(wheels(), st.floats(-6.0, 6.0), st.floats(1.0, 3.0))
def test_the_limit_is_met_where_it_is_said_to_be(wheel, exponent, factor):
    rho = 10.0**exponent
    inertia = esc.Inertia(rho, 1.0)
    limit = esc.critical_friction(wheel, inertia)
    mu = 1.0001 * factor * limit

    def first(friction):
        scene = esc.Escapement(wheel, inertia, 1.0, friction).scene
        return first_beyond(scene, 0.0, scene.edges[-1])

    angle = first(mu)
    found = wheel.transmission(angle)
    reduced = rho + found.g**2 - mu * abs(found.g * found.u)
    assert abs(reduced) <= 1e-7 * (rho + found.g**2)
    before = wheel.transmission(angle * np.linspace(0.0, 1.0 - 1e-6, 500))
    assert np.all(rho + before.g**2 - mu * np.abs(before.g * before.u) > 0.0)
    assert math.isnan(first(0.999 * limit))


@st.composite
def paths(draw):
    """A Geneva wheel, or a gear-driven one whose pin does not meet the axis."""
    if draw(st.booleans()):
        return esc.Geneva(draw(st.integers(3, 1000)), 1, draw(st.booleans()))
    curve, n = draw(st.sampled_from(CURVES)), draw(st.integers(4, 24))
    m = draw(st.fractions(0, 12, max_denominator=4))
    if curve not in ("epicycloid", "pericycloid"):
        m *= (Fraction(n, 2) - 2) / 13
    wheel = esc.GearDriven(n, m.limit_denominator(9), curve)
    assume(not wheel.through_centre)
    return wheel


@settings(deadline=None)
@given(paths(), st.floats(-8.0, 8.0))
def test_the_limit_is_the_least_ratio_and_is_reached(wheel, exponent):
    rho = 10.0**exponent
    limit = esc.critical_friction(wheel, esc.Inertia(rho, 1.0))
    # dense near the ends, where a light driver has its limit
    away = np.concatenate([np.geomspace(1e-12, 1.0, 4000), np.linspace(1e-6, 1.0, 4000)])
    found = wheel.transmission(wheel.breaks[-1] * np.concatenate([1.0 - away, away]))
    with np.errstate(divide="ignore"):
        ratio = (rho + found.g**2) / (np.abs(found.g) * np.abs(found.u))
    assert limit <= ratio.min() * (1.0 + 1e-12)
    assert limit == pytest.approx(ratio.min(), rel=1e-3)
