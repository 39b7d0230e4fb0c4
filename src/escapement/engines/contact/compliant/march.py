"""The motion between walls that yield, step by step.

Dormand and Prince's pair of order 8, whose estimates of order 5 and 3 give the error, steps from
touch to letting go and from there to the next touch. A step that passes one of them is taken
again so long that it ends there, so that the corners of the law fall between steps and the order
is kept. No step is longer than is stable with the damping of a wall.

Source: Hairer, Norsett and Wanner (1993), Solving Ordinary Differential Equations I, II.5 and
II.10.
"""

import numpy as np
from scipy.integrate import DOP853

from escapement.drive import cell_of
from escapement.engines.contact.compliant.law import (
    FREE,
    IMPULSE,
    LOCKED,
    LOST,
    STATE,
    WALLS,
    Engagement,
    place,
    rates,
    room,
    stiffest,
    stored,
)
from escapement.jit import inner_jit, jit

STAGES = 12
WEIGHTS = np.ascontiguousarray(DOP853.A[:STAGES, :STAGES])
SUM = np.ascontiguousarray(DOP853.B)
FIFTH, THIRD = np.ascontiguousarray(DOP853.E5), np.ascontiguousarray(DOP853.E3)

CLOCK = np.dtype([
    ("time", "f8"), ("step", "f8"), ("mode", "i8"), ("engagement", "i8"), ("touch", "f8"),
    ("moved", "f8"), ("steps", "i8"),
])  # fmt: skip
"""Beside its state what a motion goes on from. `moved` is when it was last faster than slip."""
TIME, CELL, MODE, TOUCH, FORCE, FIRST, BENDS = 0, 1, 2, 3, 4, 5, 5 + STATE
ROW = BENDS + 2
"""A row holds time, engagement, mode, speed of the last touch, contact force, state, and both
accelerations."""
RUNNING, ARRIVED, STANDS, TOO_LONG = 0, 1, 2, 3
"""The rows are full, the goal is reached, nothing moves, or the steps are used up."""

_STABLE = 5.7
"""Steps over the fastest time of decay, at which the method damps still (6.3 is its limit)."""
_ROUNDING = 4e-16
_TOUCHED = 1e-12
_LONGEST_FLIGHT = 0.02
"""Angle [rad] of a step in flight, so short that no wall is passed unseen."""
_MOST_IDLE = 20
_THIN = 0.05
"""Share of the contact's time scale within which states are not kept, as where a pin sticks."""
_PATIENCE = 30.0
"""A mechanism that is slower than ten slip speeds for this long [sqrt(I_f/torque)] stands."""
_SLOW = 0.1
"""Speed [sqrt(torque/I_f)] below which the error is no longer relative."""


@inner_jit
def attempt(y, h, mode, case, rtol, stages, trial):
    """Take a step into `trial`; stages[0] holds the rates before it, stages[12] those behind.

    The result is the error over the tolerance.
    """
    for i in range(1, STAGES):
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        for j in range(i):
            weight, stage = h * WEIGHTS[i, j], stages[j]
            a += weight * stage[0]
            b += weight * stage[1]
            c += weight * stage[2]
            d += weight * stage[3]
        trial[0], trial[1], trial[2], trial[3] = y[0] + a, y[1] + b, y[2] + c, y[3] + d
        rates(trial, mode, case, stages[i])
    for k in range(STATE):
        gain = 0.0
        for i in range(STAGES):
            gain += SUM[i] * stages[i, k]
        trial[k] = y[k] + h * gain
    rates(trial, mode, case, stages[STAGES])
    frequency = stiffest(y, mode, case)[0]
    scale = rtol * (_SLOW + max(abs(y[2]), abs(y[3])))
    fifth = third = 0.0
    for k in (0, 1, 2, 3, LOST, WALLS):
        one = two = 0.0
        for i in range(STAGES + 1):
            one += FIFTH[i] * stages[i, k]
            two += THIRD[i] * stages[i, k]
        unit = h / scale * (frequency if k < 2 else 1.0 if k < 4 else rtol / scale)
        fifth += (unit * one) ** 2
        third += (unit * two) ** 2
    if fifth == 0.0:
        return 0.0
    return fifth / np.sqrt(6.0 * (fifth + 0.01 * third))


