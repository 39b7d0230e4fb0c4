"""Two bodies with outlines: the law, worked examples, balances and statuses."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.dynamics.codes import Ending, Event
from escapement.dynamics.figures_of_merit import read_transient
from escapement.engines.two_bodies import march as marching
from escapement.engines.two_bodies import simulate as following
from escapement.engines.two_bodies import terminal, trajectory
from escapement.engines.two_bodies.blow import strike
from escapement.engines.two_bodies.law import Law
from escapement.engines.two_bodies.march import BEGIN, PHI, SPEED, TIME, TURNING
from escapement.engines.two_bodies.pairs import pairs_of
from escapement.engines.two_bodies.scene import prepared
from escapement.engines.two_bodies.touch import Touch, place, touch_at
from escapement.mechanisms.features import CONVEX, HOLLOW, LINE
from escapement.outlines.gaps import gap, segments_of
from escapement.outlines.touching import edges_of
from outlined_bodies import features, followed, geneva
from stepped_bodies import cores, marks


def pins(**changes):
    numbers = {
        "teeth": 12, "wheel_radius": 1.0, "tooth_depth": 0.22, "lead": math.radians(45.0),
        "back": math.radians(15.0), "tip_radius": 0.01, "pallets": "pins", "span": 2.5,
        "pallet_radius": 1.02, "pin_radius": 0.05, "driver_start": 0.05,
    }  # fmt: skip
    return esc.Runaway(**numbers | changes)


def flat(**changes):
    numbers = {
        "teeth": 20, "wheel_radius": 1.0, "tooth_depth": 0.2, "lead": math.radians(-5.0),
        "back": math.radians(30.0), "tip_radius": 0.01, "pallets": "flat", "span": 3.5,
        "pallet_radius": 0.95, "pallet_angle": math.radians(45.0), "pallet_length": 0.2,
        "pallet_thickness": 0.08, "corner_radius": 0.01, "driver_start": 0.14,
    }  # fmt: skip
    return esc.Runaway(**numbers | changes)


def runaway(wheel=None, inertias=(1.0, 0.3), friction=0.15, torque=1.0, **numbers):
    inertia = esc.Inertia(*inertias)
    return esc.Escapement(wheel or pins(), inertia, torque, friction=friction, **numbers)


# the first digits of each row, and the period of the limit cycle, come from two programs that
# share nothing
EXAMPLES = {
    "pins": (pins, (1.0, 0.3), 0.15, 0.0, (0.9626452882, 0.9556633140), 0.9554163897016),
    "flat": (flat, (1.0, 0.1), 0.15, 0.0, (0.9385579809, 0.9425041147), 0.9425425320853),
    "more friction": (flat, (1.0, 0.1), 0.20, 0.0, (), 1.0160036826793),
    "rebounds": (pins, (1.0, 0.3), 0.10, 0.25, (0.8419326454, 0.8085340826), 0.8049013206931),
}  # fmt: skip


@pytest.mark.parametrize("name", EXAMPLES)
def test_worked_example(name):
    wheel, inertias, friction, restitution, first, period = EXAMPLES[name]
    timer = runaway(wheel(), inertias, friction, restitution=restitution)
    # the flat pallets' other programs let the wheel turn from 0.05, where a tooth is in a pallet
    speed = math.sqrt(2.0 * (0.14 - 0.05)) if wheel is flat else 0.0
    motion = esc.simulate(timer, 14 if restitution else 9, initial_speed=speed)
    assert motion.status is Status.OK
    periods = np.diff(motion.handoff_times)
    assert periods[: len(first)] == pytest.approx(first, abs=1e-9)
    assert periods[-1] == pytest.approx(period, abs=2e-11)
    assert abs(motion.ledger.residual) < 1e-12


def test_terminal_is_the_cycle_that_a_long_motion_reaches():
    cycle = esc.terminal(runaway())
    assert cycle.status is Status.OK
    assert cycle.period == pytest.approx(0.9554163897016, abs=1e-12)
    assert cycle.contraction == pytest.approx(0.035, abs=5e-4)
    assert abs(cycle.energy_residual) < 1e-12
    motion = esc.simulate(runaway(), 12)
    assert cycle.handoff_velocity == pytest.approx(motion.handoff_velocities[-1], rel=1e-12)


@pytest.mark.parametrize(("slots", "pin"), [(3, 0.0), (4, 0.0), (4, 0.05), (6, 0.02)])
def test_geneva_as_outlines_is_the_geneva_of_the_slot_engine(slots, pin):
    # the slot engine knows nothing of outlines
    wheel = esc.Geneva(slots, crank_radius=1.0, pin_radius=pin, clearance=1e-3)
    other = esc.simulate(esc.Escapement(wheel, esc.Inertia(0.06, 1.0), 1.0, friction=0.3), 8)
    driver, follower, centre = geneva(slots, 5e-4, pin)
    count = 8 if wheel.continuous else 1
    states, _ending, _rows = followed(driver, follower, centre, (0.06, 1.0), count, mu_plus=0.3)
    assert states[1:, TIME] == pytest.approx(other.handoff_times[:count], rel=1e-11)
    assert states[1:, SPEED] == pytest.approx(other.handoff_velocities[:count], rel=1e-10)


PAIRS = {
    "pin on line": ((CONVEX, 0.9, 0.1, 0.3, math.pi, 0.05), (LINE, -0.4, -0.5, 1.2, 0.9, 0.0)),
    "tip on arc": ((CONVEX, 0.9, 0.1, 0.3, 0.4, 0.02), (CONVEX, -0.5, 0.1, 1.0, 2.0, 0.3)),
    "corner in hollow": ((CONVEX, 0.9, 0.1, 0.3, 0.4, 0.0), (HOLLOW, -0.6, 0.1, 1.0, 2.0, 0.7)),
}  # fmt: skip


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("name", PAIRS)
def test_rates_of_the_gap_are_its_differences(name, swapped):
    one, two = (features([row]) for row in PAIRS[name])
    bodies = (two, one) if swapped else (one, two)
    pair = next(row for row in pairs_of(*bodies) if row.nose == int(swapped))
    q, w, a, h = np.array([0.2, -0.3]), np.array([0.7, -1.1]), np.array([0.4, 0.9]), 1e-4

    def at(t):
        y = np.concatenate([q + w * t + 0.5 * a * t * t, w + a * t])
        return touch_at(pair, place(pair, 1.4, y, 0, 0))

    now, (before, after) = at(0.0), (at(-h), at(h))
    rate, bend = (after.gap - before.gap) / (2 * h), (after.gap - 2 * now.gap + before.gap) / h**2
    assert now.g0 * w[0] + now.g1 * w[1] == pytest.approx(rate, abs=1e-5)
    assert now.kappa + now.g0 * a[0] + now.g1 * a[1] == pytest.approx(bend, rel=1e-3)


def test_losses_of_every_kind_balance():
    timer = runaway(
        driver_bearing_torque=0.02, driver_viscous=0.02, follower_viscous=0.01, driver_drag=0.05,
        follower_drag=0.02, load_torque=0.01, driver_bearing_friction=0.1,
        driver_bearing_radius=0.05, follower_bearing_friction=0.1, follower_bearing_radius=0.05,
        follower_spring=0.2, follower_gravity=0.1, follower_rest_angle=0.05,
    )  # fmt: skip
    motion = esc.simulate(timer, 4)
    assert motion.status is Status.OK, motion.message
    ledger = motion.ledger
    for name in ("friction", "driver_bearing", "follower_bearing", "driver_drag", "follower_drag"):
        assert getattr(ledger, name) > 0.0
    assert ledger.load > 0.0
    assert ledger.elastic != 0.0
    assert abs(ledger.residual) < 1e-11


def test_spring_runs_down():
    timer = runaway(spring_rate=0.05)
    motion = esc.simulate(timer, 12)
    assert motion.status is Status.OK
    assert (np.diff(motion.handoff_times)[3:] > 0.96).all()
    assert abs(motion.ledger.residual) < 1e-10


def test_spring_that_is_spent_says_so():
    motion = esc.simulate(runaway(spring_rate=0.5), 20)
    assert motion.status is Status.SPENT
    assert motion.message.endswith("the spring is spent")


def test_states_between_handoffs_obey_the_law():
    motion = esc.simulate(runaway(), 3)
    t = np.linspace(0.05, motion.end_time - 0.05, 60)
    h = 1e-6
    before, now, after = motion.at(t - h), motion.at(t), motion.at(t + h)
    smooth = np.abs(after.theta_ddot - before.theta_ddot) < 1e-3
    assert smooth.sum() > 40
    slope = (after.theta_dot - before.theta_dot) / (2.0 * h)
    assert slope[smooth] == pytest.approx(now.theta_ddot[smooth], abs=1e-6)
    assert (now.contact_force >= 0.0).all()


@pytest.mark.parametrize("half_clearance", [0.0015, 0.002])
def test_driver_passes_the_peak_of_its_speed(half_clearance):
    bodies = geneva(4, half_clearance, 0.03)
    begins, ending, _ = followed(*bodies, (0.07, 0.7), 60, mu_plus=0.02)
    assert (ending, len(begins)) == (0, 61)


def test_contact_that_does_not_turn_the_pendulum_is_no_flight():
    numbers = {"lift": 2.0, "lock": 0.5, "drop": 0.9, "lead": -8.0, "back": 35.0}
    angles = {name: math.radians(value) for name, value in numbers.items()}
    clock = esc.Deadbeat(30, 1.0, 0.2, tip_radius=0.002, span=7.5, **angles)
    numbers = {"follower_gravity": 1.0, "follower_viscous": 0.02, "friction": 0.1}
    motion = esc.simulate(runaway(clock, (1e-4, 1.0), torque=0.006, **numbers), 20)
    start = motion.trajectory.start[motion.trajectory.sign == 0.0]
    assert np.isclose(motion.at(start + 1e-6).theta_ddot, 60.0).all()  # torque over inertia


def test_wheel_that_runs_free_says_so():
    # pins too far outside are never touched
    wheel, follower = pins().driver_features, features([(CONVEX, -0.2, 0.0, 0.0, math.pi, 0.01)])
    _states, ending, _rows = followed(wheel, follower, 1.4, (1.0, 0.3), 5, (0.05, 0.0))
    assert ending == 6


def test_wheel_that_jams_says_where():
    # a heavy verge dips so far that a corner meets the next tooth
    motion = esc.simulate(runaway(flat(), (0.06, 1.0), 0.15), 30)
    assert motion.status is Status.STALL
    assert "degrees" in motion.message
    assert esc.terminal(motion.escapement).status is Status.STALL


@pytest.mark.parametrize(
    ("numbers", "named"),
    [
        ({"barrel": esc.Train(ratio=2.0, efficiency=0.9)}, "barrel_efficiency"),
        ({"load_curve": esc.Unbalance(0.1)}, "load_curve"),
    ],
)
def test_what_no_engine_computes_is_refused(numbers, named):
    with pytest.raises(InvalidValue, match=named):
        runaway(**numbers)


def test_slots_have_no_pendulum():
    with pytest.raises(InvalidValue, match="follower_gravity"):
        esc.Escapement(esc.Geneva(4), esc.Inertia(1.0, 1.0), 1.0, follower_gravity=1.0)


def test_other_engines_are_refused():
    with pytest.raises(InvalidValue, match="two_bodies"):
        esc.simulate(runaway(), 2, engine="energy")
    with pytest.raises(InvalidValue, match="two_bodies"):
        esc.simulate(
            esc.Escapement(esc.Geneva(4), esc.Inertia(1.0, 1.0), 1.0), 2, engine="two_bodies"
        )


def test_rule_for_jams_is_refused():
    with pytest.raises(InvalidValue, match="slots"):
        esc.jam_rule(runaway())


def test_study_over_friction():
    grid = esc.sweep(runaway(), friction=[0.10, 0.15])
    assert grid["period"] == pytest.approx([0.9060003530, 0.9554163897], abs=1e-9)


@pytest.mark.slow
def test_sensitivities_obey_similarity():
    # T = sqrt(I/torque) F(ratio of the inertias, friction, ...)
    found = esc.sensitivities(runaway()).relative["period"]
    assert found["torque"] == pytest.approx(-0.5, abs=1e-6)
    assert found["driver_inertia"] + found["follower_inertia"] == pytest.approx(0.5, abs=1e-6)
    assert found["friction"] == pytest.approx(0.159, abs=1e-3)
    assert found["follower_inertia"] == pytest.approx(0.528, abs=1e-3)


DEADBEAT = {
    "teeth": 30, "wheel_radius": 1.0, "tooth_depth": 0.2, "lead": math.radians(-8.0),
    "back": math.radians(35.0), "tip_radius": 0.002, "span": 7.5, "lift": math.radians(2.0),
    "lock": math.radians(0.5), "drop": math.radians(1.0),
}  # fmt: skip


def clock(restitution=0.0, recoil=0.0, friction=0.1, **changes):
    numbers = DEADBEAT | changes
    wheel = esc.Recoil(**numbers, recoil_angle=recoil) if recoil else esc.Deadbeat(**numbers)
    return runaway(
        wheel, (1e-4, 1.0), friction, 0.004 if recoil else 0.006, restitution=restitution,
        follower_gravity=1.0, follower_viscous=0.02,
    )  # fmt: skip


def least_gap(motion):
    """The least gap of both outlines in the poses of a motion, by their exact distance."""
    wheel = motion.escapement.mechanism
    driver = segments_of(edges_of(wheel.driver_chains, wheel.driver_fold))
    follower = segments_of(edges_of(wheel.follower_chains))
    t = np.linspace(0.0, motion.end_time, 150 * len(motion.handoff_times), endpoint=False)
    poses = motion.at(np.sort(np.concatenate([t, motion.impacts.time])))
    return min(
        gap(
            follower.moved(np.exp(1j * phi), wheel.axes_distance),
            driver.moved(np.exp(1j * theta), 0),
        )[0]
        for theta, phi in zip(poses.theta, poses.phi, strict=True)
    )


MOTIONS = {
    "pins that rebound": (lambda: runaway(friction=0.1, restitution=0.25), 6),
    "flat pallets": (lambda: runaway(flat(), (1.0, 0.1)), 4),
    "flat pallets that rebound": (lambda: runaway(flat(), (1.0, 0.1), 0.3, restitution=0.25), 6),
    "sharp pins": (lambda: runaway(pins(tip_radius=0.0), restitution=0.5), 4),
}  # fmt: skip


@pytest.mark.parametrize("name", MOTIONS)
def test_bodies_never_overlap(name):
    make, count = MOTIONS[name]
    motion = esc.simulate(make(), count)
    assert motion.status is Status.OK
    assert least_gap(motion) > -1e-9


@pytest.mark.slow
@pytest.mark.parametrize(
    "timer",
    [
        clock(),
        # a sharp tooth rebounds on an impulse face, ever less
        clock(0.2, math.radians(10.0), tip_radius=0.0),
        clock(0.2, tip_radius=0.0),
    ],
)
def test_clocks_never_overlap(timer):
    motion = esc.simulate(timer, 30)
    assert motion.status is Status.OK
    assert np.diff(motion.handoff_times)[2:] == pytest.approx(2.0 * math.pi, rel=0.01)
    assert least_gap(motion) > -1e-9


@pytest.mark.parametrize("restitution", [0.0, 0.3])
def test_momentum_of_a_blow_closes_over_all_its_contacts(restitution):
    # a pallet that dips far strikes a tooth of the locked wheel, and both contacts stop the bodies
    timer = clock(restitution, friction=0.0)
    motion, (law, pairs, *_) = esc.simulate(timer, 25), prepared(timer)
    rows = motion.trajectory._happened[0]
    blows, most, together = rows[rows["kind"] == Event.IMPACT], 0.0, 0
    start, unit = motion.trajectory.start, timer.time_unit
    assert blows["impulse"] == pytest.approx(motion.impacts.impulse / timer.torque_unit / unit)
    for time in np.unique(blows["time"]):
        piece = int(np.searchsorted(start, time * unit * (1.0 + 1e-15), side="right")) - 1
        before, after = (motion.within(k, time * unit) for k in (piece - 1, piece))
        gain = law.rho * (after.theta_dot - before.theta_dot), after.phi_dot - before.phi_dot
        missing = np.array(gain) * unit
        here = blows[blows["time"] == time]
        for row in here:
            y, pair = np.array([row["theta"], row["phi"], 0.0, 0.0]), pairs[row["pair"]]
            touch = touch_at(pair, place(pair, law.centre, y, row["nose"], row["track"]))
            missing -= row["impulse"] * np.array([touch.g0, touch.g1])
        most = max(most, np.abs(missing).max())
        together += here.size == 2 and here["impulse"].min() > 1e-3 * here["impulse"].max()
    assert most <= 1e-11 * blows["impulse"].max()
    assert together > 3
    assert abs(motion.ledger.residual) < 1e-11


def any_runaway(seed):
    """A runaway escapement near those of the examples."""
    random = np.random.default_rng(seed)
    wheel, light = (pins, 0.3) if seed % 2 else (flat, 0.1)
    inertias = (0.06, 1.0) if seed % 5 == 1 else (1.0, light * random.uniform(0.7, 1.3))
    shape = {"lead": wheel().lead * random.uniform(0.9, 1.0), "driver_start": None}
    restitution = random.uniform(0.0, 0.4) if seed % 3 == 0 else 0.0
    return runaway(wheel(**shape), inertias, random.uniform(0.0, 0.3), restitution=restitution)


@pytest.mark.parametrize(
    "timers",
    [
        [any_runaway(seed) for seed in range(24)],
        # every second pitch is alike, and none is
        [runaway(flat(), (1.0, 0.1), mu, restitution=e) for mu, e in ((0.1, 0.25), (0.25, 0.35))],
    ],
)
def test_cycle_is_what_a_followed_motion_repeats(timers):
    kinds = set()
    for timer in timers:
        cycle, motion = esc.terminal(timer), esc.simulate(timer, 150)
        assert (cycle.status is Status.OK) == (motion.status is Status.OK)
        if cycle.status is not Status.OK:
            assert cycle.message == motion.message
            continue
        periods, size = np.diff(motion.handoff_times)[-100:], len(cycle.beats)
        if cycle.spread is not None:
            assert np.ptp(periods) > 0.01 * cycle.period
            assert abs(np.mean(periods) / cycle.period - 1.0) < 0.02
        else:
            assert sorted(periods[-size:]) == pytest.approx(sorted(cycle.beats), rel=1e-11)
            assert size == 1 or np.ptp(cycle.beats) > 1e-3 * cycle.period
        kinds.add(0 if cycle.spread is not None else size)
    assert kinds == ({1} if len(timers) > 2 else {0, 2})


def test_a_clock_counts_as_settled_when_its_slow_swings_are():
    timer = clock(recoil=math.radians(10.0))
    cycle, motion = esc.terminal(timer), esc.simulate(timer, 100)
    assert cycle.settling_time == pytest.approx(read_transient(motion, cycle)[1], rel=1e-9)


def test_start_within_each_other_is_refused():
    motion = esc.simulate(runaway(flat(driver_start=0.05), (1.0, 0.1)), 2)
    assert motion.status is Status.INVALID
    assert motion.message.startswith("driver_start and follower_start must be angles")
    assert "2.86479 and 0 degrees" in motion.message


def test_state_of_the_cycle_with_pins():
    motion = esc.simulate(runaway(), 9)
    state = motion.at(motion.handoff_times[-1])
    found = state.phi, state.theta_dot, state.phi_dot
    assert found == pytest.approx((0.0770122473, 0.5246467260, -0.4689353824), abs=1e-9)


def test_geneva_in_every_digit():
    # Meyer's wheel with a clearance of a thousandth of the crank
    driver, follower, centre = geneva(4, 5e-4)
    states, _ending, rows = followed(
        driver, follower, centre, (0.06, 1.0), 40, rows=20000, mu_plus=0.3
    )
    unit = math.sqrt(50e-6 / 0.1)
    assert np.diff(states[-2:, TIME])[0] * unit == pytest.approx(0.041665482332, abs=1e-12)
    assert states[-1, SPEED] / unit == pytest.approx(85.9951334232, abs=1e-9)
    last = rows[(rows["engagement"] == 39) & (rows["kind"] >= 0)]
    lift, blow = (np.degrees(last["theta"][last["kind"] == kind]) - 45.0 for kind in (7, 6))
    assert lift[-1] == pytest.approx(24.4721, abs=1e-4)  # before it the last pin may leave
    assert blow[-1] == pytest.approx(28.5776, abs=1e-4)


speeds = st.floats(-2.0, 2.0)


factors = st.floats(-1.5, 1.5)


@settings(deadline=None, max_examples=300)
@given(factors, factors, factors, factors, speeds, speeds, st.floats(0.0, 0.5), st.floats(0.0, 0.9))
def test_blow_keeps_momentum_and_takes_energy(g0, g1, h0, h1, w0, w1, mu, restitution):
    if min(math.hypot(g0, g1), math.hypot(h0, h1)) < 0.1 or g0 * w0 + g1 * w1 > -1e-3:
        return
    rho = 2.0
    law = Law(**dict.fromkeys(Law._fields, 0.0) | {"rho": rho, "mu_plus": mu})
    touch, y = Touch(0.0, g0, g1, h0, h1, 0.0, 1.0, 1.0), np.array([0.0, 0.0, w0, w1])
    impulse = strike(law, touch, y, restitution)
    if impulse != impulse:
        return
    change = np.array([rho * (y[2] - w0), y[3] - w1])
    # the impulse is normal and tangential: momentum of both bodies is that of two numbers
    along = change - impulse * np.array([g0, g1])
    assert abs(along[0] * h1 - along[1] * h0) <= 1e-12 * (1.0 + impulse)
    sliding = along @ [h0, h1] / max(h0 * h0 + h1 * h1, 1e-30)
    assert abs(sliding) <= mu * impulse * (1.0 + 1e-9) + 1e-12
    lost = 0.5 * (rho * w0**2 + w1**2 - rho * y[2] ** 2 - y[3] ** 2)
    assert lost >= -1e-12
    assert g0 * y[2] + g1 * y[3] >= -1e-12


def test_similarity():
    one = esc.terminal(runaway()).period
    other = esc.terminal(runaway(inertias=(2.0, 0.6), torque=5.0)).period
    assert other == pytest.approx(one * math.sqrt(2.0 / 5.0), rel=1e-12)


def test_order_of_the_features_does_not_matter():
    wheel = pins()
    driver, follower = wheel.driver_features, wheel.follower_features
    found = []
    for order in (slice(None), slice(None, None, -1)):
        given = driver._replace(
            **{n: getattr(driver, n)[order].copy() for n in driver._fields[:-1]}
        )
        states, _ending, _rows = followed(
            given, follower, wheel.axes_distance, (1.0, 0.3), 6, (0.05, 0.0), mu_plus=0.15
        )
        found.append(states[:, [TIME, SPEED, PHI, TURNING]])
    assert found[0] == pytest.approx(found[1], abs=1e-11)


def test_mirror_image_runs_alike():
    # entry and exit of both bodies change places where the wheel turns the other way
    wheel = pins(lead=math.radians(20.0), back=math.radians(20.0))
    driver, follower = wheel.driver_features, wheel.follower_features
    given = wheel.axes_distance, (1.0, 0.3), 5

    def mirrored(body):
        direction = -body.direction
        line = body.kind == LINE
        x = body.x + np.where(line, body.extent * np.cos(body.direction), 0.0)
        y = body.y + np.where(line, body.extent * np.sin(body.direction), 0.0)
        direction = np.where(line, math.pi - body.direction, direction)
        return body._replace(x=x, y=-y, direction=direction)

    first, _ending, _rows = followed(driver, follower, *given, (0.05, 0.0), mu_plus=0.1)
    # a symmetric tooth and symmetric pins are their own mirror image
    other, _ending, _rows = followed(
        mirrored(driver), mirrored(follower), *given, (0.05, 0.0), mu_plus=0.1
    )
    assert first[:, TIME] == pytest.approx(other[:, TIME], abs=1e-11)


PINS = {"span": 2.5, "lead": math.radians(45.0), "back": math.radians(15.0), "tip": 0.01}


BESIDE = {
    "flat pallets that rebound": (flat, (1.0, 0.1), 0.3, 0.25, 1e-4),
    "pins that rebound": (pins, (1.0, 0.3), 0.15, 0.25, 1e-4),
    "more friction": (pins, (1.0, 0.3), 0.3, 0.25, 1e-4),
    "a heavy verge": (pins, (0.06, 1.0), 0.3, 0.0, 1e-3),
}  # fmt: skip


FLAT = {"span": 3.5, "lead": math.radians(-5.0), "back": math.radians(30.0), "tip": 0.01}


@pytest.mark.slow
@pytest.mark.parametrize("name", BESIDE)
def test_cycle_is_that_of_small_steps_between_cores(name):
    wheel, inertias, friction, restitution, accuracy = BESIDE[name]
    teeth, start = (20, 0.14) if wheel is flat else (12, 0.05)
    face = math.radians(45.0), 0.2, 0.08, 0.01
    shape = (
        cores(teeth, **FLAT, pallet_radius=0.95, face=face)
        if wheel is flat
        else cores(teeth, **PINS, pallet_radius=1.02, pin=0.05)
    )
    stepped = marks(shape, teeth, np.array(inertias), friction, restitution, start, 8, 2e-5)
    timer = runaway(wheel(), inertias, friction, restitution=restitution)
    assert esc.terminal(timer).period == pytest.approx(np.diff(stepped)[-1], rel=accuracy)


@pytest.mark.parametrize(
    ("slopes", "noise", "bend", "size", "most"),
    [
        ((0.03, 0.0), 0.0, 0.0, 1, 12),
        ((0.86, 0.3), 0.0, 0.0, 1, 120),
        ((0.86, 0.3), 3e-11, 0.0, 1, 120),  # rounding that repeats itself every second time
        ((-1.2, 0.1), 0.0, 2.0, 2, 300),  # the fixed point repels
    ],
)
def test_a_map_is_followed_to_its_fixed_point(monkeypatch, slopes, noise, bend, size, most):
    passed = []

    def march_from(_escapement, start, count):
        states = np.tile(start, (count + 1, 1))
        for one, two in itertools.pairwise(states):
            x = one[SPEED : TURNING + 1] - (1.0, 0.3, -0.5)
            way = noise if len(passed) % 2 else -noise
            moved = np.array([slopes[0] * x[0] + bend * x[0] ** 3, slopes[1] * x[1], 0.2 * x[0]])
            two[SPEED : TURNING + 1] = moved + way + (1.0, 0.3, -0.5)
            passed.append(two)
        return Ending.DONE, states, 0.0, 0.0

    def figures(_escapement, _base, _states, last, size, same, _rtol):
        return last[SPEED], size, same

    start = np.zeros(BEGIN)
    start[SPEED] = 0.8
    monkeypatch.setattr(following, "march_from", march_from)
    monkeypatch.setattr(following, "first_state", lambda *_given: start)
    monkeypatch.setattr(terminal, "_figures", figures)
    speed, found, same = terminal.terminal(None, None, initial_speed=0.0, rtol=1e-12)
    assert found == size
    assert len(passed) <= most
    if size == 1:
        assert speed == pytest.approx(1.0, abs=max(1e-12, 10.0 * noise))
        assert same == pytest.approx(2.0 * noise, rel=1.0, abs=1e-13)


@pytest.mark.parametrize(("wheel", "verge", "most"), [(pins, 0.3, 18), (flat, 0.1, 16)])
def test_cycle_takes_few_pitches(monkeypatch, wheel, verge, most):
    followed, march = [], marching.march

    def counted(*given):
        found = march(*given)
        followed.append(found[1])
        return found

    monkeypatch.setattr(marching, "march", counted)
    monkeypatch.setattr(trajectory, "march", counted)
    figures = esc.terminal(runaway(wheel(), (1.0, verge)))
    assert sum(followed) <= most
    assert figures.settling_time >= figures.rise_time > 0.0
    assert sum(followed) <= most + 8  # they are followed once more when they are read
    assert replace(figures, message="").rise_time == figures.rise_time


def test_cycle_does_not_depend_on_the_start():
    found = [
        esc.terminal(runaway(flat(driver_start=start), (1.0, 0.1), 0.3, restitution=0.25)).period
        for start in (0.14, 0.17)
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-10)
