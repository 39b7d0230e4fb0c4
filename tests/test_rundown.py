"""How a timer runs down, against single engagements, the full motion and the law of the root."""

import csv
import json
from dataclasses import replace
from math import pi

import numpy as np
import pytest

import escapement as esc
from escapement.cli import main

INERTIA = esc.Inertia(3.389e-7, 5.649e-6)
TIMER = esc.Escapement(esc.Geneva(4), INERTIA, 0.0113, 0.35, spring_rate=1.8e-6)
CELL = TIMER.mechanism.cell_angle


def test_the_rate_follows_the_root_of_the_torque():
    """Without a load the torque at some place within an engagement is what its period tells."""
    run = esc.rundown(TIMER, turns=2000.0 / 4.0)
    left = (run.nominal_period / run.periods[20:]) ** 2
    angle = (1.0 - left) * TIMER.torque / TIMER.spring_rate
    within = angle / CELL - np.arange(20, run.periods.size)
    # a place of its own for each mechanism and friction, which hardly moves over the run
    assert within.min() > 0.0
    assert within.max() < 1.0
    assert np.ptp(within) < 1e-3


def test_what_it_tells_of_each_engagement():
    run = esc.rundown(TIMER, turns=10.0)
    assert run.turns[-1] == pytest.approx(10.0)
    assert run.remaining_turns[-1] == pytest.approx(0.0, abs=1e-12)
    assert np.cumsum(run.periods) == pytest.approx(run.times)
    assert run.mean_speeds * run.periods == pytest.approx(CELL)
    assert run.rates * run.periods == pytest.approx(1.0)
    assert run.lateness[-1] == pytest.approx(-np.sum(run.rate_errors * run.periods))
    assert run.time_of(5.0) == run.times[19]
    assert run.nominal_period == esc.terminal(replace(TIMER, spring_rate=0.0)).period
    assert len(repr(run)) <= 300


def test_a_load_stalls_it():
    timer = replace(TIMER, load_torque=0.004)
    run, motion = esc.rundown(timer), esc.simulate(timer, 2000)
    assert run.status.label == motion.status.label == "stall"
    assert run.end_time == pytest.approx(motion.end_time, rel=1e-13)
    assert f"after {run.end_turns:.6g} turns" in run.message


def random_timer(random):
    """Of a run of some hundred engagements that loses up to all of its torque."""
    wheel = esc.Geneva(int(random.integers(3, 9)))
    inertia = esc.Inertia(3e-7 * 10.0 ** random.uniform(-1, 1), 5e-6)
    torque = 10.0 ** random.uniform(-3, -1)
    friction = min(esc.critical_friction(wheel, inertia), 1.0) * random.uniform(0.2, 0.8)
    load = random.choice([0.0, random.uniform(0.0, 0.3)]) * torque / wheel.transmission_max
    count = int(10.0 ** random.uniform(2.5, 3.3))
    rate = random.uniform(0.02, 1.2) * torque / (count * wheel.cell_angle)
    timer = esc.Escapement(
        wheel, inertia, torque, friction, load_torque=load, spring_rate=rate
    )  # fmt: skip
    return timer, count * wheel.cell_angle / (2.0 * pi)


@pytest.mark.parametrize("seed", range(3))
def test_series_keep_to_the_error_of_single_engagements(seed):
    """The engine takes thousands of engagements from series where that is as exact."""
    timer, turns = random_timer(np.random.default_rng(seed))
    run = esc.rundown(timer, turns=turns)
    time, speed, cell = 0.0, 0.0, timer.mechanism.cell_angle
    for k in range(run.times.size):
        held = replace(timer, torque=timer.torque - timer.spring_rate * k * cell)
        one = esc.simulate(held, 1, initial_speed=speed)
        time, speed = time + one.end_time, float(one.handoff_velocities[0])
    assert run.times[-1] == pytest.approx(time, rel=2e-12)


def test_a_duration_ends_it():
    run = esc.rundown(TIMER, duration=10.0)
    assert run.end_time == 10.0
    assert run.times[-1] < 10.0
    whole = esc.rundown(TIMER, turns=run.end_turns + 0.25)
    assert whole.times[: run.times.size] == pytest.approx(run.times, rel=1e-12)


