"""Contact, flights and blows of one engagement, from entry to the end of the cell."""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.law import is_viscous
from escapement.dynamics.torque import REST, is_spent, is_undriven
from escapement.dynamics.train_losses import UNKNOWN
from escapement.engines.contact.rigid.blow import strike
from escapement.engines.contact.rigid.flight import ahead, arrival, launch, state_after
from escapement.engines.contact.rigid.free import is_calm
from escapement.engines.contact.rigid.panel import (
    GOES_ON,
    JAMS,
    LIFTS,
    NET,
    PLACES,
    RESTS,
    SMALLEST,
    STOPS,
    flow_behind,
    law_at,
    next_panel,
    slowed,
    solve_panel,
    width_after,
)
from escapement.engines.contact.rigid.walls import next_break, wall_scene
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.gauss import POINTS, N, root_between, to_powers
from escapement.numerics.jit import inner_jit
from escapement.numerics.records import record_dtype

DONE, OVER, STALL, SPENT, JAM, BACKS_OUT, UNDRIVEN, RESTLESS, TOO_LONG, RUNNING = range(10)
"""How an engagement ends: at the handoff; after the time asked for; because the drive stalls or the
spring is spent; at the Painleve limit; because the driver turns back out of the slot, with a drive
that would turn it forwards again or with none; or because it has more than `MOST_PIECES`, or
`MOST_STEPS`. A march that goes on is running."""
LIFTED, TURNED, STRUCK, TOUCHES = range(10, 14)
"""How a piece ends besides: at a lift-off, where a driver that turns back comes to rest, and at a
blow; while it touches a wall it does not end."""
FLIGHT, WALL, LOCKED, BLOW, EXTREMUM, LIFT, SLIDE = range(7)
"""Kinds of rows: pieces of the motion, and events."""
MOST_PIECES = 20_000
MOST_STEPS = 100_000
"""Panels of contact and parts of flights in an engagement; they take some tenths of a second."""
MOST_TURNS = 1000
"""Turns of power in a train that are followed while the pin touches a wall."""
MOST_EXTREMA = 4
"""Greatest number of extrema of the speed in one panel."""

ROW = record_dtype({
    "kind": np.int64,
    # `before` is the speed before a blow, and of an extremum 1 for a maximum, else 0
    **dict.fromkeys(
        ("wall", "time", "theta", "speed", "phi", "turning", "before", "approach", "impulse",
         "energy"), np.float64,
    ),
})  # fmt: skip
"""A row of the record: the start of a piece, or an event."""


class Body(NamedTuple):
    """Driver and follower at an instant of an engagement.

    theta, speed, phi, turning, time : as in the package's docstring.
    wall : the wall that the pin touches or has just left, 0 for none.
    trend : sign of theta_ddot before this instant, 0 if nothing is known of it.
    """

    theta: float
    speed: float
    phi: float
    turning: float
    time: float
    wall: float
    trend: float


class Notes(NamedTuple):
    """Record of pieces and events, and of the effort.

    rows : the record. used : number of rows in use, and of steps taken. wanted : whether any rows
    are wanted. limit : number of steps after which the engagement is given up.
    """

    rows: np.ndarray
    used: np.ndarray
    wanted: bool
    limit: int


@inner_jit
def _tired(notes):
    """Count a step; returns whether the engagement has taken too many."""
    notes.used[1] += 1
    return notes.used[1] > notes.limit


@inner_jit
def note(notes, kind, body):
    """Write a row if there is room; the number of rows is counted in any case."""
    at = notes.used[0]
    notes.used[0] = at + 1
    if at < notes.rows.size:
        row = notes.rows[at]
        row.kind, row.wall, row.time, row.theta = kind, body.wall, body.time, body.theta
        row.speed, row.phi, row.turning = body.speed, body.phi, body.turning
        row.before = row.approach = row.impulse = row.energy = 0.0


@inner_jit
def _last(notes):
    return notes.rows[min(notes.used[0], notes.rows.size) - 1]


