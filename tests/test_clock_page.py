"""The numbers of the page on clocks: rate and amplitude of a deadbeat escapement."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

import escapement as esc

pytestmark = pytest.mark.slow
PAGE = Path(__file__).resolve().parents[1] / "docs" / "clock.md"
RAD = math.pi / 180.0
WHEEL = esc.Deadbeat(
    30, 1.0, 0.2, -8 * RAD, 35 * RAD, 0.002, 7.5, lift=2 * RAD, lock=0.5 * RAD, drop=RAD
)
CLOCK = esc.Escapement(
    WHEEL, esc.Inertia(1e-4, 1.0), 0.006, friction=0.1, follower_gravity=1.0, follower_viscous=0.02
)
CASES = {
    "as above": (CLOCK, 6.29167353976, 0.099092179),
    "torque 1 % more": (replace(CLOCK, torque=0.00606), 6.291699743, 0.099506415),
    "friction .11": (replace(CLOCK, friction=0.11), 6.291797467, 0.096517794),
}
"""Escapements, and the period and the amplitude that two other programs found."""


@pytest.mark.parametrize("name", CASES)
def test_rate_and_amplitude_are_those_of_the_page(name):
    clock, period, amplitude = CASES[name]
    cycle = esc.terminal(clock)
    assert cycle.period == pytest.approx(period, rel=1e-9)
    farthest = float(cycle.motion.at(cycle.motion.t).phi.max())
    assert farthest == pytest.approx(amplitude, rel=1e-3)
    late = 86400.0 * (cycle.period / (2.0 * math.pi) - 1.0)
    row = f"| {name} | {cycle.period:.6f} | {late:.2f} | {math.degrees(amplitude):.3f} |"
    assert row in PAGE.read_text(encoding="utf-8")


def test_the_contraction_of_a_clock_is_that_of_its_swings():
    """What is left of the way to the cycle shrinks by it in every full swing."""
    cycle = esc.terminal(CLOCK)
    speeds = esc.simulate(CLOCK, engagements=60).handoff_velocities - cycle.handoff_velocity
    assert speeds[-1] / speeds[-2] == pytest.approx(cycle.contraction, rel=1e-3)
