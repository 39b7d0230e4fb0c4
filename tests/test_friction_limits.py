"""Limits of friction of thick pins and rubbing journals, against a search in angle and friction.

The search knows the moments about both axes alone. At every driver angle it bisects the friction
at which the product of reduced inertia and lever vanishes on the rear wall, or the lever on the
front wall, and it looks again, ever more finely, where that is least.
"""

import math

import numpy as np
import pytest

import escapement as esc
from escapement.base.status import Status
from escapement.dynamics.painleve import friction_limits
from thick_pins import CRANK, nearest_of, random_timer

POINTS, LEAST, MOST = 401, 1e-9, 1e6


def positive(timer, theta, mu):
    """Whether J h of the rear wall and h of the front wall are positive at angles, by friction."""
    wheel, rho = timer.mechanism, timer.inertia.driver / timer.inertia.follower
    distance, sign, nearest = nearest_of(wheel.slots, wheel.internal)
    pin = distance + sign * np.exp(sign * 1j * theta)
    rate = 1j * np.exp(sign * 1j * theta)  # its derivative, for 1j sign^2 = 1j
    radius = np.abs(pin)
    g, out = (rate / pin).imag, (rate * pin.conj()).real / radius
    thick, more = timer.mechanism.pin_radius / CRANK, np.hypot(1.0, mu)
    driver = timer.driver_bearing_friction * timer.driver_bearing_radius / CRANK
    follower = timer.follower_bearing_friction * timer.follower_bearing_radius / CRANK
    slides = out - thick * (g - sign)
    lever = radius - np.sign(slides) * mu * thick + follower * more
    lost = mu * np.abs(slides) + (driver + follower * np.abs(g)) * more
    rear = (rho + g * g) * lever - np.abs(g) * lost
    return (rear > 0.0) & (nearest - mu * thick - follower * more > 0.0)


def searched(timer, low, high):
    """The least friction at which one of them vanishes between two angles."""
    least = math.inf
    for _ in range(3):
        theta = np.linspace(low, high, POINTS)
        good, bad = np.full(POINTS, LEAST), np.full(POINTS, MOST)
        for _ in range(46):
            middle = np.sqrt(good * bad)
            moves = positive(timer, theta, middle)
            good, bad = np.where(moves, middle, good), np.where(moves, bad, middle)
        k = int(np.argmin(bad))
        least = min(least, float(bad[k]))
        low, high = theta[max(k - 1, 0)], theta[min(k + 1, POINTS - 1)]
    return least


@pytest.mark.parametrize("seed", range(12))
def test_limits_are_those_of_a_fine_search(seed):
    timer = random_timer(np.random.default_rng(seed))
    end = timer.mechanism.breaks[-1]
    existence, uniqueness = friction_limits(timer)
    # large journals hold the mechanism without friction in the slot
    assert existence == pytest.approx(searched(timer, 0.0, end), rel=1e-9, abs=2.0 * LEAST)
    assert uniqueness == pytest.approx(searched(timer, -end, 0.0), rel=1e-9, abs=2.0 * LEAST)


@pytest.mark.parametrize("varied", ["driver_inertia", "pin_radius", "driver_bearing_radius"])
def test_a_study_jams_the_cases_that_jam_alone(varied):
    wheel = esc.Geneva(6, 1, crank_radius=CRANK, pin_radius=0.1 * CRANK)
    bearing = {"driver_bearing_friction": 0.1, "driver_bearing_radius": 0.1 * CRANK}
    timer = esc.Escapement(wheel, esc.Inertia(1e-6, 5e-6), torque=0.01, **bearing)
    limit = friction_limits(timer)[0]
    friction = limit * np.array([0.2, 0.9, 1.0 - 1e-9, 1.0 + 1e-9, 1.5])
    owner = {"driver_inertia": timer.inertia, "pin_radius": timer.mechanism}.get(varied, timer)
    nominal = getattr(owner, varied.removesuffix("_inertia"))
    axes = {varied: nominal * np.array([1.0, 0.5, 2.0]), "friction": friction}
    study = esc.sweep(timer, results=["jam_margin"], **axes)
    status, margin = study.results["status"], study.results["jam_margin"]
    # the limit depends on what varies, and stands beside the status
    assert ((status == Status.PAINLEVE) == (margin <= 0.0)).all()
    assert (status[0] == Status.PAINLEVE).tolist() == [False, False, False, True, True]
