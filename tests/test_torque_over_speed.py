"""A torque over the speed, and over angle and speed: two engines, motors, cycles, files, limits."""

import json
import math
from dataclasses import replace

import h5py
import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InputFileError, InvalidValue
from escapement.base.status import Status
from escapement.dynamics.figure_table import OF_MOTOR
from escapement.dynamics.needs import FIXED, Kind, kind_of

TORQUE, INERTIA = 0.0113, esc.Inertia(3.39e-7, 5.65e-6)
TIMER = esc.Escapement(esc.Geneva(4), INERTIA, TORQUE, friction=0.3)
FALLING = esc.TorqueCurve(speed=[0, 50, 100, 200], torque=TORQUE * np.array([1, 0.9, 0.6, 0.0]))
TURN = np.array([0.0, 1.2, 4.0, 2.0 * math.pi])
"""Driver angles of a curve that repeats in a turn."""


def every_turn(*shares):
    """A torque over angle and speed that repeats in a turn."""
    rows = np.outer(shares, TORQUE * np.array([1.0, 0.9, 0.6, 0.1]))
    return esc.TorqueCurve(TURN, rows, periodic=True, speed=[0.0, 50.0, 100.0, 200.0])


@pytest.mark.parametrize(
    "other", [{}, {"load_torque": 0.001, "driver_viscous": 1e-6}, {"barrel": 3.0}]
)
def test_a_motor_as_a_table_is_the_motor_as_a_line(other):
    ratio = other.get("barrel", 1.0)
    if "barrel" in other:
        other = {"barrel": esc.Train(ratio, efficiency=0.9, inertia=1e-6)}
    stall, top = TORQUE * ratio, 200.0 / ratio
    x = np.array([0.0, 0.2, 0.5, 0.6, 1.0])
    table = esc.TorqueCurve(speed=top * x, torque=stall * (1.0 - x))
    line, curve = (replace(TIMER, torque=x, **other) for x in (esc.Motor(stall, top), table))
    for engine in ("energy", "ivp"):
        one, two = (esc.simulate(timer, 4, engine=engine) for timer in (line, curve))
        np.testing.assert_allclose(two.handoff_times, one.handoff_times, rtol=1e-12)
        np.testing.assert_allclose(two.handoff_velocities, one.handoff_velocities, rtol=1e-12)
        np.testing.assert_allclose(two.at(0.01).theta_ddot, one.at(0.01).theta_ddot, rtol=1e-9)
        for name in ("work", "kinetic", "friction", "driver_drag", "barrel"):
            value = getattr(one.ledger, name)
            assert getattr(two.ledger, name) == pytest.approx(value, rel=1e-10, abs=1e-17), name
    one, two = esc.terminal(line), esc.terminal(curve)
    names = ("period", "velocity_max", "velocity_min", "handoff_velocity", "rise_time", *OF_MOTOR)
    for name in names:
        assert getattr(two, name) == pytest.approx(getattr(one, name), rel=1e-12), name


def test_the_greatest_torque_of_a_motor_may_lie_above_that_at_rest():
    """As of an induction motor; over angle and speed there is no motor, and the message says so."""
    speed = np.linspace(0.0, 200.0, 21)
    torque = TORQUE * (1.0 + 2.0 * speed / 200.0 - 3.0 * (speed / 200.0) ** 2)
    curve = esc.TorqueCurve(speed=speed, torque=torque)
    found = esc.terminal(replace(TIMER, torque=curve))
    low, high = found.velocity_min, found.velocity_max
    greatest = max(float(curve(0.0, x)) for x in (low, high, np.clip(200.0 / 3.0, low, high)))
    assert found.motor_torque_max == pytest.approx(greatest, rel=1e-12)
    assert found.motor_stall_share == pytest.approx(greatest / TORQUE, rel=1e-12)
    found = esc.terminal(replace(TIMER, torque=every_turn(1.0, 0.9, 1.0, 1.0)))
    assert math.isnan(found.motor_torque_max)
    assert "speed alone" in found.message


