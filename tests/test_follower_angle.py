"""The follower angle at driver angles of any size: it grows, and it is the integral of g."""

import math

import numpy as np
import pytest

import escapement as esc
from command_scenes import TOUCHING
from escapement.base.errors import InvalidValue
from escapement.mechanisms import KINDS

_OVALS = esc.EllipticalPlanetary(0.016, 0.009)
_ROWS = np.linspace(-0.5, 0.5, 81) * _OVALS.cell_angle
_ANY = np.random.default_rng(3).uniform(-4.0, 4.0, 160) * _OVALS.cell_angle
_CELL = {"cell_angle": _OVALS.cell_angle, "follower_step": _OVALS.follower_step}
MECHANISMS = [
    *(esc.Geneva(n, pins) for n, pins in [(3, None), (4, None), (4, 1), (5, 3), (6, 1), (60, 2)]),
    *(esc.Geneva(n, internal=True) for n in (3, 8)),
    esc.GearDriven(12, 3),
    esc.GearDriven(12, 5, "epicycloid", pins=6),
    esc.GearDriven(24, 5, pins=2),
    esc.GearDriven(12, 3, "contracted-hypocycloid"),
    esc.GearDriven(7, "2/3", "pericycloid"),
    esc.GearDriven(11, "1/2", unused_lobes=2),
    esc.GearDriven(10, 3),
    esc.GearDriven(10, 3, "epicycloid", solution=2),
    _OVALS,
    esc.EllipticalPlanetary(0.02, 0.0019),
    esc.Tabulated(_ROWS, -_OVALS.follower_angle(_ROWS)),
    esc.Tabulated(_ROWS + 2.0, _OVALS.follower_angle(_ROWS) + 1.0),
    esc.CamIndexer(8, 2.0, "modified-trapezoid"),
    esc.Tabulated(_ANY, _OVALS.follower_angle(_ANY), measured=True, **_CELL),
]


def integral_of_g(mechanism, theta):
    """The integral of the transmission from 0 to ascending driver angles, by Gauss's rule.

    The pieces end at the breaks of every cell, between which g is smooth; those of a table's
    spline are as short as its rows are close.
    """
    ends = [mechanism.breaks[0], 0.0, mechanism.breaks[-1]]
    whole = np.arange(
        math.floor(theta[0] / mechanism.cell_angle) - 1,
        math.ceil(theta[-1] / mechanism.cell_angle) + 2,
    )
    edges = np.add.outer(whole * mechanism.cell_angle, ends).ravel()
    fine = np.linspace(theta[0], theta[-1], 8001)
    edges = np.unique(np.concatenate([theta, fine, [0.0], edges]))
    edges = edges[(edges >= theta[0]) & (edges <= theta[-1])]
    nodes, weights = np.polynomial.legendre.leggauss(12)
    low, high = edges[:-1], edges[1:]
    at = low[:, None] + 0.5 * (high - low)[:, None] * (1.0 + nodes)
    pieces = 0.5 * (high - low) * (mechanism.transmission(at).g @ weights)
    sums = np.concatenate([[0.0], np.cumsum(pieces)])
    sums -= sums[np.searchsorted(edges, 0.0)]
    return sums[np.searchsorted(edges, theta)]


def test_every_kind_is_tried():
    assert {mechanism.kind for mechanism in MECHANISMS} == {*KINDS} - {*TOUCHING}


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=repr)
def test_it_grows_over_ten_turns_and_is_the_integral_of_the_transmission(mechanism):
    theta = np.linspace(-3.0, 10.0, 2001) * 2.0 * math.pi
    phi = mechanism.follower_angle(theta)
    least = min(mechanism.transmission(theta).g.min(), 0.0)
    assert np.diff(phi).min() >= 2.0 * least * (theta[1] - theta[0]) - 1e-13
    assert least > -0.02  # only a measured table may turn back, as far as its noise
    turned = phi - mechanism.follower_angle(0.0)
    np.testing.assert_allclose(turned, integral_of_g(mechanism, theta), rtol=0.0, atol=2e-11)
    for cells in (1, 7, -5):
        moved = mechanism.follower_angle(theta + cells * mechanism.cell_angle)
        grown = phi + cells * mechanism.follower_step
        np.testing.assert_allclose(moved, grown, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=repr)
def test_g_and_its_derivatives_are_zero_in_a_dwell_and_the_same_in_each_cell(mechanism):
    entry, exit_ = mechanism.breaks[0], mechanism.breaks[-1]
    inside = entry + (exit_ - entry) * np.linspace(0.01, 0.99, 37)
    inside = inside[np.abs(inside) > 1e-3]
    dwell = entry + mechanism.cell_angle - exit_
    here = mechanism.transmission(inside)
    for cells in (-3, 8):
        there = mechanism.transmission(inside + cells * mechanism.cell_angle)
        for name in ("g", "u", "dg"):
            one, other = getattr(here, name), getattr(there, name)
            np.testing.assert_allclose(other, one, rtol=0.0, atol=1e-10 * (1.0 + np.abs(one).max()))
        if dwell > 1e-9:
            locked = exit_ + dwell * np.linspace(0.01, 0.99, 11) + cells * mechanism.cell_angle
            found = mechanism.transmission(locked)
            assert not np.any([found.g, found.u, found.dg])
            assert mechanism.jerk is None or not mechanism.jerk(locked).any()
            assert np.ptp(mechanism.follower_angle(locked)) == 0.0


@pytest.mark.parametrize("seed", range(3))
def test_errors_of_parts_act(seed):
    """It is what `Motion.at` gives, which reads the pattern of pins and slots."""
    random = np.random.default_rng(seed)
    wheel = esc.Geneva(
        5, 2, crank_radius=0.02, centre_distance_error=2e-5,
        pin_angle_errors=1e-3 * random.standard_normal(2),
        slot_angle_errors=1e-3 * random.standard_normal(5),
        slot_offsets=1e-5 * random.standard_normal(5),
        crank_radius_errors=1e-5 * random.standard_normal(2),
    )  # fmt: skip
    timer = esc.Escapement(wheel, esc.Inertia(1e-6, 1e-6), torque=0.01, friction=0.1)
    motion = esc.simulate(timer, engagements=25)
    state = motion.at(np.linspace(0.0, motion.end_time * (1.0 - 1e-9), 3000))
    found = wheel.follower_angle(state.theta)
    assert np.abs(found - state.phi).max() < 1e-12
    ratio = wheel.transmission(state.theta).g
    assert np.abs(ratio * state.theta_dot - state.phi_dot).max() < 1e-8 * state.phi_dot.max()
    assert float(wheel.follower_angle(1.0)) == wheel.follower_angle([1.0])[0]
    with pytest.raises(InvalidValue, match="mechanism must be without errors of its parts here"):
        wheel.jerk(0.0)
