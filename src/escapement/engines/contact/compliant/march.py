"""The motion with compliant contact, step by step.

Steps of `radau` go from the beginning of a contact to its end, and from there to the next one. A
step that passes one of these events, or a knot of the load, is repeated with the length at which
it ends there. The corners of the law thus lie between steps, and the method keeps its order.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import Ending
from escapement.dynamics.compliance import FREE, LOCKED, STATE, WALLS
from escapement.dynamics.load import has_load_curve, load_knot
from escapement.dynamics.radau import (
    ROUNDING,
    STAGES,
    attempt,
    go_on,
    growth,
    locate,
    prepare,
    workspace,
)  # fmt: skip
from escapement.dynamics.torque import REST, cell_after, cell_of, is_held, is_undriven
from escapement.engines.contact.compliant.law import (
    PinInSlot,
    angle_of_follower,
    frequency,
    rates,
    room,
    stored,
)
from escapement.engines.contact.slot import acceleration_across, pose, to_angle, to_slot, touches
from escapement.numerics.by_type import give_kernels
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.records import record_dtype

CLOCK = record_dtype({
    "time": float, "step": float, "mode": np.int64, "engagement": np.int64, "touch": float,
    "moved": float, "tries": np.int64,
})  # fmt: skip
"""What the next step needs in addition to the state. `moved` is the last time at which the
mechanism was faster than the slip speed, `tries` the number of steps that were tried, those that
locate an event included."""
STEP_END = record_dtype({
    "time": float, "engagement": np.int64, "mode": np.int64, "touch": float,
    "state": (float, (STATE,)), "series": (float, (STAGES, 2)),
})  # fmt: skip
"""The end of a step: mode, speed of the last touch and state, and the coefficients of the
polynomial in time for the accelerations in that step."""

MOST_EACH = 1000
"""Steps that a motion may try for each engagement, in addition to a limit."""
_TOUCHED = 1e-12
_LONGEST_FLIGHT, _LONGEST = 0.02, 0.1
"""Greatest angle of a step [rad] in flight, so that no touch is missed, and in contact."""
_UNSEEN = 1e-14
"""A step may pass the turning point of a pin that moves across the slot by less than this."""
_FIRST = 0.3
"""First step after an event, divided by the time scale of the contact."""
_MOST_IDLE = 20
_PATIENCE = 30.0
"""A mechanism that is slower than ten slip speeds for this long [sqrt(I_f/torque)] counts as at
rest."""
_INSTANT = 1e-9
"""How long a motion stands that is at rest from its start."""


class _Goal(NamedTuple):
    """Where a step is to end: at a driver angle, at an angle of the follower that turns in a
    `sense`, or, where both are NaN, at the beginning or the end of a contact.
    """

    driver: float
    follower: float
    sense: float


_CONTACT = _Goal(np.nan, np.nan, 1.0)


@inner_jit
def _left(case, y, mode, out, goal):
    """A number that is positive before an event: an angle left, else `law.room`.

    `out` are the `rates` of the state.
    """
    if goal.driver == goal.driver:
        return goal.driver - y[0]
    if goal.follower == goal.follower:
        return goal.sense * (goal.follower - _follower_angle(y, mode, case))
    return room(y, out, mode, case)[0]


give_kernels(PinInSlot, rates=rates, frequency=frequency, left=_left)


@inner_jit
def _follower_angle(y, mode, case):
    """phi of a state."""
    return angle_of_follower(y, pose(y, mode, case.scene), mode, case.scene)


@inner_jit
def _knot_within(y, mode, case, work):
    """The knot of the load that the follower passes in a step; `_CONTACT` if there is none."""
    if mode == LOCKED or not has_load_curve(case.scene):
        return _CONTACT
    before, behind = _follower_angle(y, mode, case), _follower_angle(work.end, mode, case)
    sense = np.sign(behind - before)
    knot = load_knot(before, sense, case.driver_angle, case.scene)
    return _Goal(np.nan, knot, sense) if sense * (behind - knot) > ROUNDING else _CONTACT


@inner_jit
def _rests(y, mode, case):
    """Whether both bodies count as at rest at a pin entry: see `escapement.simulate`."""
    at, scene = pose(y, mode, case.scene), case.scene
    energy = scene.rho * at.driver * at.driver + at.follower * at.follower
    energy += 2.0 * stored(y, mode, case)
    scene = cell_after(case.driver_angle, scene)
    if energy == 0.0:
        return is_held(y[0], scene)
    return energy <= scene.rho * REST and is_undriven(y[0], scene)


@inner_jit
def _dip(h, before, behind):
    """Length to the minimum of the cubic through both ends if that is below 0, else h."""
    value, slope = before
    end, rise = behind
    if not (value > 0.0 and end > 0.0 and slope < 0.0 and rise > 0.0):
        return h
    curvature = 3.0 * (end - value) - h * (2.0 * slope + rise)
    twist = h * (slope + rise) - 2.0 * (end - value)
    x = (
        -h
        * slope
        / (curvature + np.sqrt(max(curvature * curvature - 3.0 * twist * h * slope, 0.0)))
    )
    low = value + x * (h * slope + x * (curvature + x * twist))
    return x * h if low <= 0.0 and 1e-3 < x < 1.0 else h


@inner_jit
def _write(row, clock, y, series):
    row.time, row.engagement, row.mode = clock.time, clock.engagement, clock.mode
    row.touch = clock.touch
    for k in range(STATE):
        row.state[k] = y[k]
    for power in range(STAGES):
        row.series[power, 0], row.series[power, 1] = series[power, 0], series[power, 1]


@inner_jit
def _switch(y, clock, case):
    """Change between contact and flight, and keep the speed across the slot at a touch."""
    # a contact that ends while the wall is still pressed in loses the energy of its spring
    y[WALLS] += stored(y, clock.mode, case)
    if clock.mode != FREE:
        to_angle(y, case.scene)
        clock.mode = FREE
        return
    to_slot(y, case.scene)
    clock.mode = 1 if y[1] > 0.0 or (y[1] == 0.0 and y[3] >= 0.0) else -1
    # a wall may push again before the pin has left it
    if abs(y[1]) - case.joint.half_clearance < _TOUCHED:
        clock.touch = abs(y[3])
    y[WALLS] -= stored(y, clock.mode, case)


@inner_jit
def _arrive(y, clock, case, step):
    """Go past the end of the engagement: into the dwell, or to the next pin."""
    scene, mode = case.scene, clock.mode
    held = stored(y, mode, case)
    if touches(mode):
        to_angle(y, scene)
    if scene.dwell > 0.0 and mode != LOCKED:
        # the lock stops the follower where it stands
        y[WALLS] += 0.5 * y[3] * y[3] + held
        y[3], clock.mode = 0.0, LOCKED
        return
    y[0] = scene.edges[0]
    y[1] -= step
    clock.engagement += 1
    if mode == LOCKED:
        clock.mode = FREE
    elif mode != FREE:
        to_slot(y, scene)


@inner_jit
def _goal(clock, scene):
    """Driver angle at which the engagement, or the dwell behind it, ends."""
    return scene.edges[-1] + (scene.dwell if clock.mode == LOCKED else 0.0)


@inner_jit
def _longest(y, mode, work, scene):
    """Greatest step in which the bodies turn by no more than the angle allowed.

    In flight it also ends where the pin turns back across the slot, so that the pin is deepest in
    a wall that it reaches at the end of the step.
    """
    angle = _LONGEST_FLIGHT if mode == FREE else _LONGEST
    start = work.stages[0]
    speed, gain = abs(y[2]) + abs(y[3]), abs(start[2]) + abs(start[3])
    h = 2.0 * angle / (speed + np.sqrt(speed * speed + 2.0 * gain * angle))
    if mode == FREE:
        at = pose(y, mode, scene)
        back = acceleration_across(at, start[2], start[3], scene)
        if at.speed * back < 0.0 and at.speed * at.speed > _UNSEEN * abs(back):
            h = min(h, -at.speed / back)
    return h


@inner_jit
def _advance(y, clock, case, rtol, end, events, work):
    """Take a step to `work.end` that keeps the tolerance and ends at the first event in it.

    `events` says whether to look for the beginning or the end of a contact. Returned are the
    length of the step, 0 if none was accepted, whether the contact changes at its end, and whether
    the pin is at its goal.
    """
    mode = clock.mode
    h = min(clock.step, end - clock.time, _longest(y, mode, work, case.scene))
    error = attempt(y, h, mode, case, rtol, work)
    factor = growth(error)
    if not error <= 1.0:
        clock.step = h * factor
        return 0.0, False, False
    clock.step = max(clock.step, h * factor) if h < clock.step else h * factor
    full, passed = h, False
    if events:
        here = room(y, work.stages[0], mode, case)
        h = _dip(h, here, room(work.end, work.stages[STAGES], mode, case))
        if h < full and attempt(y, h, mode, case, rtol, work) == np.inf:
            clock.step = h
            return 0.0, False, False
        passed = room(work.end, work.stages[STAGES], mode, case)[0] <= 0.0
        if passed:
            h = locate(y, h, mode, case, rtol, work, _CONTACT)
    knot = _knot_within(y, mode, case, work) if h > 0.0 else _CONTACT
    if knot.follower == knot.follower:
        h, passed = locate(y, h, mode, case, rtol, work, knot), False
    goal = _goal(clock, case.scene)
    arrived = h > 0.0 and work.end[0] >= goal
    if arrived:
        h = locate(y, h, mode, case, rtol, work, _Goal(goal, np.nan, 1.0))
    if h == 0.0:
        clock.step = 0.5 * full
    return h, passed, arrived


@jit(allocates=True)
def march(y, clocks, scene, joint, step, rtol, engagements, end, limit, rows):
    """Continue a motion until it has passed `engagements`, or the time `end`.

    Parameters
    ----------
    y : the state, shape (STATE,). It is replaced by the last one, and so is `clocks`, of one
        `CLOCK`.
    step : angle by which the follower turns from pin to pin [rad].
    limit : number of tries after which to give up, in addition to MOST_EACH for each engagement.
    rows : array of `STEP_END`, to be filled. Where the law or the pin changes, there are two rows
        with the same time.

    Returns
    -------
    int, Ending
        Number of rows that were written, and why the march ends: RUNNING where the rows are full,
        ARRIVED at the goal, STANDS where nothing moves, TOO_LONG when the tries are used up.
    """
    clock, work, bare = clocks[0], workspace(), np.zeros((STAGES, 2))
    n, idle, fresh, enters = 0, 0, True, clock.time == 0.0
    case = PinInSlot(scene, joint, 0.0, 0.0)
    while True:
        if fresh:
            case = PinInSlot(scene, joint, clock.engagement * cell_of(scene), clock.touch)
            rates(case, y, clock.mode, work.stages[0])
            there = clock.engagement >= engagements or clock.time >= end
            if not there and room(y, work.stages[0], clock.mode, case)[0] < -_TOUCHED:
                # the next pin may be off the wall that the last one touched, or pressed into one
                _switch(y, clock, case)
                continue
            prepare(y, clock.mode, case, work)
            _write(rows[n], clock, y, bare)
            work.span[0], n, fresh = 0.0, n + 1, False
            if enters and not there and _rests(y, clock.mode, case):
                clock.time += _INSTANT
                _write(rows[n], clock, y, bare)
                return n + 1, Ending.STANDS
        if clock.engagement >= engagements or clock.time >= end:
            return n, Ending.ARRIVED
        if clock.tries >= limit + MOST_EACH * clock.engagement:
            return n, Ending.TOO_LONG
        if clock.time - clock.moved > _PATIENCE:
            return n, Ending.STANDS
        if n + 2 > rows.shape[0]:
            return n, Ending.RUNNING
        # if both a contact and a flight would end at once, one of them lasts for another step
        looks = idle < _MOST_IDLE
        h, passed, arrived = _advance(y, clock, case, rtol, end, looks, work)
        clock.tries, work.tries[0] = clock.tries + work.tries[0], 0
        if h == 0.0:
            continue
        idle = idle + 1 if h <= ROUNDING * clock.time else 0
        clock.time = end if end - clock.time <= h else clock.time + h
        go_on(y, work)
        if max(abs(y[2]), abs(y[3])) > 10.0 * joint.slip:
            clock.moved = clock.time
        _write(rows[n], clock, y, work.series)
        n += 1
        if arrived:
            _arrive(y, clock, case, step)
        elif passed:
            _switch(y, clock, case)
        enters = arrived and clock.mode != LOCKED
        if arrived or passed:
            fresh = True
            clock.step = _FIRST / frequency(case, y, clock.mode)
        else:
            prepare(y, clock.mode, case, work)
