"""One engagement in the driver-angle domain, panel by panel.

The march finds the panels too coarse for what it meets on the way (a reversal, an
extremum, a start from rest, a near stop), halves them and goes on; the chain of
panels is thus made by the scene, and later engagements reuse it.

A panel is passed in steps: `_choose` the panel and its solution, `_pass_over` it to its right
end, `_check` it for extrema, `_note_inside` what happens in it, `_advance`. Every step but
the last may find that the panel has to be halved first.
"""

import numpy as np

from escapement.dynamics import side_at
from escapement.engines.energy.events import (
    EventKind,
    extremum_kind,
    note,
    note_extremum,
)
from escapement.engines.energy.gauss import N
from escapement.engines.energy.locate import Instant, Turned, locate, reversal_at, turn, weights_to
from escapement.engines.energy.panels import (
    FIRST,
    LAST,
    MAX_PANELS,
    NO_PANELS,
    SMALLEST,
    UNSOLVED,
    halve,
    lay_out,
    points_of,
    solution_of,
)
from escapement.engines.energy.passage import (
    NOWHERE,
    Engagement,
    Extremum,
    Inside,
    Passage,
    Record,
    State,
)
from escapement.engines.energy.sampling import (
    EVERY_POINT,
    MERGED,
    NO_POINT,
    NOTHING,
    clearly_against,
    contact_at,
    dips,
    driving_at,
    duration,
    find_extremum,
    first_against,
    run_over,
)
from escapement.engines.energy.solve import solve_side
from escapement.engines.energy.start import begin, braking
from escapement.jit import inner_jit
from escapement.status import Status

OK, NO_TERMINAL = int(Status.OK), int(Status.NO_TERMINAL)
STALL, PAINLEVE, NOT_CONVERGED = int(Status.STALL), int(Status.PAINLEVE), int(Status.NOT_CONVERGED)
SLOW = 1e-8  # energy over that gained in a panel, below which the panel is one of a start
NEARLY_STOPPED = 4e-13  # half width [rad] of a panel in which a stop is taken as even braking
NEAR_STOP = 0.1  # share of the tolerance for times, whose errors have one sign near a stop
MANY = 128  # panels, more than one engagement needs


@inner_jit
def march(scene, cells, store, count, request, w, side, rising, events, used):
    """Advance from entry to exit of one engagement.

    Parameters
    ----------
    scene : Scene
    cells : as `tabulate_cells` makes them for the scene's path.
    store, count : memory, and panels in use. The chain starts with panel 0. It is laid out
        where there is none, and anew where the events of many engagements, each elsewhere,
        left too many.
    request : Request
    w : squared driver speed at entry.
    side, rising : side of the slot (0: find out), and sign of the acceleration
        before the entry (0: none).
    events, used : array of `EVENT` to be filled from row `used` on; too short a one
        ends the march.

    Returns
    -------
    Engagement
    """
    if count == NO_PANELS or count > MANY + 2 * scene.edges.size:
        count = lay_out(scene, cells, store, request.loose)
    work = store.workspace[0]
    state = _enter(scene, store.panels[FIRST], w, side, rising, used)
    if w == 0.0 and driving_at(store.panels[FIRST].entry, state.side, 0.0, scene) <= 0.0:
        return _found(STALL, state, store.panels[FIRST].left, 0.0, count)
    while state.place != LAST:
        chained = store.panels[state.place]
        starting = _prepare(scene, work, chained, state, request)
        panel = work.start if starting else chained
        passage = _pass_over(scene, work, panel, starting, state, request)
        if passage.stalled:
            return _found(STALL, state, passage.angle, passage.time, count)
        if not passage.split and request.record > Record.TIME:
            state = _note_left_end(scene, chained, state, events)
        extremum = _check(scene, work, panel, starting, state, passage, request)
        inside = _note_inside(scene, work, panel, state, passage, extremum, request, events)
        if inside.split:
            if count >= MAX_PANELS or panel.half < SMALLEST:
                return _found(NOT_CONVERGED, state, 0.0, state.time, count)
            count = halve(scene, cells, store, state.place, count)
            continue
        state = _advance(scene, panel, chained.next, state, passage, extremum, inside)
        if state.used >= events.shape[0]:
            return _found(NOT_CONVERGED, state, 0.0, state.time, count)
    return _found(OK, state, 0.0, state.time, count)


