"""One engagement, solved over the driver angle, panel by panel.

The figure in section 4 of docs/theory.md shows pieces, panels and the energy E. A march goes
through the chain of panels from left to right, and takes these steps for each of them:

1. `_face`: find which side of the slot carries the force at the left end.
2. `over_panel.choose`: solve the energy equation on the panel for that side. At a start from rest
   this is done on the spare panel instead, whose variable is the square root of the angle.
3. `over_panel.pass_over`: compute energy, time and contact at the right end, and find out whether
   the panel holds a reversal, or a stop, which ends the march.
4. `_note_left_end`: note the events of the left end.
5. `_check`: find out whether the speed has an extremum in the panel.
6. `_note_inside`: note that extremum and the reversal, and go on from the reversal with the
   solution of the other side.
7. `_advance`: make the state at the left end of the next panel.

If step 3, 5 or 6 finds that the panel is too coarse for what it holds, the panel is halved, and the
steps are repeated with its left half. The chain of panels thus becomes as fine as the scene needs,
and the marches over later engagements use it again.

Where gear trains lose power, the law depends on the direction of the power in them. Before step 1
the march then takes the scene for the direction at the left end, and step 3 splits a panel in which
the direction changes.
"""

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.codes import Event
from escapement.dynamics.law import drive_sign, side_at
from escapement.dynamics.needs import needed_scene
from escapement.dynamics.torque import REST, at_speed, has_knot, is_held, is_undriven
from escapement.dynamics.train_losses import flowing, is_lossy
from escapement.engines.energy import locate, panels, sampling
from escapement.engines.energy.located_events import extremum_kind, note, note_extremum
from escapement.engines.energy.over_panel import choose, pass_over, turns_free
from escapement.engines.energy.passage import (
    NOWHERE,
    Detail,
    Inside,
    SpeedExtremum,
    at_entry,
    behind_panel,
    behind_reversal,
    ended,
    with_rho,
)
from escapement.engines.energy.sampling import CLOSE_PAIR, NEGLIGIBLE, Points
from escapement.mechanisms.slotted import transmission_at
from escapement.numerics.altered import altered
from escapement.numerics.gauss import N
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.known import where_known

OK, NO_TERMINAL = int(Status.OK), int(Status.NO_TERMINAL)
STALL, PAINLEVE, NOT_CONVERGED = int(Status.STALL), int(Status.PAINLEVE), int(Status.NOT_CONVERGED)
SPENT = int(Status.SPENT)
# A chain is laid out again if it has more panels than this and two for every edge, which is more
# than one engagement needs.
TOO_MANY_PANELS = 128
# This is the same number for trains that lose power. The angles at which the direction of the power
# changes move with the speed, and around each of them narrow panels are cut, so the chain grows
# faster.
TOO_MANY_NARROW = 24


@jit(addressed=True)
def march(kind, scene, cells, store, count, request, w, rising, events, used):
    """March over one cell: from the entry to the exit of an engagement, and over the dwell.

    Parameters
    ----------
    kind : one of `needs.KINDS`, which is enough for the scene.
    scene : Scene
    cells : geometry of the scene's path, tabulated by `cells.tabulate_cells`.
    store, count : the memory of the panels, and the number of those in use. If that is 0, the chain
        is laid out. The chain is laid out again if it has become too long, after many engagements
        whose reversals were at different angles.
    request : the `Request`, which tells the results that are wanted and their accuracy.
    w : squared driver speed at entry.
    rising : sign of theta_ddot before the entry, 0 at the start of the motion.
    events, used : array of `EVENT` to be filled from row `used` on. The march ends with
        NOT_CONVERGED when the array is full.

    Returns
    -------
    MarchResult
    """
    # With trains that lose power `scene` changes from panel to panel, and so does its rho.
    # `first_scene` is the scene as given; with its rho the result gives E at entry and exit.
    first_scene, here = scene, needed_scene(scene, kind)
    lossy = is_lossy(here)
    # the knots of the torque divide the panels, so a chain with a knot serves one cell only
    knotted = has_knot(here)
    most = (TOO_MANY_NARROW if lossy else TOO_MANY_PANELS) + 2 * scene.edges.size
    if knotted or count == panels.NO_PANELS or count > most:
        count = panels.lay_out(here, cells, store, request.loose)
    work = store.workspace[0]
    first = store.panels[panels.FIRST_PANEL]
    if first.driver_angle != here.driver_angle:
        panels.turn_to(store, here)
    request = narrowed(request, here)
    if lossy:
        scene = flowing(first.left, 1.0, w, first_scene)
        here = needed_scene(scene, kind)
        panels.fill_again(store, first, here, cells)
    state = _enter(here, first, w, rising, used)
    # A driver at rest stays at rest if nothing accelerates it. A driver that nothing drives counts
    # as at rest if w is at most `REST`: drag alone might never stop it.
    still = w == 0.0 and (
        is_held(first.left, here)
        or sampling.net_torque_at(first.entry, state.side, 0.0, here) <= 0.0
    )
    if still or (w <= REST and is_undriven(first.left, here)):
        return ended(STALL, state, first.left, 0.0, count)
    if lossy:
        state = with_rho(state, first.entry.g, first_scene.rho, scene.rho)
    while state.panel != panels.CHAIN_END:
        chained = store.panels[state.panel]
        if lossy:
            side, before = 0.0 if chained.locked else state.side, scene.rho
            scene = flowing(chained.left, side, state.w, first_scene)
            here = needed_scene(scene, kind)
            if chained.flow != scene.flow:
                panels.fill_again(store, chained, here, cells)
            state = with_rho(state, chained.entry.g, before, scene.rho)
        if state.panel != panels.FIRST_PANEL and not chained.locked:
            state = _face(here, chained, state, events)
        starting = choose(here, work, chained, state, request)
        panel = work.spare if starting else chained
        passage = pass_over(here, work, panel, starting, state, request)
        if passage.has_stalled:
            return ended(STALL, state, passage.angle, passage.time, count)
        # the events of the left end come before those of the inside, in the order of time
        if not passage.split and request.detail > Detail.TIME:
            state = _note_left_end(here, work, chained, state, events)
        extremum = _check(here, work, panel, starting, state, passage, request)
        inside = _note_inside(here, work, panel, state, passage, extremum, request, events)
        if inside.split:
            if count >= panels.MAX_PANELS or panel.half < panels.SMALLEST:
                return ended(NOT_CONVERGED, state, 0.0, state.time, count)
            count = panels.halve(here, cells, store, state.panel, count, passage.angle)
            continue
        state = _advance(here, panel, chained.next, state, passage, extremum, inside)
        if state.used >= events.shape[0]:
            return ended(NOT_CONVERGED, state, 0.0, state.time, count)
    if lossy:
        g = 0.0 if scene.dwell > 0.0 else transmission_at(scene.path, scene.edges[-1])[0]
        state = with_rho(state, g, scene.rho, first_scene.rho)
    return ended(OK, state, 0.0, state.time, panels.NO_PANELS if knotted else count)