def test_the_motion_obeys_the_torque_that_the_curve_tells():
    """Without friction the inertias take the whole torque: I_d theta_ddot + I_f g phi_ddot."""
    curve = every_turn(1.0, 0.6, 0.9, 1.0)
    curve = replace(curve, speed=[4.0 * x for x in curve.speed])
    motion = esc.simulate(replace(TIMER, friction=0.0, torque=curve), 2)
    assert motion.status is Status.OK
    t = np.linspace(0.001, motion.end_time, 200)
    state = motion.at(t)
    taken = INERTIA.driver * state.theta_ddot
    taken += INERTIA.follower * state.phi_dot / state.theta_dot * state.phi_ddot
    turned = state.theta - motion.at(0.0).theta
    told = curve(turned, state.theta_dot)
    assert np.ptp(told) > 0.2 * TORQUE
    np.testing.assert_allclose(taken, told, rtol=1e-9, atol=1e-9 * TORQUE)


@pytest.mark.parametrize(
    ("torque", "cells", "engine"),
    [
        (
            esc.TorqueCurve(TURN, TORQUE * np.array([1.0, 0.6, 0.9, 1.0]), periodic=True),
            4,
            "energy",
        ),
        (every_turn(1.0, 0.6, 0.9, 1.0), 4, "energy"),
        (every_turn(1.0, 0.6, 0.9, 1.0), 4, "ivp"),
        (
            esc.TorqueCurve([0, 1, 0.75 * math.pi], [TORQUE, 0.5 * TORQUE, TORQUE], True),
            3,
            "energy",
        ),
    ],
)
def test_a_torque_that_repeats_has_a_cycle_over_whole_rounds(torque, cells, engine):
    timer = replace(TIMER, torque=torque, load_torque=0.02 * TORQUE)
    found = esc.terminal(timer, engine=engine)
    assert found.status is Status.OK
    note = "figures of a motor need a torque over the speed alone"
    assert found.message == (note if torque.speed else "done")
    motion = esc.simulate(timer, 12 * cells)
    times, speeds = motion.handoff_times, motion.extrema.theta_dot[-6 * cells :]
    assert found.period == pytest.approx((times[-1] - times[-1 - cells]) / cells, rel=1e-10)
    assert found.handoff_velocity == pytest.approx(motion.handoff_velocities[-1], rel=1e-9)
    assert found.velocity_max == pytest.approx(speeds.max(), rel=1e-9)
    assert found.velocity_min == pytest.approx(speeds.min(), rel=1e-9)
    assert found.motion.handoff_times.size == cells
    assert abs(found.energy_residual) <= 1e-11


def test_a_torque_that_never_repeats_in_whole_cells_has_that_of_its_start():
    curve = esc.TorqueCurve([0.0, 1.0, 3.0], [TORQUE, 0.5 * TORQUE, TORQUE], periodic=True)
    found = esc.terminal(replace(TIMER, torque=curve))
    assert found.period == pytest.approx(esc.terminal(TIMER).period, rel=1e-12)
    assert "at the start of the motion" in found.message
    rows = np.outer([1.0, 0.5], FALLING.torque)
    once = replace(TIMER, torque=esc.TorqueCurve([0.0, 9.0], rows, speed=FALLING.speed))
    falling = esc.terminal(replace(TIMER, torque=FALLING))
    assert esc.terminal(once).period == pytest.approx(falling.period, rel=1e-12)


