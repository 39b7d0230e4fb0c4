"""Springs that run down and torque curves: printed examples, two engines, limits, files.

The printed numbers come from two computations that share nothing with this package.
"""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import escapement as esc
from both_engines import agree, each_engine
from escapement.base.errors import InputFileError
from escapement.base.status import Status
from escapement.base.units import INCH_POUND
from random_drives import drives, very_few
from test_real_mechanism import TORQUE, timer

TURN = 2.0 * math.pi
WOUND = timer(spring_rate=0.02 * TORQUE / TURN)
CAM = esc.TorqueCurve([0.0, 0.5, 2.0, 2.9], [0.8, 1.0, 0.5, 0.8], periodic=True)


@each_engine
def test_printed_examples(engine):
    motion = esc.simulate(WOUND, 40, engine=engine)
    expected = {1: (0.0448624775, 85.9124488), 10: (0.423356269, 84.0330840)}
    expected[40] = (1.754465261, 77.1173932)
    for count, (time, speed) in expected.items():
        assert motion.handoff_times[count - 1] == pytest.approx(time, abs=0.51e-9)
        assert motion.handoff_velocities[count - 1] == pytest.approx(speed, abs=0.51e-7)


def test_a_load_stops_a_spring_that_still_pulls():
    loaded = timer(spring_rate=0.05 * TORQUE / TURN, load_torque=0.1 * TORQUE)
    motion = esc.simulate(loaded, 200)
    assert motion.status is Status.STALL
    assert motion.handoff_times.size == 66
    assert motion.handoff_times[-1] == pytest.approx(4.76217552, abs=0.51e-8)
    assert motion.end_time == pytest.approx(4.972434, abs=0.51e-6)
    assert "9.010 degrees from dead centre of engagement 67" in motion.message
    left = loaded.curve(motion.at(motion.end_time).theta + math.pi / 4.0) / TORQUE
    assert left == pytest.approx(0.1674986, abs=0.51e-7)


@st.composite
def curves(draw):
    """A torque that is not far from 1, with points anywhere in the first cells."""
    steps = draw(st.lists(st.floats(0.05, 3.0), min_size=1, max_size=6))
    torque = [draw(st.floats(0.7, 1.3)) for _ in range(len(steps) + 1)]
    if periodic := draw(st.booleans()):
        torque[-1] = torque[0]
    return esc.TorqueCurve(np.cumsum([0.0, *steps]), torque, periodic)


@pytest.mark.slow
@given(drives(rho=(-1.0, 1.0), most_slots=8), st.just(0.0) | st.floats(1e-6, 0.1), curves())
@very_few
def test_engines_agree_on_random_springs_and_curves(real, fall, curve):
    agree(replace(real, spring_rate=fall / real.mechanism.cell_angle), 5)
    agree(replace(real, torque=curve), 5)


@pytest.mark.parametrize("slots", [4, 5])
def test_a_spent_spring_has_given_its_energy_and_nothing_moves(slots):
    cell = esc.Geneva(slots).cell_angle
    real = timer(slots=slots, spring_rate=TORQUE / (6.4 * cell))
    motion, _ = agree(real, 100)
    assert motion.status is Status.SPENT
    assert "the spring is spent" in motion.message
    assert motion.ledger.work == pytest.approx(0.5 * TORQUE * 6.4 * cell, rel=1e-12)
    assert motion.ledger.kinetic < 1e-6 * motion.ledger.work
    # a piece begins where it is spent, in the dwell of five slots and in the slot of four
    places = motion.at(motion.trajectory.start).theta - motion.at(0.0).theta
    assert np.abs(places - 6.4 * cell).min() < 1e-9
    assert np.isfinite(motion.at(motion.t).theta_ddot).all()
    # a motion that is asked for less does not come so far
    assert esc.simulate(real, 3).status is Status.OK


def test_a_load_stops_a_driver_behind_a_spent_spring():
    real = timer(driver_bearing_torque=1e-4 * TORQUE, spring_rate=TORQUE / 9.0)
    motion, _ = agree(real, 100, rtol=1e-9)
    assert motion.status is Status.SPENT
    assert motion.at(motion.end_time).theta_dot == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("slots", [4, 5])
