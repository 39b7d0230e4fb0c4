"""Figures of merit of a case, from its transient and its terminal cycle."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import Event, is_extremum
from escapement.dynamics.figures_of_merit import (
    FALL_63,
    FALL_98,
    LEAST_RATIO,
    MAX_ENGAGEMENTS,
    RISE_BAND,
    SETTLING_BAND,
)
from escapement.dynamics.law import is_lossless
from escapement.dynamics.load import has_load_curve
from escapement.dynamics.torque import torque_at
from escapement.engines.energy import cycle
from escapement.engines.energy.leap import (
    GENTLE_TRAINS,
    GOALS,
    ROWS,
    Leap,
    fall,
    is_gentle,
    is_worth_it,
    leap,
)
from escapement.engines.energy.located_events import NO_EVENTS, ROUGH_ERROR, has_reversal
from escapement.engines.energy.march import NO_TERMINAL, NOT_CONVERGED, OK, STALL
from escapement.engines.energy.pairs import (
    Start,
    lay_out_again,
    make_exact_in_round,
    pass_round,
    round_events,
)
from escapement.engines.energy.passage import Detail, request_of
from escapement.numerics.gauss import N
from escapement.numerics.jit import inner_jit

# Greatest number of events of a transient that are kept until the terminal cycle is known.
KEPT_EVENTS = 256
# The terminal cycle is searched for after this many engagements, settled or not.
LATEST_SEARCH = 40
# Where no leap is possible so many rounds are marched before the next attempt.
RETRY = 64
# The transient of a pattern is followed for so many engagements, that of one pair for more.
LONGEST_PATTERN = 10_000
# The leaps over a pattern end at a w this far from the terminal one.
NEAR_BAND = 0.06
# A loss or an inequality of the ends of an engagement below this share is rounding.
ROUNDING = 1e-12


class Extent(IntEnum):
    """How far a transient is followed; each member includes those before it.

    CYCLE: until the terminal cycle is known. SETTLED: until rise and settling time are.
    FALLEN: until the handoff speed is near the terminal one, for `rise_time_63` and `_98`.
    """

    CYCLE = 0
    SETTLED = 1
    FALLEN = 2


class EventRows(NamedTuple):
    """The events that stand in the rows from `first` to before `end`."""

    first: int
    end: int


@inner_jit(allocates=True, inlined=True)
def transient_memory(edges, size):
    """Room for events, and memory for handoffs and the rows of a leap, of so many pairs."""
    room = KEPT_EVENTS + 2 * round_events(edges, size)
    return room, np.empty((LATEST_SEARCH + 2 * size + 2, 2)), np.empty((ROWS, N))


@inner_jit
def figures(case, handoffs, rows, w, rtol, extent, out):
    """Figures of merit of one case into out (natural units); returns the status.

    The motion is followed from its start until it has nearly settled, and its extrema are
    kept, and so are time and w of its `handoffs`. Newton's method finds the terminal cycle from
    there. The kept events are then compared with that cycle, and the motion is followed further
    until everything that `extent` requires is known. On a stall out[0] is the driver angle and
    out[1] the engagement; both are NaN where a motion without friction loses energy in every
    engagement, which `escapement.terminal` tells first.
    """
    start, size, constant_gain = w, case.data.size, _gains_alike(case)
    _forget(out)
    if constant_gain and _only_gains(case.scene):
        return NO_TERMINAL
    request, before = request_of(Detail.EXTREMA, rtol), cycle.Attempt(w, w)
    first, in_band, k, attempt, time, rising = NO_EVENTS, 0, 0, 0, 0.0, 0.0
    rows[GOALS, 0], cycle_known, sought = np.nan, False, False
    _note_handoff(handoffs, k, time, w)
    longest = MAX_ENGAGEMENTS if size == 1 else LONGEST_PATTERN
    while k < longest:
        ready = cycle_known
        found = pass_round(case, Start(w, rising, first), request)
        used, rising = found.used, found.rising
        if found.status != OK:
            return _stopped(found, k, out)
        if constant_gain:
            # every round adds the same energy: a negative one stops the motion in the end,
            # and with a positive one the speed grows without bound
            return NO_TERMINAL if found.source > 0.0 else STALL
        noted = EventRows(first, used)
        _mark_extrema(case, noted, time)
        time = _note_round(case, handoffs, k, time)
        if cycle_known:
            in_band = _judge(case, noted, in_band, out)
            if extent == Extent.FALLEN:
                _note_falls(case, start, handoffs, k, rtol, out)
        if not sought:
            step, first = cycle.newton_step(w, found, has_reversal(case.events, first, used)), used
            if _worth_seeking(case, w, step, k, used):
                status = _seek(case, w, step, before, found, rtol, rows, out)
                sought, cycle_known, first = True, status == OK, NO_EVENTS
                known = cycle_known and extent == Extent.CYCLE
                if known or status in (NOT_CONVERGED, NO_TERMINAL):
                    return status
                if cycle_known:
                    for passed in range(0, k + 1 if extent == Extent.FALLEN else 0, size):
                        _note_falls(case, start, handoffs, passed, rtol, out)
                    in_band = _judge(case, EventRows(NO_EVENTS, used), in_band, out)
                    # from rest it takes log(0.02)/log(contraction) rounds or so, here
                    # more than the limit, so no time is given
                    if out[cycle.CONTRACTION] > 1.0 - size / MAX_ENGAGEMENTS:
                        return OK
            before = cycle.Attempt(w, step.w)
        w, k = found.w, k + size
        # two motions never cross, so w at entry tends to its terminal value from one side: when
        # a maximum and a minimum of each pair are in the band, all later ones are
        settled = cycle_known and in_band >= 2 * size
        if settled and (extent < Extent.FALLEN or out[cycle.RISE_98] >= 0.0):
            return OK
        stalls = sought and not cycle_known
        if k >= attempt and (stalls or (ready and out[cycle.CONTRACTION] > 1.0 - GENTLE_TRAINS)):
            passed = _leap_on(case, request, start, w, k, found, extent, rows, out)
            attempt = k if passed.number > 0 else k + RETRY * size
            k, w, time = k + passed.number * size, passed.w, time + passed.time
            lay_out_again(case)
            _note_handoff(handoffs, k, time, w)
    # a settling time beyond the limit of engagements is not given
    if in_band < 2 * size:
        out[cycle.SETTLING] = np.nan
    return OK if cycle_known else NOT_CONVERGED


@inner_jit
def _forget(out):
    """Set all figures to NaN."""
    for i in range(cycle.FIGURES):
        out[i] = np.nan


@inner_jit
def _gains_alike(case):
    """Whether every round adds the same energy: nothing is lost, and its ends are alike."""
    slope = 0.0
    for index in range(case.data.size):
        slope += case.data[index].slope
    return is_lossless(case.scene) and abs(slope) <= ROUNDING


@inner_jit
def _note_round(case, handoffs, k, time):
    """Keep the handoffs of the round just passed, from engagement k on; returns its end."""
    for index in range(case.data.size):
        time += case.data[index].time
        _note_handoff(handoffs, k + index + 1, time, case.data[index].after)
    return time


@inner_jit
def _note_falls(case, start, handoffs, k, rtol, out):
    """Note `rise_time_63` and `_98` where the round from engagement k on passes them."""
    for index in range(case.data.size):
        last, following = case.data[index - 1].final, case.data[index].final
        note_fall(start, handoffs, k + index, last, following, rtol, out)


@inner_jit
def _seek(case, w, step, before, found, rtol, rows, out):
    """Search for the terminal cycle behind the round from w that was `found`; returns the status.

    `step` is Newton's step from w, and `before` the `Attempt` of the round before.
    """
    start = Start(_first_guess(w, step, before, found.w), found.rising, found.used)
    return cycle.terminal_cycle(case, start, found.w, cycle.Attempt(w, step.w), rtol, rows, out)


@inner_jit
def _note_handoff(handoffs, k, time, w):
    """Keep time and w at the entry of engagement k."""
    row = k % handoffs.shape[0]
    handoffs[row, 0], handoffs[row, 1] = time, w


@inner_jit
def _leap_on(case, request, start, w, k, found, extent, rows, out):
    """Leap from w, at the entry of engagement k, until shortly before the next figure is known.

    `found` is the round before, which ends with w.
    """
    none, final = Leap(0, w, 0.0), out[cycle.HANDOFF] ** 2
    step, size = cycle.newton_step(w, found, True), case.data.size
    most = ((MAX_ENGAGEMENTS if size == 1 else LONGEST_PATTERN) - k) // size
    if not final > 0.0:  # there is no terminal cycle
        return fall(case, request, w, step, most, rows)
    if not is_gentle(case.scene, w, step):
        return none
    goals = rows[GOALS]
    if np.isnan(goals[0]) and size > 1:
        # the extremes of a pattern's engagements differ, and what is left is marched
        goals[0] = goals[1] = final * (1.0 - NEAR_BAND if w < final else 1.0 + NEAR_BAND)
    elif np.isnan(goals[0]):
        far = max(w, 0.8 * final) if w < final else min(w, 1.25 * final)
        goals[0] = _first_in_band(case, request, w, found.rising, RISE_BAND, False, out)
        goals[1] = _first_in_band(case, request, far, found.rising, SETTLING_BAND, True, out)
    goal = _goal(goals, start, w, extent, out)
    if not is_worth_it(w, 1.0 - step.contraction, final, goal):
        return none
    return leap(case, request, w, final, goal, most, rows)


@inner_jit
def _goal(goals, start, w, extent, out):
    """The w at which the next figure of the transient is known; w itself if there is none left."""
    final, nearest = out[cycle.HANDOFF], out[cycle.HANDOFF] ** 2
    sense = 1.0 if w > nearest else -1.0
    for i in range(2):
        if np.isnan(out[cycle.SETTLING if i > 0 else cycle.RISE]):
            nearest = _further(nearest, goals[i], sense)
    nearest = _next_fall(nearest, start, w, extent, out)
    return nearest if nearest != final * final else w


@inner_jit
def _next_fall(nearest, start, w, extent, out):
    """Of a w and those at which `rise_time_63` and `_98` are known, that which w passes first."""
    final = out[cycle.HANDOFF]
    sense = 1.0 if w > final * final else -1.0
    for index in range(cycle.RISE_63, cycle.RISE_98 + 1):
        if extent == Extent.FALLEN and np.isnan(out[index]):
            level = FALL_63 if index == cycle.RISE_63 else FALL_98
            speed = final + level * (np.sqrt(start) - final)
            nearest = _further(nearest, speed * speed, sense)
    return nearest


@inner_jit
def _first_in_band(case, request, w, rising, band, every, out):
    """The first w from which an engagement has an extremum in the band, or all of its extremes.

    Speeds up to the terminal one are tried in steps of half a band of 2 %, because an extremum may
    appear where one of its engagement is in the band already.
    """
    final = out[cycle.HANDOFF] ** 2
    factor = (1.0 + 0.5 * RISE_BAND) ** (2.0 if w < final else -2.0)
    following = w
    while following != final and not _in_band(case, request, following, rising, band, every, out):
        w, following = following, following * factor
        if (following - final) * (w - final) <= 0.0:
            following = final
    for _ in range(24):
        middle = 0.5 * (w + following)
        if _in_band(case, request, middle, rising, band, every, out):
            following = middle
        else:
            w = middle
    return following


@inner_jit
def _in_band(case, request, w, rising, band, every, out):
    """Whether a round from w has an extremum in the band, or `every` extreme is in it."""
    lay_out_again(case)
    found = pass_round(case, Start(w, rising, NO_EVENTS), request)
    if found.rising * rising < 0.0:
        found = pass_round(case, Start(w, found.rising, NO_EVENTS), request)
    _mark_extrema(case, EventRows(NO_EVENTS, found.used), 0.0)
    inside = outside = 0
    for i in range(found.used):
        event = case.events[i]
        if is_extremum(event.kind) and (event.outermost or not every):
            make_exact_in_round(case, i)
            error = _error_of(case, i)
            inside, outside = inside + (error <= band), outside + (error > band)
    return inside > 0 and (outside == 0 or not every)


@inner_jit
def _error_of(case, i):
    """Relative error of extremum i to that of its kind and pair in the terminal cycle."""
    event = case.events[i]
    one = case.data[event.index]
    return abs(np.sqrt(event.w) / (one.top if event.kind == Event.MAXIMUM else one.low) - 1.0)


@inner_jit
def _further(nearest, other, sense):
    """Of two w that which a motion passes first; `sense` is 1 where it comes from above."""
    return max(nearest, other) if sense > 0.0 else min(nearest, other)


@inner_jit
def _only_gains(scene):
    """Whether every round without losses adds the drive's work, which is positive."""
    reaches = scene.barrel_efficiency * torque_at(scene.edges[0], scene)[0]
    return scene.load == 0.0 and reaches > scene.bearing and not has_load_curve(scene)


