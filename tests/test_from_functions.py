"""Mechanisms from functions: those of known mechanisms have their numbers."""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.status import Status

INERTIA = esc.Inertia(3e-6, 5e-6)
LOSSES = {"load_torque": 1e-3, "follower_viscous": 2e-5, "driver_drag": 1e-8}
FIGURES = ("period", "velocity_max", "velocity_min", "handoff_velocity", "contact_moment_max")


@pytest.mark.parametrize("wheel", [
    esc.Geneva(4), esc.Geneva(6, pins=1), esc.Geneva(5, internal=True), esc.Geneva(8, pins=2)
])  # fmt: skip
def test_the_functions_of_a_geneva_have_its_numbers(wheel):
    own = esc.from_functions(
        wheel.follower_angle, cell_angle=wheel.cell_angle,
        breaks=(wheel.breaks[0], wheel.breaks[-1]),
    )  # fmt: skip
    assert own.follower_step == pytest.approx(wheel.follower_step, rel=1e-12)
    turns = np.linspace(-7.0, 9.0, 301)
    assert own.follower_angle(turns) == pytest.approx(wheel.follower_angle(turns), abs=1e-10)
    assert np.abs(own.transmission(turns).g - wheel.transmission(turns).g).max() < 1e-10
    assert not own.transmission(turns).u.any()
    one, other = (
        esc.terminal(esc.Escapement(mechanism, INERTIA, 0.0113, **LOSSES))
        for mechanism in (own, wheel)
    )
    for name in FIGURES:
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-9), name


def slotted(wheel):
    """A Geneva wheel as two functions."""
    return esc.from_functions(
        wheel.follower_angle, cell_angle=wheel.cell_angle,
        breaks=(wheel.breaks[0], wheel.breaks[-1]),
        pin_distance=lambda x: wheel.crank_radius * wheel.radius(x),
    )  # fmt: skip


@pytest.mark.parametrize("numbers", [
    {}, {"follower_bearing_friction": 0.1, "follower_bearing_radius": 3e-3}
])  # fmt: skip
@pytest.mark.parametrize("engine", ["energy", "ivp"])
def test_a_pin_whose_distance_is_known_has_the_friction_of_a_geneva(engine, numbers):
    for slots, internal in ((4, False), (5, True)) if engine == "energy" else ((4, False),):
        wheel = esc.Geneva(slots, internal=internal, crank_radius=0.03)
        own = slotted(wheel)
        assert not own.meshed
        one, other = (
            esc.terminal(
                esc.Escapement(mechanism, INERTIA, 0.0113, friction=0.3, **LOSSES, **numbers),
                engine=engine,
            )
            for mechanism in (own, wheel)
        )
        for name in (*FIGURES, "contact_force_max", "rise_time", "uniqueness_friction"):
            assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-9), name
        assert one.critical_friction == pytest.approx(other.critical_friction, rel=1e-9)


def test_a_slot_jams_at_its_limit_and_its_pin_turns_round():
    wheel = esc.Geneva(4, crank_radius=0.03)
    timers = [
        esc.Escapement(mechanism, esc.Inertia(3e-7, 5e-6), 0.0113, friction=0.35)
        for mechanism in (slotted(wheel), wheel)
    ]
    one, other = (esc.simulate(timer, 3) for timer in timers)
    assert one.slide_changes.time == pytest.approx(other.slide_changes.time, rel=1e-9)
    assert one.ledger.friction == pytest.approx(other.ledger.friction, rel=1e-9)
    jammed = [esc.terminal(replace(timer, friction=0.5)) for timer in timers]
    assert [found.status for found in jammed] == [Status.PAINLEVE] * 2
    angle = math.radians(float(jammed[0].message.partition("met ")[2].split()[0]))
    at = wheel.transmission(np.array([angle - 1e-3, angle]))
    first, behind = (0.06 + at.g**2) / np.abs(at.g * at.u)  # the friction at which J vanishes
    assert angle > 0.0
    assert behind <= 0.5 < first


def test_a_quick_return_slides_both_ways():
    """Whitworth's: a crank inside the follower's circle, which turns once with it."""
    crank, apart = 0.03, 0.01

    own = esc.from_functions(
        lambda x: x - np.arctan2(apart * np.sin(x), crank + apart * np.cos(x)),
        cell_angle=2.0 * math.pi,
        pin_distance=lambda x: np.abs(apart + crank * np.exp(1j * x)),
    )
    assert own.breaks == pytest.approx((-math.pi, 0.0, math.pi), abs=1e-9)
    timer = esc.Escapement(own, INERTIA, 0.0113, friction=0.2)
    # the reference engine would need thousands of engagements to come near the cycle
    cycle = esc.terminal(timer)
    slow = esc.simulate(timer, 1, engine="ivp", initial_speed=cycle.handoff_velocity)
    assert slow.end_time == pytest.approx(cycle.period, rel=1e-8)
    assert slow.handoff_velocities[-1] == pytest.approx(cycle.handoff_velocity, rel=1e-8)
    assert own._repr_html_().startswith("<svg")


def test_engines_agree_and_gears_lose_power():
    own = esc.from_functions(lambda x: x - 0.3 * np.sin(2.0 * x), cell_angle=math.pi)
    timer = esc.Escapement(own, INERTIA, 0.0113, efficiency=0.9)
    fast, slow = (esc.simulate(timer, 3, engine=engine) for engine in ("energy", "ivp"))
    assert fast.handoff_times == pytest.approx(slow.handoff_times, rel=1e-8)
    assert pickle.loads(pickle.dumps(own)).follower_step == own.follower_step


@pytest.mark.parametrize(("function", "options", "told"), [
    (lambda x: np.abs(x - 0.2) + 2.0 * x, {}, "or name the corners"),
    (lambda x: np.sin(3.0 * x) + x, {}, "a derivative of one sign"),
    (lambda x: 1.0, {}, "for each of an array"),
    (lambda x: x, {"cell_angle": 0.0}, "cell_angle must be greater than 0"),
    (lambda x: x, {"breaks": (1.0, 0.5)}, "ascending"),
    (lambda x: x, {"breaks": (-2.0, 2.0)}, "at most a cell apart"),
    (lambda x: x, {"pin_distance": lambda x: x}, "pin_distance must be greater than 0"),
    (lambda x: x, {"pin_distance": lambda x: 2.0}, "for each of an array"),
    (lambda x: x, {"pin_distance": lambda x: 2.0 + np.abs(x - 0.2)}, "name the corners"),
])  # fmt: skip
def test_mistakes_are_told(function, options, told):
    with pytest.raises(InvalidValue, match=told):
        esc.from_functions(function, **{"cell_angle": math.pi} | options)


def test_kinks_that_are_named_are_no_mistake():
    bent = esc.from_functions(
        lambda x: np.abs(x - 0.2) + 2.0 * x, cell_angle=2.0, breaks=(-1.0, 0.2, 1.0)
    )
    assert bent.transmission(np.array([0.0, 0.5])).g == pytest.approx([1.0, 3.0])
