"""Motions without friction, by the closed form: energy is what the torque has done."""

import math
from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from escapement.mechanisms.slotted import transmission
from escapement.sources import meyer

TORQUE, DRIVER, FOLLOWER = 0.01, 1e-6, 1e-6


def drive(mechanism, **numbers):
    return esc.Escapement(mechanism, esc.Inertia(DRIVER, FOLLOWER), torque=TORQUE, **numbers)


@pytest.mark.parametrize("engine", ["energy", "ivp"])
@pytest.mark.parametrize("start", [1.0, np.pi])
def test_a_table_may_begin_where_its_follower_moves(engine, start):
    load = 0.003
    theta = start + np.linspace(0.0, 2.0 * np.pi, 61)
    table = esc.Tabulated(theta, theta + 0.5 * np.sin(theta))
    motion = esc.simulate(drive(table, load_torque=load), 3, engine=engine)
    moving = 1.0 + 0.5 * math.cos(start)
    gained = 2.0 * (TORQUE - load) * 2.0 * np.pi * np.arange(1, 4)
    speeds = np.sqrt(gained / (DRIVER + FOLLOWER * moving**2))
    # the table is a spline of 60 rows
    np.testing.assert_allclose(motion.handoff_velocities, speeds, rtol=1e-6)
    assert abs(motion.ledger.residual) < 1e-9


def test_published_cells_settle_without_friction_for_energy_jumps_at_their_handoffs():
    cell = drive(meyer.PublishedCell(6), load_torque=0.001)
    found, judge = (esc.terminal(cell, engine=engine) for engine in ("energy", "ivp"))
    for name in ("handoff_velocity", "contraction", "rise_time", "velocity_max"):
        assert getattr(found, name) == pytest.approx(getattr(judge, name), rel=1e-8)
    # the speed is continuous where the ratio leaps from its end to 0
    g = transmission(cell.mechanism.path, cell.mechanism.breaks[-1]).g
    assert found.contraction == pytest.approx(DRIVER / (DRIVER + FOLLOWER * g**2), rel=1e-9)
    settled = esc.simulate(cell, 150).handoff_velocities[-1]
    assert found.handoff_velocity == pytest.approx(settled, rel=1e-6)
    study = esc.sweep(cell, friction=[0.0, 1e-12])
    assert study.failed == 0
    assert study.results["period"][0] == pytest.approx(found.period, rel=1e-9)
    assert study.results["period"][0] == pytest.approx(study.results["period"][1], rel=1e-9)
    four = replace(cell, mechanism=meyer.PublishedCell(4))
    assert esc.terminal(four).status.label == "no_terminal"
