"""The motion from handoff to handoff, mode by mode and step by step."""

from collections import namedtuple

import numpy as np

from escapement.dynamics.codes import Ending, Event
from escapement.dynamics.event_rows import EVENT
from escapement.engines.two_bodies import step
from escapement.engines.two_bodies.change import behind_event, close, contact_of, flight
from escapement.engines.two_bodies.law import MOTION, STATE, Mode, push_at, touching
from escapement.engines.two_bodies.watch import OVERLAPS, WATCH, first_closed, longest_step
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.records import record_dtype

_IMAGES, _SIGNS = ("pair", "nose", "track"), ("sigma", "driver_sense", "follower_sense")
ROW = record_dtype({
    **EVENT, "engagement": np.int64, "lost": (float, (STATE - MOTION,)),
    "length": float,
    **dict.fromkeys(_IMAGES, np.int64), **dict.fromkeys(_SIGNS, float),
})  # fmt: skip
"""A row of the record: an event, or `STEP` within a piece, of which it has the length. Work that is
lost is counted from the start of the motion; the wall is the sense in which the contact turns the
follower, and 0 without contact."""
BEGIN = 12
"""Numbers of the state at the start of the motion or at a handoff."""
(TIME, SPEED, PHI, TURNING, THETA, STEPS, PAIR, _NOSE, _TRACK, _SIGMA, _FIRST, _SECOND) = range(12)
"""Their columns: time, speeds and angles since the last handoff, pitches that were taken off the
follower's angle, and the mode."""
STEP, UNKNOWN = -1, -2
"""A row that is no event, and the pair in the state of a motion whose mode is still to be found."""
AT_ONCE, MOST_STEPS = 20_000, 100_000
"""Steps after which a call ends at the next handoff, and those of an engagement."""
SMALLEST = 1e-14


Notes = namedtuple("Notes", "rows used engagement")
"""The record: its rows, how many are used, and the steps taken; the engagement."""


@inner_jit
def _note(law, pairs, notes, kind, time, mode, y):
    """Write a row if any are wanted; their number is counted."""
    if len(notes.rows) == 0:
        return
    at, size = notes.used[0], len(notes.rows)
    notes.used[0] = at + 1
    row = notes.rows[min(at, size - 1)]
    row.kind, row.engagement, row.time, row.theta = kind, notes.engagement, time, y[0]
    row.phi, row.speed, row.turning = y[1], y[2], y[3]
    for i in range(MOTION, STATE):
        row.lost[i - MOTION] = y[i]
    row.pair, row.nose, row.track, row.sigma = mode.pair, mode.nose, mode.track, mode.sigma
    row.driver_sense, row.follower_sense = mode.driver_sense, mode.follower_sense
    row.before = row.approach = row.impulse = row.energy = row.wall = 0.0
    if mode.pair >= 0:
        row.wall = -1.0 if touching(law, pairs, mode, y).g1 < 0.0 else 1.0


@inner_jit
def _struck(law, pairs, notes, mode, y, time, contact):
    """Take the blow of a contact that begins, and note it; returns the next mode, and `Ending`."""
    other = mode
    mode, ending, first, second = close(law, pairs, mode, y, contact)
    for blow, pair in ((first, contact), (second, other)):
        if len(notes.rows) > 0 and blow.approach > 0.0:
            _note(law, pairs, notes, Event.IMPACT, time, pair, y)
            row = notes.rows[min(notes.used[0], len(notes.rows)) - 1]
            row.before, row.approach, row.impulse = blow.before, blow.approach, blow.impulse
            row.energy, (row.speed, row.turning) = blow.energy, blow.after
    return mode, ending


