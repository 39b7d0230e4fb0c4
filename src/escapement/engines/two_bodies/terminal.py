"""The cycle of a motion of two bodies, which repeats itself after a pitch, after several, or never.

The map from pitch to pitch contracts, so it is followed until what is left of the way to its fixed
point, as a geometric series, is short: for some pitches with a runaway, for a hundred with a
pendulum. The fixed point is then extrapolated, and counts if pitches that are followed from there
repeat themselves, as far as rounding lets them. Where they do not the map is followed on.
"""

import math
from dataclasses import replace

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.batch_spread import batch_spread
from escapement.dynamics.codes import Ending
from escapement.dynamics.figures_of_merit import Figures, cycle_figures
from escapement.engines.two_bodies import simulate as following
from escapement.engines.two_bodies.march import PAIR, SPEED, STEPS, THETA, TIME, TURNING
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

_FIRST, _AT_ONCE, _LONGEST, _KEPT = 4, 10, 600, 200
"""Engagements before the first look, between two looks, before a motion counts as one that never
repeats, and how many of that."""
_SAME, _ALIKE, _NEAR = 1e-13, 1e-7, 1e-6
"""Shares of the speed: engagements repeat if their states differ by less than the first, are said
to repeat to that by which they differ if it is less than the second and does not become smaller,
and are extrapolated if less than the third is left."""
_MOST, _ROUNDS = 4, 8
"""Engagements after which a motion may repeat itself, and extrapolations."""
_MOVING = slice(SPEED, THETA)


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit of two bodies; see `escapement.terminal`."""
    states, count, again = following.first_state(escapement, initial_speed)[None], _FIRST, False
    while True:
        ending, more, theta, _end = following.march_from(escapement, states[-1], count)
        states = np.append(states, more[1:], axis=0)
        if ending != Ending.DONE:
            status, message = following.outcome(escapement, ending, theta, len(states) - 1)
            return replace(base, status=status, message=message)
        for size in range(1, _MOST + 1):
            if _apart(states[-1], states[-1 - size]) <= _SAME:
                same = _apart(states[-1], states[-2])
                size = 1 if same <= _ALIKE else size  # rounding may repeat itself as well
                return _figures(escapement, base, states, states[-1], size, same, rtol)
        left, ratio = _left(states)
        if left <= _NEAR:
            limit, same = _limit(escapement, states[-4:])
            # what is not smaller from nearer by is rounding
            enough = _ALIKE if again else _SAME
            if same <= enough and _apart(limit, states[-1]) <= 10.0 * _NEAR:
                return _figures(escapement, base, states, limit, 1, same, rtol)
            again = True
        if count == _KEPT:
            return _scattered(escapement, base, states[-1 - _KEPT :], rtol)
        count = _AT_ONCE if len(states) <= _LONGEST else _KEPT
        if _NEAR < left < math.inf and count == _AT_ONCE:
            count = min(count, 1 + int(math.log(_NEAR / left) / math.log(ratio)))


def _apart(one: FloatArray, two: FloatArray) -> float:
    """How far two states are apart, as a share of the speed."""
    if one[PAIR] != two[PAIR]:
        return math.inf
    return float(np.abs(one - two)[_MOVING].max() / np.abs(one[_MOVING]).max())


def _left(states: FloatArray) -> tuple[float, float]:
    """What is left of the way to the fixed point if the last steps go on as a geometric series, and
    its ratio; infinity if they do not become shorter."""
    steps = [_apart(states[k], states[k - 1]) for k in (-3, -2, -1)]
    if max(steps) <= _ALIKE:
        return max(steps), 1.0
    if not steps[2] < steps[1] < steps[0] < math.inf:
        return math.inf, 1.0
    ratio = steps[2] / steps[1]
    return steps[2] * ratio / (1.0 - ratio), ratio


def _limit(escapement: Escapement, states: FloatArray) -> tuple[FloatArray, float]:
    """The state that repeats itself, to which these lead, and how far it does not.

    States are extrapolated by Anderson's method: the map is taken as linear between those that were
    followed. Two pitches are followed from each, of which the last one must repeat the first.
    """
    limit, same = states[-1], math.inf
    given, found = list(states[:-1, _MOVING]), list(states[1:, _MOVING])
    for _ in range(_ROUNDS):
        steps = np.array(found) - given
        shares = np.linalg.lstsq((steps[:-1] - steps[-1]).T, -steps[-1], rcond=_NEAR)[0]
        state = _restarted(limit)
        state[_MOVING] = found[-1] + shares @ (np.array(found)[:-1] - found[-1])
        ending, states, _theta, _end = following.march_from(escapement, state, 2)
        if ending != Ending.DONE:
            return limit, math.inf
        limit, before, same = states[2], same, _apart(states[2], states[1])
        if same <= _SAME or not same < before:
            break
        given, found = [*given[-2:], *states[:2, _MOVING]], [*found[-2:], *states[1:, _MOVING]]
    return limit, same


def _restarted(state: FloatArray) -> FloatArray:
    state = state.copy()
    state[[TIME, STEPS]] = 0.0
    return state


def _figures(
    escapement: Escapement, base: Figures, states: FloatArray, last: FloatArray, size: int,
    same: float, rtol: float,
) -> Figures:  # fmt: skip
    """Figures of the round of so many engagements that begins with a state and leads back to it.

    states : those of the motion that leads to it. same : how far an engagement repeats itself.
    """
    state = _restarted(last)
    cycle = following.motion_from(escapement, state, rtol, size)
    if size > 1:
        told = ", ".join(f"{x:.9g}" for x in np.diff(cycle.handoff_times, prepend=0.0))
        message = f"the motion repeats itself after {size} pitches, with periods of {told} s"
        return replace(base, **cycle_figures(cycle), motion=cycle, message=message)
    if same > 10.0 * _SAME:
        base = replace(base, message=f"the pitches repeat to {same:.1g} of the speed")
    approach = following.motion_from(escapement, states[0], rtol, len(states) - 1, known=states)
    found = cycle_figures(cycle) | {"contraction": _contraction(escapement, state), "motion": cycle}
    start = float(states[0, SPEED] / escapement.time_unit)
    return replace(base, **found, approach=(start, approach))


def _contraction(escapement: Escapement, state: FloatArray) -> float:
    """Factor by which a pitch shrinks what a pitch before has left of a deviation; a pendulum's
    amplitude then outlasts the speed of the wheel, which stops in every swing."""
    ends = []
    for share in (1.0 - 1e-4, 1.0 + 1e-4):
        changed = state.copy()
        changed[[SPEED, TURNING]] *= share
        ending, after, _theta, _end = following.march_from(escapement, changed, 2)
        ends.append(after[:, _MOVING] if ending == Ending.DONE else np.full((3, 3), math.nan))
    before, left, last = ends[1] - ends[0]
    if left @ left < 1e-6 * (before @ before):  # another pitch would leave rounding alone
        left, last = before, left
    return float(last @ left / (left @ left))


def _scattered(escapement: Escapement, base: Figures, states: FloatArray, rtol: float) -> Figures:
    """Means over engagements that never repeat themselves, with their scatter."""
    periods = np.diff(states[:, TIME]) * escapement.time_unit
    mean = float(periods.mean())
    cycle = following.motion_from(escapement, _restarted(states[-1]), rtol, 1)
    found = cycle_figures(cycle) | {"motion": cycle}
    found["spread"] = batch_spread({"period": periods})
    found |= {"period": mean, "velocity_mean": escapement.mechanism.cell_angle / mean}
    message = (
        f"the pitches do not repeat themselves: the period is the mean of {periods.size}, which "
        f"lie between {periods.min():.9g} and {periods.max():.9g} s; other figures are those of one"
    )
    return replace(base, **found, status=Status.OK, message=message)
