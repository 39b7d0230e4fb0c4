"""The states of a motion at given times, and the work lost over each of its pieces."""

from typing import Any, NamedTuple

import numpy as np

from escapement.dynamics.codes import Event
from escapement.dynamics.law import (
    LOSSES,
    dragged_slope,
    friction_ratio,
    net_torque,
    reduced_inertia,
    root_of,
    scene_of,
)
from escapement.dynamics.law import contact as contact_of
from escapement.dynamics.state_table import losses_at
from escapement.dynamics.torque import cell_of, torque_at
from escapement.dynamics.train_losses import UNKNOWN, weight
from escapement.engines.contact.rigid.flight import launch, state_after, state_at
from escapement.engines.contact.rigid.free import driver_rate, driver_sense, follower_rate
from escapement.engines.contact.rigid.instant import follower_on
from escapement.engines.contact.rigid.march import walls_after
from escapement.engines.contact.rigid.panel import (
    SMALLEST,
    flow_behind,
    has_failed,
    law_at,
    next_panel,
    solve_panel,
    width_after,
)
from escapement.engines.contact.rigid.walls import next_break, wall_scene, walls_of
from escapement.engines.contact.rigid.workspace import workspace
from escapement.engines.contact.state_rows import FIRST_LOSS, STATE_ROWS, StateRow
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.gauss import BARYCENTRIC, POINTS, WEIGHTS, N, cumulate
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.roots import newton_in_bracket

STRICT = 1e-13
"""Greatest tail of a panel whose solution is interpolated."""
LOST = len(LOSSES) + 1
"""Length of the work over a piece: one number for each of `LOSSES`, and one for the load."""


@inner_jit
def _inside(row, x):
    """A row's value at a point x of its panel, by the barycentric formula."""
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
def _point_after(work, time, width):
    """The point x of a panel that is reached after a time; its `times` are filled."""
    low, high, sign = -1.0, 1.0, np.sign(width)
    x = 0.0
    for _ in range(60):
        passed, slope = sign * _inside(work.times, x) - time, sign * _inside(work.slowness, x)
        guess, low, high = newton_in_bracket(x, passed, slope, low, high, True)
        step, x = abs(guess - x), guess
        if step <= 4e-16:
            break
    return x


@inner_jit
def _touching_state(walls, scene, side, theta, sense, w, out, k):
    """Fill column k of `out` with the state in contact with a wall."""
    g, u, dg, radius = pose_at(scene.path, theta)
    slope, c = dragged_slope(g, dg, scene), friction_ratio(g, u, radius, side, scene)
    pull, root = torque_at(theta, scene)[0] - scene.bearing, root_of(w, scene)
    inertia, speed = reduced_inertia(g, c, scene), sense * np.sqrt(w)
    rate = net_torque(g, c, slope, pull, w, root, scene) / inertia
    out[StateRow.THETA, k], out[StateRow.PHI, k] = theta, follower_on(walls, side, theta)[0]
    out[StateRow.THETA_DOT, k], out[StateRow.PHI_DOT, k] = speed, g * speed
    out[StateRow.THETA_DDOT, k], out[StateRow.PHI_DDOT, k] = rate, g * rate + dg * w
    moment = weight(scene) * contact_of(g, slope, pull, w, root, scene) / inertia
    lost = losses_at(g, u, radius, slope, pull, w, side, scene)
    out[StateRow.CONTACT_MOMENT, k], out[StateRow.CONTACT_FORCE, k] = moment, lost.force
    out[StateRow.FRICTION, k] = lost.friction * speed
    out[StateRow.DRIVER_BEARING, k] = lost.driver_bearing * speed
    out[StateRow.FOLLOWER_BEARING, k] = lost.follower_bearing * speed
    out[StateRow.DRIVER_DRAG, k] = lost.driver_drag * speed
    out[StateRow.FOLLOWER_DRAG, k] = lost.follower_drag * speed
    out[StateRow.BARREL, k] = lost.barrel * speed
    out[StateRow.LOAD_TRAIN, k] = lost.load_train * speed