@pytest.mark.parametrize("engine", ["energy", "ivp"])
def test_a_motion_that_leaves_the_table_says_so(engine):
    timer = replace(TIMER, torque=esc.TorqueCurve(speed=[0, 50, 100], torque=[0.0113, 0.01, 0.009]))
    for found in (esc.simulate(timer, 9, engine=engine), esc.terminal(timer, engine=engine)):
        assert found.status is Status.INVALID
        assert "the torque curve ends at 100 rad/s" in found.message
        assert "\n" not in found.message
    assert math.isnan(found.period)
    assert esc.simulate(timer, 1, engine=engine, initial_speed=101.0).status is Status.INVALID
    heavy = replace(timer, load_torque=0.02)
    for found in (esc.simulate(heavy, 9, engine=engine), esc.terminal(heavy, engine=engine)):
        assert found.status is Status.STALL


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"speed": [0, 1], "torque": [1, 2, 3]}, "a torque for each speed, got 2 speeds and 3"),
        ({"speed": [1, 2], "torque": [1, 2]}, "speed of the torque curve must be ascending from 0"),
        ({"angle": [0, 1], "speed": [0, 1], "torque": [1, 2]}, "for each speed at each angle"),
        ({"speed": [0, 1], "torque": [0, 1]}, "at rest must be at least 0, not all 0"),
        ({"speed": [0, 1], "torque": [1, 0], "periodic": True}, "the same at both ends"),
        ({"speed": 3, "torque": 1}, "2 to 1000 speeds, got 1"),
        ({}, "2 to 1000 angles, got 0"),
    ],
)
def test_a_curve_that_breaks_a_rule_is_refused(given, message):
    with pytest.raises(InvalidValue, match=message):
        esc.TorqueCurve(**given)


def test_what_no_engine_computes_is_refused():
    with pytest.raises(InvalidValue, match="engines energy and ivp have a torque over the speed"):
        replace(TIMER, torque=FALLING, mechanism=esc.Geneva(4, crank_radius=0.01, clearance=1e-5))
    lossy = esc.Train(3.0, efficiency=0.9)
    with pytest.raises(InvalidValue, match="must be 1 with a torque over angle and speed"):
        replace(TIMER, torque=every_turn(1.0, 0.6, 0.9, 1.0), barrel=lossy)


def test_files_and_tables_give_the_same_curve(tmp_path):
    (tmp_path / "motor.csv").write_text("speed rpm,torque\n0,2\n600,1.5\n1200,0\n")
    found = esc.TorqueCurve.from_csv(tmp_path / "motor.csv")
    assert found.angle == ()
    assert found.speed == pytest.approx(np.array([0.0, 20.0, 40.0]) * math.pi)
    assert found.torque == (2.0, 1.5, 0.0)
    rows = [f"{angle};{speed};{angle + 1 - speed}\n" for speed in (0, 1) for angle in (0, 180)]
    (tmp_path / "both.csv").write_text("angle deg;speed;torque\n" + "".join(rows))
    found = esc.TorqueCurve.from_csv(tmp_path / "both.csv")
    assert found.angle == pytest.approx((0.0, math.pi))
    assert found.torque == ((1.0, 0.0), (181.0, 180.0))
    assert esc.TorqueCurve.from_table(found.as_table()) == found
    (tmp_path / "both.csv").write_text("angle deg;speed;torque\n" + "".join(rows[:3]))
    with pytest.raises(InputFileError, match="each pair once, got 3 rows for 2 angles and 2"):
        esc.TorqueCurve.from_csv(tmp_path / "both.csv")
    (tmp_path / "both.csv").write_text("torque;speed\n1;0\n2;3\n")
    with pytest.raises(InputFileError, match="put them in this order"):
        esc.TorqueCurve.from_csv(tmp_path / "both.csv")


def test_commands_and_studies_take_a_table(command, tmp_path):
    (tmp_path / "motor.csv").write_text(
        "speed,torque\n"
        + "".join(f"{x},{y}\n" for x, y in zip(FALLING.speed, FALLING.torque, strict=True))
    )
    options = ["--driver-inertia", "3.39e-7", "--follower-inertia", "5.65e-6", "--friction", ".3"]
    code, out, err = command("run", *options, "--torque", "motor.csv", "--json")
    assert code == 0, err
    record, expected = json.loads(out), esc.terminal(replace(TIMER, torque=FALLING))
    assert record["period"] == pytest.approx(expected.period, rel=1e-12)
    assert record["inputs"]["torque_speeds"] == [0.0, 50.0, 100.0, 200.0]
    (tmp_path / "study.toml").write_text(
        'torque = { file = "motor.csv" }\nfriction = 0.3\n[mechanism]\nslots = 4\n'
        "[inertia]\ndriver = 3.39e-7\nfollower = 5.65e-6\n[sweep]\nload_torque = [0.0, 0.0005]\n"
    )
    code, _, err = command("sweep", "study.toml", "-o", "out.h5")
    assert code == 0, err
    loaded = esc.terminal(replace(TIMER, torque=FALLING, load_torque=0.0005))
    found = [expected.period, loaded.period]
    with h5py.File(tmp_path / "out.h5") as file:
        np.testing.assert_allclose(file["period"], found, rtol=1e-12)