@pytest.mark.parametrize("angles", [(0.0, 1e-3, -2e-3, 0.0), ()])
def test_imperfect_parts_run_down(angles):
    """A turn takes them, pin by pin, through cells of different lengths."""
    wheel = esc.Geneva(
        4, crank_radius=0.02, centre_distance_error=-1e-5, pin_angle_errors=angles
    )  # fmt: skip
    timer = replace(TIMER, mechanism=wheel, spring_rate=TIMER.torque / (40.3 * CELL))
    run, motion = esc.rundown(timer), esc.simulate(timer, 50)
    assert (run.status.label, run.times.size) == ("spent", 40)
    turned = motion.at([0.0, run.end_time, *run.times]).theta
    assert turned[1] - turned[0] == pytest.approx(40.3 * CELL, rel=1e-13)
    assert turned[2:] - turned[0] == pytest.approx(2.0 * pi * run.turns, rel=1e-13)
    # over turns of the driver the mean speed is that of the whole way
    way = np.sum(run.mean_speeds * run.periods)
    assert way == pytest.approx(turned[-1] - turned[0], rel=1e-13)
    assert esc.rundown(timer, turns=5.0).times == pytest.approx(run.times[:20], rel=1e-12)


def test_a_pin_that_misses_its_slot_runs_nowhere():
    wheel = esc.Geneva(4, crank_radius=0.02, slot_angle_errors=(0.0, 0.7, 0.0, 0.0))
    run = esc.rundown(replace(TIMER, mechanism=wheel))
    assert (run.status.label, run.times.size, run.end_time) == ("invalid", 0, 0.0)
    assert run.message.startswith("pin 1 cannot drive slot 1")


def test_the_command(tmp_path, capsys):
    table, picture = tmp_path / "run.csv", tmp_path / "run.png"
    model = ["--torque", "0.0113", "--friction", "0.35", "--driver-inertia", "3.389e-7"]
    model += ["--follower-inertia", "5.649e-6", "--spring-rate", "1.8e-6"]
    assert main(["rundown", *model, "--turns", "5", "-o", str(table), "--plot", str(picture)]) == 0
    assert "rate error percent" in capsys.readouterr().out
    assert picture.stat().st_size > 0
    rows = list(csv.DictReader(table.read_text().splitlines()))
    run = esc.rundown(TIMER, turns=5.0)
    assert [float(row["time_s"]) for row in rows] == run.times.tolist()
    assert main(["rundown", *model, "--load-torque", "0.004", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["status"] == "stall"
    assert "the drive cannot carry the load" in found["message"]


DRIVES = {
    slots: esc.Escapement(esc.Geneva(slots), INERTIA, 0.0113, friction)
    for slots, friction in ((3, 0.05), (4, 0.35), (6, 0.3), (7, 0.3))
}


@pytest.mark.parametrize("slots", DRIVES)
def test_whole_turns_are_whole_engagements(slots):
    """However a turn is rounded: the time of a turn is that of its last engagement."""
    timer, most = DRIVES[slots], 50
    pins = timer.mechanism.pins
    times = esc.simulate(timer, most * pins).handoff_times[pins - 1 :: pins]
    for turns in range(1, most + 1):
        run = esc.rundown(timer, turns=turns)
        assert (run.times.size, run.end_turns, run.turns[-1]) == (turns * pins, turns, turns)
        assert run.time_of(turns) == run.times[-1] == pytest.approx(times[turns - 1], rel=1e-12)
    assert np.array_equal(run.turns[pins - 1 :: pins], np.arange(1, most + 1))
    assert [run.time_of(turns) for turns in range(1, most)] == [*run.times[pins - 1 : -1 : pins]]


def test_cells_that_do_not_divide_a_turn():
    """Eleven cells of a gear-driven wheel take three turns of its carrier."""
    wheel = esc.GearDriven(stations=11, lobes=2, curve="epicycloid")
    timer = esc.Escapement(wheel, INERTIA, 0.0113)
    for turns in range(3, 150, 21):
        run = esc.rundown(timer, turns=turns)
        assert (run.times.size, run.end_turns) == (turns // 3 * 11, turns)
        assert run.time_of(turns) == run.times[-1]


def test_a_spring_that_is_spent_after_whole_turns():
    for slots, timer in DRIVES.items():
        for turns in range(1, 40, 6):
            angle = 2.0 * pi * turns
            wound = esc.TorqueCurve((0.0, angle), (timer.torque, 0.0))
            for drive in (
                replace(timer, spring_rate=timer.torque / angle),
                replace(timer, torque=wound),
            ):
                run = esc.rundown(drive)
                assert run.status.label == "spent"
                assert run.times.size == turns * DRIVES[slots].mechanism.pins
                assert run.time_of(turns) == run.times[-1]