@inner_jit
def _engage(law, pairs, joints, watch, notes, y, path, mode, goal, end_time):
    """Follow the motion to the driver angle `goal`; returns mode, time and an `Ending`."""
    time, longest, begun, event, trend = 0.0, np.inf, True, step.NOTHING, 0.0
    reach = path.span[1] = 0.0
    touched = mode.pair >= 0 or y[0] > 1e-3 * goal
    for i in range(len(watch)):
        watch[i].distance, watch[i].behind = -1.0, 0  # each pair is looked at once a pitch
        watch[i].theta_first = np.inf
    for _ in range(MOST_STEPS):
        notes.used[1] += 1
        touched = touched or mode.pair >= 0
        push = push_at(law, pairs, mode, y)
        length = min(longest_step(y, push), longest)
        error = step.advance(law, pairs, mode, y, push, length, step.SHRINKS, path)
        if not error <= step.ERROR and length > SMALLEST:
            longest, reach = length * step.growth(error), reach if error < np.inf else 0.0
            continue
        before, reach = reach, length * step.growth(error)
        # where steps become shorter, the next one will be shorter still
        longest = reach * min(1.0, reach / max(before, SMALLEST))
        # where the driver's acceleration passes zero, rounding would give it the sense of before
        trend = -trend if event == step.TURNS else np.sign(push.driver)
        part, event = step.first_event(law, pairs, mode, y, length, goal, trend, path)
        part, closed, found = first_closed(law, pairs, joints, watch, mode, y, length, part, path)
        event = event if closed < 0 else step.NOTHING
        if found == OVERLAPS:
            return mode, time + part, Ending.OVERLAPS
        if part > 0.0:
            if len(notes.rows) > 0:
                kind = Event.FLIGHT if mode.pair < 0 else Event.CONTACT
                _note(law, pairs, notes, kind if begun else STEP, time, mode, y)
                notes.rows[min(notes.used[0], len(notes.rows)) - 1].length = length
            step.state_at(path, y, length, part, path.here)
            for i in range(len(y)):
                y[i] = path.here[i]
            if mode.pair >= 0:
                step.bring_back(law, pairs, mode, y)
            time, begun, path.span[0] = time + part, False, part
        if time >= end_time:
            return mode, time, Ending.OVER
        if closed >= 0:
            contact, touched = contact_of(closed, watch[closed].nose, watch[closed].track), True
            mode, ending = _struck(law, pairs, notes, mode, y, time, contact)
        elif event == step.HANDOFF:
            return mode, time, Ending.DONE if touched else Ending.UNDRIVEN
        elif event in (step.NOTHING, step.TURNS):
            continue
        else:
            before = mode
            mode, ending = behind_event(law, pairs, mode, y, event)
            if before.pair >= 0 and mode.pair < 0:
                _note(law, pairs, notes, Event.LIFT_OFF, time, mode, y)
            elif before.pair >= 0 and event == step.SLIPS:
                _note(law, pairs, notes, Event.SLIDE_CHANGE, time, mode, y)
        if ending != Ending.RUNNING:
            return mode, time, ending
        begun, longest, reach, path.span[1] = True, np.inf, 0.0, 0.0
    return mode, time, Ending.TOO_LONG


@inner_jit
def _read(law, begin, y):
    """The mode that a state holds; its angles and speeds are written into y."""
    y[0], y[1], y[2], y[3] = begin[THETA], begin[PHI], begin[SPEED], begin[TURNING]
    if begin[PAIR] == UNKNOWN:
        return flight(law, y)[0]
    pair, nose, track = int(begin[PAIR]), int(begin[_NOSE]), int(begin[_TRACK])
    return Mode(pair, nose, track, begin[_SIGMA], begin[_FIRST], begin[_SECOND])


@inner_jit
def _write(begin, time, mode, y, pitches, pairs, steps):
    """Write the state at a handoff, with the angles that are left of a pitch."""
    turned = np.rint(y[1] / pitches[1])
    begin[TIME], begin[THETA], begin[PHI] = time, y[0] - pitches[0], y[1] - turned * pitches[1]
    begin[SPEED], begin[TURNING], begin[STEPS], begin[PAIR] = y[2], y[3], steps + turned, mode.pair
    begin[_SIGMA], begin[_FIRST] = mode.sigma, mode.driver_sense
    begin[_SECOND], begin[_NOSE], begin[_TRACK] = mode.follower_sense, mode.nose, mode.track
    if mode.pair >= 0:
        # the same place is that of another image
        first = pairs[mode.pair].nose == 0
        begin[_NOSE] += 1.0 if first else turned
        begin[_TRACK] += turned if first else 1.0


@jit(allocates=True)
def march(law, pairs, joints, pitches, limit, first, begins, rows, used):
    """Follow engagements until `begins` is full, a time is passed, or the motion ends.

    If no rows are wanted it also returns, RUNNING, behind `AT_ONCE` steps.

    Parameters
    ----------
    law : a `Law`.
    pairs : as `pairs_of` gives them. joints : those of the features of driver and follower.
    pitches : angles after which driver and follower look the same.
    limit : time after which to stop.
    first : number of the engagement that begins with the first state.
    begins : shape (n + 1, BEGIN). The first is given; the others are filled in.
    rows : filled with the steps and events, if there is room for any.
    used : number of rows, and of steps, both 0 before.

    Returns
    -------
    ending, done, theta, time
        How the last engagement ended, how many were completed, where and when it ended.
    """
    y = np.zeros(STATE if len(rows) > 0 else MOTION)
    path, watch = step.path_for(len(y)), np.zeros(len(pairs), WATCH)
    time, mode = begins[0, TIME], _read(law, begins[0], y)
    for i in range(len(watch)):
        watch[i].nose_turn = watch[i].track_turn = 1.0  # of the images 0
    for k in range(len(begins) - 1):
        notes, begun = Notes(rows, used, first + k), used[0]
        here = altered(law, "begin", law.begin - (first + k) * pitches[0])
        ends = limit - time
        mode, end, ending = _engage(
            here, pairs, joints, watch, notes, y, path, mode, pitches[0], ends
        )
        for i in range(begun, min(used[0], len(rows))):
            rows[i].time += time
        time += end
        if ending != Ending.DONE:
            return ending, k, y[0], time
        _write(begins[k + 1], time, mode, y, pitches, pairs, begins[k, STEPS])
        mode = _read(law, begins[k + 1], y)
        if len(rows) == 0 and used[1] > AT_ONCE and k + 2 < len(begins):
            return Ending.RUNNING, k + 1, 0.0, time
    return Ending.DONE, len(begins) - 1, 0.0, time
