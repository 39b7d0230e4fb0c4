"""One engagement in the driver-angle domain, panel by panel.

The march halves a panel that is too coarse for an event in it (a reversal, an extremum, a start
from rest, a near stop) and goes on with the left half. The chain of panels thus becomes as fine
as the scene needs, and later engagements use the same chain again.

A panel is passed in steps: `_choose` between it and the spare panel of a start, `_pass_over` it
to its right end, `_note_left_end`, `_check` it for extrema, `_note_inside` the events in it,
and `_advance`. `_pass_over`, `_check` and `_note_inside` may find that it must be halved first.
`_choose` may find this for a start, from the tail of its solution.
"""

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.codes import Event
from escapement.dynamics.law import drive_sign, is_drag_free, is_viscous, side_at
from escapement.dynamics.torque import REST, has_knot, is_held, is_undriven
from escapement.dynamics.train_losses import flowing, is_lossy
from escapement.engines.energy import locate, panels, sampling
from escapement.engines.energy.events import extremum_kind, note, note_extremum
from escapement.engines.energy.passage import (
    NOWHERE,
    Detail,
    Engagement,
    Inside,
    MarchState,
    Passage,
    SpeedExtremum,
)
from escapement.engines.energy.sampling import ALL_POINTS, CLOSE_PAIR, FIRST_POINT, NEGLIGIBLE
from escapement.engines.energy.solve import slope_of_w, solve_side, solve_start
from escapement.mechanisms.slotted import transmission_at
from escapement.numerics.gauss import N
from escapement.numerics.jit import inner_jit

OK, NO_TERMINAL = int(Status.OK), int(Status.NO_TERMINAL)
STALL, PAINLEVE, NOT_CONVERGED = int(Status.STALL), int(Status.PAINLEVE), int(Status.NOT_CONVERGED)
SPENT = int(Status.SPENT)
# A panel is one of a start where E at its left end is at most this share of what it gains.
START_SHARE = 1e-8
# In a panel of at most this half width [rad] the deceleration before a stop is constant.
SHORTEST_STOP = 4e-13
# Times get this share of the tolerance, because near a stop the errors of all panels have the
# same sign and add up.
TIME_SHARE = 0.1
# One engagement needs fewer panels than this and two for every edge.
TOO_MANY_PANELS = 128


@inner_jit
def march(scene, cells, store, count, request, w, rising, events, used):
    """March over one cell: from the entry to the exit of an engagement, and over the dwell.

    Parameters
    ----------
    scene : Scene
    cells : as `tabulate_cells` makes them for the scene's path.
    store, count : memory, and number of panels in use. The chain is laid out if there is none. It
        is laid out again if it has grown too long after many engagements with reversals at
        different angles.
    request : Request
    w : squared driver speed at entry.
    rising : sign of theta_ddot before the entry, 0 at the start of the motion.
    events, used : array of `EVENT` to be filled from row `used` on. The march ends with
        NOT_CONVERGED when the array is full.

    Returns
    -------
    Engagement
    """
    # if the torque has a knot in this cell, the chain is for this cell only
    own, lossy = scene, is_lossy(scene)
    knotted = has_knot(scene)
    if knotted or count == panels.NO_PANELS or count > TOO_MANY_PANELS + 2 * scene.edges.size:
        count = panels.lay_out(scene, cells, store, request.loose)
    work = store.workspace[0]
    first = store.panels[panels.FIRST_PANEL]
    if first.turned != scene.turned:
        panels.turn_to(store, scene)
    if lossy:
        scene = flowing(first.left, 1.0, w, own)
        panels.fill_again(store, panels.FIRST_PANEL, scene, cells)
    state = _enter(scene, first, w, rising, used)
    # a driver at rest that is not accelerated stays at rest; where nothing drives it one that
    # hardly turns would come to rest after any time
    still = w == 0.0 and (
        is_held(first.left, scene)
        or sampling.net_torque_at(first.entry, state.side, 0.0, scene) <= 0.0
    )
    if still or (w <= REST and is_undriven(first.left, scene)):
        return _found(STALL, state, first.left, 0.0, count)
    if lossy:
        # outside the march, E belongs to the scene whose trains lose nothing
        state = _turned(state, first.entry.g, own.rho, scene.rho)
    while state.panel != panels.CHAIN_END:
        chained = store.panels[state.panel]
        if lossy:
            side, before = 0.0 if chained.locked else state.side, scene.rho
            scene = flowing(chained.left, side, state.w, own)
            if chained.flow != scene.flow:
                panels.fill_again(store, state.panel, scene, cells)
            state = _turned(state, chained.entry.g, before, scene.rho)
        if state.panel != panels.FIRST_PANEL and not chained.locked:
            state = _face(scene, chained, state, events)
        starting = _choose(scene, work, chained, state, request)
        panel = work.spare if starting else chained
        passage = _pass_over(scene, work, panel, starting, state, request)
        if passage.stalled:
            return _found(STALL, state, passage.angle, passage.time, count)
        # the events of the left end come before those of the inside, in the order of time
        if not passage.split and request.detail > Detail.TIME:
            state = _note_left_end(scene, work, chained, state, events)
        extremum = _check(scene, work, panel, starting, state, passage, request)
        inside = _note_inside(scene, work, panel, state, passage, extremum, request, events)
        if inside.split:
            if count >= panels.MAX_PANELS or panel.half < panels.SMALLEST:
                return _found(NOT_CONVERGED, state, 0.0, state.time, count)
            count = panels.halve(scene, cells, store, state.panel, count)
            continue
        state = _advance(scene, panel, chained.next, state, passage, extremum, inside)
        if state.used >= events.shape[0]:
            return _found(NOT_CONVERGED, state, 0.0, state.time, count)
    if lossy:
        g = 0.0 if scene.dwell > 0.0 else transmission_at(scene.path, scene.edges[-1])[0]
        state = _turned(state, g, scene.rho, own.rho)
    return _found(OK, state, 0.0, state.time, panels.NO_PANELS if knotted else count)