@inner_jit
def _turned(notes, body, trend):
    """The body with the trend of the speed from here on; an extremum is noted where it changes."""
    if trend * body.trend < 0.0:
        note(notes, EXTREMUM, body)
        _last(notes).before = 1.0 if body.trend > 0.0 else 0.0
    trend = trend if trend != 0.0 else body.trend
    return Body(body.theta, body.speed, body.phi, body.turning, body.time, body.wall, trend)


@inner_jit
def follower_on(case, side, theta):
    """Follower angle, and g, while the pin touches a wall."""
    scene = case.plus if side > 0.0 else case.minus
    x, y = case.centre + case.crank * np.cos(theta), np.sin(theta)
    behind = np.arcsin(side * case.play / np.sqrt(x * x + y * y))
    return np.arctan2(y, x) - behind, pose_at(scene.path, theta)[0]


@inner_jit
def _first_turn(work, trend, at_end):
    """Places x in a panel between which theta_ddot first loses the sign `trend`; 2 for none.

    `at_end` is theta_ddot at its right end.
    """
    low = -1.0
    for i in range(N + 1):
        place, rate = (POINTS[i], work[NET][i]) if i < N else (1.0, at_end)
        if rate * trend < 0.0:
            return low, place
        low = place
    return low, 2.0


@inner_jit
def _extrema_on(work, notes, case, panel, body, scene, way):
    """Note the extrema of the speed inside a panel; returns the trend behind them."""
    side, count, left, rest, w = body.wall, np.int64(N), body.theta, panel.width, body.speed**2
    time, trend = body.time, body.trend
    at_end = law_at(scene, side, left + rest, panel.w)[1]
    for _ in range(MOST_EXTREMA):
        low, high = _first_turn(work, trend, at_end)
        if high > 1.0:
            break
        to_powers(work[NET], work[PLACES])
        x = root_between(work[PLACES], 0.5 * (low + high), low, high, trend < 0.0)[0]
        for k in range(N):
            work[PLACES][k] = POINTS[k]
        width = 0.5 * (1.0 + x) * rest
        part = solve_panel(work, scene, side, left, width, w, count)
        left, rest, w, time = left + width, rest - width, part.w, time + part.time
        speed, (phi, g) = way * np.sqrt(w), follower_on(case, side, left)
        _turned(notes, Body(left, speed, phi, g * speed, time, side, trend), -trend)
        trend = -trend
        # the rows hold the rest of the panel, where another one may be
        solve_panel(work, scene, side, left, rest, w, count)
    return trend


@inner_jit
def touch(work, notes, case, body, end_time, tail, count):
    """Follow the motion while the pin touches a wall; returns the body at the end, and why."""
    side, theta = body.wall, body.theta
    way, w, width = 1.0 if body.speed >= 0.0 else -1.0, body.speed * body.speed, np.inf
    if w == 0.0:
        scene = wall_scene(case, side, theta, 1.0, 0.0, UNKNOWN)
        rate = law_at(scene, side, theta, 0.0)[1]
        if not rate > 0.0:
            return body, _stopped(theta, scene)
        # over the smallest angle of a panel the acceleration is taken as constant
        w, theta = 2.0 * rate * SMALLEST, theta + SMALLEST
        body = _on_wall(case, body, theta, np.sqrt(w), body.time + np.sqrt(w) / rate)
    flow, turns = UNKNOWN, 0
    if is_calm(case.plus, theta, body.speed, body.turning):
        return body, _stopped(theta, case.plus)
    while True:
        scene = wall_scene(case, side, theta, way, w, flow)
        limit = next_break(case, side, theta, way, scene)
        found = next_panel(work, scene, side, theta, w, width, limit, tail, True, count)
        if found.code == JAMS:
            return body, np.int64(JAM)
        if is_viscous(scene) and is_undriven(theta, case.plus):
            found = slowed(work, scene, side, found, w, count)
        if found.code == STOPS:
            rate = abs(law_at(scene, side, theta, w)[1])
            time = body.time + np.sqrt(w) / rate
            body = _on_wall(case, body, theta + 0.5 * way * w / rate, 0.0, time)
            return body, np.int64(TURNED) if way < 0.0 else _stopped(body.theta, scene)
        trend = body.trend
        if notes.wanted:
            body = _turned(notes, body, np.sign(law_at(scene, side, theta, w)[1]))
            trend = _extrema_on(work, notes, case, found, body, scene, way)
        ends = found.code == GOES_ON and found.width == limit - theta
        flow = flow_behind(found, scene.flow, ends)
        theta, w, width = limit if ends else theta + found.width, found.w, width_after(found, tail)
        body = Body(theta, way * np.sqrt(w), *body[2:4], body.time + found.time, side, trend)
        code = np.int64(OVER) if body.time > end_time else _how(found, case, theta, way)
        if notes.wanted or code != TOUCHES:
            body = _on_wall(case, body, theta, body.speed, body.time)
        if code != TOUCHES:
            return body, code
        if _tired(notes):
            return body, np.int64(TOO_LONG)
        turns += 1 if found.code != GOES_ON else 0
        if turns > MOST_TURNS:
            return body, np.int64(RESTLESS)
        if notes.wanted and theta == case.breaks[0 if side > 0.0 else 1, 0]:
            note(notes, SLIDE, body)


