"""Two reversals, or two extrema, close together: neither engine may pass over them.

Without friction the speed over the angle is known in closed form, and with it the initial
speed at which the contact force, or the acceleration, touches zero.
"""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import escapement as esc
from random_drives import drive

pytestmark = pytest.mark.slow


class Frictionless:
    """Contact force and acceleration, but for factors above zero: a + b E, E = J w at entry."""

    def __init__(self, wheel, inertia, load):
        self.wheel, self.inertia, self.load = wheel, inertia, load
        self.entry, self.exit = wheel.breaks[0], wheel.breaks[-1]
        self.start = float(wheel.follower_angle(self.entry))

    def parts(self, theta, what):
        ratio = self.wheel.transmission(theta)
        g, rate, rho = ratio.g, ratio.dg, self.inertia
        turned = np.asarray(self.wheel.follower_angle(theta)) - self.start
        gained = 2.0 * (theta - self.entry - self.load * turned)
        share = rate / (rho + g * g)
        if what == "force":
            return rho * (share * gained + self.load) + g, rho * share
        return 1.0 - g * (share * gained + self.load), -g * share

    def touching(self, what):
        """Least E at which it is zero somewhere inside, and where; None if first at an end."""

        def least(theta):
            constant, slope = self.parts(theta, what)
            with np.errstate(all="ignore"):
                return np.where(slope < 0.0, -constant / slope, np.inf)

        grid = np.linspace(self.entry, self.exit, 4001)
        values = least(grid)
        k = int(np.argmin(np.where(values > 0.0, values, np.inf)))
        if not 5 < k < 3995 or not np.isfinite(values[k - 1 : k + 2]).all():
            return None
        found = minimize_scalar(
            lambda x: float(least(x)), bounds=(grid[k - 1], grid[k + 1]), method="bounded",
            options={"xatol": 1e-12},
        )  # fmt: skip
        return float(found.fun), float(found.x)

    def pair(self, what, energy, middle):
        def value(theta):
            constant, slope = self.parts(theta, what)
            return float(constant + slope * energy)

        return [brentq(value, self.entry, middle), brentq(value, middle, self.exit)]


def cases(what, count):
    random = np.random.default_rng(len(what))
    while count > 0:
        internal = bool(random.random() < 0.5)
        slots = int(random.choice([3, 4, 5, 6, 8, 12, 20]))
        inertia, load = 10.0 ** random.uniform(-2.0, 2.0), random.uniform(0.01, 1.0)
        scene = Frictionless(esc.Geneva(slots, 1, internal), inertia, load)
        top = float(scene.wheel.transmission(np.linspace(scene.entry, scene.exit, 999)).g.max())
        scene = Frictionless(scene.wheel, inertia, load / top)
        touch = scene.touching(what)
        excess = 10.0 ** random.uniform(-7.0, -3.0)
        if touch is None or not touch[0] > 0.0:
            continue
        energy, at = touch[0] * (1.0 + excess), touch[1]
        try:
            expected = scene.pair(what, energy, at)
        except ValueError:
            continue
        # the driver must get there, and the pair be a pair: no other zero beside it
        grid = np.linspace(scene.entry, scene.exit, 20001)[1:-1]
        constant, slope = scene.parts(grid, what)
        signs = np.sign(constant + slope * energy)
        inside = (grid > expected[0]) & (grid < expected[1])
        turned = np.asarray(scene.wheel.follower_angle(grid)) - scene.start
        left = energy + 2.0 * (grid - scene.entry - scene.load * turned)
        if (left > 0.0).all() and (signs[~inside] > 0.0).all():
            yield scene, energy, expected
            count -= 1


