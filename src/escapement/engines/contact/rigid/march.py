"""Engagements one after the other: their handoffs, and what happens within them."""

import numpy as np

from escapement.drive import cell_after, cell_of, is_constant
from escapement.dynamics import scene_of
from escapement.engines.contact.rigid.engagement import (
    DONE,
    OVER,
    ROW,
    Body,
    Notes,
    engage,
    follower_on,
    turn_on,
)
from escapement.engines.contact.rigid.panel import PLACES, ROWS
from escapement.engines.contact.rigid.walls import Case, case_of
from escapement.gauss import POINTS, N
from escapement.jit import inner_jit, jit

STATE = 5
"""Numbers of the state at a handoff: time, speed, phi, phi_dot and the wall, 0 for none."""


@inner_jit(allocates=True)
def workspace():
    """Rows of values at the Gauss points."""
    work = np.empty((ROWS, N))
    work[PLACES] = POINTS
    return work


@inner_jit
def tail_for(rtol):
    """The tail that a panel may have; integrals over it are as exact as the square of that."""
    return min(3.0 * np.sqrt(rtol), 1e-3)


@inner_jit
def after(case, turned):
    """The case in the cell after a driver angle turned."""
    return Case(cell_after(turned, case.plus), cell_after(turned, case.minus), *case[2:])


@inner_jit
def pass_one(work, notes, case, state, step, end_time, trend, count):
    """An engagement from a state; the body at the next handoff, with its time, and how it ends."""
    body = Body(case.plus.edges[0], state[1], state[2], state[3], 0.0, state[4], trend)
    body, code = engage(work, notes, case, body, end_time, tail_for(case.rtol), count)
    if code == DONE:
        body, code = turn_on(work, notes, case, body, step, end_time, count)
    return body, code


@jit(allocates=True)
def handoffs(scene_tuple, joint, rtol, speed, limit, states):
    """March engagements until `states` is full, `limit` is passed, or the motion ends.

    Parameters
    ----------
    scene_tuple : as `scene.scene_tuple` gives it.
    joint : centre distance, crank, play, restitution and follower angle of a cell.
    rtol : relative error asked for.
    speed : driver speed at the first entry.
    limit : time after which to stop.
    states : shape (n + 1, STATE), to be filled with the start and the state at each handoff.

    Returns
    -------
    code, done, angle, time
        How the last engagement ended, how many were completed, and where and when it ended.
    """
    scene = scene_of(scene_tuple)
    case, work = case_of(scene, joint[:4], rtol), workspace()
    notes = Notes(np.empty(0, ROW), np.zeros(1, np.int64), False)
    count, cell = np.int64(N), cell_of(scene)
    middle = follower_on(Case(*case[:5], 0.0, 0.0, rtol), 1.0, scene.edges[0])[0]
    states[0] = np.array([0.0, speed, middle, 0.0, 0.0])
    lost, constant = 0.0, is_constant(scene)
    for k in range(len(states) - 1):
        if not constant:
            case = after(case, k * cell)
        begin = states[k, 0]
        body, code = pass_one(work, notes, case, states[k], joint[4], limit - begin, 0.0, count)
        # Kahan's sum of the times
        more = body.time - lost
        end = begin + more
        if code != DONE:
            return code, k, body.theta, end
        lost = (end - begin) - more
        states[k + 1, 0], states[k + 1, 1], states[k + 1, 2] = end, body.speed, body.phi
        states[k + 1, 3], states[k + 1, 4] = body.turning, body.wall
        if end >= limit:
            return OVER, k + 1, body.theta, end
    return DONE, len(states) - 1, 0.0, states[len(states) - 1, 0]


@jit(allocates=True)
def happenings(scene_tuple, joint, rtol, first, states, trend, rows, engagement):
    """Fill `rows` with what happens in the engagements that start with these states.

    `first` is the number of the first of them. Returned are how many rows there are, which may
    be more than there is room for, and the sign of theta_ddot at the end.
    """
    scene = scene_of(scene_tuple)
    case, work, count, cell = case_of(scene, joint[:4], rtol), workspace(), np.int64(N), 0.0
    notes = Notes(rows, np.zeros(1, np.int64), True)
    if not is_constant(scene):
        cell = cell_of(scene)
    for k in range(len(states)):
        case, begun = after(case, (first + k) * cell), notes.used[0]
        body, _code = pass_one(work, notes, case, states[k], joint[4], np.inf, trend, count)
        trend = body.trend
        for i in range(begun, min(notes.used[0], rows.size)):
            rows[i].time += states[k, 0]
            engagement[i] = first + k
    return notes.used[0], trend
