"""The way of a march over one panel: energy, time and contact at its right end.

`choose` solves the energy equation on the panel. `pass_over` then says that the panel has to be
halved, that the motion stops in it, or what the motion is at its right end, and whether a reversal
lies between.
"""

import numpy as np

from escapement.dynamics.law import is_drag_free, is_viscous
from escapement.dynamics.torque import REST, is_undriven
from escapement.dynamics.train_losses import is_lossy
from escapement.engines.energy import locate, panels, sampling
from escapement.engines.energy.passage import (
    NOWHERE,
    Detail,
    PanelEnds,
    Passage,
    halved,
    passed,
    split_at,
    stalled,
    with_contact,
)
from escapement.engines.energy.sampling import CLOSE_PAIR, EVERY_POINT, NEGLIGIBLE, Points
from escapement.engines.energy.solve import slope_of_w, solve_side, solve_start
from escapement.numerics.altered import altered
from escapement.numerics.gauss import N
from escapement.numerics.jit import inner_jit

# A panel is one of a start where E at its left end is at most this share of what it gains.
START_SHARE = 1e-8
# In a panel of at most this half width [rad] the deceleration before a stop is constant.
SHORTEST_STOP = 4e-13
# Times get this share of the tolerance, because near a stop the errors of all panels have the
# same sign and add up.
TIME_SHARE = 0.1


@inner_jit(merged=True)
def choose(scene, work, panel, state, request):
    """Solve a panel for side s; returns whether it is a start, solved on the spare panel."""
    solution = panels.solution_of(panel, state.side)
    shifted = solution.pull != panel.entry.pull
    if state.w > 0.0 and (solution.tail == panels.UNSOLVED or shifted or is_viscous(scene)):
        solve_side(scene, work, panel, state.side, state.energy)
    # 1/sqrt(w) is singular at rest, and nearly so if E is small compared with its gain in the
    # panel
    if state.w == 0.0 or state.energy <= START_SHARE * solution.beta_end:
        return solve_start(scene, work, panel, state.side, state.w, request.strict)
    return False


@inner_jit(merged=True)
def pass_over(scene, work, panel, starting, state, request):
    """Go to the right end of a panel, and search for a reversal or a stop on the way."""
    side, w, time = state.side, state.w, state.time
    solution = panels.solution_of(panel, side)
    ends = _ends_of(scene, panel, solution, state)
    too_coarse = halved(ends, time)
    request = _judged(request, starting)
    rough = solution.tail > request.loose
    if rough and panel.half <= SHORTEST_STOP and is_viscous(scene):
        # the linearised viscous drag has no solution on a panel that holds a stop
        distance = -w / slope_of_w(scene, panel, side, w)
        if 0.0 < distance <= 4.0 * panel.half:
            return _stops(panel, distance, w, 0.0, time)
    if is_viscous(scene) and not ends.energy > scene.rho * REST and is_undriven(panel.left, scene):
        # with viscous drag alone the speed never reaches zero: see `dynamics.law.rest_speed`
        excess = state.energy - scene.rho * REST
        if excess <= 0.0:
            return _stops(panel, 0.0, w, w, time)
        if panel.half <= SHORTEST_STOP:
            distance = 2.0 * panel.half * excess / (state.energy - ends.energy)
            return _stops(panel, distance, w, w, time)
        return too_coarse
    if rough:
        return too_coarse
    if _map_will_do(scene, panel, ends, request):
        return passed(ends, time, NOWHERE, 0)
    if turns_free(scene, panel) and ends.w > 0.0:
        # the acceleration is constant: the time is the angle over the mean speed
        time += 4.0 * panel.half / (np.sqrt(w) + np.sqrt(ends.w))
        return passed(ends, time, NOWHERE, 0)
    against, stopped, slowing = sampling.sample_panel(
        scene, work, panel, solution, side, state.energy
    )
    ends = with_contact(ends, sampling.beside(scene, panel, ends.contact, work.contact, N - 1))
    # at the stop of a mesh the sign of X is rounding, and would look like many reversals
    if starting and against > 0:
        against = sampling.clearly_against(work)
    if stopped > 0 or not ends.w > 0.0:
        if (against == 0 or panel.locked) and panel.half <= SHORTEST_STOP:
            return _stops(panel, -w / slope_of_w(scene, panel, side, w), w, 0.0, time)
        return too_coarse
    if sampling.turns_back(scene, work, panel, solution, side, w, ends.w):
        # in a start x does not grow with the angle
        cut = 0.0 if starting else locate.cut_at_turn(scene, work, panel, side, w, ends.w)
        return split_at(ends, time, cut)
    split, reversal = False, NOWHERE
    if not panel.locked and (against > 0 or ends.contact < 0.0):
        rough = starting or solution.tail > request.strict
        split, reversal = _single_reversal(scene, work, panel, against, ends, rough)
        # a change of direction after a reversal would not be detected
        if reversal >= 0 and is_lossy(scene) and panel.half > sampling.NARROW_TURN:
            left, right = ends.left_contact, ends.contact
            x = locate.locate(work, work.contact, reversal, left, right, 1.0)[0]
            return split_at(ends, time, 0.0 if split or starting else locate.cut_near(panel, x))
    if not split:
        length, split = _time_over(scene, work, panel, solution.noise, ends, reversal, request)
        time += length
    return Passage(
        split=split, has_stalled=False, angle=0.0, energy=ends.energy, w=ends.w,
        contact=ends.contact, time=time, reversal=reversal, slowing=slowing,
        left_contact=ends.left_contact,
    )  # fmt: skip


