"""The states of a motion at given times, and the work lost over each of its pieces."""

from typing import Any, NamedTuple

import numpy as np

from escapement.dynamics.codes import Event
from escapement.dynamics.contact_state import FIRST_LOSS, ContactState, write_state
from escapement.dynamics.free_bodies import driver_sense, follower_sense, free_driver, free_follower
from escapement.dynamics.law import LOSSES, scene_of, wall_state
from escapement.dynamics.load import has_load_curve, load_at, load_over
from escapement.dynamics.power_flow import weight
from escapement.dynamics.state_table import losses_at
from escapement.dynamics.torque import cell_of
from escapement.engines.contact.rigid.along_wall import ahead, behind, set_off
from escapement.engines.contact.rigid.flight import launch, state_after, state_at
from escapement.engines.contact.rigid.instant import follower_on
from escapement.engines.contact.rigid.march import walls_after
from escapement.engines.contact.rigid.panel import has_failed, next_panel, solve_panel
from escapement.engines.contact.rigid.walls import Clearance, wall_scene, walls_of
from escapement.engines.contact.rigid.workspace import workspace
from escapement.numerics.gauss import POINTS, WEIGHTS, N, cumulate, dot, invert
from escapement.numerics.jit import inner_jit, jit

STRICT = 1e-13
"""Greatest tail of a panel whose solution is interpolated."""
LOST = len(LOSSES) + 1
"""Length of the work over a piece: one number for each of `LOSSES`, and one for the load."""


@inner_jit
def _touching_state(walls, scene, way, theta, w):
    """The state in contact with a wall at a driver angle and a squared speed."""
    now, speed = wall_state(theta, w, way.side, scene), way.sense * np.sqrt(w)
    path, load = (now.g, now.u, now.radius, now.k, now.pull), 0.0
    if has_load_curve(scene):
        load = load_at(theta, way.side, scene)
    lost = losses_at(*path, w, way.side, scene, 0.0, 0.0, load)
    return ContactState(
        theta=theta, theta_dot=speed, theta_ddot=now.rate,
        phi=follower_on(walls, way.side, theta)[0], phi_dot=now.g * speed,
        phi_ddot=now.g * now.rate + now.dg * w,
        contact_moment=weight(scene) * now.moment / now.inertia, contact_force=lost.force,
        friction=lost.friction * speed, driver_bearing=lost.driver_bearing * speed,
        follower_bearing=lost.follower_bearing * speed, driver_drag=lost.driver_drag * speed,
        follower_drag=lost.follower_drag * speed, barrel=lost.barrel * speed,
        load_train=lost.load_train * speed,
    )  # fmt: skip


@inner_jit
def _free_state(scene, locked, theta, speed, phi, turning):
    """The state in a flight, or in a dwell, where the follower is `locked`."""
    driver = free_driver(scene, theta, speed, driver_sense(scene, theta, speed))
    sense = np.sign(turning)
    if has_load_curve(scene):
        sense = 0.0 if locked else follower_sense(scene, phi, turning)
    follower = free_follower(scene, phi, turning, sense)
    return ContactState(
        theta=theta, theta_dot=speed, theta_ddot=driver.rate, phi=phi, phi_dot=turning,
        phi_ddot=follower.rate, contact_moment=0.0, contact_force=0.0, friction=0.0,
        driver_bearing=driver.friction * speed, follower_bearing=0.0,
        driver_drag=driver.drag * speed, follower_drag=follower.drag * turning,
        barrel=driver.train * speed, load_train=follower.train * turning,
    )  # fmt: skip


class Wanted(NamedTuple):
    """What is wanted of a piece, and where it is filled in.

    row : the start of the piece. length : how long it lasts.
    times : since the start of the piece; those with an index from `first` on and before `last`.
    states : table with the rows of a `ContactState` and a column for each time.
    lost : work lost over the piece, shape (LOST,).
    """

    row: Any
    length: float
    times: np.ndarray
    first: int
    last: int
    states: np.ndarray
    lost: np.ndarray


@inner_jit
def _add_losses(wanted, duration, state):
    """Add the work that is lost in a time with the power of a state."""
    for j in range(LOST - 1):
        wanted.lost[j] += duration * state[FIRST_LOSS + j]


@inner_jit
def _add_load(wanted, scene, duration, state):
    """Add the work done in a time against a load over the follower angle."""
    load = load_over(state.phi, 0.0, scene.driver_angle, scene)[0]
    wanted.lost[LOST - 1] += duration * load * state.phi_dot