@inner_jit(inlined=True)
def _found(status, state, angle, time, count):
    """The result of a march that ends with `state`."""
    return Engagement(
        status, state.w, angle, time, state.exponent, state.source, state.side, state.rising,
        count, state.used,
    )  # fmt: skip


@inner_jit(inlined=True)
def _enter(scene, panel, w, rising, used):
    """MarchState at the entry, which is the left end of the first panel."""
    end = panel.entry
    side = side_at(panel.left, end.g, end.dg, end.pull, panel.slope, w, 1.0, scene)
    energy = w * (scene.rho + end.g**2)
    return MarchState(panels.FIRST_PANEL, w, energy, side, rising, 0.0, 0.0, 0.0, used, False)


@inner_jit(inlined=True)
def _face(scene, panel, state, events):
    """MarchState with the side that carries the force just behind the left end of a panel.

    A reversal there is noted, as behind a spring that is spent at dead centre. None is inside a
    panel next to one of its ends, where rounding would decide on its place.
    """
    end = panel.entry
    side = state.side
    side = side_at(panel.left, end.g, end.dg, end.pull, panel.slope, state.w, side, scene)
    if side == state.side:
        return state
    used = note(events, state.used, Event.REVERSAL, panel.left, state.time, state.w)
    return MarchState(
        state.panel, state.w, state.energy, side, state.rising, state.time, state.exponent,
        state.source, used, state.left_noted,
    )  # fmt: skip


@inner_jit(inlined=True)
def _turned(state, g, rho, after):
    """MarchState where power turns back through a train, which changes rho in E = (rho + g^2) w."""
    ratio = (after + g * g) / (rho + g * g)
    return MarchState(
        state.panel, state.w, state.w * (after + g * g), state.side, state.rising, state.time,
        state.exponent - np.log(ratio), ratio * state.source, state.used, state.left_noted,
    )  # fmt: skip


@inner_jit(inlined=True)
def _choose(scene, work, panel, state, request):
    """Solve a panel for side s; returns whether the spare panel of a start takes its place."""
    solution = panels.solution_of(panel, state.side)
    shifted = solution.pull != panel.entry.pull
    if state.w > 0.0 and (solution.tail == panels.UNSOLVED or shifted or is_viscous(scene)):
        solve_side(scene, work, panel, state.side, state.energy)
    # 1/sqrt(w) is singular at rest, and nearly so if E is small compared with its gain in the
    # panel
    if state.w == 0.0 or state.energy <= START_SHARE * solution.beta_end:
        return solve_start(scene, work, panel, state.side, state.w, request.strict)
    return False


