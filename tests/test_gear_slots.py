"""Slots of gear-driven wheels, counted by following every pin of a rolling planet."""

import math
from fractions import Fraction

import numpy as np
import pytest

from escapement import GearDriven
from escapement.base.errors import InvalidValue
from escapement.mechanisms.gear_equation import CURVES
from escapement.synthesis import find_mechanisms

TURN = 2.0 * math.pi
LOBES = [Fraction(m, 2) for m in range(8)]
DISC, RING = (5, 7, 12), (24, 25, 27)
"""Stations; a ring has room for a second pin from 24 stations on."""
DRIVES = [
    (curve, pins, RING if "hypo" in curve else DISC)
    for curve in CURVES
    for pins in ((1, 2) if "hypo" in curve else (1, 2, 3))
]


def rolling_pins(wheel, theta):
    """Every pin of the planet at carrier angles, the pins along the last axis."""
    k, first, second = float(wheel.gear_ratio), wheel.arms.first, wheel.arms.second
    places = TURN * np.arange(wheel.pins) / wheel.pins
    angles = np.asarray(theta)[..., None]
    return first * np.exp(1j * angles) + second * np.exp(1j * ((1.0 - k) * angles + places))


def passages(wheel, count):
    """Direction in turns at which each passing lobe begins and ends, in the fixed frame.

    Of all pins it is the one nearest to dead centre that passes.
    """
    spacing = TURN / (wheel.pins * abs(float(wheel.gear_ratio)))
    at_centre = abs(wheel.arms.first + wheel.arms.second)
    place = np.linspace(-0.5, 0.5, 31) * wheel.alpha
    pins = rolling_pins(wheel, spacing * np.arange(count)[:, None] + place)
    passing = np.argmin(abs(abs(pins[:, 15]) - at_centre), axis=1)
    pin = pins[np.arange(count), :, passing]
    assert abs(pin[:, 15]) == pytest.approx(at_centre, rel=1e-9)
    return np.unwrap(np.angle(pin))[:, [0, -1]] / TURN


def entered(ends, unused):
    """Where pins enter in the wheel's frame, and how that wheel stands in every passage.

    While a pin is in its slot the wheel turns with it; else it is locked.
    """
    used = np.arange(len(ends)) % (unused + 1) == 0
    turned = np.cumsum(np.where(used, ends[:, 1] - ends[:, 0], 0.0))
    before = np.concatenate([[0.0], turned[:-1]])
    return np.unique(np.round((ends[used, 0] - before[used]) % 1.0, 7) % 1.0), before, used


def meets_a_slot(ends, slots, before, used):
    """Whether an unused lobe sweeps over one of the slots."""
    low, high = (np.sort(ends, axis=1) - before[:, None])[~used].T
    ahead = (slots[None, :] - low[:, None] + 1e-6) % 1.0
    return bool(np.any(ahead <= (high - low)[:, None] + 2e-6))


@pytest.mark.parametrize(("curve", "pins", "stations"), DRIVES)
def test_pins_enter_as_many_slots_as_the_wheel_has(curve, pins, stations):
    counted = refused = 0
    for n in stations:
        for m in LOBES:
            try:
                wheel = GearDriven(n, m, curve, pins)
            except InvalidValue:
                continue
            if wheel.through_centre:
                continue
            for unused in (0, 1, 2):
                # entries come round after pins * n * (denominator of m) at the latest
                ends = passages(wheel, (unused + 1) * pins * n * m.denominator + 1)
                slots, before, used = entered(ends, unused)
                if meets_a_slot(ends, slots, before, used):
                    with pytest.raises(InvalidValue, match="unused_lobes must let the pin"):
                        GearDriven(n, m, curve, pins, unused)
                    refused += 1
                else:
                    made = GearDriven(n, m, curve, pins, unused)
                    assert made.slots == len(slots)
                    lobe = TURN / abs(float(made.gear_ratio))
                    assert made.cell_angle == pytest.approx(lobe * (unused + 1) / pins)
                    assert made.motion_ratio == pytest.approx(made.alpha / made.cell_angle)
                    counted += 1
    assert counted > 20
    assert refused > 3


@pytest.mark.parametrize(
    ("n", "m", "curve", "pins", "slots", "of_the_cognate"),
    [
        (7, 11, "epicycloid", 2, 1, 2),
        (12, 5, "epicycloid", 6, 6, 3),
        (24, 5, "hypocycloid", 2, 6, 3),
        (12, 3, "hypocycloid", 1, 12, 12),
        (9, "1/2", "epicycloid", 1, 18, 18),
    ],
)
def test_cognates_of_several_pins_have_slots_of_their_own(n, m, curve, pins, slots, of_the_cognate):
    wheel = GearDriven(n, m, curve, pins)
    assert (wheel.slots, wheel.cognate.slots) == (slots, of_the_cognate)


def test_the_search_counts_the_slots_of_cognates():
    wishes = {"tolerance": 0.05, "curves": CURVES, "most_pins": 3, "most_unused": 0}
    found = find_mechanisms(7, 0.14, most_lobes=12, **wishes)
    few = find_mechanisms(7, 0.14, most_lobes=12, most_slots=1, **wishes)
    assert few
    assert [one.mechanism for one in few] == [one.mechanism for one in found if one.slots == 1]
    assert GearDriven(7, 11, "pericycloid", 2) not in [one.mechanism for one in few]
    assert GearDriven(7, 11, "epicycloid", 2) in [one.mechanism for one in few]
