"""Imperfect parts: printed examples, both bodies in time, both engines, one-sided slopes, refusals.

The printed numbers come from two computations that share nothing with this package.
"""

import cmath
import dataclasses
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

import escapement as esc
import imperfect_bodies as bodies
from both_engines import agree
from escapement.base.status import Status
from escapement.base.units import INCH_POUND
from escapement.cli import main
from escapement.dynamics.painleve import friction_limits
from escapement.study.parse import parse_plan
from two_bodies import random_drive

CRANK = 0.01
CENTRES = CRANK / math.sin(math.pi / 4)
INERTIA = esc.Inertia(driver=3e-6 * INCH_POUND, follower=50e-6 * INCH_POUND)
NAMES = ("pin_angle_errors", "crank_radius_errors", "slot_angle_errors", "slot_offsets")


def timer(friction=0.3, slots=4, **wheel):
    mechanism = esc.Geneva(slots, **{"crank_radius": CRANK} | wheel)
    return esc.Escapement(mechanism, INERTIA, 0.10 * INCH_POUND, friction)


# of each: the errors, the time of a revolution, and how the second pin takes over
EXAMPLES = {
    "too far apart": ({"centre_distance_error": 5e-4 * CENTRES}, 4 * 0.0414341593, "overlap"),
    "too close": ({"centre_distance_error": -5e-4 * CENTRES}, 4 * 0.0416603115, "strike"),
    "a pin late": ({"pin_angle_errors": (0, 2e-3, 0, 0)}, 0.1659407735, "pick-up"),
    "a slot ahead": ({"slot_angle_errors": (0, 1e-3, 0, 0)}, 0.1661036007, "strike"),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_printed_examples(name):
    errors, time, kind = EXAMPLES[name]
    cycle = esc.terminal(timer(**errors))
    assert 4.0 * cycle.period == pytest.approx(time, abs=2.1e-10 if "too" in name else 0.51e-10)
    assert cycle.motion.handoffs.kind[0] == kind
    assert math.fsum(cycle.beats) == pytest.approx(4.0 * cycle.period, rel=1e-14)
    assert cycle.beat_error == max(cycle.beats) - min(cycle.beats)
    assert (cycle.blow_max > 0.0) == (kind == "strike")
    assert abs(cycle.energy_residual) < 1e-13


def imperfect(rng, slots, size, **rest):
    """A wheel with errors of every kind, up to `size` crank radii or rad."""
    internal = bool(rng.random() < 0.25)
    pins = esc.Geneva(slots, internal=internal).pins
    sizes = size * np.array([1.0, CRANK, 1.0, CRANK])
    counts = (pins, pins, slots, slots)
    numbers = [s * rng.uniform(-1.0, 1.0, n) for s, n in zip(sizes, counts, strict=True)]
    distance = CRANK * size * rng.uniform(-1.0, 1.0)
    given = dict(zip(NAMES, numbers, strict=True)) | {"centre_distance_error": distance}
    return esc.Geneva(slots, None, internal, CRANK, 0.05 * CRANK, **given | rest)


def random_case(seed):
    """An escapement with every loss and every error, and a speed that carries it through."""
    rng = np.random.default_rng(seed)
    wheel = imperfect(rng, int(rng.integers(3, 8)), 2e-3 * 10.0 ** rng.uniform(-2.0, 0.0))
    like = esc.Geneva(4, crank_radius=CRANK, pin_radius=0.05 * CRANK)
    drive = dataclasses.replace(random_drive(rng, mechanism=like), mechanism=wheel, friction=0.0)
    friction = rng.uniform(0.1, 0.8) * min(*friction_limits(drive), 0.8)
    drive = dataclasses.replace(drive, friction=friction, load_torque=0.3 * drive.load_torque)
    return drive, rng.uniform(2.0, 4.0) / drive.time_unit


def test_both_bodies_in_time_hand_over_alike():
    for seed in range(15):
        drive, speed = random_case(seed)
        motion = esc.simulate(drive, engagements=2, initial_speed=speed)
        assert motion.status is Status.OK
        expected, found = bodies.run(drive, speed, 2), motion.handoffs
        assert found.kind.tolist() == [one.ends.kind for one in expected]
        np.testing.assert_allclose(found.time, [one.time for one in expected], rtol=1e-9)
        np.testing.assert_allclose(found.theta_dot, [one.speed for one in expected], rtol=1e-9)
        np.testing.assert_allclose(found.jump, [one.ends.jump for one in expected], atol=1e-12)
        assert abs(motion.ledger.residual) < 1e-12


def test_wild_parts_hand_over_by_the_rule_or_are_told_where_they_do_not_fit():
    fit = 0
    for seed in range(150):
        rng = np.random.default_rng(seed)
        wheel = imperfect(rng, int(rng.integers(3, 8)), 10.0 ** rng.uniform(-3.0, 0.0))
        if wheel.misfit:
            assert "cannot drive slot" in wheel.misfit
            assert "degrees behind the first dead centre" in wheel.misfit
            continue
        meetings, fit = wheel.pairs, fit + 1
        for k, one in enumerate(meetings):
            ends, two = bodies.handoff(wheel, k), meetings[(k + 1) % len(meetings)]
            assert two.kind == ends.kind
            assert two.jump == pytest.approx(ends.jump, abs=1e-12)
            leaves = one.delay + one.edges[-1] + k * wheel.cell_angle
            starts = two.delay + two.edges[0] + (k + 1) * wheel.cell_angle
            assert (leaves, starts) == pytest.approx((ends.leaves, ends.starts), abs=1e-10)
    assert 50 < fit < 150


def test_a_blow_in_which_a_wide_pin_slides_back_is_refused():
    outcomes = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        thin = imperfect(rng, int(rng.integers(3, 9)), 10.0 ** rng.uniform(-1.5, -0.5))
        if thin.misfit:
            continue
        wheel = dataclasses.replace(thin, pin_radius=0.95 * CRANK * thin.widest_pin)
        drive, back = SimpleNamespace(mechanism=wheel), False
        for k, meeting in enumerate(thin.pairs):
            if meeting.kind == "strike":
                pair, theta = bodies.pair_of(wheel, k), k * wheel.cell_angle + meeting.delay
                theta += meeting.edges[0]
                phi, ratio = pair.asked(theta)
                first, last = (
                    bodies.Contact(drive, pair, 1.0, theta, 1.0, phi, x).sliding for x in (0, ratio)
                )
                back |= first * last < 0.0
        assert back == bool(wheel.misfit)
        outcomes.append(back)
    assert {*outcomes} == {True, False}


# of each error of 1e-6: the relative change of the mean period per unit


def test_a_stall_is_told_with_its_place():
    wheel = imperfect(np.random.default_rng(2), 4, 1e-3)
    drive = esc.Escapement(wheel, INERTIA, 0.1 * INCH_POUND, 0.3, load_torque=0.06 * INCH_POUND)
    cycle, motion = esc.terminal(drive), esc.simulate(drive, engagements=100)
    assert cycle.status is motion.status is Status.STALL
    assert cycle.message == motion.message
    assert math.isnan(cycle.velocity_max)


def test_a_motion_tells_of_its_handoffs():
    wheel = imperfect(np.random.default_rng(0), 4, 1e-3, centre_distance_error=0.0)
    drive = esc.Escapement(wheel, INERTIA, 0.10 * INCH_POUND, 0.3, load_torque=0.002 * INCH_POUND)
    motion = esc.simulate(drive, engagements=9)
    found = motion.handoffs
    assert {*found.kind} == {"overlap", "strike"}
    for k, time in enumerate(found.time[:-1]):
        (last,) = np.flatnonzero(motion.trajectory.engagement == k)[-1:]
        before, behind = (motion.within(piece, time) for piece in (last, last + 1))
        assert behind.phi - before.phi == pytest.approx(found.jump[k], abs=1e-13)
        assert before.theta_dot == pytest.approx(found.speed_before[k], rel=1e-11)
        assert behind.theta_dot == pytest.approx(found.theta_dot[k], rel=1e-11)
        assert before.theta == pytest.approx(found.theta[k], abs=1e-11)
        assert behind.theta == pytest.approx(found.theta[k], abs=1e-11)
        gained = (behind.phi_dot - before.phi_dot) * INERTIA.follower
        assert gained == pytest.approx(found.impulse[k], rel=1e-9, abs=1e-12 * INERTIA.follower)
    assert (found.clearance_needed > 0.0).tolist() == (found.jump > 0.0).tolist()
    assert motion.impacts.energy.tolist() == found.energy[found.kind == "strike"].tolist()
    assert motion.ledger.blows == pytest.approx(found.energy[:-1].sum())
    # a settled motion repeats the pattern to the end
    long = esc.simulate(drive, engagements=400)
    np.testing.assert_allclose(np.diff(long.handoff_times[-9:]), [*esc.terminal(drive).beats] * 2)


@pytest.mark.parametrize("slots", [3, 5, 6])
def test_the_clearance_needed_is_how_far_the_next_pin_lies_off_its_slot(slots):
    """While the follower is where the outgoing pin holds it; with four slots R would be r."""
    far = {"centre_distance_error": 3e-3 * CRANK}
    wheel = imperfect(np.random.default_rng(slots), slots, 1e-3, **far)
    drive = esc.Escapement(wheel, INERTIA, 0.10 * INCH_POUND, 0.2)
    found, seen = esc.simulate(drive, engagements=2 * slots).handoffs, 0
    for k in np.flatnonzero(found.jump > 0.0):
        ends, pair = bodies.handoff(wheel, int(k)), bodies.pair_of(wheel, int(k) + 1)
        rest = bodies.pair_of(wheel, int(k)).asked(ends.leaves)[0]
        out = cmath.rect(1.0, rest + pair.lean)
        pin = pair.axis + cmath.rect(pair.radius, pair.zero + pair.sense * ends.starts)
        needed = bodies.cross(out, pin) - pair.offset
        assert found.clearance_needed[k] == pytest.approx(needed, rel=0.01)
        assert abs(pin) / CRANK - 1.0 > 0.2 or abs(pin) / CRANK < 0.8
        seen += 1
    assert seen > 1


def test_a_study_solves_each_imperfect_wheel():
    errors, distances = {"slot_angle_errors": (0, 1e-3, 0, 0)}, [-1e-5, 0.0, 1e-5]
    study = esc.sweep(timer(**errors), friction=[0.25, 0.3], centre_distance_error=distances)
    cycles = [esc.terminal(timer(**errors, centre_distance_error=one)) for one in distances]
    np.testing.assert_allclose(study.results["period"][1], [one.period for one in cycles])
    names = ("beat_error", "blow_max", "rise_time", "settling_time", "velocity_min")
    one = {"centre_distance_error": distances}
    # those of a fall are computed case by case, the others by a kernel for many patterns
    for more in ((), ("rise_time_63",)):
        study = esc.sweep(timer(**errors), **one, results=(*names, *more))
        for name in (*names, *more):
            expected = [getattr(cycle, name) for cycle in cycles]
            np.testing.assert_allclose(
                study.results[name], expected, rtol=1e-9, atol=1e-15, err_msg=name
            )


@pytest.mark.parametrize(
    ("errors", "words"),
    [
        ({"slot_angle_errors": (0, 0, 0.7, 0)}, "pin 2 cannot drive slot 2"),
        ({"slot_offsets": (0, 0, 0, CRANK)}, "pin 3 cannot drive slot 3"),
        ({"centre_distance_error": -0.5 * CRANK}, "pin 0 cannot drive slot 0"),
    ],
)
def test_a_pin_that_misses_its_slot_is_named(errors, words):
    for outcome in (esc.simulate(timer(**errors)), esc.terminal(timer(**errors))):
        assert outcome.status is Status.INVALID
        assert words in outcome.message
        assert "degrees behind the first dead centre" in outcome.message
    own = timer(**errors)
    for ask in (lambda: esc.critical_friction(own.mechanism, own.inertia), lambda: own.scenes):
        with pytest.raises(esc.errors.InvalidValue, match=words):
            ask()


def test_a_sample_draws_each_pin_and_slot_alone(tmp_path):
    nominal = (0.0, 1e-3, 0.0, 0.0)
    sample = {"method": "latin-hypercube", "size": 4, "seed": 1}
    spread = {"slot_angle_errors": {"tolerance": 1e-3}, "slot_offsets": {"tolerance": 1e-5}}
    study = esc.sweep(timer(slot_angle_errors=nominal), sample=sample | spread)
    drawn = {name: [study.sampled[f"{name}_{i}"] for i in range(4)] for name in spread}
    assert len({column.tobytes() for columns in drawn.values() for column in columns}) == 8
    assert (np.abs(np.transpose(drawn["slot_angle_errors"]) - nominal) <= 1e-3).all()
    for case in range(4):
        wheel = {name: [column[case] for column in columns] for name, columns in drawn.items()}
        cycle = esc.terminal(timer(**wheel))
        assert study.results["period"][case] == pytest.approx(cycle.period, rel=1e-10)
    # what is written makes the same study again
    esc.write_study(study, tmp_path / "study.h5")
    again = esc.run_plan(parse_plan(esc.read_study(tmp_path / "study.h5").configuration))
    np.testing.assert_array_equal(again.results["period"], study.results["period"])


@pytest.mark.parametrize("drawn", [False, True])
def test_a_study_scales_errors_by_a_factor(drawn, tmp_path):
    errors, factors, kept = (0.0, 1e-3, 0.0, -5e-4), [-1.0, 0.0, 0.5], ("period", "beat_error")
    drive = timer() if drawn else timer(slot_angle_errors=errors)
    sample = {"method": "latin-hypercube", "size": 2, "slot_angle_errors": {"tolerance": 1e-3}}
    study = esc.sweep(
        drive, slot_angle_errors_factor=factors, sample=sample if drawn else None, results=kept
    )
    for i, factor in enumerate(factors):
        for case in range(2 if drawn else 1):
            numbers = errors
            if drawn:
                numbers = [study.sampled[f"slot_angle_errors_{k}"][case] for k in range(4)]
            cycle = esc.terminal(timer(slot_angle_errors=[factor * x for x in numbers]))
            place = (i, case) if drawn else i
            for name in kept:
                found = study.results[name][place]
                assert found == pytest.approx(getattr(cycle, name), rel=1e-10, abs=1e-16)
    esc.write_study(study, tmp_path / "study.h5")
    again = esc.read_study(tmp_path / "study.h5")
    assert again.units["slot_angle_errors_factor"] == "1"
    if drawn:
        assert again.units["slot_angle_errors_0"] == "rad"
    more = esc.run_plan(parse_plan(again.configuration)).results["period"]
    np.testing.assert_array_equal(more, study.results["period"])


def test_the_blow_before_a_stop_counts():
    case = timer(centre_distance_error=-5e-4 * CENTRES)
    case = dataclasses.replace(case, spring_rate=case.torque / 20.0)
    motion = esc.simulate(case, 200)
    assert motion.status is Status.SPENT
    assert motion.end_time == motion.impacts.time[-1]
    assert abs(motion.ledger.residual) < 1e-14


def test_the_command_tells_the_real_distance_of_the_axes_and_what_does_not_fit(capsys):
    """Axes 3 m apart where 2 m are right, and the wheel of a gear-driven one 1 mm off."""
    sizes = ["--slots", "6", "--pins", "1", "--crank-radius", "1", "--pin-radius", "0.1"]
    for error, apart in (("1.0", 3.0), ("1e-6", 2.000001)):
        assert main(["mechanism", *sizes, "--centre-distance-error", error, "--json"]) == 0
        out, err = capsys.readouterr()
        told = json.loads(out)
        assert told["centre_distance"] == pytest.approx(apart, rel=1e-15)
        assert told["centre_distance_over_crank_radius"] == pytest.approx(apart, rel=1e-15)
        assert (
            "the numbers except the distance of the axes are those of parts without errors" in err
        )
        assert ("pin 0 cannot drive slot 1" in err) == (apart == 3.0)
    gears = ["gear-driven", "--stations", "12", "--lobes", "3", "--curve", "hypocycloid"]
    main(["mechanism", *gears, "--fixed-radius", "1", "--centre-distance-error", "1e-3", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert told["carrier"] == pytest.approx(2.0 / 3.0 + 1e-3, rel=1e-14)
    assert told["carrier_over_fixed"] == told["carrier"]
    main(["mechanism", *sizes, "--json"])
    assert "warning" not in capsys.readouterr().err


def test_impulse_and_energy_of_every_blow_balance():
    seen = 0
    for seed in range(100):
        drive, speed = random_case(seed)
        found, own = esc.simulate(drive, engagements=4, initial_speed=speed).handoffs, drive.inertia
        for k in np.flatnonzero(found.kind == "strike"):
            before, after = found.speed_before[k], found.theta_dot[k]
            pair = bodies.pair_of(drive.mechanism, found.engagement[k])
            blow = bodies.strike(drive, pair, found.theta[k], before)
            assert after == pytest.approx(blow.speed, rel=1e-12)
            assert own.driver * (after - before) == pytest.approx(
                blow.on_driver, abs=1e-12 * own.driver * before
            )
            taken = own.follower * blow.phi_dot
            assert found.impulse[k] == pytest.approx(taken, rel=1e-12)
            kinetic = 0.5 * own.driver * before**2
            left = 0.5 * (own.driver * after**2 + own.follower * blow.phi_dot**2)
            assert found.energy[k] == pytest.approx(kinetic - left, abs=1e-12 * kinetic)
            seen += 1
    assert seen > 100


# of each error of 1e-6: the relative change of the mean period per unit
SLOPES = [
    ({"centre_distance_error": 1e-6 * CENTRES}, -3.238),
    ({"centre_distance_error": -1e-6 * CENTRES}, 9.190),
    ({"pin_angle_errors": (0, 1e-6, 0, 0)}, -0.1441),
    ({"slot_angle_errors": (0, 1e-6, 0, 0)}, 0.8872),
]


@pytest.mark.parametrize(("errors", "slope"), SLOPES)
def test_the_response_is_one_sided(errors, slope):
    perfect = esc.terminal(timer(friction=0.25)).period
    changed = esc.terminal(timer(friction=0.25, **errors)).period
    assert (changed / perfect - 1.0) / 1e-6 == pytest.approx(slope, rel=1e-3)


def test_errors_of_zero_leave_every_bit():
    zeros = dict.fromkeys(NAMES, (0.0,) * 4) | {"centre_distance_error": 0.0}
    one, two = (esc.simulate(timer(**wheel), engagements=9) for wheel in ({}, zeros))
    np.testing.assert_array_equal(one.handoff_times, two.handoff_times)
    assert two.handoffs.kind.tolist() == ["overlap"] * 9
    assert two.impacts.time.size == two.handoffs.energy.any() == two.handoffs.jump.any() == 0


@pytest.mark.parametrize("seed", range(4))
def test_both_engines_agree_on_springs_and_curves(seed):
    """The ledger takes the work of the drive from the way, whose parts are unequal."""
    rng = np.random.default_rng(seed)
    slots = int(rng.choice([3, 4, 5, 8]))
    wheel = imperfect(rng, slots, 1e-3)
    torque, way = 0.10 * INCH_POUND, 14 * wheel.cell_angle
    drive = {"torque": torque, "spring_rate": torque / way * rng.uniform(0.1, 1.2)}
    if seed % 2:
        angles = np.concatenate([[0.0], np.cumsum(rng.uniform(0.3, 2.0, 4))])
        torques = torque * rng.uniform(0.3, 1.0, 5)
        drive = {"torque": esc.TorqueCurve(angles, [*torques[:4], torques[0]], periodic=True)}
    load = 0.05 * torque / wheel.transmission_max
    case = esc.Escapement(wheel, INERTIA, friction=0.15, load_torque=load, **drive)
    agree(case, 14, rtol=1e-11)
    assert esc.terminal(case).period == esc.terminal(case.held).period