@inner_jit(inlined=True)
def _pass_over(scene, work, panel, starting, state, request):
    """Go to the right end of a panel, and search for a reversal or a stop on the way."""
    side, w = state.side, state.w
    solution = panels.solution_of(panel, side)
    tail = solution.tail
    # E at the right end, and s X at both ends: their signs say which side carries the force
    energy = solution.alpha_end * state.energy + solution.beta_end
    w_right = energy / (scene.rho + panel.exit.g**2)
    right = side * sampling.contact_at(panel.exit, w_right, scene)
    # side_at has told the side: another sign is rounding
    left = max(side * sampling.contact_at(panel.entry, w, scene), 0.0)
    # in a start all energy comes from this panel, so that its error is the error of E itself
    split = tail > (request.strict if starting else request.loose)
    time, slowing, reversal = state.time, np.int64(0), NOWHERE
    if split and panel.half <= SHORTEST_STOP and is_viscous(scene):
        # the linearised viscous drag has no solution on a panel that holds a stop
        way = -w / slope_of_w(scene, panel, side, w)
        if 0.0 < way <= 4.0 * panel.half:
            return _stops(panel, way, w, 0.0, time, energy)
    if is_viscous(scene) and not energy > scene.rho * REST and is_undriven(panel.left, scene):
        # see `dynamics.law.rest_speed`
        excess = state.energy - scene.rho * REST
        if excess <= 0.0:
            return _stops(panel, 0.0, w, w, time, energy)
        if panel.half <= SHORTEST_STOP:
            way = 2.0 * panel.half * excess / (state.energy - energy)
            return _stops(panel, way, w, w, time, energy)
        return Passage(True, False, 0.0, energy, w_right, right, time, reversal, slowing, left)
    # the map alone needs no values inside, unless the right end shows a reversal or a stop
    if split or _map_will_do(scene, panel, request, right, w_right):
        return Passage(split, False, 0.0, energy, w_right, right, time, reversal, slowing, left)
    if _turns_free(scene, panel) and w_right > 0.0:
        # the acceleration is constant: the time is the angle over the mean speed
        time += 4.0 * panel.half / (np.sqrt(w) + np.sqrt(w_right))
        return Passage(False, False, 0.0, energy, w_right, right, time, reversal, slowing, left)
    against, stopped, slowing = sampling.sample_panel(
        scene, work, panel, solution, side, state.energy
    )
    right = sampling.beside(scene, panel, right, work.contact, N - 1)
    # at the stop of a mesh the sign of X is rounding, and would look like many reversals
    if starting and against > 0:
        against = sampling.clearly_against(work)
    if stopped > 0 or not w_right > 0.0:
        if (against == 0 or panel.locked) and panel.half <= SHORTEST_STOP:
            way = -w / slope_of_w(scene, panel, side, w)
            return _stops(panel, way, w, 0.0, time, energy)
        return Passage(True, False, 0.0, energy, w_right, right, time, reversal, slowing, left)
    if sampling.turns_back(scene, work, panel, solution, side, w, w_right):
        return Passage(True, False, 0.0, energy, w_right, right, time, reversal, slowing, left)
    negligible = NEGLIGIBLE * (scene.rho + panel.entry.g**2)
    if not panel.locked and (against > 0 or right < 0.0):
        split, reversal = _single_reversal(
            work, panel, against, left, right, negligible, starting or tail > request.strict
        )
        # a change of direction after a reversal would not be detected
        split |= reversal >= 0 and is_lossy(scene) and panel.half > sampling.NARROW_TURN
    if not split:
        passed, split = _time_over(
            work, panel, solution.noise, w, w_right, left, right, negligible, reversal, request
        )
        time += passed
    return Passage(split, False, 0.0, energy, w_right, right, time, reversal, slowing, left)


@inner_jit(inlined=True)
def _map_will_do(scene, panel, request, right, w_right):
    """Whether a march for the map needs no values inside a panel."""
    moves = (right > 0.0 or panel.locked) and w_right > 0.0
    return request.detail == Detail.MAP and moves and not is_lossy(scene)


@inner_jit(inlined=True)
def _stops(panel, way, w, after, time, energy):
    """The passage to a stop, which lies a short way after the left end of a panel.

    With constant deceleration w changes linearly to its value `after`, and the time is the way
    over the mean speed.
    """
    # a driver at rest that rounding alone moves stops where it starts
    if way > 0.0:
        time += 2.0 * way / (np.sqrt(w) + np.sqrt(after))
    return Passage(
        False, True, panel.left + way, energy, w, 1.0, time, NOWHERE, np.int64(0), 1.0
    )  # fmt: skip


