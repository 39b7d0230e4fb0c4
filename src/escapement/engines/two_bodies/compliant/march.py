"""The motion of two bodies whose outlines yield, step by step.

Closed contacts are kept in a list. A contact enters it where its gap closes, or where the foot of a
contact beside it leaves its feature, and leaves it where its gap opens. What comes from behind a
track never enters it. Steps of `dynamics.radau` end at these events, so that the law is
smooth within each.
"""

import numpy as np

from escapement.dynamics.codes import Ending
from escapement.dynamics.compliance import STATE, WALLS
from escapement.dynamics.radau import (
    ROUNDING,
    STAGES,
    attempt,
    go_on,
    growth,
    locate,
    prepare,
    workspace,
)
from escapement.engines.two_bodies.compliant.law import (
    CLOSES,
    CONTACT,
    HANDOFF,
    LIFTS,
    MOST,
    NOTHING,
    PUSHES,
    Goal,
    Yielding,
    frequency,
    left,
    pressed,
    rates,
    stored,
)
from escapement.engines.two_bodies.touch import ALLOWED, dot, images, nearness, place
from escapement.engines.two_bodies.watch import joined
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.records import record_dtype

CLOCK = record_dtype({
    **dict.fromkeys(("time", "step", "moved"), float),
    **dict.fromkeys(("mode", "engagement", "turned", "touched", "tries"), np.int64),
})  # fmt: skip
"""What the next step needs in addition to the state: see `compliant.march.CLOCK` of the pin in its
slot. `turned` counts the pitches that were taken off the follower's angle."""
STEP_END = record_dtype({
    **dict.fromkeys(("time", "touch"), float),
    **dict.fromkeys(("engagement", "turned", "mode", "count"), np.int64),
    "state": (float, (STATE,)), "series": (float, (STAGES, 2)),
    "places": (np.int64, (MOST, 4)), "touches": (float, (MOST,)),
})  # fmt: skip
"""The end of a step: the mode is the sense in which the last contact turns the follower, or 0."""
MOST_EACH = 20_000
"""Steps that a motion may try for each engagement, in addition to a limit."""
_LONGEST = 0.02
"""Greatest angle of a step [rad]."""
_MARGIN = 1e-4
"""A step may end with a nose so deep in the other body [length of the mechanism]."""
_BEHIND = 1e-6
"""A contact that begins deeper than this came from behind, or, if it is not deeper than a step can
end, past the end of a feature beside it: a shorter step then tells."""
_SHORTEST = 1e-7
"""A shorter step tells no more."""
_BESIDE = 1e-8
"""Beside each other features differ by less than this in the depth of a nose."""
_FIRST = 0.3
"""First step after an event, divided by the time scale of the contact."""
_MOST_IDLE = 20
_PATIENCE = 30.0
"""Bodies that are slower than ten slip speeds for this long count as at rest."""


@inner_jit
def _survey(case, y, mode, start):
    """Look at every pair; returns the longest step in which no contact can be missed."""
    speed, gain = abs(y[2]) + abs(y[3]), abs(start[2]) + abs(start[3])
    longest = 2.0 * _LONGEST / (speed + np.sqrt(speed * speed + 2.0 * gain * _LONGEST))
    for i in range(len(case.pairs)):
        seen, pair = case.seen[i], case.pairs[i]
        nose, track = images(pair, case.law.centre, y)
        seen.pair, seen.nose, seen.track = i, nose, track
        at = pressed(case, seen, y)
        # what comes from behind never touches
        seen.active = 0 if at.foot >= 0.0 and at.depth > ALLOWED else 1
        for k in range(mode):
            if joined(case.pairs, case.joints, case.held[k], i, nose, track):
                seen.active = 0
        if seen.active == 0:
            continue
        here = place(pair, case.law.centre, y, nose, track)
        near = nearness(pair, here)
        closing = abs(here.v) if near.jumps else max(-dot(near.direction, here.v), 0.0)
        bend = abs(here.a) + gain * max(abs(here.arm), abs(here.at))
        way = max(near.distance, 0.0) + _MARGIN
        longest = min(
            longest, 2.0 * way / (closing + np.sqrt(closing * closing + 2.0 * bend * way))
        )
    return longest


