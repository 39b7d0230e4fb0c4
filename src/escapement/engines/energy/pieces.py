"""The motion between the handoffs: its events, and its states at given times.

A piece is a part of the motion with one side of the slot. For its states it is solved again on
separate panels, fine enough for interpolation, and time as a function of the angle is inverted.
The figures of merit need none of this.
"""

from typing import Any, NamedTuple

import numpy as np

from escapement.dynamics.codes import Event
from escapement.dynamics.law import LOSSES, scene_of
from escapement.dynamics.state_table import losses_at
from escapement.dynamics.torque import at_speed, fall_after, next_knot
from escapement.dynamics.train_losses import flowing
from escapement.engines.energy import panels
from escapement.engines.energy.calls import scene_and_pattern
from escapement.engines.energy.locate import invert
from escapement.engines.energy.located_events import NO_EVENTS
from escapement.engines.energy.march import OK
from escapement.engines.energy.pairs import (
    Start,
    engage,
    lay_out_again,
    make_exact,
    new_case,
    prepare,
    scene_at,
    scene_of_pair,
)
from escapement.engines.energy.panels import NUMBER, WHOLE
from escapement.engines.energy.passage import Detail, request_of
from escapement.engines.energy.peaks import raise_peaks
from escapement.engines.energy.sampling import duration, sample_panel, turns_back
from escapement.engines.energy.solve import slope_of_w, solve_side
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import transmission_at
from escapement.model.escapement import Escapement
from escapement.model.torque_curve import MOST_KNOTS
from escapement.numerics.gauss import WEIGHTS, N, cumulate, dot
from escapement.numerics.held import held
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.records import record_dtype

MOTION_EVENT = record_dtype(
    {
        **dict.fromkeys(("engagement", "kind"), WHOLE),
        **dict.fromkeys(("angle", "time", "w", "side"), NUMBER),
    }
)
"""An event of a motion: driver angle from dead centre, time since the entry, infinite at the end of
the cell, and w; at an entry also s, and 0 elsewhere."""

# One engagement gets memory for this many events, and for four more at every edge.
ROOM = 64
# Greatest number of times that a piece is halved, one half inside the other.
HALVINGS = 80
# The acceleration is constant over an angle of at most this much [rad].
_SHORTEST = 1e-12
# Greatest number of panels of a piece; a few hundred suffice even next to a stop.
_MOST_PANELS = 20_000


@inner_jit(inlined=True)
def _append(table, filled, engagement, kind, angle, time, w, side):
    row = table[filled]
    row.engagement, row.kind, row.side = engagement, kind, side
    row.angle, row.time, row.w = angle, time, w
    return filled + 1


@inner_jit
def _set_all(row, value):
    # assigning to a slice would take long to compile, because of its error messages
    for i in range(row.size):
        row[i] = value


@inner_jit
def _copy(table, to, filled):
    for i in range(filled):
        row, other = to[i], table[i]
        row.engagement, row.kind, row.side = other.engagement, other.kind, other.side
        row.angle, row.time, row.w = other.angle, other.time, other.w


@jit(allocates=True)
def events_of(addresses, packed, cells, pattern, numbers, driver_angle, squares, rtol):
    """All events of the engagements `numbers`, ascending, which start with the w of `squares`.

    `addresses`, `packed`, `cells` and `pattern` are as `calls.prepared` gives them;
    `driver_angle` are the values of `Scene.driver_angle`. Each engagement gets panels of its own,
    so that its events do not depend on the others.

    Returns
    -------
    events : ndarray of MOTION_EVENT
        The events of each engagement in turn; its entry comes first.
    reached : ndarray
        w with which each leaves for the next, NaN where the march does not come to its end.
    """
    scene = scene_of(packed)
    room = ROOM + 4 * scene.edges.size + MOST_KNOTS
    inputs = new_case(addresses, scene, cells, pattern, room)
    return _events_of(inputs, numbers, driver_angle, squares, rtol)


