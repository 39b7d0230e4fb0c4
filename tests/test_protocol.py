"""What is asked of a mechanism and of a trajectory: defaults, and classes of a user's own."""

from dataclasses import dataclass, field

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.dynamics.trajectory import Trajectory
from escapement.measurement.positions import position, slope
from escapement.mechanisms.protocol import Mechanism
from escapement.model.numbers import numbers_of, with_number
from escapement.outlines.parts import parts_of

INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
WHEEL = esc.Geneva(5)


@dataclass(frozen=True)
class Own(Mechanism):
    """A wheel of which only what a mechanism must give is known."""

    wheel: esc.Geneva = WHEEL
    number: float = field(default=1.0)

    @property
    def cell_angle(self):
        return self.wheel.cell_angle

    @property
    def breaks(self):
        return self.wheel.breaks

    @property
    def follower_step(self):
        return self.wheel.follower_step

    @property
    def path(self):
        return self.wheel.path

    def follower_angle(self, theta):
        return self.wheel.follower_angle(theta)


class Unrelated:
    """Attributes of a mechanism, in a class that is not derived from one."""

    cell_angle, breaks, follower_step = WHEEL.cell_angle, WHEEL.breaks, WHEEL.follower_step
    path, follower_angle = WHEEL.path, WHEEL.follower_angle


def timer(mechanism, **numbers):
    return esc.Escapement(mechanism, INERTIA, 0.0113, friction=0.2, **numbers)


@pytest.mark.parametrize("engine", ["energy", "ivp"])
def test_a_mechanism_of_ones_own_moves_like_the_wheel_whose_path_it_has(engine):
    own, wheel = (esc.simulate(timer(m), 4, engine=engine) for m in (Own(), WHEEL))
    np.testing.assert_array_equal(own.handoff_times, wheel.handoff_times)
    np.testing.assert_array_equal(own.contact_moment, wheel.contact_moment)
    assert own.contact_force is None
    assert own.impacts.time.size == 0
    assert own.ledger.residual == wheel.ledger.residual


def test_figures_and_studies_of_a_mechanism_of_ones_own_are_those_of_the_wheel():
    own, wheel = timer(Own()), timer(WHEEL)
    figures = [esc.terminal(one).as_dict() for one in (own, wheel)]
    for found in figures:  # a mechanism without slots has no pins whose loads could be counted
        del found["pin_load_frequency"]
    assert str(figures[0]) == str(figures[1])
    assert numbers_of(own) == numbers_of(wheel)
    assert with_number(own, "friction", 0.1).friction == 0.1
    studies = [esc.sweep(one, torque=[0.01, 0.02]).results for one in (own, wheel)]
    np.testing.assert_array_equal(studies[0]["period"], studies[1]["period"])
    drives = [esc.index(m, 10.0, 0.01, follower_inertia=5.65e-6) for m in (Own(), WHEEL)]
    assert drives[0].torque_max == pytest.approx(drives[1].torque_max, rel=1e-9)
    assert drives[0].moment_deviation == 0.0


def test_angles_of_a_mechanism_of_ones_own_are_those_of_the_wheel():
    theta = np.linspace(*WHEEL.breaks[::2], 50)
    np.testing.assert_array_equal(position(Own(), theta), position(WHEEL, theta))
    np.testing.assert_array_equal(slope(Own(), theta), slope(WHEEL, theta))
    assert Own().report() == pytest.approx({key: WHEEL.report()[key] for key in Own().report()})


def test_what_a_mechanism_of_ones_own_lacks_is_refused_by_name():
    for numbers, rule in (
        ({"stiffness": 1e7}, "stiffness must be left out for a mechanism without a length"),
        ({"efficiency": 0.9}, "efficiency must be 1 for a slotted mechanism"),
    ):
        with pytest.raises(InvalidValue, match=rule):
            timer(Own(), **numbers)
    with pytest.raises(InvalidValue, match="Own has no parts that could be drawn"):
        parts_of(Own())


def test_a_class_that_is_not_derived_from_the_base_is_told_to_be():
    for use in (timer, lambda it: esc.index(it, 10.0, 0.01, follower_inertia=5.65e-6)):
        with pytest.raises(InvalidValue, match="a class of your own is derived from Mechanism"):
            use(Unrelated())


def test_a_trajectory_of_ones_own_answers_what_a_motion_asks():
    solved = esc.simulate(timer(WHEEL), 2)

    class Told(Trajectory):
        """The pieces of a motion, and the states within one of them."""

        start, engagement = solved.trajectory.start, solved.trajectory.engagement
        sign, losses = solved.trajectory.sign, solved.trajectory.losses
        reversals, extrema = solved.trajectory.reversals, solved.trajectory.extrema

        def state(self, piece, t):
            return solved.trajectory.states(np.full(t.size, piece), t)

    told = esc.Motion(
        solved.escapement, "own", solved.rtol, Told(), solved.end_time, solved.handoff_times,
        solved.handoff_velocities, solved.status, solved.message,
    )  # fmt: skip
    np.testing.assert_array_equal(told.theta_dot, solved.theta_dot)
    assert told.ledger == solved.ledger
    np.testing.assert_array_equal(told.slide_changes.time, solved.slide_changes.time)


@pytest.mark.parametrize("speed", [0.0, 300.0])
def test_the_reference_refuses_a_duration_that_it_would_take_hours_for(speed):
    case = esc.Escapement(esc.Geneva(4), INERTIA, 0.0113, friction=0.35)
    most = esc.simulate(case, 10_000, initial_speed=speed).end_time
    with pytest.raises(InvalidValue, match="of at most 10000 engagements") as refused:
        esc.simulate(case, duration=1e9, engine="ivp", initial_speed=speed)
    told = float(str(refused.value).partition("here about ")[2].split()[0])
    assert told == pytest.approx(most, rel=0.01)