@inner_jit
def _along_wall(work, walls, wanted):
    """Fill the states of a piece in contact, and the work lost over it."""
    row, times, states, length = wanted.row, wanted.times, wanted.states, wanted.length
    way, k = set_off(walls, row.wall, row.theta, row.speed, 0.0), wanted.first
    while way.w > 0.0 and length - way.time > 1e-14 * length:
        side, theta, w, (scene, limit) = way.side, way.theta, way.w, ahead(walls, way)
        # by rounding, the piece may last longer than the distance to its end takes
        if limit == theta:
            break
        found = next_panel(work, scene, side, theta, w, way.width, limit, STRICT, False)
        if has_failed(found):
            break
        following = behind(way, scene, limit, found, STRICT)
        cumulate(work.slowness, work.scratch)
        while k < wanted.last and times[k] <= following.time:
            x = _point_after(work, max(times[k] - way.time, 0.0), found)
            angle = theta + 0.5 * found.width * (1.0 + x)
            squared = max(dot(work.at_x, work.w, work.points), 0.0)
            write_state(states, k, _touching_state(walls, scene, way, angle, squared))
            k += 1
        if following.time > length * (1.0 + 1e-13):
            # the piece ends inside this panel
            part = 0.5 * found.width * (1.0 + _point_after(work, length - way.time, found))
            found = solve_panel(work, scene, side, theta, part, w)
            following = behind(way, scene, limit, found, STRICT)
        for i in range(N):
            angle = theta + 0.5 * found.width * (1.0 + POINTS[i])
            state = _touching_state(walls, scene, way, angle, work.w[i])
            duration = 0.5 * abs(found.width) * WEIGHTS[i] / np.sqrt(work.w[i])
            _add_losses(wanted, duration, state)
            if has_load_curve(scene):
                _add_load(wanted, walls.plus, duration, state)
        moved = follower_on(walls, side, following.theta)[0] - follower_on(walls, side, theta)[0]
        wanted.lost[LOST - 1] += walls.plus.load * abs(moved)
        way = following
    scene = wall_scene(walls, way.side, way.theta, way.sense, way.w, way.flow)
    while k < wanted.last:
        write_state(states, k, _touching_state(walls, scene, way, way.theta, way.w))
        k += 1


@inner_jit
def _point_after(work, time, found):
    """The point x of a panel that is reached after a time; its `scratch` holds the times."""
    sign = np.sign(found.width)
    return invert(work, sign * time, sign * found.time)


@inner_jit
def _through_flight(work, walls, wanted):
    """Fill the states of a flight or a dwell, and the work lost over it."""
    row, times, length, k = wanted.row, wanted.times, wanted.length, wanted.first
    scene, time, locked = walls.plus, 0.0, row.kind == Event.DWELL
    end = scene.edges[-1] + (scene.dwell if locked else 0.0)
    theta, speed, phi, turning = row.theta, row.speed, row.phi, row.turning
    while True:
        flight = launch(work, scene, theta, speed, phi, turning, end)
        # what its train loses jumps where the follower comes to rest
        part = min(flight.length, flight.rest, length - time)
        # a length is a difference of times, and their rounding may leave it longer than the flight
        ends = not time + part > time or length - time - part <= 1e-14 * length
        while k < wanted.last and (times[k] <= time + part or ends):
            since = min(max(times[k] - time, 0.0), part)
            state = _free_state(scene, locked, *state_at(work, flight, since))
            write_state(wanted.states, k, state)
            k += 1
        for i in range(N):
            since = 0.5 * part * (1.0 + POINTS[i])
            state = _free_state(scene, locked, *state_at(work, flight, since))
            _add_losses(wanted, 0.5 * part * WEIGHTS[i], state)
            if has_load_curve(scene):
                _add_load(wanted, scene, 0.5 * part * WEIGHTS[i], state)
        before, time = phi, time + part
        theta, speed, phi, turning = state_after(work, flight, part)
        wanted.lost[LOST - 1] += scene.load * abs(phi - before)
        if ends:
            break


@jit(allocates=True)
def trace(packed, clearance, rtol, pieces, engagement, lengths, firsts, times, states, lost):
    """Fill the states at times within pieces, and the work lost over each piece.

    Parameters
    ----------
    packed, clearance, rtol : as of `march.march`.
    pieces, engagement : rows at which the pieces start, and the engagements they belong to.
    lengths : how long each lasts.
    firsts : shape (pieces + 1,): where the times of each piece begin among `times`.
    times : since the start of their pieces, ascending within each.
    states : shape (STATE_ROWS, times), angles of the cell; see `state_rows.ContactState`.
    lost : shape (pieces, LOST), zeros.
    """
    scene = scene_of(packed)
    walls, memory = walls_of(scene, Clearance(*clearance), rtol), workspace()
    cell = cell_of(scene)
    for k in range(pieces.size):
        if lengths[k] == 0.0 and firsts[k] == firsts[k + 1]:
            continue
        wanted = Wanted(
            row=pieces[k], length=lengths[k], times=times, first=firsts[k], last=firsts[k + 1],
            states=states, lost=lost[k],
        )  # fmt: skip
        work, here = memory[0], walls_after(walls, engagement[k] * cell)
        if pieces[k].kind == Event.CONTACT:
            _along_wall(work, here, wanted)
        else:
            _through_flight(work, here, wanted)
