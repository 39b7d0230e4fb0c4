"""The states of a motion at given times, and the work lost over each of its pieces."""

import numpy as np

from escapement.dynamics.law import (
    LOSSES,
    bend,
    dragged_slope,
    net_torque,
    reduced_inertia,
    root_of,
    scene_of,
)
from escapement.dynamics.law import contact as contact_of
from escapement.dynamics.tables import losses_at
from escapement.dynamics.torque import cell_of, torque_at
from escapement.dynamics.train_losses import UNKNOWN, weight
from escapement.engines.contact.rigid.engagement import LOCKED, WALL, follower_on
from escapement.engines.contact.rigid.flight import launch, place_at, state_after
from escapement.engines.contact.rigid.free import driver_rate, driver_sense, follower_rate
from escapement.engines.contact.rigid.march import after, workspace
from escapement.engines.contact.rigid.panel import (
    SLOW,
    SMALLEST,
    STOPS,
    B,
    W,
    flow_behind,
    law_at,
    next_panel,
    solve_panel,
    width_after,
)
from escapement.engines.contact.rigid.walls import case_of, next_break, wall_scene
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.gauss import BARYCENTRIC, POINTS, WEIGHTS, N, cumulate
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.roots import newton_in_bracket

STRICT = 1e-13
"""Greatest tail of a panel whose solution is interpolated."""
TABLE, LOST = 8 + len(LOSSES), len(LOSSES) + 1
"""Length of a state: `state.COLUMNS` and the power of each of `LOSSES`. Length of the work over a
piece: one number for each of `LOSSES`, and one for the load."""


@inner_jit
def _inside(row, x):
    """A row's value at a place x of its panel, by the barycentric formula."""
    above = below = 0.0
    for i in range(N):
        apart = x - POINTS[i]
        if apart == 0.0:
            return row[i]
        weight = BARYCENTRIC[i] / apart
        above += weight * row[i]
        below += weight
    return above / below


@inner_jit
def _place_after(work, time, width):
    """The place x of a panel that is reached after a time; row B holds the times at its points."""
    low, high, sign = -1.0, 1.0, np.sign(width)
    x = 0.0
    for _ in range(60):
        passed, slope = sign * _inside(work[B], x) - time, sign * _inside(work[SLOW], x)
        guess, low, high = newton_in_bracket(x, passed, slope, low, high, True)
        step, x = abs(guess - x), guess
        if step <= 4e-16:
            break
    return x


@inner_jit
def _touching_state(case, scene, side, theta, way, w, out, k):
    """Fill column k of `out` with the state in contact with a wall."""
    g, u, dg, radius = pose_at(scene.path, theta)
    slope, c = dragged_slope(g, dg, scene), bend(g, u, radius, side, scene)
    pull, root = torque_at(theta, scene)[0] - scene.bearing, root_of(w, scene)
    inertia, speed = reduced_inertia(g, c, scene), way * np.sqrt(w)
    rate = net_torque(g, c, slope, pull, w, root, scene) / inertia
    out[0, k], out[1, k], out[2, k] = theta, speed, rate
    out[3, k], out[4, k] = follower_on(case, side, theta)[0], g * speed
    out[5, k] = g * rate + dg * w
    out[6, k] = weight(scene) * contact_of(g, slope, pull, w, root, scene) / inertia
    lost = losses_at(g, u, radius, slope, pull, w, side, scene)
    out[7, k] = lost[0]
    for j in range(len(LOSSES)):
        out[8 + j, k] = lost[1 + j] * speed


@inner_jit
def _free_state(scene, theta, speed, phi, turning, out, k):
    """Fill column k of `out` with the state in a flight."""
    sense, way = driver_sense(scene, theta, speed), np.sign(turning)
    out[0, k], out[1, k], out[3, k], out[4, k] = theta, speed, phi, turning
    out[2, k] = driver_rate(scene, theta, speed, sense)
    out[5, k] = follower_rate(scene, turning, way)
    out[6, k] = out[7, k] = out[8, k] = out[10, k] = 0.0
    square, other = speed * speed, turning * turning
    out[9, k] = scene.bearing * abs(speed)
    out[11, k] = (scene.driver_drag * abs(speed) + scene.driver_viscous) * square
    out[12, k] = (scene.follower_drag * abs(turning) + scene.follower_viscous) * other
    out[13, k] = out[14, k] = 0.0
    # what the accelerations leave of the torques is lost in the trains
    if scene.barrel_efficiency != 1.0:
        out[13, k] = (torque_at(theta, scene)[0] - scene.rho * out[2, k]) * speed
        out[13, k] -= out[9, k] + out[11, k]
    if scene.load_train_efficiency != 1.0:
        out[14, k] = -scene.load * abs(turning) - out[12, k] - out[5, k] * turning


