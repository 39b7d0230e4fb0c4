"""The motion from handoff to handoff, mode by mode and step by step."""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import Ending, Event
from escapement.engines.two_bodies.change import behind_event, close, contact_of, flight
from escapement.engines.two_bodies.law import MOTION, STATE, Mode, push_at, touching
from escapement.engines.two_bodies.step import (
    ERROR,
    HANDOFF,
    NOTHING,
    TURNS,
    advance,
    first_event,
    memory_for,
)
from escapement.engines.two_bodies.watch import WATCH, bounds_of, look, passes
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.records import record_dtype

_MODE = {
    **dict.fromkeys(("pair", "nose", "track"), np.int64),
    **dict.fromkeys(("sigma", "driver_sense", "follower_sense"), float),
}
ROW = record_dtype({
    "kind": np.int64, "engagement": np.int64, "time": float, "y": (float, (STATE,)), **_MODE,
    "side": float,  # the sense in which the contact turns the follower, 0 in flight
    # of an impact: driver speed before it, speed of approach, impulse, and the energy that it takes
    **dict.fromkeys(("before", "approach", "impulse", "energy"), float),
})  # fmt: skip
"""A row of the record: the start of a step. Its kind is an `Event`, or `STEP` within a piece. Work
that is lost is counted from the start of the motion."""
BEGIN = record_dtype({
    "time": float, **dict.fromkeys(("theta", "phi", "speed", "turning"), float),
    **dict.fromkeys(("fresh", "number", "steps"), np.int64), **_MODE,
})  # fmt: skip
"""The state at the start of the motion or at a handoff, with the angles since the last handoff.

fresh : whether the mode is still to be found. number : of the engagement. steps : pitches of a
follower that repeats, which were taken off its angle."""
STEP = -1
AT_ONCE, MOST_STEPS = 20_000, 100_000
"""Steps after which a call ends at the next handoff, and those of an engagement."""
SMALLEST = 1e-14


class Notes(NamedTuple):
    """The record of a motion: its rows, how many are used, and the steps taken; whether rows are
    wanted, and the engagement.
    """

    rows: np.ndarray
    used: np.ndarray
    wanted: bool
    engagement: int


@inner_jit
def _note(law, pairs, notes, kind, time, mode, y):
    """Write a row if there is room; the number of rows is counted in any case."""
    at = notes.used[0]
    notes.used[0] = at + 1
    if at < notes.rows.size:
        row = notes.rows[at]
        row.kind, row.engagement, row.time = kind, notes.engagement, time
        for i in range(len(y)):
            row.y[i] = y[i]
        row.pair, row.nose, row.track, row.sigma = mode.pair, mode.nose, mode.track, mode.sigma
        row.driver_sense, row.follower_sense = mode.driver_sense, mode.follower_sense
        row.before = row.approach = row.impulse = row.energy = row.side = 0.0
        if mode.pair >= 0:
            row.side = np.sign(touching(law, pairs, mode, y).g1)


@inner_jit
def _note_impact(law, pairs, notes, time, mode, y, before, found):
    """Write the row of a blow in the mode of the contact that closed."""
    _note(law, pairs, notes, Event.IMPACT, time, mode, y)
    if notes.used[0] <= notes.rows.size:
        row = notes.rows[notes.used[0] - 1]
        row.before, row.approach = before, found.approach
        row.impulse, row.energy = found.impulse, found.energy


@inner_jit
def _kind_of(mode):
    return Event.FLIGHT if mode.pair < 0 else Event.CONTACT


@inner_jit
def _first_closed(law, pairs, joints, watch, mode, y, push, bounds, time):
    """Look at the pairs whose times have come; returns the one that closes, or -1, and a time."""
    until = time + bounds.cap
    for i in range(len(watch)):
        if watch[i].until <= time and look(
            law, pairs, joints, watch, i, mode, y, push, bounds, time
        ):
            return i, time
        until = min(until, watch[i].until)
    return -1, until


@inner_jit
def _passed(law, pairs, watch, mode, y, length, out, work):
    """A near pair whose track is passed within a step, or -1, and the length to there."""
    found = -1
    for i in range(len(watch)):
        if watch[i].near == 0 or not passes(law, pairs, watch, i, out):
            continue
        low, high = 0.0, length
        while high - low > 1e-15 * length:
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            advance(law, pairs, mode, y, middle, out, work)
            if passes(law, pairs, watch, i, out):
                high = middle
            else:
                low = middle
        length, found = high, i
        advance(law, pairs, mode, y, length, out, work)
    return found, length


@inner_jit
def _look_anew(watch, time):
    """Every pair has to be looked at again."""
    for i in range(len(watch)):
        watch[i].until = time