@inner_jit
def note_fall(start, handoffs, k, last, following, rtol, out):
    """Note `rise_time_63` and `_98` where engagement k passes them, as `metrics.fall_times` does.

    start : w at the first entry.
    handoffs : time and w at the entry of engagement k in row k, counted round.
    last, following : terminal speeds at the entries of engagement k and of the one behind it.
    """
    whole = abs(np.sqrt(start) - out[cycle.HANDOFF])
    if whole <= rtol * out[cycle.HANDOFF]:
        out[cycle.RISE_63], out[cycle.RISE_98] = 0.0, 0.0
        return
    one, two = k % handoffs.shape[0], (k + 1) % handoffs.shape[0]
    before = max(abs(np.sqrt(handoffs[one, 1]) - last) / whole, LEAST_RATIO)
    after = max(abs(np.sqrt(handoffs[two, 1]) - following) / whole, LEAST_RATIO)
    for index in range(cycle.RISE_63, cycle.RISE_98 + 1):
        level = FALL_63 if index == cycle.RISE_63 else FALL_98
        if np.isnan(out[index]) and after <= level:
            share = np.log(before / level) / np.log(before / after)
            out[index] = handoffs[one, 0] + share * (handoffs[two, 0] - handoffs[one, 0])


@inner_jit
def _first_guess(w, step, before, following):
    """The w from which the search for the terminal cycle starts."""
    if not step.w > 0.0:
        return following
    if step.sound and before.better != before.w:
        return cycle.extrapolate(w, step.w, before)
    return step.w