@inner_jit
def _how(found, case, theta, way):
    """How a piece in contact ends behind a panel, if it does."""
    edges = case.plus.edges
    if found.code == LIFTS:
        return np.int64(LIFTED)
    if found.code == RESTS:
        return _stopped(theta, case.plus)
    if way > 0.0 and not theta < edges[-1]:
        return np.int64(DONE)
    return (
        _thrown_out(theta, case.plus) if way < 0.0 and not theta > edges[0] else np.int64(TOUCHES)
    )


@inner_jit
def _thrown_out(theta, scene):
    """Why a motion ends whose driver turns back out of the slot."""
    return np.int64(UNDRIVEN) if is_undriven(theta, scene) else np.int64(BACKS_OUT)


@inner_jit
def _stopped(theta, scene):
    """Why a motion ends whose driver comes to rest: a stall, or a spent spring."""
    return np.int64(SPENT) if is_spent(theta, scene) else np.int64(STALL)


@inner_jit
def _on_wall(case, body, theta, speed, time):
    """The body at another driver angle, speed and time, on the wall that it touches."""
    phi, g = follower_on(case, body.wall, theta)
    return Body(theta, speed, phi, g * speed, time, body.wall, body.trend)


@inner_jit
def fly(work, notes, case, body, end, locked, end_time, count):
    """Follow a flight to a wall or to the driver angle `end`; returns the body there, and why."""
    scene = case.plus
    while True:
        # the pin of a driver that turns back leaves the slot where it has entered it
        if body.speed < 0.0 and body.theta <= scene.edges[0] + 1e-12:
            return body, _thrown_out(body.theta, scene)
        flight = launch(work, scene, body.theta, body.speed, body.phi, body.turning, end)
        if notes.wanted:
            body = _turned(notes, body, np.sign(flight.rate))
        if not flight.length < np.inf or is_calm(scene, body.theta, body.speed, body.turning):
            return body, _stopped(body.theta, scene)
        time, struck = flight.length, 0.0
        if not locked:
            time, struck = arrival(work, case, flight, body.wall)
        theta, speed, phi, turning = state_after(work, flight, time)
        if struck == 0.0 and abs(theta - end) < 1e-12:
            theta = end
        body = Body(theta, speed, phi, turning, body.time + time, struck, body.trend)
        if struck != 0.0:
            return body, np.int64(STRUCK)
        if theta == end:
            return body, np.int64(DONE)
        if body.time > end_time:
            return body, np.int64(OVER)
        if _tired(notes):
            return body, np.int64(TOO_LONG)