@inner_jit(inlined=True)
def _turns_free(scene, panel):
    """Whether the driver turns under a constant torque, so that its acceleration is constant."""
    return panel.locked and panel.slope == 0.0 and is_drag_free(scene)


@inner_jit(inlined=True)
def _single_reversal(work, panel, against, left, right, negligible, rough):
    """Whether a panel must be halved for its reversals, and the first point after its one
    reversal, `NOWHERE` without one.

    A panel may hold one reversal, so that s X <= 0 at all points after it and at the right end. A
    panel that is `rough` may hold none, since values inside it are not accurate.
    """
    reversal = sampling.first_against(work)
    split = rough or N - reversal != against or right > 0.0 or (reversal == 0 and left <= 0.0)
    split = split or sampling.may_vanish(
        work, work.contact, negligible, left, right, FIRST_POINT, reversal
    )
    if split and panel.half <= CLOSE_PAIR:
        # in so short a panel a pair of reversals changes nothing; a single one is kept, though
        # rounding may have mixed the signs at the points
        return False, reversal if right <= 0.0 else NOWHERE
    return split, reversal


@inner_jit(inlined=True)
def _time_over(work, panel, noise, w, w_right, left, right, negligible, reversal, request):
    """Time over a panel up to its right end, and whether the panel must be halved first."""
    # time = int theta'/sqrt(w) dx
    passed, roughness = sampling.duration(work)
    limit = request.strict if reversal >= 0 else TIME_SHARE * request.loose
    split = roughness > max(limit, noise)
    if reversal >= 0:
        return passed, split
    if split and panel.half <= SHORTEST_STOP:
        # next to a stop the deceleration is constant over so short a way: the time is the
        # angle over the mean speed
        return 4.0 * panel.half / (np.sqrt(w) + np.sqrt(w_right)), False
    if not split and panel.half > CLOSE_PAIR and not panel.locked:
        split = sampling.may_vanish(
            work, work.contact, negligible, left, right, FIRST_POINT, ALL_POINTS
        )
    return passed, split


@inner_jit(inlined=True)
def _note_left_end(scene, work, panel, state, events):
    """Note a break of the mechanism, and an extremum where theta_ddot goes through zero."""
    used, rising = state.used, state.rising
    if panel.kink and not state.left_noted:
        left_slot = panel.left == scene.edges[-1]
        kind = Event.EXIT if left_slot else Event.BREAK
        used = note(events, used, kind, panel.left, state.time, state.w)
    # at a kink of |u|, an exit, and an entry on another side than before, theta_ddot jumps
    now = sampling.net_torque_at(panel.entry, state.side, state.w, scene)
    if panel.locked and panel.slope == 0.0 and not panel.kink:
        now = 0.0  # nothing jumps inside a dwell, and near the final speed this is rounding
    elif (
        not _turns_free(scene, panel)
        and sampling.beside(scene, panel, now, work.net_torque, 0) == 0.0
    ):
        now = work.net_torque[0]
    if now * rising < 0.0:
        used = note(events, used, extremum_kind(rising), panel.left, state.time, state.w)
    if now != 0.0:
        rising = np.sign(now)
    return MarchState(
        state.panel, state.w, state.energy, state.side, rising, state.time, state.exponent,
        state.source, used, True,
    )  # fmt: skip