@inner_jit(allocates=True)
def _events_of(inputs, numbers, driver_angle, squares, rtol):
    case, request = held(inputs), request_of(Detail.EVERYTHING, rtol)
    prepare(case)
    table = np.empty(8 * numbers.size + 64, MOTION_EVENT)
    filled, rising, reached = NO_EVENTS, 0.0, np.full(numbers.size, np.nan)
    for i in range(numbers.size):
        k, w, index = numbers[i], squares[i], numbers[i] % case.data.size
        if i == 0 or numbers[i - 1] != k - 1:
            rising = 0.0  # what came before is not known
        lay_out_again(case)
        found = engage(case, index, Start(w, rising, NO_EVENTS), request, driver_angle[i])
        rising, used = found.rising, found.used
        if found.status == OK:
            reached[i] = found.w
        if filled + used + 1 > table.shape[0]:
            larger = np.empty(2 * table.shape[0] + used, MOTION_EVENT)
            _copy(table, larger, filled)
            table = larger
        # the march returns s at the exit, and every reversal has changed its sign
        side, entry = (
            side_at_entry(found.side, case.events, used),
            scene_at(case, index, 0.0).edges[0],
        )
        filled = _append(table, filled, k, Event.ENTRY, entry, 0.0, w, side)
        for j in range(used):
            event = case.events[j]
            event.index = index
            make_exact(case, j, driver_angle[i])
            # an impact comes at the very end
            time = event.time if event.time < found.time else np.inf
            filled = _append(table, filled, k, event.kind, event.angle, time, event.w, 0.0)
    happened = np.empty(filled, MOTION_EVENT)
    _copy(table, happened, filled)
    return happened, reached


@inner_jit
def side_at_entry(side, events, used):
    """s at the entry, from `side`, which is s at the exit, and the reversals between."""
    for i in range(used):
        if events[i].kind == Event.REVERSAL:
            side = -side
    return side


class Section(NamedTuple):
    """A part of a piece: the driver angles of its ends, and the time and w at its left end."""

    left: float
    right: float
    time: float
    w: float


class Asked(NamedTuple):
    """Times since the start of a piece, and the driver angles and w there, which are filled.

    `end` is the driver angle at which the piece ends; later times get the state there.
    """

    times: Any
    theta: Any
    squares: Any
    end: float


@jit(allocates=True)
def states_of(scene, pattern, pieces, counts, times, rtol, theta, squares, losses, peaks):
    """Fill driver angles and w at times since the start of each piece, one piece after the other.

    Parameters
    ----------
    scene, pattern : of an escapement, see `calls.scene_and_pattern`.
    pieces : rows of the index of the pair, s, 0 in a dwell, driver angles of start and end, w,
        and `Scene.driver_angle`.
    counts : how many of the times belong to each piece.
    times : since the start; later ones than the end of the piece give the state at its end.
    theta, squares : results, angles and w, as long as `times`; NaN where a piece cannot be
        solved on a bounded number of panels.
    losses : result, a row for each piece: the work lost in each of `dynamics.law.LOSSES`.
    peaks : rows as well, which are raised to the greatest magnitude of each of `PEAKS`; of
        length 0 where they are not wanted.
    """
    first, store, ends = 0, panels.new_store(1), np.empty(HALVINGS)
    for i in range(len(pieces)):
        index, side, left, end, w, driver_angle = pieces[i]
        here, last = scene_of_pair(scene, pattern, int(index), driver_angle), first + counts[i]
        asked = Asked(
            times=times[first:last], theta=theta[first:last], squares=squares[first:last], end=end
        )
        states_in(here, store, ends, left, w, side, rtol, asked, losses[i], peaks[i])
        first = last