@inner_jit
def _left(trial, stages, mode, case, goal):
    """What is positive before an event: the angle to a `goal`, or without one the `room`."""
    if goal == goal:
        return goal - trial[0]
    return room(trial, stages[STAGES], mode, case)[0]


@inner_jit
def _locate(y, h, mode, case, rtol, stages, trial, goal):
    """Length of the step that ends at an event within it, by false position (Illinois)."""
    low, high, length = 0.0, h, h
    at_high = _left(trial, stages, mode, case, goal)
    at_low = goal - y[0] if goal == goal else room(y, stages[0], mode, case)[0]
    at_low, last = max(at_low, 0.0), 0
    for _ in range(100):
        length = (low * at_high - high * at_low) / (at_high - at_low)
        if not low < length < high:
            length = 0.5 * (low + high)
        # where no double lies between, it is the end behind the event
        done = high - low <= 1e-15 * h or not low < length < high
        length = high if done else length
        attempt(y, length, mode, case, rtol, stages, trial)
        value = _left(trial, stages, mode, case, goal)
        if done or abs(value) <= _ROUNDING:
            break
        if value > 0.0:
            low, at_low = length, value
            at_high = 0.5 * at_high if last == 1 else at_high
            last = 1
        else:
            high, at_high = length, value
            at_low = 0.5 * at_low if last == -1 else at_low
            last = -1
    return length


@inner_jit
def _dip(h, before, behind):
    """Length to the least value of the cubic through both ends if that is below 0, else h."""
    value, slope = before
    end, rise = behind
    if not (value > 0.0 and end > 0.0 and slope < 0.0 and rise > 0.0):
        return h
    bend = 3.0 * (end - value) - h * (2.0 * slope + rise)
    twist = h * (slope + rise) - 2.0 * (end - value)
    x = -h * slope / (bend + np.sqrt(max(bend * bend - 3.0 * twist * h * slope, 0.0)))
    low = value + x * (h * slope + x * (bend + x * twist))
    return x * h if low <= 0.0 and 1e-3 < x < 1.0 else h


@inner_jit
def _write(rows, n, clock, y, out):
    rows[n, TIME], rows[n, CELL], rows[n, MODE] = clock.time, clock.engagement, clock.mode
    rows[n, TOUCH], rows[n, FORCE] = clock.touch, out[IMPULSE]
    for k in range(STATE):
        rows[n, FIRST + k] = y[k]
    rows[n, BENDS], rows[n, BENDS + 1] = out[2], out[3]


@inner_jit
def _switch(y, clock, case):
    """Let go, or note a touch and the speed across the slot in it."""
    # a wall that lets go while it is still pressed in loses what its spring holds
    y[WALLS] += stored(y, clock.mode, case)
    if clock.mode != FREE:
        clock.mode = FREE
        return
    across, _radius, _sine, _cosine, speed = place(y, case.scene)
    clock.mode = 1 if across > 0.0 or (across == 0.0 and speed >= 0.0) else -1
    # a wall may push again before the pin has left it
    if abs(across) - case.joint.play < _TOUCHED:
        clock.touch = abs(speed)
    y[WALLS] -= stored(y, clock.mode, case)


@inner_jit
def _arrive(y, clock, case, step):
    """Pass the end of the engagement: into the dwell, or to the next pin."""
    scene = case.scene
    if scene.dwell > 0.0 and clock.mode != LOCKED:
        # the lock stops the follower where it stands
        y[WALLS] += 0.5 * y[3] * y[3] + stored(y, clock.mode, case)
        y[3], clock.mode = 0.0, LOCKED
        return
    y[0] = scene.edges[0]
    y[1] -= step
    clock.engagement += 1
    if clock.mode == LOCKED:
        clock.mode = FREE


@inner_jit
def _goal(clock, scene):
    """Driver angle at which the engagement, or the dwell behind it, ends."""
    return scene.edges[-1] + (scene.dwell if clock.mode == LOCKED else 0.0)