@where_known("pace", lambda request, scene: request)
def narrowed(request, scene):
    """The request for a scene: a spline over the speed is not smooth enough for loose panels."""
    return altered(request, "loose", request.strict) if scene.pace > 0.0 else request


@inner_jit(inlined=True)
def _enter(scene, panel, w, rising, used):
    """The state at the entry, which is the left end of the first panel."""
    end = panel.entry
    pull = at_speed(end.pull, end.turned, w, scene)
    side = side_at(panel.left, end.g, end.dg, pull, panel.slope, w, 1.0, scene)
    energy = w * (scene.rho + end.g**2)
    return at_entry(w, energy, side, rising, used)


@inner_jit(inlined=True)
def _face(scene, panel, state, events):
    """The state with the side that carries the force just behind the left end of a panel.

    If that is another side than before, a reversal is noted at the left end. `pass_over` leaves a
    reversal to this function if it is next to the end of a panel, where rounding would decide in
    which of the two panels it is. A spring that is spent at dead centre causes such a reversal.
    """
    end = panel.entry
    side = state.side
    pull = at_speed(end.pull, end.turned, state.w, scene)
    side = side_at(panel.left, end.g, end.dg, pull, panel.slope, state.w, side, scene)
    if side == state.side:
        return state
    used = note(events, state.used, Event.REVERSAL, panel.left, state.time, state.w)
    return altered(state, "side", side, "used", used)


@inner_jit(inlined=True)
def _note_left_end(scene, work, panel, state, events):
    """Note a break of the mechanism, and an extremum of the speed, at the left end of a panel."""
    used, rising = state.used, state.rising
    if panel.kink and not state.left_noted:
        pin_leaves = panel.left == scene.edges[-1]
        kind = Event.EXIT if pin_leaves else Event.BREAK
        used = note(events, used, kind, panel.left, state.time, state.w)
    # The speed has an extremum here if theta_ddot jumps to the other sign. It may jump at a kink of
    # |u|, at the exit, and at the entry if the pin before pressed on the other side.
    now = sampling.net_torque_at(panel.entry, state.side, state.w, scene)
    if panel.locked and panels.is_level(panel, scene) and not panel.kink:
        # inside a dwell nothing jumps, and near the steady speed the sign is due to rounding
        now = 0.0
    elif (
        not turns_free(scene, panel)
        and sampling.beside(scene, panel, now, work.net_torque, 0) == 0.0
    ):
        # the sign changes so close to the left end that the one at the first point counts
        now = work.net_torque[0]
    if now * rising < 0.0:
        used = note(events, used, extremum_kind(rising), panel.left, state.time, state.w)
    if now != 0.0:
        rising = np.sign(now)
    return altered(state, "rising", rising, "used", used, "left_noted", True)