@inner_jit(allocates=True)
def states_in(scene, store, ends, left, w, side, rtol, asked, losses, peaks):
    """As `states_of`, of one piece that begins at the angle `left` with w on a side.

    The piece is divided into sections, each halved until the panel over it is fine enough. `store`
    is memory for that panel, and `ends` for the right ends of the halves that wait for their turn.
    """
    _loose, strict = panels.tolerances(rtol)
    store.panels[panels.FIRST_PANEL].locked = side == 0.0
    waiting = panels_solved = 0
    part = Section(left, _next(scene, left, asked.end), 0.0, w)
    _set_all(losses, 0.0)
    values = np.empty((N + 2, peaks.size))
    for j in range(asked.times.size):
        asked.theta[j], asked.squares[j] = left, w
    if not w >= 0.0:
        _forget(0.0, asked, losses)
        return
    while part.left < asked.end:
        # a record does not keep its memory alive: `store` must be in use to the end of the loop
        work, panel = store.workspace[0], store.panels[panels.FIRST_PANEL]
        here = flowing(part.left, side, part.w, scene)
        good = _solve(here, work, panel, part, side, strict)
        panels_solved += 1
        if panels_solved > _MOST_PANELS:
            _forget(part.time, asked, losses)
            break
        short, middle = part.right - part.left <= _SHORTEST, 0.5 * (part.left + part.right)
        if not good and not short and waiting < HALVINGS and part.left < middle < part.right:
            ends[waiting] = part.right
            waiting += 1
            part = Section(part.left, middle, part.time, part.w)
            continue
        if short and not good:
            length, after = _pass_short(here, work, panel, part, side, asked)
        else:
            length, after = _pass(here, work, panel, part, side, asked)
        _add_losses(here, work, panel, side, losses)
        if peaks.size > 0 and good:
            raise_peaks(here, work, panel, side, (part.w, after), values, peaks)
        now = part.time + length
        if after == 0.0:
            _stay(now, part.right, asked)
            break
        right = _next(scene, part.right, asked.end)
        if waiting > 0:
            waiting -= 1
            right = ends[waiting]
        part = Section(part.right, right, now, after)


@inner_jit
def _pass(scene, work, panel, part, side, asked):
    """Read the states within a part off its panel; returns its duration and w at its right end."""
    solution = panels.solution_of(panel, side)
    energy = part.w * (scene.rho + panel.entry.g**2)
    # E = alpha E_left + beta at the right end, and w = E/(rho + g^2), 0 after a stop
    after = solution.alpha_end * energy + solution.beta_end
    after = max(after / (scene.rho + panel.exit.g**2), 0.0)
    length = duration(work)[0]
    _read(scene, work, panel, part, length, asked)
    return length, after


@inner_jit
def _pass_short(scene, work, panel, part, side, asked):
    """As `_pass`, of a part so short that its acceleration is constant.

    Next to a stop its panel is no good. The time is the angle over the mean speed.
    """
    gain = slope_of_w(scene, panel, side, part.w) * (part.right - part.left)
    after = max(part.w + gain, 0.0)
    length = 2.0 * (part.right - part.left) / (np.sqrt(part.w) + np.sqrt(after))
    for i in range(N):
        work.w[i] = 0.5 * (part.w + after)
    _read_short(part, length, after, asked)
    return length, after


@inner_jit
def _stay(since, angle, asked):
    """Set the states from a time on to those of a motion that has stopped at an angle."""
    for j in range(asked.times.size):
        if asked.times[j] >= since:
            asked.theta[j], asked.squares[j] = angle, 0.0


@inner_jit
def _forget(since, asked, losses):
    """Set the states from a time on, and the work lost, to NaN."""
    _set_all(losses, np.nan)
    for j in range(asked.times.size):
        if not asked.times[j] < since:
            asked.theta[j] = asked.squares[j] = np.nan