@inner_jit(inlined=True)
def _found(status, state, angle, time, count):
    """What the march found, where it ends with `state`."""
    return Engagement(
        status, state.w, angle, time, state.exponent, state.source, state.side, state.rising,
        count, state.used,
    )  # fmt: skip


@inner_jit(inlined=True)
def _enter(scene, panel, w, side, rising, used):
    """State at the entry, at the left end of the first panel."""
    end = panel.entry
    if side == 0.0:
        side = side_at(end.g, end.dg, w, scene)
    energy = w * (scene.rho + end.g**2)
    return State(FIRST, w, energy, side, rising, 0.0, 0.0, 0.0, used, False)


@inner_jit(inlined=True)
def _prepare(scene, work, panel, state, request):
    """Have a panel solved for the side at hand; whether the start's panel takes its place."""
    solution = solution_of(panel, state.side)
    if state.w > 0.0 and solution.tail == UNSOLVED:
        solve_side(scene, work, panel, state.side)
    if state.w == 0.0 or state.energy <= SLOW * solution.beta_end:
        return begin(scene, work, panel, state.side, state.w, request.strict)
    return False


@inner_jit(inlined=True)
def _pass_over(scene, work, panel, starting, state, request):
    """Go to the right end of a panel, and look for a reversal or a stop on the way."""
    side, w = state.side, state.w
    solution = solution_of(panel, side)
    tail = solution.tail
    energy = solution.alpha_end * state.energy + solution.beta_end
    w_right = energy / (scene.rho + panel.exit.g**2)
    right = side * contact_at(panel.exit, w_right, scene)
    left = side * contact_at(panel.entry, w, scene)
    # next to rest an error of the energy counts in full
    split = tail > (request.strict if starting else request.loose)
    time, slower, reversal = state.time, NO_POINT, NOWHERE
    # where only the map is asked for, the right end says whether more has to be known
    if split or (request.record == Record.MAP and right > 0.0 and w_right > 0.0):
        return Passage(split, False, 0.0, energy, w_right, right, time, reversal, slower, left)
    against, stopped, slower = run_over(scene, work, panel, solution, side, state.energy)
    if starting and against > 0:
        against = clearly_against(work)
    if stopped > 0 or not w_right > 0.0:
        if against == 0 and panel.half <= NEARLY_STOPPED:
            way = -w / braking(scene, panel, side, w)
            time += 2.0 * way / np.sqrt(w)
            angle = panel.left + way
            return Passage(False, True, angle, energy, w, right, time, reversal, slower, left)
        return Passage(True, False, 0.0, energy, w_right, right, time, reversal, slower, left)
    nothing = NOTHING * (scene.rho + panel.entry.g**2)
    if against > 0 or right <= 0.0:
        split, reversal = _single_reversal(
            work, panel, against, left, right, nothing, starting or tail > request.strict
        )
    if not split:
        passed, split = _time_over(
            work, panel, solution.noise, w, w_right, left, right, nothing, reversal, request
        )
        time += passed
    return Passage(split, False, 0.0, energy, w_right, right, time, reversal, slower, left)


@inner_jit(inlined=True)
def _single_reversal(work, panel, against, left, right, nothing, rough):
    """Whether a panel must be halved to hold one reversal, and the first point behind that.

    A panel may hold one reversal: behind it all is on the other side. `rough` panels
    may hold none.
    """
    reversal = first_against(work)
    split = rough or N - reversal != against or right > 0.0
    count = points_of(work)
    split = split or dips(work.contact, nothing, left, right, NO_POINT, reversal, count)
    if split and panel.half <= MERGED:
        # so close a pair does nothing; of one the order of points is rounding
        return False, reversal if right <= 0.0 else NOWHERE
    return split, reversal


@inner_jit(inlined=True)
def _time_over(work, panel, noise, w, w_right, left, right, nothing, reversal, request):
    """Time over a panel up to its right end, and whether the panel must be halved first."""
    passed, roughness = duration(work)
    limit = request.strict if reversal >= 0 else NEAR_STOP * request.loose
    split = roughness > max(limit, noise)
    if reversal >= 0:
        return passed, split
    if split and panel.half <= NEARLY_STOPPED:
        # next to a stop: so short a way is braked evenly
        return 4.0 * panel.half / (np.sqrt(w) + np.sqrt(w_right)), False
    if not split and panel.half > MERGED:
        count = points_of(work)
        split = dips(work.contact, nothing, left, right, NO_POINT, EVERY_POINT, count)
    return passed, split