@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_oil_behind_a_spent_spring_stops_a_driver_in_finite_time(slots, friction):
    """It ends where both bodies have the energy of a driver at the threshold."""
    viscous = 0.1 * math.sqrt(timer().inertia.follower * TORQUE)
    cell = esc.Geneva(slots).cell_angle
    real = timer(
        slots=slots, friction=friction, driver_viscous=viscous, spring_rate=TORQUE / (3.3 * cell)
    )
    motion, slow = agree(real, 200, rtol=1e-9)
    assert motion.status is slow.status is Status.SPENT
    assert slow.end_time == pytest.approx(motion.end_time, rel=1e-9)
    end, own = motion.at(motion.end_time), real.inertia
    energy = own.driver * end.theta_dot**2 + own.follower * end.phi_dot**2
    assert energy == pytest.approx(1e-6 * own.driver * TORQUE / own.follower, rel=1e-9)
    assert abs(motion.ledger.residual) < 1e-12


def test_curves_that_say_the_same_give_the_same():
    straight = esc.TorqueCurve([0.0, TORQUE / WOUND.spring_rate], [TORQUE, 0.0])
    bent = esc.TorqueCurve(
        [0.0, 3.0, 7.5, *straight.angle[1:]], [*WOUND.curve([0.0, 3.0, 7.5]), 0.0]
    )
    expected = esc.simulate(WOUND, 30)
    for torque in (straight, bent):
        found = esc.simulate(replace(WOUND, torque=torque, spring_rate=0.0), 30)
        np.testing.assert_allclose(found.handoff_times, expected.handoff_times, rtol=1e-13)
        np.testing.assert_allclose(found.extrema.theta_dot, expected.extrema.theta_dot, rtol=1e-12)
    level = esc.TorqueCurve([0.0, 1.0, 2.5], [TORQUE] * 3, periodic=True)
    found, constant = (esc.simulate(timer(torque=torque), 30) for torque in (level, TORQUE))
    np.testing.assert_allclose(found.handoff_times, constant.handoff_times, rtol=1e-13)


def test_a_weak_spring_rate_is_no_spring_and_a_rate_of_zero_leaves_every_bit():
    none = esc.simulate(timer(), 30)
    weak = esc.simulate(timer(spring_rate=1e-13 * TORQUE), 30)
    np.testing.assert_allclose(weak.handoff_times, none.handoff_times, rtol=1e-11)
    zero = esc.simulate(timer(spring_rate=0.0), 30)
    np.testing.assert_array_equal(zero.handoff_times, none.handoff_times)
    stiff = esc.simulate(timer(spring_rate=1e8), 30)
    assert (stiff.status, stiff.handoff_times.size) == (Status.SPENT, 0)


@pytest.mark.parametrize("torque", [CAM, esc.TorqueCurve([0.0, 2.0, 3.0], [1.0, 0.2, 0.4])])
def test_without_losses_the_speed_follows_from_the_work(torque):
    wheel = esc.Geneva(5)
    real = esc.Escapement(wheel, esc.Inertia(0.3, 1.0), torque)
    motion = esc.simulate(real, 6)
    state = motion.at(motion.t)
    # work by a fine sum, apart from the curve's own integral
    grid = np.linspace(0.0, float(state.theta[-1] - state.theta[0]), 200_001)
    work = np.concatenate(
        [[0.0], np.cumsum(0.5 * np.diff(grid) * (torque(grid[1:]) + torque(grid[:-1])))]
    )
    kinetic = 0.5 * (0.3 * state.theta_dot**2 + state.phi_dot**2)
    turned = state.theta - state.theta[0]
    np.testing.assert_allclose(kinetic, np.interp(turned, grid, work), atol=1e-8)
    np.testing.assert_allclose(kinetic, real.drive_work(turned), atol=1e-11)