@pytest.mark.parametrize("what", ["force", "acceleration"])
@pytest.mark.parametrize("engine", ["energy", "ivp"])
def test_a_pair_is_found_where_the_closed_form_has_it(what, engine):
    for scene, energy, expected in cases(what, 100 if engine == "energy" else 12):
        entry_ratio = float(scene.wheel.transmission(scene.entry).g)
        speed = np.sqrt(energy / (scene.inertia + entry_ratio**2))
        timer = esc.Escapement(scene.wheel, esc.Inertia(scene.inertia, 1.0), 1.0, 0.0, scene.load)
        motion = esc.simulate(timer, 1, initial_speed=speed, engine=engine)
        found = (motion.reversals if what == "force" else motion.extrema).theta
        near = found[(found > scene.entry + 1e-9) & (found < scene.exit - 1e-9)]
        assert near == pytest.approx(expected, abs=1e-6), (scene.wheel, scene.inertia, scene.load)


@pytest.mark.parametrize(
    ("slots", "inertia", "friction", "load", "speed"),
    [
        (4, 5.0, 0.5, 0.37, 0.12065),
        (4, 14.606151221241705, 3.726891127293215, 0.12967044109526968, 0.0414),
        (100, 0.11379251425400713, 3.535209570940652, 10.023919222737323, 17.74156477897008),
        # the first of the two a hair behind the middle of the way out
        (6, 77.1660000212392, 8.676917340368181, 0.050086541193986145, 0.12167297189104886),
    ],
)
def test_with_friction_the_speed_depends_on_it(slots, inertia, friction, load, speed):
    scene = drive(slots, 1, inertia, friction, load)
    one = esc.simulate(scene, 1, initial_speed=speed)
    two = esc.simulate(scene, 1, initial_speed=speed, engine="ivp", rtol=1e-12)
    assert one.reversals.theta == pytest.approx(two.reversals.theta, abs=1e-8)
    assert len(one.reversals.theta) == 2
    assert one.handoff_velocities == pytest.approx(two.handoff_velocities, rel=1e-12)
    assert one.handoff_times == pytest.approx(two.handoff_times, rel=1e-12)
    assert abs(one.ledger.residual) < 1e-14


def test_a_pair_a_hair_behind_the_edge_of_a_panel_is_one():
    """At sixteenths of the engagement, where the fast engine's panels end."""
    one = drive(8, 1, 21.229480106477777, 0.0, 0.5605460519473697)
    two = drive(4, 1, 19.59796696558348, 0.0, 2.101616849446852, internal=True)
    motions = [
        (esc.simulate(one, 1, initial_speed=0.8372590709099732, engine=engine).reversals.theta,
         esc.simulate(two, 1, initial_speed=2.348679211668878, engine=engine).extrema.theta)
        for engine in ("energy", "ivp")
    ]  # fmt: skip
    for fast, reference in zip(*motions, strict=True):
        assert len(fast) == 2
        assert fast == pytest.approx(reference, abs=1e-6)


@pytest.mark.parametrize("friction", [0.0, 0.002])
@pytest.mark.parametrize("speed", [299.0375, 299.04, 299.05, 299.1])
def test_the_last_step_of_a_piece_is_looked_through(friction, speed):
    scene = drive(1000, 1, 1.2811205572454039, friction, 280.9483327670186)
    one, two = (esc.simulate(scene, 1, initial_speed=speed, engine=e) for e in ("energy", "ivp"))
    assert len(one.reversals.theta) == (1 if speed > 299.042 else 2)
    assert one.reversals.theta == pytest.approx(two.reversals.theta, abs=1e-7)


@pytest.mark.parametrize(
    ("inertia", "friction"),
    [(0.7436058826003106, 0.7153156866920372), (2.697559013652471, 6.6148256530536775)],
)
def test_a_pair_of_extrema_may_decide_when_a_motion_has_settled(inertia, friction):
    scene = drive(6, 1, inertia, friction, 0.0)
    one, two = (esc.terminal(scene, engine=engine) for engine in ("energy", "ivp"))
    assert one.settling_time == pytest.approx(two.settling_time, rel=1e-9)
    study = esc.sweep(scene, friction=[friction])
    assert study.results["settling_time"][0] == pytest.approx(two.settling_time, rel=1e-9)
