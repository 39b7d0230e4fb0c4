"""The cycle of a motion of two bodies, which repeats itself after a pitch, after several, or never.

The map from pitch to pitch mostly contracts so fast that it is followed. Where it does not, such as
that of a clock with a pendulum, Newton's method finds the state that repeats itself, and the motion
is then followed from there.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.codes import Ending
from escapement.dynamics.figures_of_merit import BatchSpread, Figures, cycle_figures, read_figures
from escapement.dynamics.motion import Motion
from escapement.engines.two_bodies.simulate import (
    begin_of,
    march_from,
    motion_from,
    outcome,
    simulate,
)
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

LONGEST_TRANSIENT = 10_000
"""Engagements of a transient that is followed."""
_AT_ONCE, _TRIES, _KEPT = 12, 30, 200
"""Engagements between two looks, how often, and how many of a motion that never repeats."""
_SAME, _ALIKE = 1e-13, 1e-9
"""Engagements repeat if their states are the same to this share of the speed, and are said to
nearly repeat if their periods are so to that."""
_MOST_ROUNDS = 4
_NUMBERS = ("phi", "speed", "turning")


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit of two bodies; see `escapement.terminal`."""
    begin = begin_of(escapement, initial_speed)
    for k in range(_TRIES):
        ending, begins, theta, _end = march_from(escapement, begin, _AT_ONCE)
        if ending != Ending.DONE:
            passed = k * _AT_ONCE + len(begins) - 1
            status, message = outcome(escapement, ending, theta, passed)
            return replace(base, status=status, message=message)
        for size in range(1, _MOST_ROUNDS + 1):
            if _distance(begins[-1], begins[-1 - size]) <= _SAME:
                return _figures(escapement, base, begins[-1:], size, initial_speed, rtol)
        begin = begins[-1:].copy()
        begin["time"] = 0.0
        if k % 3 == 1:
            begin = _newton(escapement, begin)
    return _scattered(escapement, base, begin, rtol)


def _distance(one: Any, two: Any) -> float:
    """Distance of two states over their speed; infinite if their contacts differ."""
    if one["pair"] != two["pair"]:
        return math.inf
    speed = max(abs(one["speed"]), abs(one["turning"]))
    return float(max(abs(one[name] - two[name]) for name in _NUMBERS) / speed)


def _newton(escapement: Escapement, begin: np.ndarray) -> np.ndarray:
    """A state nearer to one that repeats itself, if the motion is in flight there."""
    x = np.array([begin[name][0] for name in _NUMBERS])
    if begin["pair"][0] >= 0:
        return begin

    def behind(at: FloatArray) -> FloatArray | None:
        start = begin.copy()
        for name, value in zip(_NUMBERS, at, strict=True):
            start[name] = value
        ending, begins, _theta, _end = march_from(escapement, start, 1)
        if ending != Ending.DONE or begins[-1]["pair"] >= 0:
            return None
        return np.array([begins[-1][name] for name in _NUMBERS])

    for _ in range(4):
        found = behind(x)
        columns = []
        for i in range(x.size):
            step = 1e-6 * max(abs(x[i]), 1e-3)
            ends = [behind(x + way * step * np.eye(x.size)[i]) for way in (1.0, -1.0)]
            if found is None or ends[0] is None or ends[1] is None:
                return begin
            columns.append((ends[0] - ends[1]) / (2.0 * step))
        change = np.linalg.solve(np.eye(x.size) - np.array(columns).T, found - x)
        if not np.abs(change).max() < 0.5 * np.abs(x).max():
            return begin
        x = x + change
    made = begin.copy()
    for name, value in zip(_NUMBERS, x, strict=True):
        made[name] = value
    return made


def _figures(
    escapement: Escapement, base: Figures, begin: np.ndarray, size: int, speed: float, rtol: float
) -> Figures:
    """Figures of the round of so many engagements that begins with a state and leads back to it."""
    begin = begin.copy()
    begin["time"], begin["number"] = 0.0, 0
    cycle = motion_from(escapement, begin, size, None, rtol, LONGEST_TRANSIENT)
    if size > 1:
        periods = np.diff(cycle.handoff_times, prepend=0.0)
        told = ", ".join(f"{period:.9g}" for period in periods)
        message = f"the motion repeats itself after {size} pitches, with periods of {told} s"
        return replace(base, **cycle_figures(cycle), motion=cycle, message=message)

    def follow(count: int) -> Motion:
        return simulate(
            escapement, engagements=count, duration=None, initial_speed=speed, rtol=rtol
        )

    contraction = _contraction(escapement, begin)
    return read_figures(base, cycle, contraction, speed, follow, LONGEST_TRANSIENT)


def _contraction(escapement: Escapement, begin: np.ndarray) -> float:
    """By how much a pitch shrinks a deviation of both speeds, by a central difference."""
    ends = []
    for share in (1.0 - 1e-5, 1.0 + 1e-5):
        changed = begin.copy()
        changed["speed"] *= share
        changed["turning"] *= share
        ending, begins, _theta, _end = march_from(escapement, changed, 1)
        ends.append(begins[-1]["speed"] ** 2 if ending == Ending.DONE else math.nan)
    return float((ends[1] - ends[0]) / (4e-5 * begin["speed"][0] ** 2))


def _scattered(escapement: Escapement, base: Figures, begin: np.ndarray, rtol: float) -> Figures:
    """Means over engagements that never repeat themselves, with their scatter."""
    ending, begins, theta, _end = march_from(escapement, begin, _KEPT)
    if ending != Ending.DONE:
        status, message = outcome(escapement, ending, theta, len(begins) - 1)
        return replace(base, status=status, message=message)
    periods = np.diff(begins["time"]) * escapement.time_unit
    mean, spread = float(periods.mean()), float(np.ptp(periods))
    last = begins[-1:].copy()
    last["time"], last["number"] = 0.0, 0
    cycle = motion_from(escapement, last, 1, None, rtol, LONGEST_TRANSIENT)
    found = cycle_figures(cycle) | {"motion": cycle}
    if spread <= _ALIKE * mean:
        return replace(base, **found, message=f"the pitches repeat to {spread / mean:.1g}")
    batches = periods.reshape(10, -1).mean(axis=1)
    interval = 2.262 * float(batches.std(ddof=1)) / math.sqrt(10.0)
    scatter = BatchSpread(
        periods.size, {"period": float(periods.std(ddof=1))}, {"period": interval}
    )
    found |= {"period": mean, "velocity_mean": escapement.mechanism.cell_angle / mean}
    message = (
        f"the pitches do not repeat themselves: the period is the mean of {periods.size}, which "
        f"lie between {periods.min():.9g} and {periods.max():.9g} s; all other figures "
        "are those of one pitch"
    )
    return replace(base, **found, spread=scatter, status=Status.OK, message=message)