@inner_jit(inlined=True)
def _check(scene, work, panel, starting, state, passage, request):
    """Look for an extremum of the driver speed in a panel, up to its reversal if it has one.

    Behind the reversal there must be none: `locate.pass_reversal` makes sure of that.
    """
    side = state.side
    first, final, point, split = 1.0, 1.0, NOWHERE, passage.split
    # In a dwell under a constant torque the speed tends to the one at which drag balances the
    # torque, and never passes it, so that it has no extremum.
    steady = panel.locked and panels.is_level(panel, scene)
    if not split and request.detail > Detail.TIME and not steady:
        first = sampling.net_torque_at(panel.entry, side, state.w, scene)
        first = sampling.beside(scene, panel, first, work.net_torque, 0)
        last = passage.reversal
        # at a reversal X = rho F + g D = 0, so that J theta_ddot = D - p F = D J/rho has the sign
        # of D
        if last >= 0:
            last_point = min(last, N - 1)
            pull = panels.pull_at(panel.entry.pull, panel.pull, last_point, scene)
            pull = at_speed(pull, panel.turned[last_point], work.w[last_point], scene)
            final = drive_sign(pull, work.w[last_point], scene)
        else:
            final, last = sampling.net_torque_at(panel.exit, side, passage.w, scene), N
            final = sampling.beside(scene, panel, final, work.net_torque, N - 1)
        slowing, changes = passage.slowing, 0
        # if J theta_ddot has one sign at all points and at both ends, no sign changes
        gains = slowing == 0 and first > 0.0 and final > 0.0
        if not gains and not (slowing == N and first < 0.0 and final < 0.0):
            changes, point = sampling.find_extremum(work.net_torque, last, first, final)
        # A panel may hold one extremum. The spare panel of a start may hold none, since its x does
        # not grow in proportion to the angle.
        split = changes > 1 or (changes == 1 and starting)
        if not split and panel.half > CLOSE_PAIR:
            # two extrema between neighbouring points would leave the signs at all points alike
            tried = Points(0, last)
            split = sampling.may_vanish(work, work.net_torque, NEGLIGIBLE, first, final, tried)
    return SpeedExtremum(
        split=split, point=point, first=first, final=final, time=state.time, energy=state.energy,
        side=side, coarse=panels.solution_of(panel, side).tail > request.strict,
    )  # fmt: skip


@inner_jit(inlined=True)
def _note_inside(scene, work, panel, state, passage, extremum, request, events):
    """Note the extremum and the reversal of a panel, and go on behind the reversal.

    Behind the reversal the other side carries the force, up to the right end of the panel.
    """
    used, split, reversal = state.used, extremum.split, passage.reversal
    after_reversal = locate.AfterReversal(
        good=True, energy=passage.energy, length=0.0, exponent=0.0, source=0.0
    )
    if split or (reversal < 0 and extremum.point < 0):
        return Inside(split, used, after_reversal)
    x, slope = 1.0, 0.0
    if reversal >= 0:
        # the reversal is at the left end if s X is 0 there and negative at the first point
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
        # theta_ddot is continuous at the reversal, so an error of x changes E and time at the right
        # end with its square only; x is improved only if the event itself is wanted
        if request.detail == Detail.EVERYTHING:
            instant = locate.reversal_at(scene, work, panel, state.side, x, slope, state.w)
        time = state.time + instant.elapsed
        used = note(events, used, Event.REVERSAL, instant.angle, time, instant.w)
        if extremum.final == 0.0:
            # Without a contact force and without a drive, as with a spent spring, theta_ddot is 0
            # here: the reversal is also an extremum.
            kind = extremum_kind(state.rising)
            used = note(events, used, kind, instant.angle, time, instant.w)
        trend = extremum.final if request.detail > Detail.TIME else 0.0
        after_reversal = locate.pass_reversal(
            scene, work, panel, state.side, reversal, request.strict, trend, state.source
        )
        if trend == 0.0 and request.detail > Detail.TIME:
            # `pass_reversal` was given no sign of theta_ddot to expect behind such a reversal; the
            # sign must be the same at all points there
            for i in range(reversal + 1, N):
                split |= work.net_torque[i] * work.net_torque[i - 1] < 0.0
    return Inside(split or not after_reversal.good, used, after_reversal)


@inner_jit(inlined=True)
def _advance(scene, panel, following, state, passage, extremum, inside):
    """The state at the right end of a panel, which is the left end of the one at `following`."""
    # Behind a reversal theta_ddot has the sign of the drive, `extremum.final`. Without a drive the
    # reversal is an extremum, and the sign changes there.
    if passage.reversal >= 0:
        after = inside.after_reversal
        rising = extremum.final if extremum.final != 0.0 else -state.rising
        w = after.energy / (scene.rho + panel.exit.g**2)
        return behind_reversal(following, state, after, w, rising, inside.used)
    solution = panels.solution_of(panel, state.side)
    rising = -state.rising if extremum.point >= 0 else state.rising
    return behind_panel(following, state, passage, solution, rising, inside.used)
