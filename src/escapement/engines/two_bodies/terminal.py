"""The cycle of a motion of two bodies, which repeats itself after a pitch, after several, or never.

The map from pitch to pitch contracts, so it is followed: that of a runaway for ten pitches or so,
that of a clock with a pendulum for some hundreds.
"""

import math
from dataclasses import replace

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.batch_spread import batch_spread
from escapement.dynamics.codes import Ending
from escapement.dynamics.figures_of_merit import Figures, cycle_figures, read_figures
from escapement.dynamics.motion import Motion
from escapement.engines.two_bodies import simulate as following
from escapement.engines.two_bodies.march import PAIR, SPEED, STEPS, THETA, TIME
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

_AT_ONCE, _TRIES, _KEPT = 10, 60, 200
"""Engagements between two looks, how often, and how many of a motion that never repeats."""
_SAME, _ALIKE = 1e-13, 1e-9
"""Engagements repeat if their states are the same to this share of the speed, and are said to
nearly repeat if their periods are so to that."""
_MOST = 4
_MOVING = slice(SPEED, THETA)


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit of two bodies; see `escapement.terminal`."""
    state = following.first_state(escapement, initial_speed)
    for k in range(_TRIES + 1):
        count = _AT_ONCE if k < _TRIES else _KEPT
        ending, states, theta, _end = following.march_from(escapement, state, count)
        if ending != Ending.DONE:
            passed = k * _AT_ONCE + len(states) - 1
            status, message = following.outcome(escapement, ending, theta, passed)
            return replace(base, status=status, message=message)
        for size in range(1, _MOST + 1):
            one, two = states[-1], states[-1 - size]
            apart = np.abs(one - two)[_MOVING].max() / np.abs(one[_MOVING]).max()
            if one[PAIR] == two[PAIR] and apart <= _SAME:
                return _figures(escapement, base, _restarted(one), size, initial_speed, rtol)
        state = _restarted(states[-1])
    return _scattered(escapement, base, states, rtol)


def _restarted(state: FloatArray) -> FloatArray:
    state = state.copy()
    state[[TIME, STEPS]] = 0.0
    return state


def _figures(
    escapement: Escapement, base: Figures, state: FloatArray, size: int, speed: float, rtol: float
) -> Figures:
    """Figures of the round of so many engagements that begins with a state and leads back to it."""
    cycle = following.motion_from(escapement, state, rtol, size)
    if size > 1:
        told = ", ".join(f"{x:.9g}" for x in np.diff(cycle.handoff_times, prepend=0.0))
        message = f"the motion repeats itself after {size} pitches, with periods of {told} s"
        return replace(base, **cycle_figures(cycle), motion=cycle, message=message)

    def follow(count: int) -> Motion:
        start = {"duration": None, "initial_speed": speed, "rtol": rtol}
        return following.simulate(escapement, engagements=count, **start)  # type: ignore[arg-type]

    ends = []
    for share in (1.0 - 1e-5, 1.0 + 1e-5):
        changed = state.copy()
        changed[[SPEED, SPEED + 2]] *= share
        ending, states, _theta, _end = following.march_from(escapement, changed, 1)
        ends.append(states[-1, SPEED] ** 2 if ending == Ending.DONE else math.nan)
    contraction = float((ends[1] - ends[0]) / (4e-5 * state[SPEED] ** 2))
    return read_figures(base, cycle, contraction, speed, follow, following.LONGEST)


def _scattered(escapement: Escapement, base: Figures, states: FloatArray, rtol: float) -> Figures:
    """Means over engagements that never repeat themselves, with their scatter."""
    periods = np.diff(states[:, TIME]) * escapement.time_unit
    mean, spread = float(periods.mean()), float(np.ptp(periods))
    cycle = following.motion_from(escapement, _restarted(states[-1]), rtol, 1)
    found = cycle_figures(cycle) | {"motion": cycle}
    if spread <= _ALIKE * mean:
        return replace(base, **found, message=f"the pitches repeat to {spread / mean:.1g}")
    found["spread"] = batch_spread({"period": periods})
    found |= {"period": mean, "velocity_mean": escapement.mechanism.cell_angle / mean}
    message = (
        f"the pitches do not repeat themselves: the period is the mean of {periods.size}, which "
        f"lie between {periods.min():.9g} and {periods.max():.9g} s; other figures are those of one"
    )
    return replace(base, **found, status=Status.OK, message=message)
