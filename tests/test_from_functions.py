"""Mechanisms from functions: those of known mechanisms have their numbers."""

import math
import pickle

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue

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
    theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 401)
    assert np.abs(own.transmission(theta).g - wheel.transmission(theta).g).max() < 1e-10
    one, other = (
        esc.terminal(esc.Escapement(mechanism, INERTIA, 0.0113, **LOSSES))
        for mechanism in (own, wheel)
    )
    for name in FIGURES:
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-9), name


def test_engines_agree_and_gears_lose_power():
    own = esc.from_functions(lambda x: x - 0.3 * np.sin(2.0 * x), cell_angle=math.pi)
    timer = esc.Escapement(own, INERTIA, 0.0113, efficiency=0.9)
    fast, slow = (esc.terminal(timer, engine=engine) for engine in ("energy", "ivp"))
    assert fast.period == pytest.approx(slow.period, rel=1e-8)
    assert pickle.loads(pickle.dumps(own)).follower_step == own.follower_step


@pytest.mark.parametrize(("function", "options", "told"), [
    (lambda x: np.abs(x - 0.2) + 2.0 * x, {}, "name the corners of a transmission"),
    (lambda x: np.sin(3.0 * x) + x, {}, "a derivative of one sign"),
    (lambda x: 1.0, {}, "for each of an array"),
    (lambda x: x, {"cell_angle": 0.0}, "cell_angle must be greater than 0"),
    (lambda x: x, {"breaks": (1.0, 0.5)}, "ascending"),
    (lambda x: x, {"breaks": (-2.0, 2.0)}, "at most a cell apart"),
])  # fmt: skip
def test_mistakes_are_told(function, options, told):
    with pytest.raises(InvalidValue, match=told):
        esc.from_functions(function, **{"cell_angle": math.pi} | options)


def test_kinks_that_are_named_are_no_mistake():
    bent = esc.from_functions(
        lambda x: np.abs(x - 0.2) + 2.0 * x, cell_angle=2.0, breaks=(-1.0, 0.2, 1.0)
    )
    assert bent.transmission(np.array([0.0, 0.5])).g == pytest.approx([1.0, 3.0])