@inner_jit
def _along_wall(work, case, row, length, times, first, last, out, lost, spare, count):
    """Fill the states at times[first:last] of a piece in contact, and the work lost over it."""
    side, theta, w, time, width = row.wall, row.theta, row.speed * row.speed, 0.0, np.inf
    way = 1.0 if row.speed >= 0.0 else -1.0
    if w == 0.0:
        way = 1.0
        rate = law_at(wall_scene(case, side, theta, way, w, UNKNOWN), side, theta, 0.0)[1]
        if rate > 0.0:
            w, theta, time = 2.0 * rate * SMALLEST, theta + SMALLEST, np.sqrt(2.0 * SMALLEST / rate)
        else:
            # at rest for good
            time = length
    flow = UNKNOWN
    while length - time > 1e-14 * length:
        scene = wall_scene(case, side, theta, way, w, flow)
        limit = next_break(case, side, theta, way, scene)
        if limit == theta:
            # by rounding, the piece may last longer than the way to its end takes
            break
        start = w
        found = next_panel(work, scene, side, theta, w, width, limit, STRICT, False, count)
        if found.code >= STOPS:
            break
        flow = flow_behind(found, scene.flow, found.width == limit - theta)
        cumulate(work[SLOW], work[B])
        while first < last and times[first] <= time + found.time:
            x = _place_after(work, max(times[first] - time, 0.0), found.width)
            place, w = theta + 0.5 * found.width * (1.0 + x), max(_inside(work[W], x), 0.0)
            _touching_state(case, scene, side, place, way, w, out, first)
            first += 1
        end, over = theta + found.width, time + found.time
        if over > length * (1.0 + 1e-13):
            # the piece ends inside this panel
            part = 0.5 * found.width * (1.0 + _place_after(work, length - time, found.width))
            found = solve_panel(work, scene, side, theta, part, start, count)
            end, over = theta + found.width, length
        elif found.width == limit - theta:
            end = limit
        for i in range(N):
            place = theta + 0.5 * found.width * (1.0 + POINTS[i])
            _touching_state(case, scene, side, place, way, work[W][i], spare, 0)
            share = 0.5 * abs(found.width) * WEIGHTS[i] / np.sqrt(work[W][i])
            for j in range(LOST - 1):
                lost[j] += share * spare[8 + j, 0]
        moved = follower_on(case, side, end)[0] - follower_on(case, side, theta)[0]
        lost[LOST - 1] += case.plus.load * abs(moved)
        theta, w, time, width = end, found.w, over, width_after(found, STRICT)
    while first < last:
        scene = wall_scene(case, side, theta, way, w, flow)
        _touching_state(case, scene, side, theta, way, w, out, first)
        first += 1


@inner_jit
def _through_flight(work, case, row, length, times, first, last, out, lost, spare, count):
    """Fill the states at times[first:last] of a flight or a dwell, and the work lost over it."""
    scene, time = case.plus, 0.0
    end = scene.edges[-1] + (scene.dwell if row.kind == LOCKED else 0.0)
    theta, speed, phi, turning = row.theta, row.speed, row.phi, row.turning
    while True:
        flight = launch(work, scene, theta, speed, phi, turning, end)
        # what its train loses jumps where the follower comes to rest
        part = min(flight.length, flight.rest, length - time)
        # a length is a difference of times, and their rounding may leave it longer than the flight
        ends = not time + part > time or length - time - part <= 1e-14 * length
        while first < last and (times[first] <= time + part or ends):
            since = min(max(times[first] - time, 0.0), part)
            _free_state(scene, *place_at(work, flight, since), out, first)
            first += 1
        for i in range(N):
            since = 0.5 * part * (1.0 + POINTS[i])
            _free_state(scene, *place_at(work, flight, since), spare, 0)
            for j in range(LOST - 1):
                lost[j] += 0.5 * part * WEIGHTS[i] * spare[8 + j, 0]
        before, time = phi, time + part
        theta, speed, phi, turning = state_after(work, flight, part)
        lost[LOST - 1] += scene.load * abs(phi - before)
        if ends:
            break


@jit(allocates=True)
def trace(scene_tuple, joint, rtol, pieces, engagement, lengths, firsts, times, out, lost):
    """Fill the states at times within pieces, and the work lost over each piece.

    Parameters
    ----------
    scene_tuple, joint, rtol : as of `march.march`.
    pieces, engagement : rows at which the pieces start, and the engagements they belong to.
    lengths : how long each lasts.
    firsts : shape (pieces + 1,): where the times of each piece begin among `times`.
    times : since the start of their pieces, ascending within each.
    out : shape (TABLE, times), angles of the cell.
    lost : shape (pieces, LOST), zeros.
    """
    scene = scene_of(scene_tuple)
    case, memory, count = case_of(scene, joint[:4], rtol), workspace(), np.int64(N)
    cell, spare = cell_of(scene), np.empty((TABLE, 1))
    for k in range(pieces.size):
        row, work = pieces[k], memory[0]
        own = after(case, engagement[k] * cell)
        at = work, own, row, lengths[k], times, firsts[k], firsts[k + 1], out, lost[k], spare, count
        if lengths[k] == 0.0 and firsts[k] == firsts[k + 1]:
            continue
        if row.kind == WALL:
            _along_wall(*at)
        else:
            _through_flight(*at)