@inner_jit(inlined=True)
def _judged(request, starting):
    """The request for a panel; in a start errors inside it are errors of E and of the time."""
    return altered(request, "loose", request.strict) if starting else request


@inner_jit(merged=True)
def _ends_of(scene, panel, solution, state):
    """`PanelEnds` of a panel with a solution that begins with a state."""
    energy = solution.alpha_end * state.energy + solution.beta_end
    w = energy / (scene.rho + panel.exit.g**2)
    left = state.side * sampling.contact_at(panel.entry, state.w, scene)
    # s has been chosen so that s X is positive at the left end: another sign is rounding
    return PanelEnds(
        left_w=state.w, left_contact=max(left, 0.0), energy=energy, w=w,
        contact=state.side * sampling.contact_at(panel.exit, w, scene),
    )  # fmt: skip


@inner_jit(merged=True)
def _map_will_do(scene, panel, ends, request):
    """Whether a march for the map needs no values inside a panel.

    It does not, unless the right end shows a reversal or a stop.
    """
    moves = (ends.contact > 0.0 or panel.locked) and ends.w > 0.0
    return request.detail == Detail.MAP and moves and not is_lossy(scene)


@inner_jit(merged=True)
def _stops(panel, distance, w, after, time):
    """The passage to a stop, which lies a short way after the left end of a panel.

    With constant deceleration w changes linearly to its value `after`, and the time is the way
    over the mean speed.
    """
    # a driver at rest that rounding alone moves stops where it starts
    if distance > 0.0:
        time += 2.0 * distance / (np.sqrt(w) + np.sqrt(after))
    return stalled(panel.left + distance, time)


@inner_jit(merged=True)
def turns_free(scene, panel):
    """Whether the driver turns under a constant torque, so that its acceleration is constant."""
    return panel.locked and panel.slope == 0.0 and is_drag_free(scene)


@inner_jit(merged=True)
def _single_reversal(scene, work, panel, against, ends, rough):
    """Whether a panel must be halved for its reversals, and the first point after its one
    reversal, `NOWHERE` without one.

    A panel may hold one reversal, so that s X <= 0 at all points after it and at the right end. A
    panel that is `rough` may hold none, since values inside it are not accurate.
    """
    left, right = ends.left_contact, ends.contact
    reversal = sampling.first_against(work)
    split = rough or N - reversal != against or right > 0.0 or (reversal == 0 and left <= 0.0)
    split = split or sampling.may_vanish(
        work, work.contact, _negligible(scene, panel), left, right, Points(0, reversal)
    )
    if split and panel.half <= CLOSE_PAIR:
        # in so short a panel a pair of reversals changes nothing; a single one is kept, though
        # rounding may have mixed the signs at the points
        return False, reversal if right <= 0.0 else NOWHERE
    return split, reversal


@inner_jit(merged=True)
def _negligible(scene, panel):
    """The X of a panel that is rounding."""
    return NEGLIGIBLE * (scene.rho + panel.entry.g**2)


@inner_jit(merged=True)
def _time_over(scene, work, panel, noise, ends, reversal, request):
    """Time over a panel up to its right end, and whether the panel must be halved first."""
    # time = int theta'/sqrt(w) dx
    length, roughness = sampling.duration(work)
    limit = request.strict if reversal >= 0 else TIME_SHARE * request.loose
    split = roughness > max(limit, noise)
    if reversal >= 0:
        return length, split
    if split and panel.half <= SHORTEST_STOP:
        # next to a stop the deceleration is constant over so short a way: the time is the
        # angle over the mean speed
        return 4.0 * panel.half / (np.sqrt(ends.left_w) + np.sqrt(ends.w)), False
    if not split and panel.half > CLOSE_PAIR and not panel.locked:
        split = sampling.may_vanish(
            work, work.contact, _negligible(scene, panel), ends.left_contact, ends.contact,
            EVERY_POINT,
        )  # fmt: skip
    return length, split