@inner_jit
def _free_state(scene, theta, speed, phi, turning, out, k):
    """Fill column k of `out` with the state in a flight."""
    rate = driver_rate(scene, theta, speed, driver_sense(scene, theta, speed))
    turning_rate = follower_rate(scene, turning, np.sign(turning))
    out[StateRow.THETA, k], out[StateRow.PHI, k] = theta, phi
    out[StateRow.THETA_DOT, k], out[StateRow.PHI_DOT, k] = speed, turning
    out[StateRow.THETA_DDOT, k], out[StateRow.PHI_DDOT, k] = rate, turning_rate
    out[StateRow.CONTACT_MOMENT, k] = out[StateRow.CONTACT_FORCE, k] = 0.0
    out[StateRow.FRICTION, k] = out[StateRow.FOLLOWER_BEARING, k] = 0.0
    square, other = speed * speed, turning * turning
    bearing = scene.bearing * abs(speed)
    drag = (scene.driver_drag * abs(speed) + scene.driver_viscous) * square
    air = (scene.follower_drag * abs(turning) + scene.follower_viscous) * other
    # what the accelerations leave of the torques is lost in the trains
    barrel = train = 0.0
    if scene.barrel_efficiency != 1.0:
        barrel = (torque_at(theta, scene)[0] - scene.rho * rate) * speed
        barrel -= bearing + drag
    if scene.load_train_efficiency != 1.0:
        train = -scene.load * abs(turning) - air - turning_rate * turning
    out[StateRow.DRIVER_BEARING, k] = bearing
    out[StateRow.DRIVER_DRAG, k], out[StateRow.FOLLOWER_DRAG, k] = drag, air
    out[StateRow.BARREL, k], out[StateRow.LOAD_TRAIN, k] = barrel, train


class Wanted(NamedTuple):
    """What is wanted of a piece, and where it is filled in.

    row : the start of the piece. length : how long it lasts.
    times : since the start of the piece; those with an index from `first` on and before `last`.
    states : table with the rows of `StateRow` and a column for each time.
    lost : work lost over the piece, shape (LOST,).
    spare : a table with one column.
    """

    row: Any
    length: float
    times: np.ndarray
    first: int
    last: int
    states: np.ndarray
    lost: np.ndarray
    spare: np.ndarray


@inner_jit
def _add_losses(wanted, duration):
    """Add the work that is lost in a time with the power in the column of `spare`."""
    for j in range(LOST - 1):
        wanted.lost[j] += duration * wanted.spare[FIRST_LOSS + j, 0]


@inner_jit
def _along_wall(work, walls, wanted):
    """Fill the states of a piece in contact, and the work lost over it."""
    row, times, states, length = wanted.row, wanted.times, wanted.states, wanted.length
    side, theta, w, time, width = row.wall, row.theta, row.speed * row.speed, 0.0, np.inf
    sense = 1.0 if row.speed >= 0.0 else -1.0
    if w == 0.0:
        sense = 1.0
        scene = wall_scene(walls, side, theta, sense, w, UNKNOWN)
        rate = law_at(scene, side, theta, 0.0)[1]
        if rate > 0.0:
            w, theta, time = 2.0 * rate * SMALLEST, theta + SMALLEST, np.sqrt(2.0 * SMALLEST / rate)
        else:
            # at rest for good
            time = length
    flow, k = UNKNOWN, wanted.first
    while length - time > 1e-14 * length:
        scene = wall_scene(walls, side, theta, sense, w, flow)
        limit = next_break(walls, side, theta, sense, scene)
        if limit == theta:
            # by rounding, the piece may last longer than the distance to its end takes
            break
        start = w
        found = next_panel(work, scene, side, theta, w, width, limit, STRICT, False)
        if has_failed(found):
            break
        flow = flow_behind(found, scene.flow, found.width == limit - theta)
        cumulate(work.slowness, work.times)
        while k < wanted.last and times[k] <= time + found.time:
            x = _point_after(work, max(times[k] - time, 0.0), found.width)
            angle, w = theta + 0.5 * found.width * (1.0 + x), max(_inside(work.w, x), 0.0)
            _touching_state(walls, scene, side, angle, sense, w, states, k)
            k += 1
        end, over = theta + found.width, time + found.time
        if over > length * (1.0 + 1e-13):
            # the piece ends inside this panel
            part = 0.5 * found.width * (1.0 + _point_after(work, length - time, found.width))
            found = solve_panel(work, scene, side, theta, part, start)
            end, over = theta + found.width, length
        elif found.width == limit - theta:
            end = limit
        for i in range(N):
            angle = theta + 0.5 * found.width * (1.0 + POINTS[i])
            _touching_state(walls, scene, side, angle, sense, work.w[i], wanted.spare, 0)
            _add_losses(wanted, 0.5 * abs(found.width) * WEIGHTS[i] / np.sqrt(work.w[i]))
        moved = follower_on(walls, side, end)[0] - follower_on(walls, side, theta)[0]
        wanted.lost[LOST - 1] += walls.plus.load * abs(moved)
        theta, w, time, width = end, found.w, over, width_after(found, STRICT)
    while k < wanted.last:
        scene = wall_scene(walls, side, theta, sense, w, flow)
        _touching_state(walls, scene, side, theta, sense, w, states, k)
        k += 1