@inner_jit
def _number(goal, k, mode):
    """The event with a number: the handoff, three of each contact, then those of every pair."""
    if k == 0:
        return Goal(HANDOFF, 0, goal)
    if k <= 3 * mode:
        return Goal(LIFTS + (k - 1) // mode, (k - 1) % mode, goal)
    return Goal(CLOSES, k - 3 * mode - 1, goal)


@inner_jit
def _advance(case, y, clock, rtol, end, goal, looks, work):
    """Take a step to `work.end` that keeps the tolerance and ends at the first event in it.

    `looks` says whether to look for changes of contacts. Returned are the length of the step, 0 if
    none was accepted, and the event.
    """
    mode, nothing = clock.mode, Goal(NOTHING, 0, goal)
    h = min(clock.step, end - clock.time, _survey(case, y, mode, work.stages[0]))
    error = attempt(y, h, mode, case, rtol, work)
    factor, full, found = growth(error), h, nothing
    if not error <= 1.0:
        clock.step = h * factor
        return 0.0, nothing
    clock.step = max(clock.step, h * factor) if h < clock.step else h * factor
    for k in range(1 + 3 * mode + len(case.seen) if looks else 1):
        event = _number(goal, k, mode)
        if event.kind == CLOSES and case.seen[event.index].active == 0:
            continue
        if left(case, work.end, mode, work.stages[STAGES], event) > 0.0:
            continue
        length = locate(y, h, mode, case, rtol, work, event)
        depth = (
            pressed(case, case.seen[event.index], work.end).depth if event.kind == CLOSES else 0.0
        )
        beside = _BEHIND < depth <= 2.0 * _MARGIN and full > _SHORTEST
        behind = depth > _BEHIND
        if length == 0.0 or beside or (behind and attempt(y, h, mode, case, rtol, work) == np.inf):
            clock.step = 0.5 * full
            return 0.0, nothing
        if behind:
            continue
        h, found = length, event
    return h, found


@inner_jit
def _take(case, k, contact):
    """Write a contact into the list."""
    held = case.held[k]
    held.pair, held.nose, held.track = contact.pair, contact.nose, contact.track
    held.touch, held.active = contact.touch, contact.active


@inner_jit
def _change(case, y, clock, event):
    """Change the list of contacts behind an event."""
    before, k = stored(case, y, clock.mode), event.index
    if event.kind == CLOSES:
        case.seen[k].touch = pressed(case, case.seen[k], y).rate
        _take(case, clock.mode, case.seen[k])
        clock.mode, clock.touched = clock.mode + 1, 1
    elif event.kind == PUSHES:
        case.held[k].active = 1
    elif event.kind == LIFTS and case.held[k].active != 0:
        case.held[k].active = 0
    elif event.kind == LIFTS or not _pass_on(case, y, case.held[k]):
        clock.mode -= 1
        for i in range(k, clock.mode):
            _take(case, i, case.held[i + 1])
    # a force that ends while the contact is pressed in loses the energy of its spring
    y[WALLS] += before - stored(case, y, clock.mode)


@inner_jit
def _pass_on(case, y, contact):
    """Hand a contact on to the feature beside the one that its foot leaves, if there is one."""
    depth, old = pressed(case, contact, y).depth, case.pairs[contact.pair]
    for i in range(len(case.seen)):
        seen, pair = case.seen[i], case.pairs[i]
        seen.nose, seen.track = images(pair, case.law.centre, y)
        same = pair.nose == old.nose and pair.nose_feature == old.nose_feature
        same = same and pair.track_feature == old.track_feature
        same = same and (seen.nose - contact.nose) % pair.nose_fold == 0
        if same and (seen.track - contact.track) % pair.track_fold == 0:
            continue
        if not joined(case.pairs, case.joints, contact, i, seen.nose, seen.track):
            continue
        at = pressed(case, seen, y)
        if at.foot >= -_BESIDE and abs(at.depth - depth) <= _BESIDE:
            contact.pair, contact.nose, contact.track = i, seen.nose, seen.track
            return True
    return False


@inner_jit
def _hand_over(case, y, clock, pitches):
    """Take a pitch off the angles at a handoff; contacts have other images then."""
    turned = np.rint(y[1] / pitches[1])
    y[0] -= pitches[0]
    y[1] -= turned * pitches[1]
    clock.engagement += 1
    clock.turned += turned
    for k in range(clock.mode):
        held, first = case.held[k], case.pairs[case.held[k].pair].nose == 0
        held.nose += 1 if first else turned
        held.track += turned if first else 1


@inner_jit
def _write(row, clock, case, y, series):
    row.time, row.engagement, row.turned = clock.time, clock.engagement, clock.turned
    row.count, row.mode, row.touch = clock.mode, 0, 0.0
    for k in range(STATE):
        row.state[k] = y[k]
    for power in range(STAGES):
        row.series[power, 0], row.series[power, 1] = series[power, 0], series[power, 1]
    for k in range(clock.mode):
        held = case.held[k]
        row.places[k, 0], row.places[k, 1], row.places[k, 2] = held.pair, held.nose, held.track
        row.places[k, 3], row.touches[k] = held.active, held.touch
        if held.active != 0:
            row.mode = 1 if pressed(case, held, y).touch.g1 > 0.0 else -1
            row.touch = held.touch


@inner_jit
def _depth(case, y, mode):
    """Depth of the deepest contact."""
    most = 0.0
    for k in range(mode):
        most = max(most, pressed(case, case.held[k], y).depth)
    return most


@jit(allocates=True)
def march(y, clocks, held, bodies, pitches, deepest, rtol, engagements, end, limit, rows):
    """Continue a motion until it has passed `engagements`, or the time `end`.

    Parameters
    ----------
    y : the state, shape (STATE,). It is replaced by the last one, and so are `clocks`, of one
        `CLOCK`, and `held`, of `MOST` of `CONTACT`.
    bodies : law, pairs, joints and joint of a `Yielding`. pitches : of driver and follower.
    deepest : depth of a contact at which the motion ends.
    limit : number of tries after which to give up, in addition to MOST_EACH for each engagement.
    rows : array of `STEP_END`, to be filled. Where the law changes, there are two rows with the
        same time.

    Returns
    -------
    int, Ending
        Number of rows that were written, and why the march ends: RUNNING where the rows are full.
    """
    law, pairs, joints, joint = bodies
    clock, work, bare = clocks[0], workspace(), np.zeros((STAGES, 2))
    seen, n, idle, fresh = np.zeros(len(pairs), CONTACT), 0, 0, True
    case = Yielding(law, pairs, joints, joint, held, seen)
    while True:
        if fresh:
            begin = law.begin - clock.engagement * pitches[0]
            case = Yielding(altered(law, "begin", begin), pairs, joints, joint, held, seen)
            rates(case, y, clock.mode, work.stages[0])
            prepare(y, clock.mode, case, work)
            _write(rows[n], clock, case, y, bare)
            work.span[0], n, fresh = 0.0, n + 1, False
        if clock.engagement >= engagements or clock.time >= end:
            return n, Ending.ARRIVED
        if clock.tries >= limit + MOST_EACH * clock.engagement:
            return n, Ending.TOO_LONG
        if clock.time - clock.moved > _PATIENCE:
            return n, Ending.STANDS
        if _depth(case, y, clock.mode) > deepest:
            return n, Ending.SINKS
        if n + 2 > rows.shape[0]:
            return n, Ending.RUNNING
        looks = idle < _MOST_IDLE
        h, event = _advance(case, y, clock, rtol, end, pitches[0], looks, work)
        clock.tries, work.tries[0] = clock.tries + work.tries[0], 0
        if h == 0.0:
            continue
        idle = idle + 1 if h <= ROUNDING * clock.time else 0
        clock.time = end if end - clock.time <= h else clock.time + h
        go_on(y, work)
        if max(abs(y[2]), abs(y[3])) > 10.0 * joint.slip:
            clock.moved = clock.time
        _write(rows[n], clock, case, y, work.series)
        n += 1
        if event.kind == NOTHING:
            prepare(y, clock.mode, case, work)
            continue
        if event.kind == HANDOFF:
            _hand_over(case, y, clock, pitches)
            if clock.touched == 0 and clock.engagement > 1:
                return n, Ending.UNDRIVEN
            clock.touched = min(clock.mode, 1)
        elif event.kind == CLOSES and clock.mode == MOST:
            return n, Ending.STALL
        else:
            _change(case, y, clock, event)
        fresh, clock.step = True, _FIRST / frequency(case, y, clock.mode)
