"""Contact with a wall, panel by panel, until the pin lifts off or the engagement ends."""

import numpy as np

from escapement.dynamics.codes import Ending, Event
from escapement.dynamics.law import is_viscous, wall_state
from escapement.dynamics.torque import is_spent, is_undriven
from escapement.engines.contact.rigid.along_wall import ahead, behind, set_off
from escapement.engines.contact.rigid.flight import is_calm
from escapement.engines.contact.rigid.instant import RigidState, on_wall
from escapement.engines.contact.rigid.notes import follow_trend, note, takes_too_many
from escapement.engines.contact.rigid.panel import next_panel, slowed, solve_panel
from escapement.engines.contact.rigid.walls import breaks_of
from escapement.numerics.altered import altered
from escapement.numerics.gauss import first_change, root_between, to_powers
from escapement.numerics.jit import inner_jit

MOST_TURNS = 1000
"""Turns of power in a train that are followed while the pin touches a wall."""
MOST_EXTREMA = 4
"""Greatest number of extrema of the speed in one panel."""


@inner_jit
def touch(work, notes, walls, now, end_time, tail):
    """Follow the motion while the pin touches a wall; returns the instant at the end, and why."""
    way, turns = set_off(walls, now.wall, now.theta, now.speed, now.time), 0
    if way.time > now.time:
        now = on_wall(walls, now, way.theta, np.sqrt(way.w), way.time)
    if way.w == 0.0 or is_calm(walls.plus, way.theta, now.speed, now.turning):
        return now, stopped(way.theta, walls.plus)
    while True:
        side, theta, w, (scene, limit) = way.side, way.theta, way.w, ahead(walls, way)
        found = next_panel(work, scene, side, theta, w, way.width, limit, tail, True)
        if found.ending == Ending.JAM:
            return now, Ending.JAM
        if is_viscous(scene) and is_undriven(theta, walls.plus):
            found = slowed(work, scene, side, found, w)
        if found.ending == Ending.STOPPED:
            rate = abs(wall_state(theta, w, side, scene).rate)
            time = now.time + np.sqrt(w) / rate
            now = on_wall(walls, now, theta + 0.5 * way.sense * w / rate, 0.0, time)
            return now, Ending.TURNED if way.sense < 0.0 else stopped(now.theta, scene)
        trend = now.trend
        if notes.wanted:
            now = follow_trend(notes, now, np.sign(wall_state(theta, w, side, scene).rate))
            trend = _note_extrema(work, notes, walls, found, now, scene, way.sense)
        way = behind(way, scene, limit, found, tail)
        # that of the follower stays until `on_wall` computes it
        now = RigidState(
            theta=way.theta, speed=way.sense * np.sqrt(way.w), phi=now.phi, turning=now.turning,
            time=way.time, wall=side, trend=trend,
        )  # fmt: skip
        ending = _ending_of(found, walls, way.theta, way.sense)
        ending = Ending.OVER if now.time > end_time else ending
        if notes.wanted or ending != Ending.TOUCHES:
            now = on_wall(walls, now, now.theta, now.speed, now.time)
        if ending != Ending.TOUCHES:
            return now, ending
        if takes_too_many(notes):
            return now, Ending.TOO_LONG
        turns += 1 if found.ending != Ending.TOUCHES else 0
        if turns > MOST_TURNS:
            return now, Ending.RESTLESS
        if notes.wanted and way.theta == breaks_of(walls, side).slide_change:
            note(notes, Event.SLIDE_CHANGE, now)


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
    at_end = wall_state(left + rest, panel.w, side, scene).rate
    for _ in range(MOST_EXTREMA):
        low, high = first_change(work.net_torque, trend, at_end)
        if trend == 0.0 or high > 1.0:
            break
        to_powers(work.net_torque, work.series)
        x = root_between(work.series, 0.5 * (low + high), low, high, trend < 0.0)[0]
        width = 0.5 * (1.0 + x) * rest
        part = solve_panel(work, scene, side, left, width, w)
        left, rest, w, time = left + width, rest - width, part.w, time + part.time
        there = on_wall(walls, now, left, sense * np.sqrt(w), time)
        follow_trend(notes, altered(there, "trend", trend), -trend)
        trend = -trend
        # the rows hold the rest of the panel, where another one may be
        solve_panel(work, scene, side, left, rest, w)
    return trend