@inner_jit
def _engage(law, pairs, joints, watch, notes, memory, mode, goal, end_time):
    """Follow the motion to the driver angle `goal`; returns mode, time and an `Ending`."""
    y, out, work = memory
    time, length, begun = 0.0, np.inf, True
    touched = mode.pair >= 0 or y[0] > 1e-3 * goal
    _look_anew(watch, time)
    for _ in range(MOST_STEPS):
        notes.used[1] += 1
        touched = touched or mode.pair >= 0
        push = push_at(law, pairs, mode, y)
        bounds = bounds_of(law, y, push, mode)
        closed, until = _first_closed(law, pairs, joints, watch, mode, y, push, bounds, time)
        event = NOTHING
        if closed < 0:
            part = min(until - time, length)
            error = advance(law, pairs, mode, y, part, out, work)
            length = np.inf
            if error > ERROR and part > SMALLEST:
                length = part * max(0.2, 0.8 * (ERROR / error) ** (1.0 / 7.0))
                continue
            if notes.wanted and (begun or mode.pair >= 0 or not law.plain):
                _note(law, pairs, notes, _kind_of(mode) if begun else STEP, time, mode, y)
            begun, trend = False, np.sign(push.driver)
            part, event = first_event(law, pairs, mode, y, part, goal, trend, out, work)
            closed, part = _passed(law, pairs, watch, mode, y, part, out, work)
            time += part
            for i in range(len(y)):
                y[i] = out[i]
        if time >= end_time:
            return mode, time, Ending.OVER
        if closed >= 0:
            touched, before = True, y[2]
            seen = watch[closed]
            struck = contact_of(closed, seen.nose, seen.track)
            found = close(law, pairs, mode, y, struck)
            if notes.wanted and found.approach > 0.0:
                _note_impact(law, pairs, notes, time, struck, y, before, found)
        elif event == HANDOFF:
            return mode, time, Ending.DONE if touched else Ending.UNDRIVEN
        elif event in (NOTHING, TURNS):
            continue
        else:
            found = behind_event(law, pairs, mode, y, event)
        mode = found.mode
        if found.ending != Ending.RUNNING:
            return mode, time, found.ending
        begun = True
        _look_anew(watch, time)
    return mode, time, Ending.TOO_LONG


@inner_jit
def _read(begin, y):
    """The mode that a `BEGIN` holds; its angles and speeds are written into y."""
    y[0], y[1], y[2], y[3] = begin.theta, begin.phi, begin.speed, begin.turning
    return Mode(
        pair=begin.pair, nose=begin.nose, track=begin.track, sigma=begin.sigma,
        driver_sense=begin.driver_sense, follower_sense=begin.follower_sense,
    )  # fmt: skip


@inner_jit
def _write(begin, time, mode, y, driver_pitch, follower_pitch, pair, steps):
    """Write the state at a handoff, with the angles that are left of a pitch."""
    turned = np.round(y[1] / follower_pitch)
    begin.time, begin.theta, begin.phi = time, y[0] - driver_pitch, y[1] - turned * follower_pitch
    begin.speed, begin.turning, begin.steps = y[2], y[3], steps + int(turned)
    begin.pair, begin.nose, begin.track, begin.sigma = mode.pair, mode.nose, mode.track, mode.sigma
    begin.driver_sense, begin.follower_sense = mode.driver_sense, mode.follower_sense
    if mode.pair >= 0:
        # the same place is that of another image
        driver_first = pair.nose == 0
        begin.nose = mode.nose + (1 if driver_first else int(turned))
        begin.track = mode.track + (int(turned) if driver_first else 1)


@jit(allocates=True)
def march(law, pairs, joints, pitches, limit, begins, rows, used):
    """Follow engagements until `begins` is full, a time is passed, or the motion ends.

    It also returns, RUNNING, behind an engagement with which it has taken `AT_ONCE` steps.

    Parameters
    ----------
    law : a `Law`.
    pairs : as `pairs_of` gives them. joints : those of the features of driver and follower.
    pitches : angles after which driver and follower look the same.
    limit : time after which to stop.
    begins : `BEGIN`, shape (n + 1,). The first is given; the others are filled in.
    rows : filled with the steps and events, if there is room for any.
    used : number of rows, and of steps, both 0 before.

    Returns
    -------
    ending, done, theta, time
        How the last engagement ended, how many were completed, where and when it ended.
    """
    wanted = len(rows) > 0
    size = STATE if wanted else MOTION
    y, out = np.zeros(size), np.zeros(size)
    memory = (y, out, memory_for(size))
    watch = np.zeros(len(pairs), WATCH)
    fresh = begins[0].fresh != 0
    mode = _read(begins[0], y)
    if fresh:
        mode = flight(law, y).mode
    begin, time = law.begin, 0.0
    for k in range(len(begins) - 1):
        notes = Notes(rows=rows, used=used, wanted=wanted, engagement=k)
        start, first = begins[k].time, used[0]
        here = altered(law, "begin", begin - (k + begins[0].number) * pitches[0])
        mode, time, ending = _engage(
            here, pairs, joints, watch, notes, memory, mode, pitches[0], limit - start
        )
        for i in range(first, min(used[0], len(rows))):
            rows[i].time += start
        time += start
        if ending != Ending.DONE:
            return ending, k, y[0], time
        pair = pairs[max(mode.pair, 0)]
        _write(begins[k + 1], time, mode, y, pitches[0], pitches[1], pair, begins[k].steps)
        begins[k + 1].number = begins[k].number + 1
        mode = _read(begins[k + 1], y)
        if used[1] > AT_ONCE and k + 2 < len(begins):
            return Ending.RUNNING, k + 1, 0.0, time
    return Ending.DONE, len(begins) - 1, 0.0, time
