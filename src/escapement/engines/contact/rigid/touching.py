"""Contact with a wall, panel by panel, until the pin lifts off or the engagement ends."""

import numpy as np

from escapement.dynamics.codes import Ending, Event
from escapement.dynamics.law import is_viscous
from escapement.dynamics.torque import is_spent, is_undriven
from escapement.dynamics.train_losses import UNKNOWN
from escapement.engines.contact.rigid.free import is_calm
from escapement.engines.contact.rigid.instant import Instant, instant_with, on_wall
from escapement.engines.contact.rigid.notes import follow_trend, note, takes_too_many
from escapement.engines.contact.rigid.panel import (
    SMALLEST,
    flow_behind,
    law_at,
    next_panel,
    slowed,
    solve_panel,
    width_after,
)
from escapement.engines.contact.rigid.walls import breaks_of, next_break, wall_scene
from escapement.numerics.gauss import POINTS, N, root_between, to_powers
from escapement.numerics.jit import inner_jit

MOST_TURNS = 1000
"""Turns of power in a train that are followed while the pin touches a wall."""
MOST_EXTREMA = 4
"""Greatest number of extrema of the speed in one panel."""


@inner_jit
def touch(work, notes, walls, now, end_time, tail):
    """Follow the motion while the pin touches a wall; returns the instant at the end, and why."""
    side, theta = now.wall, now.theta
    sense, w, width = 1.0 if now.speed >= 0.0 else -1.0, now.speed * now.speed, np.inf
    if w == 0.0:
        scene = wall_scene(walls, side, theta, 1.0, 0.0, UNKNOWN)
        rate = law_at(scene, side, theta, 0.0)[1]
        if not rate > 0.0:
            return now, stopped(theta, scene)
        # over the smallest angle of a panel the acceleration is taken as constant
        w, theta = 2.0 * rate * SMALLEST, theta + SMALLEST
        now = on_wall(walls, now, theta, np.sqrt(w), now.time + np.sqrt(w) / rate)
    flow, turns = UNKNOWN, 0
    if is_calm(walls.plus, theta, now.speed, now.turning):
        return now, stopped(theta, walls.plus)
    while True:
        scene = wall_scene(walls, side, theta, sense, w, flow)
        limit = next_break(walls, side, theta, sense, scene)
        found = next_panel(work, scene, side, theta, w, width, limit, tail, True)
        if found.ending == Ending.JAM:
            return now, Ending.JAM
        if is_viscous(scene) and is_undriven(theta, walls.plus):
            found = slowed(work, scene, side, found, w)
        if found.ending == Ending.STOPPED:
            rate = abs(law_at(scene, side, theta, w)[1])
            time = now.time + np.sqrt(w) / rate
            now = on_wall(walls, now, theta + 0.5 * sense * w / rate, 0.0, time)
            return now, Ending.TURNED if sense < 0.0 else stopped(now.theta, scene)
        trend = now.trend
        if notes.wanted:
            now = follow_trend(notes, now, np.sign(law_at(scene, side, theta, w)[1]))
            trend = _note_extrema(work, notes, walls, found, now, scene, sense)
        whole = found.ending == Ending.TOUCHES and found.width == limit - theta
        flow = flow_behind(found, scene.flow, whole)
        theta, w, width = limit if whole else theta + found.width, found.w, width_after(found, tail)
        now = _moved(now, theta, sense * np.sqrt(w), now.time + found.time, trend)
        ending = Ending.OVER if now.time > end_time else _ending_of(found, walls, theta, sense)
        if notes.wanted or ending != Ending.TOUCHES:
            now = on_wall(walls, now, theta, now.speed, now.time)
        if ending != Ending.TOUCHES:
            return now, ending
        if takes_too_many(notes):
            return now, Ending.TOO_LONG
        turns += 1 if found.ending != Ending.TOUCHES else 0
        if turns > MOST_TURNS:
            return now, Ending.RESTLESS
        if notes.wanted and theta == breaks_of(walls, side).slide_change:
            note(notes, Event.SLIDE_CHANGE, now)


@inner_jit
def _moved(now, theta, speed, time, trend):
    """The instant behind a panel; that of the follower stays, until `on_wall` computes it."""
    return Instant(
        theta=theta, speed=speed, phi=now.phi, turning=now.turning, time=time, wall=now.wall,
        trend=trend,
    )  # fmt: skip


@inner_jit
def _ending_of(panel, walls, theta, sense):
    """How a piece in contact ends behind a panel; TOUCHES if it goes on."""
    edges = walls.plus.edges
    if panel.ending == Ending.LIFTED:
        return Ending.LIFTED
    if panel.ending == Ending.RESTED:
        return stopped(theta, walls.plus)
    if sense > 0.0 and not theta < edges[-1]:
        return Ending.DONE
    backs_out = sense < 0.0 and not theta > edges[0]
    return thrown_out(theta, walls.plus) if backs_out else Ending.TOUCHES


@inner_jit
def thrown_out(theta, scene):
    """Why a motion ends whose driver turns back out of the slot."""
    return Ending.UNDRIVEN if is_undriven(theta, scene) else Ending.BACKS_OUT


@inner_jit
def stopped(theta, scene):
    """Why a motion ends whose driver comes to rest: a stall, or a spent spring."""
    return Ending.SPENT if is_spent(theta, scene) else Ending.STALL


@inner_jit
def _note_extrema(work, notes, walls, panel, now, scene, sense):
    """Note the extrema of the speed inside a panel; returns the trend behind them."""
    side, left, rest, w = now.wall, now.theta, panel.width, now.speed**2
    time, trend = now.time, now.trend
    at_end = law_at(scene, side, left + rest, panel.w)[1]
    for _ in range(MOST_EXTREMA):
        low, high = _first_turn(work, trend, at_end)
        if high > 1.0:
            break
        to_powers(work.net_torque, work.series)
        x = root_between(work.series, 0.5 * (low + high), low, high, trend < 0.0)[0]
        width = 0.5 * (1.0 + x) * rest
        part = solve_panel(work, scene, side, left, width, w)
        left, rest, w, time = left + width, rest - width, part.w, time + part.time
        there = on_wall(walls, now, left, sense * np.sqrt(w), time)
        follow_trend(notes, instant_with(there, trend=trend), -trend)
        trend = -trend
        # the rows hold the rest of the panel, where another one may be
        solve_panel(work, scene, side, left, rest, w)
    return trend


@inner_jit
def _first_turn(work, trend, at_end):
    """Points x of a panel between which theta_ddot first loses the sign `trend`; 2 for none.

    `at_end` is theta_ddot at its right end.
    """
    low = -1.0
    for i in range(N + 1):
        x, rate = (POINTS[i], work.net_torque[i]) if i < N else (1.0, at_end)
        if rate * trend < 0.0:
            return low, x
        low = x
    return low, 2.0
