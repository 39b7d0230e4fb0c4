"""Gear-driven wheels with imperfect parts: explicit positions, balances of power, both engines."""

import math

import mpmath as mp
import numpy as np
import pytest

import escapement as esc
from escapement.base.status import Status
from escapement.dynamics.law import left_by_impact
from escapement.mechanisms.slotted import pose_at
from imperfect_bodies import hand_over
from planets import Planet, Touch, by_power
from two_bodies import BOTH, close, law, random_drive

FIXED = 0.05
CURVES = [
    ("hypocycloid", 7, 1, 1),
    ("hypocycloid", 9, "3/2", 1),
    ("epicycloid", 6, 1, 2),
    ("epicycloid", 5, "1/2", 3),
    ("contracted-hypocycloid", 7, 1, 1),
    ("pericycloid", 6, 1, 1),
]


def imperfect(rng, curve, stations, lobes, pins, size=1e-3, **rest):
    """A wheel with errors up to `size` times its closest radius."""
    perfect = esc.GearDriven(stations, lobes, curve, pins, fixed_radius=FIXED)
    closest = FIXED * min(perfect.closest_radius_over_fixed, perfect.entry_radius_over_fixed)
    offsets = size * closest * rng.uniform(-1.0, 1.0, perfect.slots)
    errors = {"centre_distance_error": size * closest * rng.uniform(-1.0, 1.0)}
    errors |= {"slot_offsets": tuple(offsets), "pin_radius": 0.3 * FIXED * perfect.widest_pin}
    return esc.GearDriven(stations, lobes, curve, pins, fixed_radius=FIXED, **errors | rest)


class Pair:
    """A pin and its slot: what wheel angle the pin asks for at a carrier angle, in full turns."""

    def __init__(self, wheel, k):
        self.dead, self.step = k * wheel.cell_angle, k * wheel.follower_step
        offset = wheel.slot_offsets[k % wheel.slots]
        self.planet = Planet(wheel, self.dead, offset)

    def asked(self, theta):
        def angle(x):
            # a carrier that points back may be longer than the arm
            middle = (self.planet.carrier + self.planet.arm) * mp.expj(self.dead)
            return self.planet.sense * mp.arg(self.planet.slot(x)[0] / middle)

        return self.step + float(angle(theta)), float(mp.diff(angle, theta))


@pytest.fixture(autouse=True)
def thirty_digits():
    with mp.workdps(30):
        yield


@pytest.mark.parametrize("curve", CURVES)
def test_every_engagement_has_the_path_of_its_pin_and_slot(curve):
    wheel = imperfect(np.random.default_rng(len(curve[0])), *curve)
    k_ratio = float(wheel.gear_ratio)
    sense = Pair(wheel, 0).planet.sense
    for k in range(2 * wheel.slots):
        pair, meeting = Pair(wheel, k), wheel.pairs[k % len(wheel.pairs)]
        # one of the pins is at dead centre, and a slot stands there: the same one in each round
        pins = k_ratio * pair.dead * wheel.pins / (2.0 * math.pi)
        assert pins == pytest.approx(round(pins), abs=1e-9)
        slots = wheel.slots * (pair.dead - float(sense) * pair.step) / (2.0 * math.pi)
        assert slots == pytest.approx(round(slots), abs=1e-9)
        first = Pair(wheel, k % wheel.slots)
        turns = (pair.dead - first.dead - float(sense) * (pair.step - first.step)) / (2.0 * math.pi)
        assert turns == pytest.approx(round(turns), abs=1e-9)
        for x in np.linspace(meeting.edges[0], meeting.edges[-1], 5):
            planet, theta = pair.planet, pair.dead + x
            g, u, dg, radius = pose_at(meeting.path, x)
            expected = planet.ratio(theta), planet.ratio(theta, 2), planet.slot(theta)[1] / FIXED
            expected = *expected, planet.slide(theta) / FIXED
            close((g, dg, radius, u * radius), [float(x) for x in expected], 1.0, 1e-11)
            asked = pair.asked(theta)[0] - pair.step
            assert meeting.follower_angle(x) == pytest.approx(asked, abs=1e-13)


@pytest.mark.parametrize("curve", CURVES)
def test_pins_hand_over_by_the_rule(curve):
    wheel = imperfect(np.random.default_rng(7), *curve, 3e-3)
    meetings = wheel.pairs
    for k in range(len(meetings)):
        a, b = Pair(wheel, k), Pair(wheel, k + 1)
        ends = hand_over(a, b, a.dead, b.dead, math.pi / abs(float(wheel.gear_ratio)))
        one, two = meetings[k], meetings[(k + 1) % len(meetings)]
        assert two.kind == ends.kind
        assert two.jump == pytest.approx(ends.jump, abs=1e-12)
        dead = k * wheel.cell_angle
        assert dead + one.edges[-1] == pytest.approx(ends.leaves, abs=1e-10)
        starts = dead + wheel.cell_angle + two.edges[0]
        assert starts == pytest.approx(ends.starts, abs=1e-10)


@pytest.mark.parametrize("curve", CURVES)
def test_the_law_and_the_blow_follow_from_the_power_that_is_lost(curve):
    rng = np.random.default_rng(len(curve[0]) + 1)
    wheel = imperfect(rng, *curve)
    drive = random_drive(rng, mechanism=wheel)
    for k in range(min(4, len(wheel.pairs))):
        planet, scene = Planet(wheel, 0.0, wheel.slot_offsets[k % wheel.slots]), drive.scenes[k]
        theta = scene.edges[0] + (scene.edges[-1] - scene.edges[0]) * rng.uniform(0.03, 0.97)
        speed = 1.0 / drive.time_unit
        found = {side: by_power(drive, planet, theta, speed, side) for side in BOTH}
        (side,) = [side for side in BOTH if found[side][1] > 0.0]
        acceleration, force, sliding = found[side]
        computed = law(drive, theta, speed, side, k)
        torques = drive.torque + drive.inertia.follower * speed**2
        close(computed[0], acceleration, torques / drive.inertia.driver)
        close(computed[1], side * force, torques / FIXED)
        close(computed[2]["friction"] / abs(computed[1]), drive.friction * sliding * speed)
        # an impact at the entry: impulse of the wheel, and power lost, for a normal impulse of 1
        start = float(scene.edges[0]) + 0.1
        touch = Touch(planet, start, wheel.pin_radius, 1.0)
        g = planet.ratio(start)
        lever, lost = touch.losses(drive, g, 1.0)
        own = drive.inertia
        left = own.driver / (own.driver + own.follower * g * (g + lost / lever))
        edges = np.array([start, scene.edges[-1]])
        assert left_by_impact(scene._replace(edges=edges)) == pytest.approx(float(left), rel=1e-12)


def test_a_pin_that_misses_its_slot_ends_in_a_status():
    wheel = esc.GearDriven(7, 1, fixed_radius=FIXED, centre_distance_error=-0.9 * FIXED)
    cycle = esc.terminal(esc.Escapement(wheel, esc.Inertia(5e-6, 5e-6), 0.01, 0.0))
    assert cycle.status is Status.INVALID
    assert "pin 0 cannot drive slot 0" in cycle.message