@inner_jit
def _advance(y, clock, case, rtol, end, events, stages, trial):
    """Take a step that the error allows into `trial`, so long at most that it ends at an event.

    `events` tells whether a touch or letting go is looked for. The result is its length, 0 where
    none was accepted, and whether the contact changes there and the pin is at its goal.
    """
    mode = clock.mode
    decay = stiffest(y, mode, case)[1]
    most = _STABLE / decay if decay > 0.0 else np.inf
    if mode == FREE:
        most = _LONGEST_FLIGHT / (abs(y[2]) + abs(y[3]) + case.joint.slip)
    h = min(clock.step, end - clock.time, most)
    error = attempt(y, h, mode, case, rtol, stages, trial)
    clock.steps += 1
    factor = min(max(0.9 * error**-0.125, 0.2), 6.0) if error > 0.0 else 6.0
    if not error <= 1.0:
        clock.step = h * (factor if error == error else 0.1)
        return 0.0, False, False
    clock.step = max(clock.step, h * factor) if h < clock.step else h * factor
    passed = False
    if events:
        here, full = room(y, stages[0], mode, case), h
        h = _dip(h, here, room(trial, stages[STAGES], mode, case))
        if h < full:
            attempt(y, h, mode, case, rtol, stages, trial)
        passed = room(trial, stages[STAGES], mode, case)[0] <= 0.0
        if passed:
            h = _locate(y, h, mode, case, rtol, stages, trial, np.nan)
    goal = _goal(clock, case.scene)
    arrived = trial[0] >= goal
    if arrived:
        h = _locate(y, h, mode, case, rtol, stages, trial, goal)
    return h, passed, arrived


@jit(allocates=True)
def march(y, clocks, scene, joint, step, rtol, engagements, end, limit, rows):
    """Go on with a motion until it has passed `engagements`, or the time `end`.

    Parameters
    ----------
    y : shape (STATE,); it is moved on, and so is `clocks`, of one `CLOCK`.
    step : angle by which the follower turns from pin to pin [rad].
    rows : shape (n, ROW), for the states at the ends of steps. Where the law or the pin
        changes there are two rows of one time.

    Returns
    -------
    int, int
        Rows that were written, and why it ends.
    """
    clock = clocks[0]
    stages, trial = np.empty((STAGES + 1, STATE)), np.empty(STATE)
    n, idle, fresh = 0, 0, True
    case = Engagement(scene, joint, 0.0, 0.0)
    while True:
        if fresh:
            case = Engagement(scene, joint, clock.engagement * cell_of(scene), clock.touch)
            rates(y, clock.mode, case, stages[0])
            _write(rows, n, clock, y, stages[0])
            n, fresh = n + 1, False
        if clock.engagement >= engagements or clock.time >= end:
            return n, ARRIVED
        if clock.steps >= limit:
            return n, TOO_LONG
        if clock.time - clock.moved > _PATIENCE:
            return n, STANDS
        if n + 2 > rows.shape[0]:
            return n, RUNNING
        # where both the contact and the flight end at once, one of them goes on for a step
        looks = idle < _MOST_IDLE
        h, passed, arrived = _advance(y, clock, case, rtol, end, looks, stages, trial)
        if h == 0.0:
            continue
        idle = idle + 1 if h <= _ROUNDING * clock.time else 0
        clock.time = end if end - clock.time <= h else clock.time + h
        y[:], stages[0] = trial, stages[STAGES]
        if max(abs(y[2]), abs(y[3])) > 10.0 * joint.slip:
            clock.moved = clock.time
        event = arrived or passed or clock.time >= end
        if event or clock.time - rows[n - 1, TIME] >= _THIN / stiffest(y, clock.mode, case)[0]:
            _write(rows, n, clock, y, stages[0])
            n += 1
        if arrived:
            _arrive(y, clock, case, step)
        elif passed:
            _switch(y, clock, case)
        if arrived or passed:
            fresh = True
            clock.step = min(clock.step, 0.1 / np.sqrt(joint.stiffness / scene.rho))
