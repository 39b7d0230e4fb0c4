"""Results of `simulate`: both engines agree, and events are exact."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import escapement as esc
from any_path import Plain
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.dynamics.motion import Motion
from escapement.dynamics.painleve import critical_friction
from escapement.engines.solver import LOOSEST, METHODS
from random_drives import drive

BOTH = ("energy", "ivp")
INERTIA = esc.Inertia(3.39e-7, 5.65e-6)


@pytest.fixture(params=BOTH)
def engine(request):
    """Either engine, one after the other."""
    return request.param


# what is asked for


def test_defaults():
    motion = esc.simulate(drive())
    assert isinstance(motion, Motion)
    assert (motion.engine, motion.rtol, motion.status) == ("energy", 1e-12, Status.OK)
    assert motion.handoff_times.size == 20
    assert motion.end_time == motion.handoff_times[-1]
    assert motion.message == "done"


def test_the_default_grid_is_even_between_handoffs_with_all_events(engine):
    motion = esc.simulate(drive(5, 1), 3, engine=engine)
    assert motion.t[0] == 0.0
    assert motion.t[-1] == motion.end_time
    events = {*motion.handoff_times, *motion.trajectory.start[1:]}
    events |= {*motion.reversals.time, *motion.extrema.time}
    assert events <= set(motion.t)
    even = np.sort([*set(motion.t) - events, *motion.handoff_times])
    steps = np.diff(even).reshape(3, -1)
    np.testing.assert_allclose(steps, steps[:, :1] + 0.0 * steps, rtol=1e-11)
    np.testing.assert_array_equal(motion.theta_dot, motion.at(motion.t).theta_dot)


def test_pieces_may_be_given_one_by_one_or_together(engine):
    motion = esc.simulate(drive(5, 1, crank_radius=0.02, mu=0.1), 3, engine=engine)
    bounds = np.append(motion.trajectory.start, motion.end_time)
    grid = np.linspace(bounds[:-1], bounds[1:], 7, axis=-1)
    pieces = np.arange(bounds.size - 1)
    together = motion.within(pieces[::-1, None], grid[::-1])
    for piece, times in enumerate(grid):
        alone = motion.within(piece, times)
        for name in ("t", "theta", "theta_dot", "theta_ddot", "phi_ddot", "contact_force"):
            row = getattr(together, name)[pieces.size - 1 - piece]
            np.testing.assert_array_equal(row, getattr(alone, name))


def test_states_have_the_shape_of_their_times(engine):
    motion = esc.simulate(drive(), 2, engine=engine)
    for shape in ((), (1,), (0,), (3, 1, 2)):
        state = motion.at(np.full(shape, 0.5 * motion.end_time))
        assert state.t.shape == state.phi_ddot.shape == state.contact_moment.shape == shape
        assert state.contact_force is None
    assert motion.at(motion.end_time).theta_dot == pytest.approx(motion.handoff_velocities[-1])


@pytest.mark.parametrize(
    "settings", [{"rtol": 1e-7}, {"engine": "ivp", "method": "RK45", "rtol": 1e-6}]
)
def test_a_solver_stands_for_the_separate_settings(settings):
    scene, solver = drive(4, mu=0.3), esc.Solver(**settings)
    apart, together = esc.simulate(scene, 2, **settings), esc.simulate(scene, 2, solver=solver)
    assert (together.engine, together.rtol) == (apart.engine, apart.rtol)
    np.testing.assert_array_equal(together.handoff_times, apart.handoff_times)
    cycle = esc.terminal(scene, solver=solver)
    assert cycle.period == esc.terminal(scene, **settings).period
    study = esc.sweep(scene, solver=solver, friction=[0.3])
    assert study.configuration["solver"] == {"engine": "energy"} | settings
    assert study.results["period"] == pytest.approx(cycle.period, rel=1e-12)


CALLS = {
    "simulate": lambda **settings: esc.simulate(drive(4), 1, **settings),
    "terminal": lambda **settings: esc.terminal(drive(4), **settings),
    "sweep": lambda **settings: esc.sweep(drive(4), friction=[0.3], **settings),
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_a_solver_comes_alone(call):
    for more, said in (({"rtol": 1e-9}, "rtol"), ({"engine": "ivp", "rtol": 1e-9}, "engine, rtol")):
        with pytest.raises(InvalidValue, match=f"^solver must not come with {said}, got both; "):
            call(solver=esc.Solver(), **more)
    with pytest.raises(InvalidValue, match="solver must be a Solver, got 'ivp'; give for example"):
        call(solver="ivp")


@pytest.mark.parametrize(
    "method",
    [pytest.param(m, marks=[pytest.mark.slow] * (m == "Radau")) for m in METHODS],
)
def test_every_method_of_solve_ivp_serves(method):
    rtol = 1e-7 if method in ("DOP853", "LSODA", "RK45") else 1e-3
    found = esc.simulate(drive(), 1, engine="ivp", method=method, rtol=rtol)
    best = esc.simulate(drive(), 1)
    np.testing.assert_allclose(found.handoff_times, best.handoff_times, rtol=10.0 * rtol)


def test_a_shorter_longest_step_is_kept():
    motion = esc.simulate(drive(), 1, engine="ivp", rtol=1e-3, max_step=0.01)
    for piece in motion.trajectory.solution:
        assert np.diff(piece.dense.ts).max() <= 0.01 * piece.unit * (1.0 + 1e-12)


@pytest.mark.parametrize(
    ("method", "steps", "order"),
    [
        ("RK23", (64, 128, 256), 3.0),
        ("RK45", (64, 128, 256), 5.0),
        ("DOP853", (32, 40, 50, 64), 8.0),
    ],
)
def test_no_event_costs_a_method_its_order(method, steps, order):
    """By regression over a dead centre, a reversal and a handoff; a corner would leave 1 or 2.

    Means over several starts, as an error that passes through zero feigns order.
    """
    scene, errors = drive(rho=1.0, mu=0.2), []
    starts = np.linspace(0.5, 2.0, 4)
    exact = [esc.simulate(scene, 1, initial_speed=v, rtol=1e-13).handoff_times[0] for v in starts]
    for count in steps:
        fixed = {"rtol": 0.9, "atol": 1e6, "engine": "ivp", "method": method}
        found = [
            esc.simulate(scene, 1, initial_speed=v, max_step=t / count, **fixed).handoff_times[0]
            for v, t in zip(starts, exact, strict=True)
        ]
        errors.append(np.sqrt(np.mean((np.array(found) / exact - 1.0) ** 2)))
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert -slope == pytest.approx(order, abs=1.0)


# events


# the Painleve limit


@pytest.mark.parametrize("n", [5, 8, 40])
def test_the_limit_itself_is_beyond_the_limit(n):
    """Also where the two factors of the limit have their extremes at one angle: rho = T^2."""
    rho = math.tan(math.pi / n) ** 4
    wheel = esc.Geneva(n)
    mu = critical_friction(wheel, esc.Inertia(rho, 1.0))
    for friction in (mu, np.nextafter(mu, 2.0 * mu)):
        scene = esc.Escapement(wheel, esc.Inertia(rho, 1.0), 1.0, float(friction))
        for engine in BOTH:
            assert esc.simulate(scene, 1, engine=engine).status is Status.PAINLEVE
        assert esc.terminal(scene).status is Status.PAINLEVE
        study = esc.sweep(scene, friction=[friction])
        assert study.results["status"].tolist() == [Status.PAINLEVE]
    below = replace(scene, friction=float(mu * (1.0 - 1e-6)))
    assert esc.simulate(below, 1).status is Status.OK


@pytest.mark.parametrize("path", [[1.0, 2.0], np.ones(9)])
def test_a_path_that_is_none_is_refused(path):
    with pytest.raises(InvalidValue, match=r"mechanism\.path must be a Path"):
        esc.Escapement(Plain(path, 0.5), INERTIA, 0.01)


def test_an_engagement_is_never_solved_less_accurately_than_the_help_says():
    """A larger tolerance gives the same bits, and a smaller one gives others."""
    found = [
        esc.simulate(drive(), 1, rtol=rtol).handoff_times[0]
        for rtol in (0.5, 1e-4, LOOSEST, 1e-3 * LOOSEST, 1e-13)
    ]
    assert found[0] == found[1] == found[2] != found[3]
    assert found[0] == pytest.approx(found[-1], rel=LOOSEST)


@pytest.mark.parametrize("piece", [-1, 9, [0, 9], 0.5, True, "first"])
def test_a_piece_that_is_not_there_is_refused(piece):
    motion = esc.simulate(drive(), engagements=3)
    assert motion.trajectory.start.size == 9
    with pytest.raises(InvalidValue, match="piece must be whole and from 0 to 8, got"):
        motion.within(piece, np.zeros(2))
    assert motion.within(8, motion.end_time).theta_dot == motion.at(motion.end_time).theta_dot


@pytest.mark.parametrize("changes", [{}, {"load_torque": 0.1}, {"follower_viscous": 0.02}])
def test_the_cycle_of_terminal_is_what_simulate_gives(changes):
    timer = replace(drive(), **changes)
    cycle = esc.terminal(timer)
    motion = esc.simulate(timer, 1, initial_speed=cycle.handoff_velocity)
    for name in ("end_time", "handoff_times", "handoff_velocities"):
        expected = getattr(motion, name)
        np.testing.assert_allclose(getattr(cycle.motion, name), expected, rtol=2e-12, atol=0.0)


DEFAULT = {"energy": 1e-12, "ivp": 1e-10}


def test_a_duration_may_end_anywhere(engine):
    """In the first instant, in a dwell, on a handoff or a bit beside it."""
    # times and durations meet in other units, where their last bits may differ
    scene = esc.Escapement(esc.Geneva(5, 1), INERTIA, 0.0113, friction=0.1)
    whole = esc.simulate(scene, 4, engine=engine)
    dwell = whole.trajectory.start[np.nonzero(whole.trajectory.sign == 0.0)[0][0]]
    handoffs = whole.handoff_times[:3]
    bits = [np.nextafter(handoffs, side) for side in (0.0, math.inf)]
    for duration in (1e-9, 0.5 * (dwell + handoffs[0]), *handoffs, *np.concatenate(bits)):
        cut = esc.simulate(scene, duration=float(duration), engine=engine)
        assert cut.end_time == duration
        done = np.count_nonzero(whole.handoff_times <= duration)
        # at the very handoff the last bit decides, which the reference need not have
        beside = np.isclose(handoffs, duration, rtol=1e-12).any()
        assert cut.handoff_times.size == done or (engine == "ivp" and beside)
        expected = float(whole.at(duration).theta_dot)
        assert cut.at(duration).theta_dot == pytest.approx(expected, rel=1e-8)
        # of the first instant's work hardly a digit is left
        assert abs(cut.ledger.residual) <= 10.0 * DEFAULT[engine] or duration < 1e-8


def local(motion, events):
    return events.theta - events.engagement * motion.escapement.mechanism.cell_angle


def locus(scene, angle, w):
    """Angles near `angle` where rho (g' w + load) + g vanishes; w' = 2/rho there."""
    rho = scene.inertia.driver

    def law(theta):
        found = scene.mechanism.transmission(theta)
        return rho * (found.dg * (w + 2.0 * (theta - angle) / rho) + scene.load_torque) + found.g

    return brentq(law, angle - 1e-4, angle + 1e-4, xtol=1e-15)


@pytest.mark.parametrize(
    ("scene", "speed"),
    [
        (drive(), 0.0),
        (drive(8, 1, rho=1118.9, mu=3e-4, load=0.0023), 0.0766),
        (drive(5, 1, rho=29764.0, mu=4e-6, internal=True), 0.0),
        (drive(7, 1, rho=7950.0, mu=0.0), 6.06),
        (drive(4, 4, rho=10025.0), 5276.0),
        (drive(3, 6, rho=71.42325839141594, mu=0.0, load=0.38494331400811665), 8603.179701318482),
        (drive(4, 4, rho=225.70131618371116, load=0.031121924629788092), 298434.51804616104),
        (drive(8, 1, rho=58.386705256164646, load=0.00017080852328393728), 77420.46942690747),
        (drive(12, 1, rho=173380.65260580444, internal=True), 25919.406470347898),
        (drive(6, 1, rho=469773.1507, mu=0.000294256, internal=True), 3824.8042684),
    ],
)
def test_reversals_are_located_exactly(scene, speed):
    """One an engagement; of a fast or a heavy driver it lies close behind dead centre."""
    fast, judge = (esc.simulate(scene, 4, engine=e, initial_speed=speed, rtol=1e-11) for e in BOTH)
    np.testing.assert_allclose(judge.handoff_times, fast.handoff_times, rtol=1e-10)
    for motion in (fast, judge):
        turns = motion.reversals
        assert turns.engagement.tolist() == [0, 1, 2, 3]
        found = local(motion, turns)
        exact = [locus(scene, *at) for at in zip(found, turns.theta_dot**2, strict=True)]
        np.testing.assert_allclose(found, exact, rtol=0.0, atol=1e-10)


def test_a_light_driver_keeps_the_tolerance_asked_for():
    for scene in (drive(3, 6, rho=1e-7, mu=1e-4), drive(4, 4, rho=1e-8, mu=1e-4)):
        fast, judge = (esc.simulate(scene, 3, engine=e, rtol=1e-11) for e in BOTH)
        np.testing.assert_allclose(
            judge.handoff_velocities, fast.handoff_velocities, rtol=1e-10, err_msg="10 rtol"
        )


@pytest.mark.parametrize(
    ("scene", "speed"),
    [
        (drive(4, 4, rho=8.1037, load=0.0039546), 5.4357),
        (drive(3, 5, rho=57.011, load=0.0049955), 1.27843),
        (drive(3, 1, rho=39.181), 0.0),
    ],
)
def test_the_ledger_closes_to_the_tolerance(engine, scene, speed):
    motion = esc.simulate(scene, 4, engine=engine, initial_speed=speed, rtol=1e-11)
    assert abs(motion.ledger.residual) <= 1e-10


@pytest.mark.parametrize(
    ("scene", "speed"),
    [
        (drive(30, 1, rho=623.69, mu=34354.52, load=27.3742), 0.49077),
        (drive(6, 3, rho=0.018736, load=46.42253), 0.101012),
        (drive(3, 4, rho=0.004686, mu=0.0666427, load=44.36695), 0.206728),
        (drive(4, 4, rho=907.63, mu=333.789, load=0.72528), 0.110035),
    ],
)
def test_the_ledger_of_a_stop_closes(scene, speed):
    """But for what the rounding of the stop's angle is worth against load and friction."""
    motion = esc.simulate(scene, 4, initial_speed=speed)
    assert motion.status is Status.STALL
    found = scene.mechanism.transmission(np.linspace(*scene.mechanism.breaks[::2], 801))
    resistance = 1.0 + scene.load_torque * (found.g + scene.friction * np.abs(found.u)).max()
    there = max(motion.ledger.work, 0.5 * scene.inertia.driver * speed**2)
    assert abs(motion.ledger.residual) <= 1e-11 + 1e-12 * resistance / there