@inner_jit(inlined=True)
def _note_left_end(scene, panel, state, events):
    """Note a break of the mechanism, and an extremum at a corner of the speed."""
    used, rising = state.used, state.rising
    if panel.kink and not state.kink_noted:
        used = note(events, used, np.int64(EventKind.BREAK), panel.left, state.time, state.w)
    now = driving_at(panel.entry, state.side, state.w, scene)
    if now * rising < 0.0:
        used = note(events, used, extremum_kind(rising), panel.left, state.time, state.w)
    if now != 0.0:
        rising = np.sign(now)
    return State(
        state.place, state.w, state.energy, state.side, rising, state.time, state.exponent,
        state.source, used, True,
    )  # fmt: skip


@inner_jit(inlined=True)
def _check(scene, work, panel, starting, state, passage, request):
    """Look for an extremum of the driver speed in a panel, up to its reversal if it has one."""
    side, energy = state.side, state.energy
    first, final, point, split = 1.0, 1.0, NOWHERE, passage.split
    if not split and request.record > Record.TIME:
        first = driving_at(panel.entry, side, state.w, scene)
        last = passage.reversal
        # on a reversal the driver turns free of the follower and gains speed
        if last < 0:
            final, last = driving_at(panel.exit, side, passage.w, scene), EVERY_POINT
        slower, changes = passage.slower, 0
        gains = slower == 0 and first > 0.0 and final > 0.0
        if not gains and not (slower == N and first < 0.0 and final < 0.0):
            changes, point = find_extremum(work.rate, last, first, final)
        split = changes > 1 or (changes == 1 and starting)
        if not split and panel.half > MERGED:
            count = points_of(work)
            split = dips(work.rate, NOTHING, first, final, NO_POINT, last, count)
    coarse = solution_of(panel, side).tail > request.strict
    return Extremum(split, point, first, final, state.time, energy, side, coarse)


@inner_jit(inlined=True)
def _note_inside(scene, work, panel, state, passage, extremum, request, events):
    """Note a panel's extremum and its reversal, and go on behind that on the other side."""
    used, split, reversal = state.used, extremum.split, passage.reversal
    turned = Turned(True, passage.energy, 0.0, 0.0, 0.0)
    if split or (reversal < 0 and extremum.point < 0):
        return Inside(split, used, turned)
    x, slope = 1.0, 0.0
    if reversal >= 0:
        other = solution_of(panel, -state.side)
        if other.tail == UNSOLVED:
            solve_side(scene, work, panel, -state.side)
        if other.tail > request.strict:
            return Inside(True, used, turned)
        # rounding alone may have it that the force is on the other side all along
        x = -1.0
        if passage.left_contact > 0.0:
            left, right = passage.left_contact, passage.contact
            x, slope = locate(work, work.contact, reversal, left, right, 1.0)
    if extremum.point >= 0:
        kind = extremum_kind(state.rising)
        used = note_extremum(scene, events, used, kind, work, panel, extremum, x)
    if reversal >= 0:
        instant = Instant(np.nan, np.nan, np.nan)
        if request.record == Record.EVERYTHING:
            instant = reversal_at(scene, work, panel, state.side, x, slope, state.w)
        else:
            # an error of the place changes energy and time by its square alone
            weights_to(work, x)
        time = state.time + instant.elapsed
        kind = np.int64(EventKind.REVERSAL)
        used = note(events, used, kind, instant.angle, time, instant.w)
        extrema = request.record > Record.TIME
        turned = turn(
            scene, work, panel, state.side, reversal, request.strict, extrema, state.source
        )
    return Inside(not turned.good, used, turned)


@inner_jit(inlined=True)
def _advance(scene, panel, following, state, passage, extremum, inside):
    """State at the right end of a panel, which is the left end of the one at `following`."""
    if passage.reversal >= 0:
        turned = inside.turned
        w = turned.energy / (scene.rho + panel.exit.g**2)
        return State(
            following, w, turned.energy, -state.side, 1.0, state.time + turned.length,
            state.exponent + turned.exponent, turned.source, inside.used, False,
        )  # fmt: skip
    solution = solution_of(panel, state.side)
    rising = -state.rising if extremum.point >= 0 else state.rising
    return State(
        following, passage.w, passage.energy, state.side, rising, passage.time,
        state.exponent + solution.b_end, solution.alpha_end * state.source + solution.beta_end,
        inside.used, False,
    )  # fmt: skip
