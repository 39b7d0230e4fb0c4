"""A motor as the drive: a straight line of torque over speed, behind a gearbox or without."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from clearance_bodies import same_as_two_bodies
from escapement import plots
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.cli import main
from escapement.dynamics.figure_table import OF_MOTOR

TABLE = esc.Geneva(6, pins=1, crank_radius=0.05)
LOOSE = esc.Geneva(4, crank_radius=0.02, clearance=4e-4)
INERTIA = esc.Inertia(0.02, 0.1)
STALL, NO_LOAD = 5.0, 9.0
MOTOR = esc.Motor(STALL, NO_LOAD)
GEARBOX = esc.Train(ratio=0.1, efficiency=0.8, inertia=1e-4)


def machine(torque=MOTOR, **numbers):
    model = {"friction": 0.08, "load_torque": 0.3, **numbers}
    return esc.Escapement(TABLE, INERTIA, torque, **model)


def geared(barrel=GEARBOX, **numbers):
    return machine(esc.Motor(0.5, 90.0), barrel=barrel, **numbers)


@pytest.mark.parametrize("engine", ["energy", "ivp", "contact"])
def test_a_motor_is_a_torque_and_viscous_drag_to_the_last_bit(engine):
    oil = 0.02
    one, other = machine(driver_viscous=oil), machine(STALL, driver_viscous=oil + STALL / NO_LOAD)
    if engine == "contact":
        one, other = (replace(it, mechanism=replace(TABLE, clearance=1e-4)) for it in (one, other))
    first, second = (esc.simulate(it, 4, engine=engine) for it in (one, other))
    np.testing.assert_array_equal(first.handoff_times, second.handoff_times)
    np.testing.assert_array_equal(first.handoff_velocities, second.handoff_velocities)
    assert first.ledger == second.ledger
    if engine == "energy":
        assert esc.terminal(one, engine=engine).period == esc.terminal(other, engine=engine).period


def test_the_torque_falls_in_a_straight_line():
    assert MOTOR.torque(0.0) == STALL
    assert MOTOR.torque(NO_LOAD) == 0.0
    assert MOTOR.torque(1.5 * NO_LOAD) == -0.5 * STALL
    motion = esc.simulate(machine(friction=0.0, load_torque=0.0), 3)
    state = motion.at(np.linspace(0.01, 0.99, 301) * motion.end_time)
    ratio = state.phi_dot / state.theta_dot
    needed = INERTIA.driver * state.theta_ddot + ratio * INERTIA.follower * state.phi_ddot
    np.testing.assert_allclose(needed, STALL * (1.0 - state.theta_dot / NO_LOAD), atol=1e-9)


def test_a_gearbox_takes_its_share_of_the_power_either_way():
    """The motor's torque less that of its rotor passes with its efficiency, or against it."""
    motion = esc.simulate(geared(), 4)
    state = motion.at(np.linspace(0.02, 0.98, 501) * motion.end_time)
    speed = state.theta_dot / GEARBOX.ratio
    rotor = GEARBOX.inertia * state.theta_ddot / GEARBOX.ratio
    power = (0.5 * (1.0 - speed / 90.0) - rotor) * speed
    taken = np.where(power > 0.0, 0.2, 1.0 / 0.8 - 1.0) * np.abs(power)
    assert power.min() < 0.0 < power.max()
    np.testing.assert_allclose(state.power_lost["barrel"], taken, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(
        state.power_lost["driver_drag"], 0.5 * speed / 90.0 * speed, rtol=1e-12
    )
    assert abs(motion.ledger.residual) < 1e-12
    turns = motion.at(motion.flow_changes.time)
    rotor = GEARBOX.inertia * turns.theta_ddot / GEARBOX.ratio
    torque = 0.5 * (1.0 - turns.theta_dot / GEARBOX.ratio / 90.0)
    inside = np.abs(motion.flow_changes.time[:, None] - motion.handoff_times).min(axis=1) > 1e-9
    assert inside.sum() >= 4
    np.testing.assert_allclose(torque[inside], rotor[inside], atol=1e-9)


@pytest.mark.parametrize(("barrel", "no_load"), [(None, 60.0), (esc.Train(0.2, 0.7, 1e-8), 30.0)])
def test_two_bodies_in_time_agree(barrel, no_load):
    """Without a gearbox the driver turns back after an impact."""
    ratio = barrel.ratio if barrel else 1.0
    drive = esc.Escapement(
        LOOSE, esc.Inertia(2e-7, 5.65e-6), esc.Motor(0.0113 * ratio, no_load / ratio),
        friction=0.1, restitution=0.5, barrel=barrel,
    )  # fmt: skip
    motion = same_as_two_bodies(drive, 2, 60.0)
    if barrel is None:
        assert motion.at(np.linspace(0.0, motion.end_time, 9001)).theta_dot.min() < 0.0


@pytest.mark.parametrize("drive", [machine(), geared()], ids=["direct", "geared"])
def test_the_effective_torque_balances_the_power(drive):
    """What the motor gives in a cycle is what load and losses take; rms and mean give it."""
    cycle = esc.terminal(drive)
    ratio = drive.barrel.ratio if drive.barrel else 1.0
    stall, no_load = drive.torque, drive.no_load_speed
    mean = cycle.velocity_mean / ratio / no_load
    square = (cycle.motor_torque_rms / stall) ** 2 - 1.0 + 2.0 * mean
    power = stall * no_load * (mean - square)
    ledger = cycle.motion.ledger
    taken = (ledger.load + ledger.friction + ledger.barrel) / cycle.period
    assert power == pytest.approx(taken, rel=1e-9)
    slowest = cycle.velocity_min / ratio
    assert cycle.motor_torque_max == pytest.approx(stall * (1.0 - slowest / no_load), rel=1e-12)
    assert cycle.motor_stall_share == pytest.approx(cycle.motor_torque_max / stall, rel=1e-12)
    assert cycle.speed_dip == pytest.approx(1.0 - cycle.velocity_min / cycle.velocity_max)
    other = esc.terminal(drive, engine="ivp")
    for name in OF_MOTOR:
        assert getattr(other, name) == pytest.approx(getattr(cycle, name), rel=1e-8)


def test_without_a_motor_there_are_no_figures_of_one():
    found = esc.terminal(machine(5.0, driver_viscous=0.5))
    assert all(math.isnan(getattr(found, name)) for name in OF_MOTOR)


def test_a_study_varies_both_numbers_and_keeps_figures_of_the_motor():
    stalls, speeds, ratios = [0.4, 0.5], [80.0, 90.0], [0.1, 0.2]
    names = ["period", *OF_MOTOR]
    study = esc.sweep(
        geared(), torque=stalls, no_load_speed=speeds, barrel_ratio=ratios, results=names
    )
    for i, j, k in np.ndindex(2, 2, 2):
        motor = esc.Motor(stalls[i], speeds[j])
        one = esc.terminal(machine(motor, barrel=replace(GEARBOX, ratio=ratios[k])))
        for name in names:
            assert study[name][i, j, k] == pytest.approx(getattr(one, name), rel=1e-11)


def test_equal_scenes_of_a_study_keep_their_own_torque_of_the_motor():
    """Two of these gearboxes and motors give the driver the same torque at the same speed."""
    drive = machine(esc.Motor(0.5, 90.0), barrel=esc.Train(0.1))
    found = esc.sweep(
        drive, torque=[0.5, 1.0], no_load_speed=[90.0, 45.0], barrel_ratio=[0.1, 0.2],
        results=["period", "motor_torque_max"],
    )  # fmt: skip
    one, other = (0, 0, 0), (1, 1, 1)
    assert found["period"][other] == pytest.approx(found["period"][one], rel=1e-12)
    torque = found["motor_torque_max"]
    assert torque[other] == pytest.approx(2.0 * torque[one], rel=1e-12)


def test_sensitivities_and_budgets_know_the_motor():
    drive = machine()
    found = esc.sensitivities(drive)
    step = 1e-5
    ends = [
        esc.terminal(replace(drive, torque=STALL, no_load_speed=NO_LOAD * (1.0 + sign * step)))
        for sign in (1.0, -1.0)
    ]
    slope = math.log(ends[0].period / ends[1].period) / (2.0 * step)
    assert found.relative["period"]["no_load_speed"] == pytest.approx(slope, rel=1e-7)
    assert found.relative["motor_torque_rms"]["torque"] > 0.0
    tolerances = {name: {"tolerance": 0.1} for name in ("torque", "no_load_speed")}
    budget = esc.budget(drive, tolerances, figures=["period"])
    assert {*budget.spreads} == {*tolerances}
    assert budget.figures["period"].worst.high > budget.figures["period"].worst.low


def test_the_command_line_and_files_take_a_motor(capsys, tmp_path):
    words = "run --slots 6 --pins 1 --crank-radius .05 --friction .08 --load-torque .3 --torque .5"
    words += " --driver-inertia .02 --follower-inertia .1 --barrel-ratio .1 --barrel-inertia 1e-4"
    words = [*words.split(), "--barrel-efficiency", ".8", "--no-load-speed", "90 rad/s", "--json"]
    assert main(words) == 0
    found, cycle = json.loads(capsys.readouterr().out), esc.terminal(geared())
    assert found["inputs"]["no_load_speed"] == 90.0
    assert found["motor_torque_rms"] == pytest.approx(cycle.motor_torque_rms, rel=1e-12)
    study = tmp_path / "study.toml"
    study.write_text(
        "torque = 0.5\nload_torque = 0.3\nfriction = 0.08\n[mechanism]\nslots = 6\npins = 1\n"
        "[inertia]\ndriver = 0.02\nfollower = 0.1\n[barrel]\nratio = 0.1\nefficiency = 0.8\n"
        'inertia = 1e-4\n[sweep]\nno_load_speed = ["90 rad/s"]\n'
    )
    assert main(["sweep", str(study), "-o", str(tmp_path / "a.h5"), "--quiet"]) == 0
    stored = esc.read_study(tmp_path / "a.h5")
    assert float(stored["period"][0]) == pytest.approx(cycle.period, rel=1e-12)
    motion = esc.simulate(geared(), 3)
    esc.write_motion(motion, tmp_path / "m.h5")
    assert esc.read_motion(tmp_path / "m.h5").escapement == motion.escapement


MODEL = (
    "--slots 6 --pins 1 --crank-radius .05 --friction .08 --load-torque .3 --follower-inertia .1 "
    "--driver-inertia .02 --barrel-ratio .1 --barrel-inertia 1e-4 --barrel-efficiency .8 --json"
)


@pytest.mark.parametrize(("units", "motor"), [("SI", "0.5,90"), ("mm", "500,90 rad/s")])
def test_two_numbers_of_a_motor_are_one_option(capsys, units, motor):
    given = {"--load-torque": "300", "--crank-radius": "50", "--follower-inertia": "1e5"}
    given |= {"--driver-inertia": "2e4", "--barrel-inertia": "100"}
    words = MODEL.split()
    for name, value in given.items() if units == "mm" else ():
        words[words.index(name) + 1] = value
    assert main(["run", *words, "--units", units, "--motor", motor]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["period"] == pytest.approx(esc.terminal(geared()).period, rel=1e-12)
    assert "motor" not in found["inputs"]


def test_an_index_with_a_motor_is_an_escapement(capsys):
    """Its figures beside those at constant speed; the efficiency is that of the gearbox."""
    table = esc.index(TABLE, 6.0, 0.3, follower_inertia=0.1, friction=0.08)
    motor = esc.Motor(0.5, 90.0)
    assert table.driven_by(motor, driver_inertia=0.02, gearbox=GEARBOX) == geared()
    lossy = replace(table, efficiency=0.8)
    gears = replace(GEARBOX, efficiency=1.0)
    assert lossy.driven_by(motor, driver_inertia=0.02, gearbox=gears) == geared()
    assert table.driven_by(MOTOR, driver_inertia=0.02) == machine()
    assert main(["index", *MODEL.split(), "--speed", "6", "--motor", "0.5,90 rad/s"]) == 0
    found, cycle = json.loads(capsys.readouterr().out), esc.terminal(geared())
    for name in ("velocity_mean", *OF_MOTOR):
        assert found[name] == pytest.approx(getattr(cycle, name), rel=1e-12)
    assert found["torque_max"] == pytest.approx(table.torque_max, rel=1e-12)
    assert found["inputs"]["motor_no_load_speed"] == 90.0
    speed, torque = plots.plot_index(table, motor=esc.simulate(geared(), 2)).axes[-2:]
    share = speed.get_lines()[1].get_ydata() / 90.0
    size = 1e3 if "mN" in torque.get_ylabel() else 1.0
    np.testing.assert_allclose(torque.get_lines()[1].get_ydata(), 0.5 * size * (1.0 - share))


@pytest.mark.parametrize(
    ("command", "typed", "said"),
    [
        ("run", "--torque .5 --motor .5,90", "--torque must not come with --motor, got 0.5; leave"),
        ("run", "--motor .5", "--motor must be stall torque and no-load speed, with a comma betw"),
        ("run", "--motor 0,90", "--motor, stall torque, must be greater than 0, got 0.0; give th"),
        ("index", "--speed 6 --motor .001,90", "--motor must carry the load and all losses, got 0"),
        ("index", "--speed 6", "--driver-inertia must come with --motor STALL,NO-LOAD, got none; "),
    ],
)
def test_a_motor_that_cannot_be_is_refused_in_one_line(capsys, tmp_path, command, typed, said):
    out = tmp_path / "a.csv"
    words = [command, *MODEL.split(), *typed.split(), "-o", str(out)]
    assert main(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"escapement: error: {said}")
    assert not out.exists()


def test_a_motor_that_stalls_says_what_it_gives():
    for found in (esc.terminal(machine(load_torque=40.0)), esc.simulate(machine(load_torque=40.0))):
        assert found.status is Status.STALL
        assert found.message.endswith(
            "the drive cannot carry the load and losses; at rest the motor gives the driver 5 N m, "
            "which is its most"
        )


def test_what_cannot_be_is_refused_in_one_line():
    with pytest.raises(InvalidValue, match=r"^stall_torque must be .*, got 0"):
        esc.Motor(0.0, 1.0)
    with pytest.raises(InvalidValue, match=r"^no_load_speed must be .*, got -1"):
        esc.Motor(1.0, -1.0)
    with pytest.raises(InvalidValue, match=r"^no_load_speed must be left out with a Motor, whose"):
        machine(no_load_speed=5.0)
    with pytest.raises(InvalidValue, match=r"^no_load_speed must be left out with a spring rate"):
        machine(spring_rate=0.1)
    curve = esc.TorqueCurve([0.0, 1.0], [1.0, 2.0])
    with pytest.raises(InvalidValue, match=r"^no_load_speed must be left out with a torque curve"):
        machine(curve, no_load_speed=5.0)
    table = esc.index(TABLE, 6.0, 0.3, follower_inertia=0.1, efficiency=0.8)
    with pytest.raises(InvalidValue, match=r"^gearbox efficiency must be 1 with an efficiency of"):
        table.driven_by(MOTOR, driver_inertia=0.02, gearbox=GEARBOX)
    with pytest.raises(InvalidValue, match=r"^motor must be a Motor, got 5.0"):
        table.driven_by(5.0, driver_inertia=0.02)
    with pytest.raises(InvalidValue, match=r"^turns must be given, as turns or as duration"):
        esc.rundown(machine())
    with pytest.raises(InvalidValue, match=r"^motion must be of an escapement with a motor, got"):
        plots.plot_motor(esc.simulate(machine(5.0), 1))


def test_the_figure_has_speed_and_torque_of_the_motor():
    drive = geared()
    motion = esc.simulate(drive, 2)
    above, below = plots.plot_motor(motion, esc.terminal(drive)).axes
    curves = [ax.get_lines()[1].get_ydata() for ax in (above, below)]
    assert curves[0][0] == 0.0
    assert curves[1][0] == pytest.approx(0.5 * (1e3 if "mN" in below.get_ylabel() else 1.0))
    line = curves[1] / curves[1][0] + curves[0] / 90.0
    np.testing.assert_allclose(line, 1.0, rtol=1e-12)


def test_a_gearbox_without_losses_is_a_change_of_numbers():
    mine = geared(esc.Train(0.1, inertia=1e-4))
    by_hand = machine(5.0, driver_viscous=5.0 / 9.0)
    by_hand = replace(by_hand, inertia=esc.Inertia(0.02 + 0.01, 0.1))
    for engine in ("energy", "ivp"):
        times = [esc.simulate(one, 4, engine=engine).handoff_times for one in (mine, by_hand)]
        np.testing.assert_allclose(*times, rtol=1e-12)
    alone = mine.without_trains
    assert (alone.torque, alone.no_load_speed, alone.driver_viscous) == (5.0, 9.0, 0.0)


def test_engines_agree_behind_a_gearbox_with_losses():
    rng = np.random.default_rng(44)
    for _ in range(6):
        gearbox = esc.Train(0.1, rng.uniform(0.5, 1.0), 10.0 ** rng.uniform(-5.0, -3.0))
        drive = geared(gearbox, driver_viscous=rng.choice([0.0, 0.1]))
        fast, slow = (esc.simulate(drive, 3, engine=name) for name in ("energy", "ivp"))
        np.testing.assert_allclose(fast.handoff_times, slow.handoff_times, rtol=1e-9)
        np.testing.assert_allclose(fast.handoff_velocities, slow.handoff_velocities, rtol=1e-9)
        assert abs(fast.ledger.residual) < 1e-12


def test_compliant_walls_tend_to_rigid_ones():
    barrel = esc.Train(0.2, 0.7, 4e-8)
    drive = esc.Escapement(
        LOOSE, esc.Inertia(2e-6, 5.65e-6), esc.Motor(0.0113 * 0.2, 150.0), friction=0.1,
        barrel=barrel,
    )  # fmt: skip
    hard = esc.simulate(replace(drive, stiffness=1e8, damping=4e3), 3)
    rigid = esc.simulate(drive, 3)
    np.testing.assert_allclose(hard.handoff_times, rigid.handoff_times, rtol=1e-4)
    assert abs(hard.ledger.residual) < 1e-8