def test_figures_are_those_of_the_full_spring():
    full, wound = esc.terminal(timer()), esc.terminal(WOUND)
    assert (wound.period, wound.velocity_max) == (full.period, full.velocity_max)
    assert "of the full spring" in wound.message
    begins = esc.terminal(timer(torque=CAM * TORQUE))
    assert begins.period == pytest.approx(full.period / math.sqrt(0.8), rel=1e-12)
    assert "at the start of the motion" in begins.message
    (swept,) = esc.sweep(timer(), spring_rate=[0.0, 1e-4]).results["period"][None]
    np.testing.assert_array_equal(swept, full.period)


def test_a_long_run_goes_by_series_as_by_engagements():
    real = timer(spring_rate=TORQUE / (3000.0 * TURN), load_torque=0.02 * TORQUE)
    motion = esc.simulate(real, 9000)
    speeds, lengths = motion.handoff_velocities, np.diff(motion.handoff_times)
    cell = real.mechanism.cell_angle
    for k in (40, 1700, 5003, 8998):  # one engagement, begun with the torque that is left
        left = replace(real, torque=float(real.curve(k * cell)))
        one = esc.simulate(left, 1, initial_speed=speeds[k - 1])
        assert one.handoff_times[0] == pytest.approx(lengths[k - 1], rel=1e-9)
        assert one.handoff_velocities[0] == pytest.approx(speeds[k], rel=1e-12)


FILE = """
units = "in-lbf-s"
torque = { file = "spring.csv" }
friction = 0.3
[mechanism]
slots = 4
[inertia]
driver = 3e-6
follower = 50e-6
[sweep]
load_torque = [0.0, 0.01]
"""


def test_a_study_reads_a_curve_beside_it_and_keeps_its_points(command, tmp_path):
    folder = tmp_path / "deep"
    folder.mkdir()
    (folder / "spring.csv").write_text("# bench test\nangle,torque\n0,0.1\n10,0.09\n20.5,0.04\n")
    (folder / "study.toml").write_text(FILE)
    code, _, err = command("sweep", folder / "study.toml", "-o", "out.h5")
    assert code == 0, err
    (folder / "spring.csv").unlink()
    code, out, err = command("run", "--from", "out.h5", "--select", "load_torque=0", "--json")
    record = json.loads(out)
    assert code == 0, err
    curve = esc.TorqueCurve([0.0, 10.0, 20.5], np.array([0.1, 0.09, 0.04]) * INCH_POUND)
    expected = esc.simulate(timer(torque=curve))
    np.testing.assert_allclose(record["handoff_times"], expected.handoff_times, rtol=1e-12)
    assert "at the start of the motion" in record["message"]
    (tmp_path / "curve.csv").write_text("0,0.1\n10,0.09\n20.5,0.04\n")
    options = ["--driver-inertia", "3e-6", "--follower-inertia", "50e-6", "--friction", ".3"]
    options += ["--torque", "curve.csv", "--units", "in-lbf-s", "--json"]
    code, out, err = command("run", *options)
    assert code == 0, err
    found = json.loads(out)
    np.testing.assert_allclose(found["handoff_times"], expected.handoff_times, rtol=1e-12)
    assert found["inputs"]["torque_angles"] == [0.0, 10.0, 20.5]
    assert found["inputs"]["torque"]["in-lbf-s"] == pytest.approx([0.1, 0.09, 0.04])


def test_a_file_in_degrees_says_so(tmp_path):
    (tmp_path / "bad.csv").write_text("0,1\n2,-1\n")
    with pytest.raises(InputFileError, match="at least 0"):
        esc.TorqueCurve.from_csv(tmp_path / "bad.csv")
    (tmp_path / "curve.csv").write_text("angle_deg;torque\n0;2\n180;1\n")
    found = esc.TorqueCurve.from_csv(tmp_path / "curve.csv")
    assert found.angle == pytest.approx((0.0, math.pi), rel=1e-15)
    assert found.torque == (2.0, 1.0)
    assert (
        repr(found) == "TorqueCurve(points=2, angle=3.14159 rad, torque=1 to 2 N m, periodic=False)"
    )
