"""Intervals of `fit_beats` where durations of beats are known, or their instants with jitter.

``python benchmarks/beat_faults.py [--seeds 100]``

Ten patterns of beats with planted errors of parts and noise of 5 microseconds. An interval is right
if it contains the true value. Where the fit gives NaN it says that the beats do not determine a
number, which is neither right nor wrong.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from common import asked, tell

import escapement as esc

INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
NOISE, ROUNDS = 5e-6, 10


class Case(NamedTuple):
    """A wheel, and how its ticks are heard: times of ticks and a random generator to times."""

    slots: int
    pins: int
    slot_errors: tuple[float, ...]
    pin_errors: tuple[float, ...]
    heard: Callable
    parts: str = "both"
    noise: float = 1.0
    times: bool = False
    rounds: int = ROUNDS


def as_they_are(ticks, random):
    return ticks


def jitter(ticks, random):
    return ticks + NOISE * random.standard_normal(ticks.size)


THREE, FIVE = (0.9e-3, -1.3e-3, 0.4e-3), (-1.6e-3, -0.8e-3, 0.4e-3, 0.7e-3, 1.3e-3)
FOUR, SIX = (-1e-3, 0.2e-3, 0.3e-3, 0.5e-3), (-1e-3, 0.2e-3, 0.3e-3, 0.5e-3, -0.4e-3, 0.4e-3)
CASES = {
    "clean": Case(5, 3, FIVE, THREE, as_they_are),
    "stamps with jitter": Case(5, 3, FIVE, THREE, jitter, noise=0.0, times=True),
    "their differences": Case(5, 3, FIVE, THREE, jitter, noise=0.0),
    "stamps, and noise of beats": Case(5, 3, FIVE, THREE, jitter, noise=0.3, times=True),
}
for name, noise in {
    "": 0.0,
    ", and noise of beats": 0.3,
    ", and as much noise of beats": 1.0,
}.items():
    CASES[f"three rounds of stamps{name}"] = Case(
        5, 3, FIVE, THREE, jitter, noise=noise, times=True, rounds=3
    )
CASES |= {
    "four slots, their errors": Case(4, 4, FOUR, (), as_they_are, "slots"),
    "six slots, their errors": Case(6, 3, SIX, (), as_they_are, "slots"),
    "six slots, three pins' errors": Case(6, 3, (), THREE, as_they_are, "pins"),
}


def fits_of(case, seeds):
    """The fit for each seed."""
    wheel = esc.Geneva(case.slots, pins=case.pins, crank_radius=0.02)
    design = esc.Escapement(wheel, INERTIA, torque=0.0113, friction=0.3)
    bad = replace(wheel, pin_angle_errors=case.pin_errors, slot_angle_errors=case.slot_errors)
    beats = np.tile(esc.terminal(replace(design, mechanism=bad)).beats, case.rounds)
    found = []
    for seed in range(seeds):
        random = np.random.default_rng(seed)
        noise = case.noise * NOISE * random.standard_normal(beats.size)
        ticks = case.heard(np.concatenate([[0.0], np.cumsum(beats + noise)]), random)
        given = esc.Readings.of_beats(ticks + 1.7e9) if case.times else np.diff(ticks)
        found.append(esc.fit_beats(given, design, parts=case.parts))
    return found


def row_of(name, case, seeds):
    """For how many seeds intervals contained the true value.

    answers, least, most : seeds with numbers for all parts; and among them for how many the
        interval of a part was right, for the worst and the best part.
    rates, rate_right : seeds with a number for the rate, and for how many its interval was right.
    """
    fits = fits_of(case, seeds)
    true, held = np.array([*case.pin_errors, *case.slot_errors]), []
    for fit in fits:
        parts = [(fit.pin_angle_errors, fit.pin_half_widths)] * bool(case.pin_errors)
        parts += [(fit.slot_angle_errors, fit.slot_half_widths)] * bool(case.slot_errors)
        found, half = (np.concatenate(one) for one in zip(*parts, strict=True))
        if np.isfinite(found).all():
            held.append(np.abs(found - true) <= half)
    inside = np.sum(held, axis=0) if held else np.zeros(1, int)
    rates = [abs(fit.rate - 1.0) <= fit.rate_half_width for fit in fits if np.isfinite(fit.rate)]
    return {
        "case": name, "seeds": seeds, "answers": len(held),
        "least": inside.min(), "most": inside.max(), "rates": len(rates), "rate_right": sum(rates),
    }  # fmt: skip


def main():
    """Fit all cases, print and write how often the intervals are right."""
    seeds, whole = asked(__doc__, seeds=100)
    tell("beat_faults", [row_of(name, case, seeds) for name, case in CASES.items()], whole)


if __name__ == "__main__":
    main()