@inner_jit
def _knocked(notes, case, body):
    """The body after the blow on the wall that it has reached, whether it rebounds, and whether
    the blow has a solution.
    """
    blow = strike(case, body.wall, body.theta, body.speed, body.turning)
    rho = case.plus.rho
    if not blow.sound:
        return body, False, False
    if notes.wanted:
        body = _turned(notes, body, np.sign(blow.speed - body.speed))
    now = Body(
        body.theta, blow.speed, body.phi, blow.turning, body.time, body.wall, body.trend
    )  # fmt: skip
    if notes.wanted:
        note(notes, BLOW, now)
        row = _last(notes)
        row.before, row.approach, row.impulse = body.speed, blow.approach, blow.impulse
        # differences of squares as products, which keep the digits of a small loss
        row.energy = 0.5 * rho * (body.speed - blow.speed) * (body.speed + blow.speed)
        row.energy += 0.5 * (body.turning - blow.turning) * (body.turning + blow.turning)
    return now, blow.rebounds, True


@inner_jit
def rests(scene, body):
    """Whether both bodies count as at rest at a pin entry: see `escapement.simulate`.

    Where nothing drives them, bodies that hardly move would come to rest after any time.
    """
    energy = scene.rho * body.speed * body.speed + body.turning * body.turning
    return energy <= scene.rho * REST and is_undriven(body.theta, scene)


@inner_jit
def holds(case, body):
    """Whether the wall that the pin touches carries a force, and whether J_s is positive."""
    way = 1.0 if body.speed >= 0.0 else -1.0
    scene = wall_scene(case, body.wall, body.theta, way, body.speed * body.speed, UNKNOWN)
    force, _rate, sound = law_at(scene, body.wall, body.theta, body.speed * body.speed)
    return force > 0.0, sound


@inner_jit
def engage(work, notes, case, body, end_time, tail, count):
    """Follow an engagement from its entry, in flight; returns the body at its end, and why."""
    exit_, touching = case.plus.edges[-1], False
    if rests(case.plus, body):
        if notes.wanted:
            note(notes, FLIGHT, body)
        return body, _stopped(body.theta, case.plus)
    for _ in range(MOST_PIECES):
        if notes.wanted:
            note(notes, WALL if touching else FLIGHT, body)
        if touching:
            body, code = touch(work, notes, case, body, end_time, tail, count)
            touching = code == TURNED and holds(case, body)[0]
            if code == LIFTED and notes.wanted:
                note(notes, LIFT, body)
        else:
            body, code = fly(work, notes, case, body, exit_, False, end_time, count)
            if code == STRUCK:
                body, rebounds, sound = _knocked(notes, case, body)
                if not sound:
                    return body, np.int64(JAM)
                # a pin that rebounds flies on, whatever the force at the wall would be
                if not rebounds:
                    touching, sound = holds(case, body)
                if touching and not sound:
                    return body, np.int64(JAM)
                if touching:
                    body = _on_wall(case, body, body.theta, body.speed, body.time)
        if code == DONE:
            # the wall that the pin touches here is the one that the next pin starts from
            wall = body.wall if abs(_gap(case, body)) < 1e-12 else 0.0
            return Body(*body[:5], wall, body.trend), code
        if code < LIFTED:
            return body, code
    return body, np.int64(RESTLESS)


@inner_jit
def _gap(case, body):
    return ahead(case, body.theta, 0.0, body.phi, 0.0)[0] - body.wall * case.play


@inner_jit
def turn_on(work, notes, case, body, step, end_time, count):
    """The dwell behind an exit, and the change to the next pin and slot."""
    scene, code = case.plus, np.int64(DONE)
    if scene.dwell > 0.0:
        radius = pose_at(scene.path, body.theta)[3]
        moved = abs(body.turning)
        locked = Body(*body[:3], 0.0, body.time, 0.0, body.trend)
        if notes.wanted and moved > 0.0:
            note(notes, BLOW, locked)
            row = _last(notes)
            row.before, row.energy = body.speed, 0.5 * moved * moved
            # what is behind a lossy train gives back less than it holds
            inertia = 1.0 + (scene.load_train_efficiency - 1.0) * scene.load_train
            row.approach, row.impulse = moved * radius, inertia * moved / radius
        if notes.wanted:
            note(notes, LOCKED, locked)
        end = scene.edges[-1] + scene.dwell
        locked, code = fly(work, notes, case, locked, end, True, end_time, count)
        body = Body(*locked[:5], body.wall, locked.trend)
    if code == DONE:
        body = Body(scene.edges[0], body.speed, body.phi - step, *body[3:])
    return body, code