@inner_jit
def _stopped(found, k, out):
    """Write the angle and the engagement of a stall into `out`; returns the status."""
    _forget(out)
    out[0], out[1] = found.angle, k + found.pair
    return found.status


@inner_jit
def _worth_seeking(case, w, step, k, used):
    """Whether the terminal cycle is searched for after the round from engagement k on.

    That is when the entry speed is within twice the settling band of its terminal value, since
    this round may be the first that is settled. It is also after LATEST_SEARCH
    engagements, and when the memory for events runs out.
    """
    most = round_events(case.scene.edges, case.pattern.size)
    # twice the band in the speed is four times the band in w
    settled = step.sound and abs(step.w - w) <= 4.0 * SETTLING_BAND * step.w
    return settled or k >= LATEST_SEARCH or used + most > case.events.shape[0]


@inner_jit
def _mark_extrema(case, noted, time):
    """Mark the extrema of a round that begins at a time, and the outermost of each pair."""
    events = case.events
    for i in range(noted.first, noted.end):
        if is_extremum(events[i].kind):
            events[i].engagement_start += time
            events[i].outermost = _is_outermost(case, noted, i)


@inner_jit
def _is_outermost(case, noted, i):
    """Whether event i is the greatest maximum, or the least minimum, of its engagement."""
    event = case.events[i]
    for j in range(noted.first, noted.end):
        other = case.events[j]
        if j == i or other.kind != event.kind or other.index != event.index:
            continue
        # rough speeds that are too close to be compared, or NaN, are made exact first
        if not abs(other.w / event.w - 1.0) > ROUGH_ERROR:
            make_exact_in_round(case, i)
            make_exact_in_round(case, j)
        further = other.w > event.w
        if further == (event.kind == Event.MAXIMUM) and other.w != event.w:
            return False
    return True