def test_sensitivities_scale_the_whole_table():
    timer = replace(TIMER, torque=FALLING)
    found = esc.sensitivities(timer).relative["period"]["torque"]
    near = [esc.terminal(replace(timer, torque=FALLING * (1.0 + x))).period for x in (-1e-4, 1e-4)]
    assert found == pytest.approx(math.log(near[1] / near[0]) / 2e-4, rel=1e-6)


def test_only_a_torque_over_the_speed_needs_its_kernels():
    """Scenes without one are of the kinds that they were, and a motor's line needs no table."""
    others = {"torque": esc.Motor(0.02, 300.0)}, {"spring_rate": 1e-4}, {"follower_viscous": 1e-6}

    def kind(timer):
        return kind_of(timer.scene.torque, timer.scene[FIXED:])

    assert kind(TIMER) == Kind.STEADY
    assert {kind(replace(TIMER, **other)) for other in others} == {Kind.WHOLE}
    assert kind(replace(TIMER, torque=FALLING)) == Kind.SPEED


def random_timer(seed):
    """A timer under a random smooth table over speeds that it reaches, or over angles too."""
    rng = np.random.default_rng(seed)
    wheel, friction = esc.Geneva(int(rng.choice([3, 4, 5, 6]))), rng.uniform(0.1, 0.25)
    inertia = esc.Inertia(3.39e-7 * rng.uniform(0.5, 2.0), 5.65e-6 * rng.uniform(0.3, 1.0))
    stall = TORQUE * rng.uniform(0.5, 2.0)
    timer = esc.Escapement(wheel, inertia, stall, friction=friction)
    if rng.random() < 0.4:
        timer = replace(timer, load_torque=0.05 * stall)
    if rng.random() < 0.3:
        timer = replace(timer, follower_viscous=0.01 * math.sqrt(stall * inertia.follower))
    fastest = esc.simulate(timer, 6).extrema.theta_dot.max()
    x = np.linspace(0.0, 1.0, int(rng.integers(4, 12)))

    def shares():
        bent = rng.uniform(-0.3, 0.3) * np.sin(math.pi * rng.uniform(0.5, 1.5) * x)
        return 1.0 - 0.9 * x + bent

    speed = 1.2 * fastest * x
    if seed % 2:
        return replace(timer, torque=esc.TorqueCurve(speed=speed, torque=stall * shares()))
    angle = np.cumsum([0.0, *rng.uniform(0.2, 1.5, 3)])
    rows = stall * np.array([rng.uniform(0.6, 1.0) * shares() for _ in angle])
    rows[-1] = rows[0]
    return replace(timer, torque=esc.TorqueCurve(angle, rows, bool(seed % 4), speed))


def agree(timer, count=6):
    engines = "energy", "ivp"
    fast, slow = (esc.simulate(timer, count, engine=name, rtol=1e-12) for name in engines)
    assert fast.status is slow.status is Status.OK
    np.testing.assert_allclose(fast.handoff_times, slow.handoff_times, rtol=1e-9)
    np.testing.assert_allclose(fast.handoff_velocities, slow.handoff_velocities, rtol=1e-9)
    np.testing.assert_allclose(fast.extrema.theta_dot, slow.extrema.theta_dot, rtol=1e-9)
    assert abs(fast.ledger.residual) <= 1e-12
    assert abs(slow.ledger.residual) <= 1e-11


@pytest.mark.parametrize("seed", range(4))
def test_engines_agree_on_random_tables(seed):
    agree(random_timer(seed))
