"""A load that changes with the follower's angle: a curve over a step or a turn, or a weight."""

import itertools
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import escapement as esc
from clearance_bodies import between_elastic_walls, same_as_two_bodies
from escapement.base.errors import InputFileError, InvalidValue
from escapement.base.status import Status
from escapement.cli import main
from escapement.dynamics.painleve import friction_limits

SIX = esc.Geneva(6, pins=1, crank_radius=0.05)
INERTIA = esc.Inertia(0.02, 0.1)
STEP = math.pi / 3.0
CAM = esc.LoadCurve(
    np.array([-0.5, -0.3, -0.1, 0.2, 0.4, 0.5]) * STEP, [0.1, 0.5, -0.3, 0.2, 0.8, 0.1]
)
WEIGHT = esc.Unbalance(0.4, 0.3)


def drive(load, mechanism=SIX, **numbers):
    model = {"torque": 3.0, "friction": 0.1, "load_torque": 0.3, **numbers}
    return esc.Escapement(mechanism, INERTIA, load_curve=load, **model)


def random_load(rng, step, steps=1):
    """A curve with points anywhere, at most half of the torque."""
    inner = np.sort(rng.uniform(-0.5, 0.5, rng.integers(1, 9)))
    angle = np.concatenate([[-0.5], inner, [0.5]]) * step * steps
    torque = rng.uniform(-1.5, 1.5, angle.size)
    torque[-1] = torque[0]
    return esc.LoadCurve(angle + rng.uniform(-3.0, 3.0), torque)


def loose_drive(rng, **more):
    """With clearance, and a load that can throw the follower from wall to wall."""
    slots, inside, radius, torque = int(rng.choice([3, 4, 5, 6, 8])), rng.random() < 0.3, 0.01, 0.01
    one = inside or rng.random() < 0.4
    wheel = esc.Geneva(
        slots, 1 if one else None, inside, radius,
        pin_radius=rng.choice([0.0, rng.uniform(0.02, 0.1) * radius]),
        clearance=2.0 * radius * 10.0 ** rng.uniform(-4.5, -2.0),
    )  # fmt: skip
    model = {"load_torque": 0.1 * torque} if rng.random() < 0.5 else {}
    model |= {"driver_bearing_torque": 0.05 * torque} if rng.random() < 0.3 else {}
    model |= {"restitution": 0.3} if rng.random() < 0.2 else {}
    if rng.random() < 0.3:
        model["load_train"] = esc.Train(2.0, efficiency=0.8, inertia=2.5e-7)
    load = esc.Unbalance(rng.uniform(0.05, 0.8) * torque, rng.uniform(-3.0, 3.0))
    if rng.random() < 0.7:
        steps = slots if rng.random() < 0.5 else 1
        load = random_load(rng, 2.0 * math.pi / slots, steps) * (0.4 * torque)
    inertia = esc.Inertia(5e-6 * 10.0 ** rng.uniform(-1.5, 0.5), 5e-6)
    limit = friction_limits(esc.Escapement(wheel, inertia, torque, **model))[0]
    friction = rng.random() * 0.7 * min(limit, 1.0)
    return esc.Escapement(wheel, inertia, torque, friction, load_curve=load, **model | more)


def agrees_with_two_bodies(one):
    """Whether it moves to its end as two bodies in time do, which know no transmission."""
    start = 0.5 / one.time_unit
    motion = esc.simulate(one, 3, initial_speed=start)
    assert abs(motion.ledger.residual) < 1e-12
    if motion.status is not Status.OK:
        return False
    same_as_two_bodies(one, 3, start)
    return True


@pytest.mark.parametrize("seed", [1, 2])
def test_two_bodies_with_clearance_agree(seed):
    assert agrees_with_two_bodies(loose_drive(np.random.default_rng(seed)))


