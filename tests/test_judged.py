"""No result with an open energy balance says ok, whatever a user looks at first."""

from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from both_engines import each_engine
from escapement.base.status import Status
from escapement.base.units import INCH_POUND
from escapement.engines.energy import batch, cycle
from escapement.engines.energy.trajectory import EnergyTrajectory
from escapement.study import checked

INERTIA = esc.Inertia(3e-6 * INCH_POUND, 50e-6 * INCH_POUND)
TIMER = esc.Escapement(esc.Geneva(4, crank_radius=0.01), INERTIA, 0.1 * INCH_POUND, 0.35)
UNEVEN = replace(TIMER, mechanism=replace(TIMER.mechanism, pin_angle_errors=(1e-3, 0.0, 0.0, 0.0)))


@pytest.fixture(autouse=True)
def nothing_solved(monkeypatch):
    """As in a process that has not checked any scene yet."""
    monkeypatch.setattr(checked, "_solved", {})


@pytest.fixture
def lossy(monkeypatch):
    """Losses that are read a hundred-thousandth too great."""
    right = EnergyTrajectory.losses
    wrong = property(lambda motion: right.func(motion) * (1.0 + 1e-5))
    monkeypatch.setattr(EnergyTrajectory, "losses", wrong)


@pytest.mark.parametrize("engagements", [1, 20, 600])
@pytest.mark.parametrize("timer", [TIMER, UNEVEN])
def test_the_status_of_a_motion_waits_for_its_balance(lossy, timer, engagements):
    for first in ("status", "message"):
        motion = esc.simulate(timer, engagements)
        getattr(motion, first)
        assert motion.status is Status.NOT_CONVERGED
        assert "not accounted for" in motion.message
        assert "not accounted for" in repr(motion)
        assert motion.outcome is Status.NOT_CONVERGED


@pytest.mark.parametrize("timer", [TIMER, UNEVEN])
def test_the_status_of_figures_waits_for_the_balance_of_the_cycle(lossy, timer):
    for first in ("status", "message"):
        figures = esc.terminal(timer)
        getattr(figures, first)
        assert figures.status is Status.NOT_CONVERGED
        assert "not accounted for" in figures.message
    assert replace(esc.terminal(timer), period=1.0).status is Status.NOT_CONVERGED


@each_engine
def test_a_motion_whose_balance_closes_is_ok(engine):
    for timer in (TIMER, UNEVEN):
        assert esc.simulate(timer, 3, engine=engine).status is Status.OK
        assert esc.terminal(timer, engine=engine).status is Status.OK


def test_a_failed_motion_keeps_its_reason(lossy):
    motion = esc.simulate(replace(TIMER, load_torque=TIMER.torque), 3)
    assert motion.status is Status.STALL
    assert "stalls" in motion.message


def study(timer, **axes):
    results = ["period", "velocity_max", "velocity_min"]
    return esc.sweep(timer, results=results, **axes).results


def planted(monkeypatch, rows, share=1.0 + 1e-5):
    """Let the kernels of a study give a wrong period in some rows of every slice."""
    right = batch.solve

    def wrong(*given):
        table, status = right(*given)
        table[rows, cycle.COLUMNS.index("period")] *= share
        return table, status

    monkeypatch.setattr(batch, "solve", wrong)


@pytest.mark.parametrize("timer", [TIMER, UNEVEN])
def test_a_study_whose_kernels_are_wrong_says_so(monkeypatch, timer):
    planted(monkeypatch, slice(None))
    found = study(timer, friction=np.linspace(0.1, 0.3, 10))
    assert (found["status"] == Status.NOT_CONVERGED).all()
    assert np.isnan(found["period"]).all()


def test_one_wrong_extreme_is_found_and_the_others_are_kept(monkeypatch):
    right = study(TIMER, friction=np.linspace(0.1, 0.3, 10))
    checked._solved.clear()
    planted(monkeypatch, 4, share=2.0)
    found = study(TIMER, friction=np.linspace(0.1, 0.3, 10))
    failed = found["status"] == Status.NOT_CONVERGED
    assert failed.sum() == 1
    assert (found["period"][~failed] == right["period"][~failed]).all()


def test_a_study_that_asks_for_the_residual_is_judged_in_every_case(lossy):
    friction = np.linspace(0.1, 0.3, 5)
    found = esc.sweep(TIMER, results=["period", "energy_residual"], friction=friction).results
    assert (found["status"] == Status.NOT_CONVERGED).all()
    assert (abs(found["energy_residual"]) > 1e-6).all()
    assert np.isnan(found["period"]).all()


@pytest.fixture
def cases(monkeypatch):
    """Cases of studies that are checked."""
    found, right = [], checked._is_right
    monkeypatch.setattr(checked, "_is_right", lambda *given: found.append(0) or right(*given))
    return found


def test_the_first_scenes_of_each_kind_are_checked_and_then_one_of_many(cases):
    for timer in (TIMER, replace(TIMER, load_torque=0.1 * TIMER.torque), UNEVEN):
        before = len(cases)
        for _ in range(5):
            study(timer, friction=np.linspace(0.1, 0.3, 10))
        assert len(cases) == before + 1
    for _ in range(21):
        study(TIMER, friction=np.linspace(0.1, 0.3, 100))
    assert len(cases) == before + 2


def test_wrong_kernels_are_found_again_in_each_study(monkeypatch):
    planted(monkeypatch, slice(None))
    for _ in range(3):
        found = study(TIMER, friction=np.linspace(0.1, 0.3, 10))
        assert (found["status"] == Status.NOT_CONVERGED).all()


def test_few_cases_of_a_study_are_checked(cases):
    found = study(TIMER, friction=np.linspace(0.0, 0.5, 3000))
    assert 1 <= len(cases) <= 3
    assert {*found["status"]} == {Status.OK, Status.NO_TERMINAL, Status.PAINLEVE}