@inner_jit(inlined=True)
def _check(scene, work, panel, starting, state, passage, request):
    """Look for an extremum of the driver speed in a panel, up to its reversal if it has one."""
    side, energy = state.side, state.energy
    first, final, point, split = 1.0, 1.0, NOWHERE, passage.split
    # under a constant torque the speed in a dwell tends to that at which drag takes all of it,
    # and never passes it
    steady = panel.locked and panel.slope == 0.0
    if not split and request.detail > Detail.TIME and not steady:
        first = sampling.net_torque_at(panel.entry, side, state.w, scene)
        first = sampling.beside(scene, panel, first, work.net_torque, 0)
        last = passage.reversal
        # at a reversal X = 0, so that J theta_ddot = D J/rho has the sign of the drive D
        if last >= 0:
            last_point = min(last, N - 1)
            final = drive_sign(panel.pull[last_point], work.w[last_point], scene)
        else:
            final, last = sampling.net_torque_at(panel.exit, side, passage.w, scene), ALL_POINTS
            final = sampling.beside(scene, panel, final, work.net_torque, N - 1)
        slowing, changes = passage.slowing, 0
        # one sign at all points and at both ends means that there is nothing to find
        gains = slowing == 0 and first > 0.0 and final > 0.0
        if not gains and not (slowing == N and first < 0.0 and final < 0.0):
            changes, point = sampling.find_extremum(work.net_torque, last, first, final)
        # a panel may hold one extremum, and the spare panel of a start may hold none
        split = changes > 1 or (changes == 1 and starting)
        if not split and panel.half > CLOSE_PAIR:
            torque = work.net_torque
            split = sampling.may_vanish(work, torque, NEGLIGIBLE, first, final, FIRST_POINT, last)
    coarse = panels.solution_of(panel, side).tail > request.strict
    return SpeedExtremum(split, point, first, final, state.time, energy, side, coarse)


@inner_jit(inlined=True)
def _note_inside(scene, work, panel, state, passage, extremum, request, events):
    """Note the extremum and the reversal of a panel, and pass the reversal to the other side."""
    used, split, reversal = state.used, extremum.split, passage.reversal
    after_reversal = locate.AfterReversal(True, passage.energy, 0.0, 0.0, 0.0)
    if split or (reversal < 0 and extremum.point < 0):
        return Inside(split, used, after_reversal)
    x, slope = 1.0, 0.0
    if reversal >= 0:
        # with s X = 0 at the left end and s X < 0 at the first point the reversal lies there
        x = -1.0
        if reversal > 0 or passage.left_contact > 0.0:
            left, right = passage.left_contact, passage.contact
            x, slope = locate.locate(work, work.contact, reversal, left, right, 1.0)
        locate.weights_to(work, x)
        locate.solve_behind(scene, work, panel, state.side)
        if panels.solution_of(panel, -state.side).tail > request.strict:
            return Inside(True, used, after_reversal)
    if extremum.point >= 0:
        kind = extremum_kind(state.rising)
        used = note_extremum(scene, events, used, kind, work, panel, extremum, x)
    if reversal >= 0:
        instant = locate.Instant(np.nan, np.nan, np.nan)
        # E and time change with the square of an error of x only, so they need no correction of x
        if request.detail == Detail.EVERYTHING:
            instant = locate.reversal_at(scene, work, panel, state.side, x, slope, state.w)
        time = state.time + instant.elapsed
        used = note(events, used, Event.REVERSAL, instant.angle, time, instant.w)
        if extremum.final == 0.0:
            # after the spring is spent nothing acts on the driver here, which is an extremum too
            kind = extremum_kind(state.rising)
            used = note(events, used, kind, instant.angle, time, instant.w)
        trend = extremum.final if request.detail > Detail.TIME else 0.0
        after_reversal = locate.pass_reversal(
            scene, work, panel, state.side, reversal, request.strict, trend, state.source
        )
        if trend == 0.0 and request.detail > Detail.TIME:
            # there the sign of theta_ddot after it is not known before, but it must not change
            for i in range(reversal + 1, N):
                split |= work.net_torque[i] * work.net_torque[i - 1] < 0.0
    return Inside(split or not after_reversal.good, used, after_reversal)


@inner_jit(inlined=True)
def _advance(scene, panel, following, state, passage, extremum, inside):
    """MarchState at the right end of a panel, which is the left end of the one at `following`."""
    # after a reversal theta_ddot keeps its sign, see `_check`, unless it vanishes there
    if passage.reversal >= 0:
        after = inside.after_reversal
        rising = extremum.final if extremum.final != 0.0 else -state.rising
        w = after.energy / (scene.rho + panel.exit.g**2)
        return MarchState(
            following, w, after.energy, -state.side, rising, state.time + after.length,
            state.exponent + after.exponent, after.source, inside.used, False,
        )  # fmt: skip
    solution = panels.solution_of(panel, state.side)
    # the affine map of the panel is composed with that up to its left end
    rising = -state.rising if extremum.point >= 0 else state.rising
    return MarchState(
        following, passage.w, passage.energy, state.side, rising, passage.time,
        state.exponent + solution.b_end, solution.alpha_end * state.source + solution.beta_end,
        inside.used, False,
    )  # fmt: skip