@pytest.mark.parametrize("load", [CAM, WEIGHT], ids=["curve", "weight"])
def test_an_integrator_of_its_own_agrees_between_elastic_walls(load):
    loose = esc.Geneva(6, crank_radius=0.05, clearance=1e-4)
    unit = 3.0 / 0.05**2
    one = drive(load, loose, load_torque=0.0, stiffness=2e3 * unit, slip_speed=1e-3)
    end = 0.9 * float(esc.simulate(one, 1).handoff_times[0])
    state = esc.simulate(one, duration=end, rtol=1e-12).at(end)
    found = [state.theta, state.phi, state.theta_dot, state.phi_dot]
    assert np.array(found) == pytest.approx(between_elastic_walls(one, end), rel=1e-8)


@pytest.mark.parametrize("more", [{}, {"stiffness": 1e8}], ids=["rigid", "elastic"])
@pytest.mark.parametrize("load", [CAM, WEIGHT], ids=["curve", "weight"])
def test_clearance_has_a_cycle_over_all_that_repeats(load, more):
    loose = esc.Geneva(6, pins=1, crank_radius=0.05, clearance=1e-4)
    one = drive(load, loose, **more)
    cycle = esc.terminal(one)
    count = 1 if load is CAM else 6
    assert (cycle.status, len(cycle.beats)) == (Status.OK, count)
    assert abs(cycle.energy_residual) < 1e-10
    motion = esc.simulate(one, 60)
    beats = np.diff(motion.handoff_times)[-count:]
    np.testing.assert_allclose(beats, cycle.beats, rtol=1e-7)
    assert abs(motion.ledger.residual) < 1e-10


def test_a_heavy_weight_swings_the_follower_back_in_its_slot():
    """In flight it is a pendulum: its energy is that of a weight on a lever."""
    loose = esc.Geneva(6, pins=1, crank_radius=0.05, clearance=2e-3)
    weight = esc.Unbalance(1.5, 2.0)
    motion = esc.simulate(drive(weight, loose, load_torque=0.0, restitution=0.5), 6)
    flights = np.flatnonzero(motion.trajectory.sign == 0.0)
    begins = np.append(motion.trajectory.start, motion.end_time)
    times = begins[flights, None] + np.diff(begins)[flights, None] * np.linspace(0.0, 1.0, 7)
    state = motion.within(flights[:, None], times)
    lifted = 0.5 * 0.1 * state.phi_dot**2 - 1.5 * np.cos(state.phi + 2.0)
    assert (np.ptp(state.phi, axis=1) > 1e-3).sum() > 5
    np.testing.assert_allclose(lifted, lifted[:, :1] + 0.0 * times, atol=1e-12)
    assert abs(motion.ledger.residual) < 1e-13


@pytest.mark.parametrize("engine", ["energy", "ivp"])
def test_a_weight_without_friction_has_a_closed_form(engine):
    """Twice the kinetic energy is that of the drive less m g e (cos - cos)."""
    motion = esc.simulate(drive(WEIGHT, friction=0.0, load_torque=0.0), 9, engine=engine)
    state = motion.at(np.linspace(0.03, 1.0, 200) * motion.end_time)
    begin = float(SIX.follower_angle(SIX.breaks[0]))
    lifted = 0.4 * (math.cos(begin + 0.3) - np.cos(state.phi + 0.3))
    energy = 3.0 * (state.theta - SIX.breaks[0]) - lifted
    kinetic = 0.5 * (INERTIA.driver * state.theta_dot**2 + INERTIA.follower * state.phi_dot**2)
    np.testing.assert_allclose(kinetic, energy, rtol=1e-9)
    assert abs(motion.ledger.residual) < 1e-10