@inner_jit
def _through_flight(work, walls, wanted):
    """Fill the states of a flight or a dwell, and the work lost over it."""
    row, times, length, k = wanted.row, wanted.times, wanted.length, wanted.first
    scene, time = walls.plus, 0.0
    end = scene.edges[-1] + (scene.dwell if row.kind == Event.DWELL else 0.0)
    theta, speed, phi, turning = row.theta, row.speed, row.phi, row.turning
    while True:
        flight = launch(work, scene, theta, speed, phi, turning, end)
        # what its train loses jumps where the follower comes to rest
        part = min(flight.length, flight.rest, length - time)
        # a length is a difference of times, and their rounding may leave it longer than the flight
        ends = not time + part > time or length - time - part <= 1e-14 * length
        while k < wanted.last and (times[k] <= time + part or ends):
            since = min(max(times[k] - time, 0.0), part)
            _free_state(scene, *state_at(work, flight, since), wanted.states, k)
            k += 1
        for i in range(N):
            since = 0.5 * part * (1.0 + POINTS[i])
            _free_state(scene, *state_at(work, flight, since), wanted.spare, 0)
            _add_losses(wanted, 0.5 * part * WEIGHTS[i])
        before, time = phi, time + part
        theta, speed, phi, turning = state_after(work, flight, part)
        wanted.lost[LOST - 1] += scene.load * abs(phi - before)
        if ends:
            break


@jit(allocates=True)
def trace(scene_tuple, clearance, rtol, pieces, engagement, lengths, firsts, times, states, lost):
    """Fill the states at times within pieces, and the work lost over each piece.

    Parameters
    ----------
    scene_tuple, clearance, rtol : as of `march.march`.
    pieces, engagement : rows at which the pieces start, and the engagements they belong to.
    lengths : how long each lasts.
    firsts : shape (pieces + 1,): where the times of each piece begin among `times`.
    times : since the start of their pieces, ascending within each.
    states : shape (STATE_ROWS, times), angles of the cell; see `state_rows.StateRow`.
    lost : shape (pieces, LOST), zeros.
    """
    scene = scene_of(scene_tuple)
    walls, memory = walls_of(scene, clearance, rtol), workspace()
    cell, spare = cell_of(scene), np.empty((STATE_ROWS, 1))
    for k in range(pieces.size):
        if lengths[k] == 0.0 and firsts[k] == firsts[k + 1]:
            continue
        wanted = Wanted(
            row=pieces[k], length=lengths[k], times=times, first=firsts[k], last=firsts[k + 1],
            states=states, lost=lost[k], spare=spare,
        )  # fmt: skip
        work, here = memory[0], walls_after(walls, engagement[k] * cell)
        if pieces[k].kind == Event.CONTACT:
            _along_wall(work, here, wanted)
        else:
            _through_flight(work, here, wanted)
