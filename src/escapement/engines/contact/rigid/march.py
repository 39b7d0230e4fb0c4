"""Engagements one after the other: states at their handoffs, and the events within them."""

import numpy as np

from escapement.dynamics.law import scene_of
from escapement.dynamics.torque import cell_after, cell_of, is_constant
from escapement.engines.contact.rigid.engagement import (
    DONE,
    MOST_STEPS,
    OVER,
    RUNNING,
    Body,
    Notes,
    engage,
    turn_on,
)
from escapement.engines.contact.rigid.panel import PLACES, WORKSPACE
from escapement.engines.contact.rigid.walls import Case, case_of
from escapement.numerics.gauss import POINTS, N
from escapement.numerics.jit import inner_jit, jit

STATE = 5
"""Numbers of the state at a handoff: time, speed, phi, phi_dot and the wall, 0 for none."""
AT_ONCE = 50_000
"""Steps of one call, which take a tenth of a second; between calls Ctrl-C takes effect."""


@inner_jit(allocates=True)
def workspace():
    """Memory for one record of rows of values at the Gauss points.

    The compiler frees memory after its last use, and does not count records among the uses: a
    kernel that needs the record in a loop takes it from this memory within the loop.
    """
    memory = np.empty(1, WORKSPACE)
    memory[0][PLACES][:] = POINTS
    return memory


@inner_jit
def tail_for(rtol):
    """Greatest tail of a panel; the relative error of its integrals is about the square of it."""
    return min(0.3 * np.sqrt(rtol), 1e-4)


@inner_jit(allocates=True)
def after(case, turned):
    """The case with the torque of the cell that begins after a driver angle turned."""
    return Case(cell_after(turned, case.plus), cell_after(turned, case.minus), *case[2:])


@inner_jit
def pass_one(work, notes, case, state, step, end_time, trend, count):
    """Follow an engagement from a state; returns the body at the next handoff, and why it ends."""
    body = Body(case.plus.edges[0], state[1], state[2], state[3], 0.0, state[4], trend)
    body, code = engage(work, notes, case, body, end_time, tail_for(case.rtol), count)
    if code == DONE:
        body, code = turn_on(work, notes, case, body, step, end_time, count)
    return body, code


@inner_jit
def _same(one, two):
    """Whether two handoffs have the same state except for rounding, so that all later ones do."""
    apart = 0.0
    for i in range(1, STATE):
        apart = max(apart, abs(one[i] - two[i]))
    return apart <= 4e-15 * two[1]


@inner_jit
def _repeat(states, k, length, limit):
    """Repeat the engagement that led to handoff k, to the end or the limit; returns the last."""
    for j in range(k + 1, len(states)):
        for i in range(1, STATE):
            states[j, i] = states[k, i]
        states[j, 0] = states[k, 0] + (j - k) * length
        if states[j, 0] >= limit:
            return j
    return len(states) - 1


@jit(allocates=True)
def march(scene_tuple, joint, rtol, limit, first, states, numbers, rows, engagement, used):
    """Follow engagements until `states` is full, a time is passed, or the motion ends.

    It also returns, RUNNING, behind an engagement with which it has taken `AT_ONCE` steps.

    Parameters
    ----------
    scene_tuple : as `model.scene.scene_tuple` gives it.
    joint : centre distance, crank, play, restitution and follower angle of a cell.
    rtol : relative error asked for.
    limit : time after which to stop.
    first : number of the engagement that begins with the first of the states.
    states : shape (n + 1, STATE). The first one is given; the others are filled with the states
        at handoffs.
    numbers : shape (k,), engagements of which the rows are wanted; then `states`, of shape
        (k, STATE), gives the state with which each begins. Empty if no rows are wanted.
    rows, engagement : filled with pieces and events, and the engagement of each. If `used[0]`,
        their number, exceeds the size, the rest is missing.
    used : that number, and the number of steps taken, both 0 before.

    Returns
    -------
    code, done, angle, time
        How the last engagement ended, how many were completed, where and when it ended.
    """
    scene = scene_of(scene_tuple)
    case, memory = case_of(scene, joint[:4], rtol), workspace()
    count, cell, lost, constant = np.int64(N), cell_of(scene), 0.0, is_constant(scene)
    code, end, trend, last = np.int64(DONE), states[0, 0], 0.0, np.int64(0)
    wanted = numbers.size > 0
    for k in range(numbers.size if wanted else len(states) - 1):
        notes = Notes(rows, used, wanted, used[1] + MOST_STEPS)
        number = numbers[k] if wanted else first + k
        if not constant:
            case = after(case, number * cell)
        begin, begun, work = states[k, 0], used[0], memory[0]
        # the sign of theta_ddot before is not known behind engagements that are left out
        trend = trend if number == last + 1 else 0.0
        body, code = pass_one(work, notes, case, states[k], joint[4], limit - begin, trend, count)
        trend, last = body.trend, number
        if wanted:
            for i in range(begun, min(used[0], rows.size)):
                rows[i].time += begin
                engagement[i] = number
            continue
        # Kahan's sum of the times
        more = body.time - lost
        end = begin + more
        if code != DONE:
            return code, k, body.theta, end
        lost = (end - begin) - more
        states[k + 1, 0], states[k + 1, 1], states[k + 1, 2] = end, body.speed, body.phi
        states[k + 1, 3], states[k + 1, 4] = body.turning, body.wall
        if end >= limit:
            return np.int64(OVER), k + 1, body.theta, end
        if constant and _same(states[k], states[k + 1]):
            done = _repeat(states, k + 1, body.time, limit)
            over = states[done, 0] >= limit
            return np.int64(OVER if over else DONE), done, 0.0, states[done, 0]
        if used[1] > AT_ONCE and k + 2 < len(states):
            return np.int64(RUNNING), k + 1, 0.0, end
    return code, len(states) - 1, 0.0, end