def test_the_equation_of_motion_with_friction_by_an_integrator_of_its_own():
    """solve_ivp of the law of theory.md with the load written out, over the first engagement."""
    one = drive(CAM)

    def rates(_t, y):
        theta, speed = y
        found = SIX.transmission(theta)
        g, u, dg = float(found.g), float(found.u), float(found.dg)
        load = 0.3 + float(CAM(SIX.follower_angle(theta)))
        resist = INERTIA.follower * dg * speed**2 + load
        side = np.sign(INERTIA.driver * resist + INERTIA.follower * g * 3.0)
        p = g + side * 0.1 * abs(u)
        return speed, (3.0 - p * resist) / (INERTIA.driver + INERTIA.follower * g * p)

    entry, exit_ = SIX.breaks[0], SIX.breaks[-1]

    def leaves(_t, y):
        return y[0] - exit_

    leaves.terminal = True
    found = solve_ivp(
        rates, (0.0, 5.0), [entry, 1e-9], events=leaves, rtol=1e-11, atol=1e-13, max_step=1e-3
    )
    motion = esc.simulate(one, 1)
    speed = motion.at(float(found.t[-1])).theta_dot
    assert speed == pytest.approx(found.y[1, -1], rel=1e-6)


@pytest.mark.slow
def test_a_curve_over_a_turn_has_a_cycle_of_six_engagements():
    angle = np.linspace(0.0, 2.0 * math.pi, 7)
    ramp = esc.LoadCurve(angle, [0.0, 0.5, 1.0, 0.2, 0.0, -0.3, 0.0])
    cycle = esc.terminal(drive(ramp))
    assert len(cycle.beats) == 6
    assert cycle.beat_error > 5e-3 * cycle.period
    motion = esc.simulate(drive(ramp), 7, initial_speed=cycle.handoff_velocity)
    assert motion.engine == "energy"
    slow = esc.terminal(drive(ramp), engine="ivp")
    for name in ("period", "velocity_max", "beat_error", "contraction", "rise_time"):
        assert getattr(cycle, name) == pytest.approx(getattr(slow, name), rel=1e-7)
    beats = np.diff(motion.handoff_times, prepend=0.0)
    np.testing.assert_allclose(beats, [*cycle.beats, cycle.beats[0]], rtol=1e-8)
    # a curve over a step that is written out over a turn
    steps = [angle + k * STEP for k in range(6) for angle in CAM.angle[:-1]]
    written = esc.LoadCurve([*steps, steps[0] + 2.0 * math.pi], [*CAM.torque[:-1]] * 6 + [0.1])
    one, other = esc.simulate(drive(written), 5), esc.simulate(drive(CAM), 5)
    np.testing.assert_allclose(one.handoff_times, other.handoff_times, rtol=1e-12)


def test_a_train_of_the_load_leaves_the_curve_at_the_follower():
    geared = drive(CAM, load_torque=0.1, load_train=esc.Train(3.0, inertia=1e-3))
    by_hand = esc.Escapement(
        SIX, esc.Inertia(0.02, 0.1 + 9e-3), 3.0, 0.1, load_torque=0.3, load_curve=CAM
    )
    times = [esc.simulate(one, 3).handoff_times for one in (geared, by_hand)]
    np.testing.assert_allclose(*times, rtol=1e-12)


@pytest.mark.parametrize("engine", ["energy", "ivp"])
def test_a_motor_and_a_lossy_gearbox_carry_a_curve(engine):
    one = drive(
        CAM, torque=esc.Motor(0.5, 90.0), barrel=esc.Train(0.1, efficiency=0.8, inertia=1e-4)
    )
    motion = esc.simulate(one, 3, engine=engine)
    other = esc.simulate(one, 3, engine="ivp")
    np.testing.assert_allclose(motion.handoff_times, other.handoff_times, rtol=1e-9)
    assert abs(motion.ledger.residual) < 1e-11


def test_without_losses_the_mean_of_the_curve_decides():
    up = esc.LoadCurve([-0.5 * STEP, 0.0, 0.5 * STEP], [19.0, 20.0, 19.0])
    assert esc.terminal(drive(up, friction=0.0)).status is Status.STALL
    assert esc.terminal(drive(CAM, friction=0.0)).status is Status.NO_TERMINAL