@inner_jit
def _solve(scene, work, panel, part, side, strict):
    """Solve a panel over a part of a piece; returns whether it is fine enough to interpolate."""
    panels.evaluate_geometry(work, panel, scene, part.left, part.right)
    energy = part.w * (scene.rho + panel.entry.g**2)
    solve_side(scene, work, panel, side, energy)
    solution = panels.solution_of(panel, side)
    _against, stopped, _slowing = sample_panel(scene, work, panel, solution, side, energy)
    roughness = duration(work)[1]
    smooth = roughness <= max(strict, solution.noise)
    if solution.tail > strict or stopped > 0 or not smooth:
        return False
    w_right = solution.alpha_end * energy + solution.beta_end
    w_right /= scene.rho + panel.exit.g**2
    return not turns_back(scene, work, panel, solution, side, part.w, w_right)


@inner_jit
def _read(scene, work, panel, part, length, asked):
    """Fill the states at the times within a part, by interpolation on its panel."""
    # the integral of dt/dx from the left end to every point
    cumulate(work.slowness, work.scratch)
    for j in range(asked.times.size):
        t = asked.times[j] - part.time
        if t < 0.0 or (t > length and part.right < asked.end):
            continue
        x = invert(work, min(t, length), length)
        angle = 0.5 * (part.left + part.right) + panel.half * x
        g = 0.0 if panel.locked else transmission_at(scene.path, angle)[0]
        # E is interpolated, which is mostly smoother than w: the factor of w = E/(rho + g^2)
        # is then exact
        energy = dot(work.at_x, work.energy, panels.points_of(work))
        asked.theta[j], asked.squares[j] = angle, energy / (scene.rho + g * g)


@inner_jit
def _read_short(part, length, after, asked):
    """Fill the states at the times within a part so short that its acceleration is constant."""
    before, gain = np.sqrt(part.w), np.sqrt(after) - np.sqrt(part.w)
    for j in range(asked.times.size):
        t = asked.times[j] - part.time
        if t < 0.0 or (t > length and part.right < asked.end):
            continue
        t = min(t, length)
        speed = before + t * gain / length
        asked.theta[j] = part.left + 0.5 * t * (before + speed)
        asked.squares[j] = speed * speed


def follow(
    escapement: Escapement, pieces: FloatArray, owners: np.ndarray, since: FloatArray, rtol: float
) -> FloatArray:
    """Driver angles and squared speeds at times since the start of pieces; natural units.

    Parameters
    ----------
    escapement : Escapement
    pieces : ndarray, shape (n, 6)
        As for `states_of`.
    owners : ndarray of int, shape (m,)
        The piece of each time.
    since : ndarray, shape (m,)
        Times since the starts of the pieces.
    rtol : float
        Relative error allowed.

    Returns
    -------
    ndarray, shape (2, m)
    """
    order = np.argsort(owners, kind="stable")
    which, counts = np.unique(owners, return_counts=True)
    found, states = np.empty((2, owners.size)), np.empty((2, owners.size))
    given = *scene_and_pattern(escapement), pieces[which], counts, since[order], rtol
    states_of(*given, *found, np.empty((which.size, len(LOSSES))), np.empty((which.size, 0)))
    states[:, order] = found
    return states


@inner_jit
def _next(scene, left, end):
    """The first edge or knot of the torque behind `left`, or the end where that comes before."""
    for i in range(scene.edges.size):
        if scene.edges[i] > left:
            return next_knot(left, min(scene.edges[i], end), scene)
    return next_knot(left, end, scene)


@inner_jit
def _add_losses(scene, work, panel, side, losses):
    """Add the work lost over a panel to each of `losses`."""
    for i in range(N):
        g, u, radius, k = panel.g[i], panel.u[i], panel.radius[i], panel.dg[i]
        w, load = work.w[i], panel.load[i]
        pull = at_speed(panel.pull[i], panel.turned[i], w, scene)
        fall = fall_after(panel.turned[i], np.sqrt(max(w, 0.0)), scene)[0]
        rates = losses_at(g, u, radius, k, pull, w, side, scene, 0.0, 0.0, load, fall)
        share = panel.half * WEIGHTS[i]
        for j in range(losses.size):
            losses[j] += share * rates[j + 1]
