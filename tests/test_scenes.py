"""Scenes that blocks share are solved once, with the same bits in every order."""

import numpy as np
import pytest

import escapement as esc
from escapement.engines.energy import batch
from escapement.study import scenes
from escapement.study.parse import plan_from
from escapement.study.result import RESULTS
from escapement.study.running import run_plan
from study_tools import TIMER

TORQUE, FRICTION = np.linspace(0.005, 0.02, 500), np.linspace(0.05, 0.4, 90)
GRIDS = {
    "torque first": {"torque": TORQUE, "friction": FRICTION},
    "torque last": {"friction": FRICTION, "torque": TORQUE},
    "torque in the middle": {"slots": [3, 4], "torque": TORQUE, "friction": FRICTION[:45]},
}


@pytest.mark.parametrize("workers", [1, 4])
@pytest.mark.parametrize("order", GRIDS)
def test_a_scene_is_solved_once_in_all_blocks(order, workers, solves):
    plan = plan_from(TIMER, GRIDS[order])
    assert plan.cases == 45_000  # three blocks
    run_plan(plan, workers=workers)
    assert sum(solves) == 90


@pytest.mark.parametrize("order", GRIDS)
def test_the_bits_do_not_depend_on_what_is_shared(order, monkeypatch):
    plan = plan_from(TIMER, GRIDS[order])
    shared, threads = run_plan(plan), run_plan(plan, workers=4)
    monkeypatch.setattr(scenes, "MOST_SHARED", 50)  # too few: every block for itself
    assert scenes.shared_scenes(plan) is None
    alone = run_plan(plan)
    for name in RESULTS:
        np.testing.assert_array_equal(shared.results[name], threads.results[name])
        np.testing.assert_array_equal(shared.results[name], alone.results[name])


REAL = esc.Escapement(
    esc.Geneva(4, crank_radius=0.01), esc.Inertia(3.4e-7, 5.65e-6), 0.0113, 0.2,
    driver_bearing_friction=0.1,
)  # fmt: skip
INERTIAS = {"driver_inertia": [1e-6, 2e-6, 4e-6], "follower_inertia": [1e-6, 2e-6, 4e-6]}
TWO = {"torque": [1.0, 2.0]}
PINS = {"torque": [0.01, 0.02, 0.03], "pin_radius": [0.0, 1e-4]}


@pytest.mark.parametrize(
    ("axes", "count"),
    [
        (TWO, 1),
        ({"friction": [0.1, 0.2]}, 2),
        ({"torque": np.linspace(1, 2, 50), "friction": np.linspace(0.1, 0.3, 7)}, 7),
        (TWO | {"slots": [3, 4, 6]}, 3),
        # equal ratios of inertias, of load and torque, of speed and torque are one scene
        (INERTIAS, 5),
        (INERTIAS | TWO | {"friction": [0.1, 0.2]}, 10),
        (INERTIAS | {"load_torque": [0.0, 0.001]}, 10),
        (INERTIAS | {"initial_speed": [3.0]}, 9),
        ({"driver_inertia": [1e-6, 2e-6], "follower_inertia": [1e-6, 3e-6]}, 4),
        (TWO | {"load_torque": [0.0, 0.0]}, 1),
        (TWO | {"load_torque": [0.0, 0.1]}, 3),
        (TWO | {"initial_speed": [3.0]}, 2),
        (PINS | {"driver_drag": [1e-8]}, 2),
        (PINS | {"driver_bearing_radius": [1e-4]}, 2),
        (PINS | {"load_torque": [1e-4]}, 6),
        (PINS | {"driver_bearing_torque": [1e-4]}, 6),
        (PINS | {"follower_viscous": [1e-6]}, 6),
        (PINS | {"initial_speed": [3.0]}, 6),
    ],
)
def test_no_scene_is_solved_twice(axes, count, solves):
    """From rest, where nothing is compared with the torque, it only changes the unit of time."""
    run_plan(plan_from(REAL, axes))
    assert sum(solves) == count


def test_an_error_while_solving_ends_the_study(monkeypatch):
    def broken(*_):
        raise MemoryError

    monkeypatch.setattr(batch, "solve", broken)
    with pytest.raises(MemoryError):
        run_plan(plan_from(TIMER, GRIDS["torque first"]), workers=4)