def test_studies_files_and_the_command_line_take_it(capsys, tmp_path):
    (tmp_path / "cam.csv").write_text(
        "angle rad,torque\n"
        + "".join(f"{a!r},{t!r}\n" for a, t in zip(CAM.angle, CAM.torque, strict=True))
    )
    period = esc.terminal(drive(CAM)).period
    words = "run --slots 6 --pins 1 --crank-radius .05 --friction .1 --load-torque .3 --torque 3"
    words += " --driver-inertia .02 --follower-inertia .1 --json --load-curve"
    assert main([*words.split(), str(tmp_path / "cam.csv")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["period"] == pytest.approx(period, rel=1e-12)
    assert found["inputs"]["load_curve_angles"] == pytest.approx(CAM.angle)
    fixed = (
        "torque = 3\nload_torque = 0.3\n[mechanism]\nslots = 6\npins = 1\ncrank_radius = 0.05\n"
        "[inertia]\ndriver = 0.02\nfollower = 0.1\n[sweep]\nfriction = [0.1, 0.2]\n"
    )
    for name, table in (
        ("file", 'file = "cam.csv"\n'),
        ("points", f"angle = {[*CAM.angle]}\ntorque = {[*CAM.torque]}\n"),
    ):
        study = tmp_path / f"{name}.toml"
        study.write_text(f"{fixed}[load_curve]\n{table}")
        assert main(["sweep", str(study), "-o", str(tmp_path / f"{name}.h5"), "--quiet"]) == 0
        stored = esc.read_study(tmp_path / f"{name}.h5")
        assert float(stored["period"][0]) == pytest.approx(period, rel=1e-12)
    for load in (CAM, WEIGHT):
        motion = esc.simulate(drive(load), 2)
        esc.write_motion(motion, tmp_path / "m.h5", force=True)
        assert esc.read_motion(tmp_path / "m.h5").escapement == motion.escapement
    found = esc.sensitivities(drive(CAM)).relative["period"]["torque"]
    ends = [esc.terminal(drive(CAM, torque=3.0 * (1.0 + d))).period for d in (1e-5, -1e-5)]
    assert found == pytest.approx(math.log(ends[0] / ends[1]) / 2e-5, rel=1e-6)


@pytest.mark.parametrize(("load", "indexes"), [(CAM, 1), (WEIGHT, 6)], ids=["curve", "weight"])
def test_the_figures_of_an_index_are_those_of_all_that_repeat(load, indexes):
    found = esc.index(SIX, 6.0, 0.3, follower_inertia=0.1, friction=0.08, load_curve=load)
    assert found.indexes == indexes
    theta = np.linspace(SIX.breaks[0], SIX.breaks[-1], 100_001)
    theta = theta + SIX.cell_angle * np.arange(indexes)[:, None]
    state = found.at(theta)
    assert found.torque_max == pytest.approx(state.torque.max(), rel=1e-7)
    assert found.torque_min == pytest.approx(state.torque.min(), rel=1e-7)
    at = theta.reshape(-1)[state.torque.argmax()]
    assert found.torque_max_angle == pytest.approx(at, abs=1e-4)
    assert found.hardest == (0 if indexes == 1 else round(at / SIX.cell_angle))
    width = theta[0, -1] - theta[0, 0]
    mean = np.trapezoid(state.torque, theta).mean() / width
    assert found.torque_mean_index == pytest.approx(mean, rel=1e-6)
    square = np.trapezoid(state.torque**2, theta).mean() / SIX.cell_angle
    assert found.torque_rms == pytest.approx(math.sqrt(square), rel=1e-6)
    alike = esc.cam_drive(replace(found, friction=0.0), "cycloidal")
    assert (alike.indexes, alike.load_curve) == (indexes, load)
    # the law written out, with friction on the wall that carries the force
    path = SIX.transmission(SIX.breaks[0] * 0.4)
    here = found.at(SIX.breaks[0] * 0.4)
    moment = 0.3 + float(load(here.phi)) + 0.1 * 36.0 * float(path.dg)
    ratio = float(path.g) + math.copysign(0.08, moment) * abs(float(path.u))
    assert here.torque == pytest.approx(ratio * moment, rel=1e-12)


LOOSE = esc.Geneva(6, pins=1, crank_radius=0.05, clearance=1e-4)
HARD = {
    "pushes back": esc.LoadCurve(np.array([-0.5, -0.15, 0.2, 0.5]) * STEP, [1.0, 2.0, -1.0, 1.0]),
    "pulls ahead": esc.LoadCurve(np.array([-0.5, 0.0, 0.5]) * STEP, [-4.0, 6.0, -4.0]),
    "holds back": esc.LoadCurve(np.array([-0.5, 0.0, 0.5]) * STEP, [9.0, -6.0, 9.0]),
    "weight": esc.Unbalance(9.0, 0.4),
}  # fmt: skip
IMPACTS = ("entry_impact_angle", "entry_impact_energy", "reversal_impact_angle",
           "reversal_impact_energy")  # fmt: skip


@pytest.mark.parametrize("clearance", [1e-4, 1e-3])
@pytest.mark.parametrize("constant", [0.0, 2.0])
@pytest.mark.parametrize("load", HARD.values(), ids=HARD)
def test_blows_under_a_load_as_with_a_heavy_driver_and_rigid_contact(load, constant, clearance):
    """The hardest of all indexes, each simulated from its own entry."""
    wheel, inertia = replace(LOOSE, clearance=clearance), 0.4
    found = esc.index(wheel, 6.0, constant, follower_inertia=inertia, load_curve=load)
    entries, reversals = [], []
    for k in range(found.indexes):
        turned = replace(load, angle=load.angle + k * STEP) if found.indexes > 1 else load
        heavy = esc.Escapement(
            wheel, esc.Inertia(1e7 * inertia, inertia), torque=1e-3, load_torque=constant,
            load_curve=turned,
        )  # fmt: skip
        impacts = esc.simulate(heavy, 1, initial_speed=6.0).impacts
        angles = (impacts.theta[:2] + k * wheel.cell_angle).tolist()
        entries.append((impacts.energy[0], angles[0]))
        reversals.append((impacts.energy[1], angles[1]))
    expected = [*reversed(max(entries)), *reversed(max(reversals))]
    assert [getattr(found, name) for name in IMPACTS] == pytest.approx(expected, rel=1e-5)


def test_the_torque_of_a_loose_pin_under_a_load_is_that_of_a_tight_one():
    given = {"follower_inertia": 0.1, "load_curve": CAM, "friction": 0.08}
    loose, tight = (esc.index(wheel, 6.0, 0.3, **given) for wheel in (LOOSE, SIX))
    for name in ("torque_max", "torque_rms", "contact_force_max"):
        assert getattr(loose, name) == getattr(tight, name)
    assert loose.reversals == pytest.approx(tight.reversals, abs=1e-12)


@pytest.mark.parametrize("load", [CAM, WEIGHT], ids=["curve", "weight"])
def test_studies_have_the_blows_of_single_drives(load):
    names = [name.replace("angle", "deg") for name in IMPACTS]
    given = {"follower_inertia": 0.1, "load_curve": load}
    study = esc.sweep(
        esc.index(LOOSE, 6.0, 0.3, **given), clearance=[0.0, 1e-3], speed=[3.0, 6.0], results=names
    )
    assert np.isnan(np.asarray(study[names[0]])[0]).all()
    one = esc.index(replace(LOOSE, clearance=1e-3), 6.0, 0.3, **given)
    values = [getattr(one, name) for name in IMPACTS]
    values = [math.degrees(x) if "angle" in n else x for n, x in zip(IMPACTS, values, strict=True)]
    assert [float(study[name][1, 1]) for name in names] == pytest.approx(values, rel=1e-12)


def test_studies_of_drives_take_a_load():
    names = ["torque_max", "torque_min", "torque_rms", "torque_max_deg", "greatest_speed", "zone"]
    wheel = esc.Geneva(6, pins=1, crank_radius=0.05, pin_radius=0.004)
    for load in (CAM, WEIGHT):
        given = {"follower_inertia": 0.1, "friction": 0.08, "load_curve": load}
        study = esc.sweep(
            esc.index(wheel, 6.0, 0.3, **given), speed=[3.0, 6.0], pin_radius=[0.0, 0.006],
            results=names,
        )  # fmt: skip
        assert study.failed == 0
        for (i, speed), (j, pin) in itertools.product(
            enumerate((3.0, 6.0)), enumerate((0.0, 0.006))
        ):
            one = esc.index(replace(wheel, pin_radius=pin), speed, 0.3, **given)
            expected = [one.torque_max, one.torque_min, one.torque_rms]
            expected += [math.degrees(one.torque_max_angle), math.nan, one.zone]
            assert [study[name][i, j] for name in names] == pytest.approx(
                expected, rel=1e-11, nan_ok=True
            )


def test_what_cannot_be_is_refused_in_one_line(tmp_path):
    with pytest.raises(InvalidValue, match=r"^torque of the load curve must be the same at both e"):
        esc.LoadCurve([0.0, STEP], [0.0, 1.0])
    with pytest.raises(InvalidValue, match=r"^angle of the load curve must be ascending, got"):
        esc.LoadCurve([0.0, 2.0, 1.0], [0.0, 1.0, 0.0])
    with pytest.raises(InvalidValue, match=r"^the load curve must have 2 to 1000 angles and as m"):
        esc.LoadCurve([0.0, 2.0, 3.0], [0.0, 0.0])
    with pytest.raises(InvalidValue, match=r"^load_curve must be periodic in a step of the follow"):
        drive(esc.LoadCurve([0.0, 1.0], [0.2, 0.2]))
    with pytest.raises(InvalidValue, match=r"^moment must be .* got -1"):
        esc.Unbalance(-1.0)
    with pytest.raises(InvalidValue, match=r"^load_curve must be a LoadCurve or an Unbalance, got"):
        drive(3.0)
    given = {"follower_inertia": 0.1, "load_curve": CAM}
    with pytest.raises(InvalidValue, match=r"^locking_radius must be 0 with a load that changes,"):
        esc.index(SIX, 6.0, locking_radius=0.03, locking_angle=0.3, **given)
    with pytest.raises(InvalidValue, match=r"^locking_radius must be 0 with a load that changes,"):
        esc.sweep(esc.index(SIX, 6.0, **given), locking_radius=[0.0, 0.03], locking_angle=[0.3])
    (tmp_path / "bad.csv").write_text("angle,torque\n0,1\n1,2\n")
    with pytest.raises(InputFileError, match=r"^load curve .*bad.csv: torque of the load curve"):
        esc.LoadCurve.from_csv(tmp_path / "bad.csv")


def random_drive(rng):
    """With a load over a step or a turn, some with errors of the parts or a lossy load train."""
    leads = (rng.standard_normal(6) * 2e-4).tolist()
    mechanism = [
        esc.Geneva(int(rng.integers(3, 9)), pins=1, crank_radius=0.05),
        esc.Geneva(int(rng.choice([3, 4, 6])), crank_radius=0.05, pin_radius=0.002),
        esc.Geneva(6, internal=True, crank_radius=0.05),
        esc.CamIndexer(6, math.radians(120.0)),
        esc.EllipticalPlanetary(2.0, 1.0),
        esc.Geneva(6, crank_radius=0.05, slot_angle_errors=leads),
        esc.Geneva(6, pins=1, crank_radius=0.05, slot_angle_errors=leads, slot_offsets=[1e-5] * 6),
    ][rng.integers(7)]
    losses = {"efficiency": 0.9} if mechanism.meshed else {"friction": rng.uniform(0.0, 0.15)}
    losses |= {"follower_viscous": 0.02} if rng.random() < 0.3 else {}
    if mechanism.perfect and rng.random() < 0.3:
        losses["load_train"] = esc.Train(2.0, efficiency=0.8, inertia=1e-2)
    inertia = esc.Inertia(10.0 ** rng.uniform(-2.5, -1.0), 0.1)
    step = abs(float(mechanism.follower_step))
    steps = round(2.0 * math.pi / step) if rng.random() < 0.5 else 1
    weight = esc.Unbalance(rng.uniform(0.1, 2.0), rng.uniform(-3.0, 3.0))
    load = weight if rng.random() < 0.2 else random_load(rng, step, steps)
    return esc.Escapement(mechanism, inertia, 4.0, load_torque=0.2, load_curve=load, **losses)


def test_a_steep_flank_is_not_taken_for_a_kink():
    """Rounding of the follower's angle is a great one of the torque there."""
    wheel = esc.Geneva(6, pins=1, crank_radius=0.05, slot_offsets=[1e-5] * 6)
    angle = [-0.5 * STEP, 0.1, 0.11, 0.4, 0.41, 0.5 * STEP]
    one = drive(esc.LoadCurve(angle, [0.1, 0.1, 1.5, 1.5, 0.1, 0.1]), wheel)
    fast, slow = (esc.simulate(one, 2, engine=name) for name in ("energy", "ivp"))
    np.testing.assert_allclose(fast.handoff_times, slow.handoff_times, rtol=1e-10)
    assert abs(fast.ledger.residual) < 1e-12


@pytest.mark.slow
def test_fifty_random_curves_agree_with_the_reference_engine():
    rng, seen = np.random.default_rng(44), 0
    for _ in range(50):
        one = random_drive(rng)
        fast, slow = (esc.simulate(one, 4, engine=name) for name in ("energy", "ivp"))
        assert fast.status is slow.status
        np.testing.assert_allclose(fast.handoff_times, slow.handoff_times, rtol=1e-9)
        np.testing.assert_allclose(fast.handoff_velocities, slow.handoff_velocities, rtol=1e-9)
        assert fast.reversals.time.size == slow.reversals.time.size
        assert abs(fast.ledger.residual) < 1e-12
        seen += fast.reversals.time.size > 0
    assert seen > 10


@pytest.mark.slow
def test_random_curves_with_clearance_agree_with_two_bodies():
    """The two bodies take minutes for a play below a ten-thousandth of the crank radius."""
    drives = [loose_drive(np.random.default_rng(seed)) for seed in range(4, 18)]
    drives = [one for one in drives if one.mechanism.clearance > 2e-4 * one.mechanism.crank_radius]
    assert sum(agrees_with_two_bodies(one) for one in drives) >= 8


def _knots(i):
    return np.array(CAM.angle[1:-1]) + i * STEP


@pytest.mark.parametrize("engine", ["energy", "ivp"])
def test_energy_alone_gives_the_speed_without_friction(engine):
    one = drive(CAM, friction=0.0)
    motion = esc.simulate(one, 3, engine=engine)
    begin = float(SIX.follower_angle(SIX.breaks[0]))
    for k, speed in enumerate(motion.handoff_velocities, 1):
        work = sum(
            quad(CAM, begin + i * STEP, begin + (i + 1) * STEP, points=_knots(i), epsabs=1e-13)[0]
            for i in range(k)
        )
        energy = 3.0 * k * SIX.cell_angle - 0.3 * k * STEP - work
        assert speed == pytest.approx(math.sqrt(2.0 * energy / INERTIA.driver), rel=1e-11)


@pytest.mark.slow
def test_engines_agree_on_the_terminal_cycle_and_its_figures():
    fast, slow = (esc.terminal(drive(CAM), engine=name) for name in ("energy", "ivp"))
    for name in ("period", "velocity_max", "velocity_min", "contact_moment_max", "rise_time"):
        assert getattr(fast, name) == pytest.approx(getattr(slow, name), rel=1e-8)
    assert fast.reversal_angles == pytest.approx(slow.reversal_angles, abs=1e-8)


def test_a_level_curve_is_a_constant_load():
    level = esc.LoadCurve([-0.5 * STEP, 0.1, 0.5 * STEP], [0.2] * 3)
    times = [esc.simulate(one, 4).handoff_times for one in (
        drive(level), drive(None, load_torque=0.5)
    )]  # fmt: skip
    np.testing.assert_allclose(*times, rtol=1e-12)
