"""Intervals of `fit_beats` where ticks are missed, doubled, out of place, or are time stamps.

``python benchmarks/beat_faults.py [--seeds 100]``

Ten patterns of beats with planted errors of parts and noise of 5 microseconds; for each seed the
faults are at other places. An interval is right if it contains the true value. Where the fit gives
NaN it says that the beats do not determine a number, which is neither right nor wrong.
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


def missed(count):
    """Ticks without some in the middle."""
    return lambda ticks, random: np.delete(
        ticks, random.choice(np.arange(2, ticks.size - 2), count, replace=False)
    )


def next_to_each_other(ticks, random):
    place = random.integers(2, ticks.size - 4)
    return np.delete(ticks, [place, place + 1])


def echo(ticks, random):
    place = random.integers(1, ticks.size - 1)
    later = random.uniform(0.02, 0.98) * (ticks[place + 1] - ticks[place])
    return np.insert(ticks, place + 1, ticks[place] + later)


def out_of_place(ticks, random):
    place, found = random.integers(1, ticks.size - 1), ticks.copy()
    found[place] += random.choice([-1.0, 1.0]) * random.uniform(0.01, 0.6) * (ticks[1] - ticks[0])
    return found


def both(ticks, random):
    return missed(1)(echo(ticks, random), random)


def jitter(ticks, random):
    return ticks + NOISE * random.standard_normal(ticks.size)


THREE, FIVE = (0.9e-3, -1.3e-3, 0.4e-3), (-1.6e-3, -0.8e-3, 0.4e-3, 0.7e-3, 1.3e-3)
FOUR, SIX = (-1e-3, 0.2e-3, 0.3e-3, 0.5e-3), (-1e-3, 0.2e-3, 0.3e-3, 0.5e-3, -0.4e-3, 0.4e-3)
HEARD = {
    "clean": as_they_are,
    "a tick missed": missed(1),
    "two ticks missed": missed(2),
    "neighbouring ticks missed": next_to_each_other,
    "second tick missed": lambda ticks, random: np.delete(ticks, 1),
    "last but one missed": lambda ticks, random: np.delete(ticks, -2),
    "an echo": echo,
    "an echo and a tick missed": both,
    "a tick out of place": out_of_place,
}
CASES = {name: Case(5, 3, FIVE, THREE, heard) for name, heard in HEARD.items()} | {
    "stamps with jitter": Case(5, 3, FIVE, THREE, jitter, noise=0.0, times=True),
    "their differences": Case(5, 3, FIVE, THREE, jitter, noise=0.0),
    "stamps with jitter, a tick missed": Case(
        5, 3, FIVE, THREE, lambda it, random: missed(1)(jitter(it, random), random),
        noise=0.0, times=True,
    ),
    "stamps, and noise of beats": Case(5, 3, FIVE, THREE, jitter, noise=0.3, times=True),
}  # fmt: skip
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
        given = ticks + 1.7e9 if case.times else np.diff(ticks)
        found.append(esc.fit_beats(given, design, parts=case.parts, times=case.times))
    return found


def row_of(name, case, seeds):
    """For how many seeds intervals contained the true value.

    named : for how many the message names a fault of the ticks.
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
    named = sum(bool(fit.rounds.faults) for fit in fits)
    return {
        "case": name, "seeds": seeds, "named": named, "answers": len(held),
        "least": inside.min(), "most": inside.max(), "rates": len(rates), "rate_right": sum(rates),
    }  # fmt: skip


def main():
    """Fit all cases, print and write how often the intervals are right."""
    seeds, whole = asked(__doc__, seeds=100)
    tell("beat_faults", [row_of(name, case, seeds) for name, case in CASES.items()], whole)


if __name__ == "__main__":
    main()