@inner_jit
def _judge(case, noted, in_band, out):
    """Compare the extrema among some events with the terminal cycle.

    Only the greatest and the least speed of an engagement tend to the terminal extremes, so
    the settling time depends on these alone. Returns how many of them in a row, `in_band` at
    first, were within the settling band.
    """
    for i in range(noted.first, noted.end):
        if is_extremum(case.events[i].kind):
            in_band = _judge_one(case, i, in_band, out)
    return in_band


@inner_jit
def _judge_one(case, i, in_band, out):
    """Compare extremum i with the terminal cycle; returns the new `in_band`."""
    event = case.events[i]
    error = _error_of(case, i)
    # the relative error of a speed is half of that of w
    unsure = 0.5 * ROUGH_ERROR
    if not (abs(error - RISE_BAND) > unsure and abs(error - SETTLING_BAND) > unsure):
        make_exact_in_round(case, i)
        error = _error_of(case, i)
    if np.isnan(out[cycle.RISE]) and error <= RISE_BAND:
        make_exact_in_round(case, i)
        out[cycle.RISE] = event.engagement_start + event.time
    if not event.outermost:
        return in_band
    if error > SETTLING_BAND:
        out[cycle.SETTLING] = np.nan
        return 0
    if np.isnan(out[cycle.SETTLING]):
        make_exact_in_round(case, i)
        out[cycle.SETTLING] = event.engagement_start + event.time
    return in_band + 1
