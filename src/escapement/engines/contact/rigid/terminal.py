"""The round that repeats itself, and how the motion gets there.

A round is one engagement, or those in one turn of the follower with a load that repeats in a turn.
The motion tends to a round, so it is followed; Aitken's extrapolation of the speed at the
handoff makes this faster. Near the Painleve limit, or with rebounds, there may
be no such round: then many are followed, and the message gives their spread.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.codes import Ending
from escapement.dynamics.figures_of_merit import Figures, read_figures
from escapement.dynamics.motion import Motion
from escapement.engines.contact.rigid.march import SPEED, TIME, TURNING, WALL
from escapement.engines.contact.rigid.simulate import (
    first_state,
    march_from,
    motion_from,
    outcome,
    simulate,
)
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

LONGEST_TRANSIENT = 10_000
"""Engagements of a transient that is followed."""
_STEPS, _ROUNDS, _TRIES = 12, 3, 40
"""Engagements, and rounds, that are followed at least between two extrapolations, and how many
times."""
_MANY, _KEPT = 1000, 500
_ALIKE = 1e-5
"""Engagements repeat if their periods spread by less than this share of the period."""


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit with clearance; see `escapement.terminal`."""
    state, size = first_state(escapement, initial_speed), len(escapement.pairs)
    for _ in range(_TRIES):
        count = size * max(_STEPS // size, _ROUNDS)
        ending, states, _angle, _end = march_from(escapement, state, count, rtol)
        if ending != Ending.DONE:
            # an extrapolated speed may be one that the motion itself never has
            return _followed(escapement, base, initial_speed, rtol)
        states = states[::size]
        if _repeats(states, rtol):
            return _figures(escapement, base, states[-1], initial_speed, rtol)
        state = _extrapolated(states)
    return _followed(escapement, base, initial_speed, rtol)


def _repeats(states: FloatArray, rtol: float) -> bool:
    """Whether the last two of the states before rounds are the same, and those before nearly."""
    moving = slice(SPEED, WALL)
    changes = np.abs(np.diff(states[-3:, moving], axis=0)) / np.abs(states[-1, moving]).max()
    return bool(changes.max() <= max(1e-3 * rtol, 1e-14))


def _extrapolated(states: FloatArray) -> FloatArray:
    """The state to which the last ones tend, as a geometric series."""
    speed, before, last = states[-3:, SPEED]
    one, two = before - speed, last - before
    state = np.array(states[-1])
    ratio = two / one if one != 0.0 else 0.0
    if abs(ratio) < 0.999 and abs(two) > 1e-15 * last:
        to = max(last + two * ratio / (1.0 - ratio), 0.5 * last)
        # while the pin touches a wall, the follower's speed is proportional to the driver's
        state[SPEED], state[TURNING] = to, state[TURNING] * to / last
    state[TIME] = 0.0
    return state


def _followed(escapement: Escapement, base: Figures, initial_speed: float, rtol: float) -> Figures:
    """The figures if no state repeats: those of a motion that ends, or of many engagements."""
    start, size = first_state(escapement, initial_speed), len(escapement.pairs)
    ending, states, angle, _end = march_from(escapement, start, _MANY // size * size, rtol)
    if ending != Ending.DONE:
        status, message = outcome(escapement, ending, angle, len(states) - 1)
        return replace(base, status=status, message=message)
    states, kept = states[::size], _KEPT // size
    if _repeats(states, rtol):
        return _figures(escapement, base, states[-1], initial_speed, rtol)
    clock = escapement.time_unit
    periods = np.diff(states[-kept - 1 :, TIME]) * clock / size
    speeds = states[-kept:, SPEED] / clock
    period = float(periods.mean())
    spread = float(np.ptp(periods) / period)
    if spread <= _ALIKE:
        found = _figures(escapement, base, states[-1], initial_speed, rtol)
        return replace(found, message=f"the engagements repeat to {spread:.1g} of the period")
    message = (
        f"the engagements do not repeat: over {kept * size} of them the period is between "
        f"{periods.min():.6g} and {periods.max():.6g} s, with a mean of {period:.6g} s, and the "
        f"handoff velocity between {speeds.min():.6g} and {speeds.max():.6g} rad/s"
    )
    return replace(base, status=Status.NOT_CONVERGED, message=message)


def _figures(
    escapement: Escapement, base: Figures, state: FloatArray, initial_speed: float, rtol: float
) -> Figures:
    """Figures of the round that begins with a state and leads back to it."""
    state = state.copy()
    state[TIME] = 0.0
    cycle = motion_from(escapement, state, len(escapement.pairs), None, rtol)
    settings: dict[str, Any] = {"initial_speed": initial_speed, "rtol": rtol}

    def follow(count: int) -> Motion:
        return simulate(escapement, engagements=count, duration=None, **settings)

    contraction = _contraction(escapement, state, rtol)
    return read_figures(base, cycle, contraction, initial_speed, follow, LONGEST_TRANSIENT)


def _contraction(escapement: Escapement, state: FloatArray, rtol: float) -> float:
    """dw_out/dw_in of a round, by a central difference."""
    ends = []
    for share in (1.0 - 1e-5, 1.0 + 1e-5):
        changed = state.copy()
        changed[[SPEED, TURNING]] *= share
        ending, states, _angle, _end = march_from(escapement, changed, len(escapement.pairs), rtol)
        ends.append(states[-1, SPEED] ** 2 if ending == Ending.DONE else np.nan)
    return float((ends[1] - ends[0]) / (4e-5 * state[SPEED] ** 2))
