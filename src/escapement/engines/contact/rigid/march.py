"""Engagements one after the other: states at their handoffs, and the events within them."""

import numpy as np

from escapement.dynamics.codes import Ending
from escapement.dynamics.law import scene_of
from escapement.dynamics.load import repeats_each_step
from escapement.dynamics.torque import cell_after, cell_of, is_constant
from escapement.engines.contact.rigid.engagement import MOST_STEPS, engage, turn_on
from escapement.engines.contact.rigid.instant import RigidState
from escapement.engines.contact.rigid.notes import Notes
from escapement.engines.contact.rigid.walls import Clearance, walls_of
from escapement.engines.contact.rigid.workspace import workspace
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit, jit

STATE = 5
"""Numbers of the state at a handoff."""
TIME, SPEED, PHI, TURNING, WALL = range(STATE)
"""Their columns: time, theta_dot, phi, phi_dot, and the wall that the pin touches, 0 for none."""
AT_ONCE = 50_000
"""Steps of one call, which take a tenth of a second; between calls Ctrl-C takes effect."""


@inner_jit
def tail_for(rtol):
    """Greatest tail of a panel; the relative error of its integrals is about the square of it."""
    return min(0.3 * np.sqrt(rtol), 1e-4)


@inner_jit(allocates=True)
def walls_after(walls, driver_angle):
    """The walls with the torque of the cell that begins after a driver angle turned."""
    plus, minus = cell_after(driver_angle, walls.plus), cell_after(driver_angle, walls.minus)
    return altered(walls, "plus", plus, "minus", minus)


@inner_jit
def pass_one(work, notes, walls, state, end_time, trend):
    """Follow an engagement from a state; returns the instant at the next handoff, and why it ends.

    `trend` is the sign of theta_ddot before it, 0 if nothing is known of it.
    """
    now = RigidState(
        theta=walls.plus.edges[0], speed=state[SPEED], phi=state[PHI], turning=state[TURNING],
        time=0.0, wall=state[WALL], trend=trend,
    )  # fmt: skip
    now, ending = engage(work, notes, walls, now, end_time, tail_for(walls.rtol))
    if ending == Ending.DONE:
        now, ending = turn_on(work, notes, walls, now, end_time)
    return now, ending


@inner_jit
def _write(state, time, now):
    """Write the state at a handoff."""
    state[TIME], state[SPEED], state[PHI] = time, now.speed, now.phi
    state[TURNING], state[WALL] = now.turning, now.wall


@inner_jit
def _same(one, two):
    """Whether two handoffs have the same state except for rounding, so that all later ones do."""
    apart = 0.0
    for i in range(SPEED, STATE):
        apart = max(apart, abs(one[i] - two[i]))
    return apart <= 4e-15 * two[SPEED]


@inner_jit
def _repeat(states, k, length, limit):
    """Repeat the engagement that led to handoff k, to the end or the limit; returns the last."""
    for j in range(k + 1, len(states)):
        for i in range(SPEED, STATE):
            states[j, i] = states[k, i]
        states[j, TIME] = states[k, TIME] + (j - k) * length
        if states[j, TIME] >= limit:
            return j
    return len(states) - 1


@jit(allocates=True)
def march(packed, clearance, rtol, limit, first, states, numbers, rows, engagement, used):
    """Follow engagements until `states` is full, a time is passed, or the motion ends.

    It also returns, RUNNING, behind an engagement with which it has taken `AT_ONCE` steps.

    Parameters
    ----------
    packed : as `model.scene.packed` gives it.
    clearance : the numbers of a `Clearance`, as a plain tuple.
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
    ending, done, angle, time
        How the last engagement ended, how many were completed, where and when it ended.
    """
    scene = scene_of(packed)
    walls, memory = walls_of(scene, Clearance(*clearance), rtol), workspace()
    cell, lost, constant = cell_of(scene), 0.0, is_constant(scene) and repeats_each_step(scene)
    ending, end, trend, last = Ending.DONE, states[0, TIME], 0.0, first
    wanted = numbers.size > 0
    for k in range(numbers.size if wanted else len(states) - 1):
        notes = Notes(rows=rows, used=used, wanted=wanted, limit=used[1] + MOST_STEPS)
        number = numbers[k] if wanted else first + k
        if not constant:
            walls = walls_after(walls, number * cell)
        begin, begun, work = states[k, TIME], used[0], memory[0]
        # the sign of theta_ddot before is not known behind engagements that are left out
        trend = trend if number == last + 1 else 0.0
        now, ending = pass_one(work, notes, walls, states[k], limit - begin, trend)
        trend, last = now.trend, number
        if wanted:
            for i in range(begun, min(used[0], rows.size)):
                rows[i].time += begin
                engagement[i] = number
            continue
        # Kahan's sum of the times
        more = now.time - lost
        end = begin + more
        if ending != Ending.DONE:
            return ending, k, now.theta, end
        lost = (end - begin) - more
        _write(states[k + 1], end, now)
        if end >= limit:
            return Ending.OVER, k + 1, now.theta, end
        if constant and _same(states[k], states[k + 1]):
            done = _repeat(states, k + 1, now.time, limit)
            over = states[done, TIME] >= limit
            return Ending.OVER if over else Ending.DONE, done, 0.0, states[done, TIME]
        if used[1] > AT_ONCE and k + 2 < len(states):
            return Ending.RUNNING, k + 1, 0.0, end
    return ending, len(states) - 1, 0.0, end
