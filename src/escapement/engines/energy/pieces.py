"""What lies between the handoffs: events, and states at given times.

Nothing here is on the path of the figures of merit. A piece is solved again on
panels of its own, fine enough to be interpolated, and its time is inverted.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics import drive, power_lost, scene_of
from escapement.engines.energy.calls import march, place
from escapement.engines.energy.events import EVENT, NONE, EventKind
from escapement.engines.energy.gauss import WEIGHTS, N, cumulate, dot
from escapement.engines.energy.locate import weights_to
from escapement.engines.energy.march import OK
from escapement.engines.energy.panels import (
    FIRST,
    MAX_PANELS,
    NO_PANELS,
    at_gauss_points,
    new_store,
    points_of,
    solution_of,
    survey,
    tolerances,
)
from escapement.engines.energy.passage import Record, Request
from escapement.engines.energy.records import NUMBER, WHOLE, record
from escapement.engines.energy.sampling import duration, run_over
from escapement.engines.energy.solve import solve_side
from escapement.jit import inner_jit, jit
from escapement.mechanisms.slotted import transmission_at
from escapement.scene import Scene

HAPPENED = record(
    {
        **dict.fromkeys(("engagement", "kind"), WHOLE),
        **dict.fromkeys(("angle", "time", "w", "side"), NUMBER),
    }
)
"""An event of a motion: driver angle from dead centre, time from the start, w; at an entry
the side of the slot."""

ONE = np.int64(1)
_ROOM = 64  # events of one engagement
_HALVINGS = 80  # of a piece, one inside the other
_EVEN = 1e-12  # width below which the acceleration is constant [rad]


@inner_jit
def _put(table, filled, engagement, kind, angle, time, w, side):
    row = table[filled]
    row.engagement, row.kind, row.side = engagement, kind, side
    row.angle, row.time, row.w = angle, time, w
    return filled + 1


@inner_jit
def _copy(table, to, filled):
    # not by slices, whose error messages take a tenth of all compilation
    for i in range(filled):
        row, other = to[i], table[i]
        row.engagement, row.kind, row.side = other.engagement, other.kind, other.side
        row.angle, row.time, row.w = other.angle, other.time, other.w


@jit(allocates=True)
def events_of(calls, plain, cells, starts, squares, rtol):
    """All events of the engagements that start at `starts` with `squares`.

    `calls`, `plain` and `cells` are as `prepare.prepared` gives them.

    Returns
    -------
    ndarray of HAPPENED
        The events of each engagement in turn; its entry comes first.
    """
    scene = scene_of(plain)
    loose, strict = tolerances(rtol)
    request = Request(np.int64(Record.EVERYTHING), loose, strict)
    store = new_store(MAX_PANELS)
    events = np.empty(_ROOM + 4 * scene.edges.size, EVENT)
    table = np.empty(8 * starts.size + 64, HAPPENED)
    count, filled, rising = NO_PANELS, NONE, 0.0
    exit_ = scene.edges[-1]
    for k in range(starts.size):
        w, start = squares[k], starts[k]
        found = march(calls, scene, cells, store, count, request, w, 0.0, rising, events, NONE)
        count, rising, used = found.panels, found.rising, found.used
        if filled + used + 3 > table.shape[0]:
            larger = np.empty(2 * table.shape[0] + used, HAPPENED)
            _copy(table, larger, filled)
            table = larger
        side = _side_at_entry(found.side, events, used)
        kind = np.int64(EventKind.ENTRY)
        filled = _put(table, filled, k, kind, scene.edges[0], start, w, side)
        for i in range(used):
            place(calls, scene, store, events, i)
            event = events[i]
            time = start + event.time
            filled = _put(table, filled, k, event.kind, event.angle, time, event.w, 0.0)
        if found.status != OK:
            break
        if scene.dwell > 0.0:
            kind, time = np.int64(EventKind.MINIMUM), start + found.time
            if rising < 0.0:
                filled = _put(table, filled, k, kind, exit_, time, found.w, 0.0)
            kind = np.int64(EventKind.EXIT)
            filled = _put(table, filled, k, kind, exit_, time, found.w, 0.0)
            rising = 1.0
    happened = np.empty(filled, HAPPENED)
    _copy(table, happened, filled)
    return happened


@inner_jit
def _side_at_entry(side, events, used):
    """Side of the slot at the entry, from that at the exit."""
    for i in range(used):
        if events[i].kind == EventKind.REVERSAL:
            side = -side
    return side


class Stretch(NamedTuple):
    """A part of a piece: driver angles where it begins and ends, time and w where it begins."""

    left: float
    right: float
    time: float
    w: float


@jit(allocates=True)
def states_in(scene, left, end, w, side, rtol, times, theta, squares):
    """Angles and squared speeds at times since the start of one piece.

    Parameters
    ----------
    left, end : driver angle where the piece starts and ends.
    w, side : squared speed at its start, side of the slot.
    times : since the start; clipped to the piece.
    theta, squares : results, as long as `times`.

    Returns
    -------
    loss : work lost in friction over the piece.
    """
    _loose, strict = tolerances(rtol)
    store = new_store(ONE)
    work, panel = store.workspace[0], store.panels[FIRST]
    ends = np.empty(_HALVINGS)
    waiting = 0
    part = Stretch(left, _next(scene.edges, left, end), 0.0, w)
    loss = 0.0
    for j in range(times.size):
        theta[j], squares[j] = left, w
    while part.left < end:
        good = _solve(scene, work, panel, part, side, strict)
        even = part.right - part.left <= _EVEN
        middle = 0.5 * (part.left + part.right)
        if not good and not even and waiting < _HALVINGS and part.left < middle < part.right:
            ends[waiting] = part.right
            waiting += 1
            part = Stretch(part.left, middle, part.time, part.w)
            continue
        solution = solution_of(panel, side)
        energy = part.w * (scene.rho + panel.entry.g**2)
        after = solution.alpha_end * energy + solution.beta_end
        after = max(after / (scene.rho + panel.exit.g**2), 0.0)
        loss += panel.half * _lost(scene, work, panel, side)
        length = duration(work)[0]
        if even and not good:
            length = 2.0 * (part.right - part.left) / (np.sqrt(part.w) + np.sqrt(after))
            _read_even(part, length, after, end, times, theta, squares)
        else:
            _read(scene, work, panel, part, length, end, times, theta, squares)
        now = part.time + length
        if after == 0.0:
            # a stop, and nothing moves later
            for j in range(times.size):
                if times[j] >= now:
                    theta[j], squares[j] = part.right, 0.0
            break
        right = _next(scene.edges, part.right, end)
        if waiting > 0:
            waiting -= 1
            right = ends[waiting]
        part = Stretch(part.right, right, now, after)
    return loss


@inner_jit
def _solve(scene, work, panel, part, side, strict):
    """Solve a panel over a part of a piece; whether it is fine enough to be interpolated."""
    at_gauss_points(work)
    survey(work, panel, scene.path, scene.rho, part.left, part.right)
    solve_side(scene, work, panel, side)
    solution = solution_of(panel, side)
    energy = part.w * (scene.rho + panel.entry.g**2)
    _against, stopped, _slower = run_over(scene, work, panel, solution, side, energy)
    roughness = duration(work)[1]
    smooth = roughness <= max(strict, solution.noise)
    return solution.tail <= strict and stopped == 0 and smooth


@inner_jit
def _read(scene, work, panel, part, length, end, times, theta, squares):
    """States at the times within a part, on its panel."""
    cumulate(work.slowness, work.series)
    for j in range(times.size):
        t = times[j] - part.time
        if t < 0.0 or (t > length and part.right < end):
            continue
        x = _invert(work, min(t, length), length)
        theta[j] = 0.5 * (part.left + part.right) + panel.half * x
        g = transmission_at(scene.path, theta[j])[0]
        squares[j] = dot(work.at_x, work.energy, points_of(work)) / (scene.rho + g * g)


@inner_jit
def _read_even(part, length, after, end, times, theta, squares):
    """States at the times within a part so short that its acceleration is constant."""
    before, gain = np.sqrt(part.w), np.sqrt(after) - np.sqrt(part.w)
    for j in range(times.size):
        t = times[j] - part.time
        if t < 0.0 or (t > length and part.right < end):
            continue
        t = min(t, length)
        speed = before + t * gain / length
        theta[j] = part.left + 0.5 * t * (before + speed)
        squares[j] = speed * speed


def follow(
    scene: Scene, start: tuple[float, float, float], end: float, times: np.ndarray, rtol: float
) -> tuple[np.ndarray, np.ndarray]:
    """Driver angles and squared speeds at times since the start of a piece; natural units.

    Parameters
    ----------
    scene : Scene
    start : (float, float, float)
        Driver angle [rad], squared speed and side of the slot, 0 in a dwell.
    end : float
        Driver angle where the piece ends at the latest [rad].
    times : ndarray, shape (n,)
        Since the start.
    rtol : float
        Relative error allowed.

    Returns
    -------
    theta, squares : ndarray, shape (n,)
    """
    angle, w, side = start
    if side == 0.0:
        speed, gain = np.sqrt(w), times * drive(scene) / scene.rho
        return angle + times * (speed + 0.5 * gain), (speed + gain) ** 2
    theta, squares = np.empty_like(times), np.empty_like(times)
    states_in(scene, angle, end, w, side, rtol, times, theta, squares)
    return theta, squares


@inner_jit
def _next(edges, left, end):
    """The first edge behind `left`, if it comes before the end."""
    for i in range(edges.size):
        if edges[i] > left:
            return min(edges[i], end)
    return end


@inner_jit
def _lost(scene, work, panel, side):
    """Work lost in friction over a panel, by x."""
    total = 0.0
    for i in range(N):
        lost = power_lost(panel.g[i], panel.u[i], panel.dg[i], work.w[i], side, scene)
        total += WEIGHTS[i] * lost
    return total


@inner_jit
def _invert(work, target, whole_time):
    """x in [-1, 1] at a time since the left end; leaves the weights to it in the workspace."""
    count = points_of(work)
    x = 2.0 * target / whole_time - 1.0
    low, high = -1.0, 1.0
    for _ in range(60):
        weights_to(work, x)
        passed = dot(work.from_left, work.series, count)
        if passed > target:
            high = x
        else:
            low = x
        guess = x + (target - passed) / dot(work.at_x, work.slowness, count)
        if not low <= guess <= high:
            guess = 0.5 * (low + high)
        step = abs(guess - x)
        x = guess
        if step <= 1e-8:
            break
    weights_to(work, x)
    return x
