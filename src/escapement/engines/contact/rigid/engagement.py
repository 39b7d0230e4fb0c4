"""One engagement with clearance: from the entry of a pin to that of the next one.

The figure in section 4 of docs/theory.md shows the two walls of a slot. At its entry the pin is in
flight between them. From there `engage` follows one piece of the motion after the other:

- `fly`: a flight, until the pin strikes a wall. Behind the impact the pin stays at the wall if it
  does not rebound and the wall carries a force; otherwise it flies on.
- `touching.touch`: contact with a wall. The pin lifts off where the wall would have to pull it.

Where the pin leaves the slot, at the driver angle `scene.edges[-1]`, the engagement ends with
`Ending.DONE`. It ends before with another `Ending` if the motion ends there. `turn_on` then goes on
to the next pin and slot; in a wheel with a dwell it first follows the driver through the dwell,
in which the follower is locked.

These functions take driver and follower as a `RigidState`, and return the state at the end
together with an `Ending`. If rows of the `Notes` are wanted, they also write the starts of pieces
and the events.
"""

import numpy as np

from escapement.dynamics.codes import Ending, Event, has_ended
from escapement.dynamics.law import wall_state
from escapement.dynamics.power_flow import UNKNOWN
from escapement.dynamics.torque import REST, is_undriven
from escapement.engines.contact.rigid.arrival import arrival, pin_offset
from escapement.engines.contact.rigid.flight import is_calm, launch, state_after
from escapement.engines.contact.rigid.impact import strike
from escapement.engines.contact.rigid.instant import RigidState, on_wall
from escapement.engines.contact.rigid.notes import follow_trend, last_row, note, takes_too_many
from escapement.engines.contact.rigid.touching import stopped, thrown_out, touch
from escapement.engines.contact.rigid.walls import wall_scene
from escapement.engines.contact.slot import frame_of
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit

MOST_PIECES = 20_000
"""Greatest number of pieces of an engagement."""
MOST_STEPS = 100_000
"""Greatest number of steps of an engagement, which are the panels of contacts and the parts of
flights. So many take some tenths of a second."""


@inner_jit
def engage(work, notes, walls, now, end_time, tail):
    """Follow an engagement from its entry, in flight; returns the state at its end and an `Ending`.

    It ends early after the first step that ends later than `end_time`. `tail` is the greatest tail
    of a panel of contact, which sets the accuracy.
    """
    exit_, touching = walls.plus.edges[-1], False
    if rests(walls.plus, now):
        if notes.wanted:
            note(notes, Event.FLIGHT, now)
        return now, stopped(now.theta, walls.plus)
    for _ in range(MOST_PIECES):
        if notes.wanted:
            note(notes, Event.CONTACT if touching else Event.FLIGHT, now)
        if touching:
            now, ending = touch(work, notes, walls, now, end_time, tail)
            # a driver that has turned back and come to rest may press on the same wall again
            touching = ending == Ending.TURNED and holds(walls, now)[0]
            if ending == Ending.LIFTED and notes.wanted:
                note(notes, Event.LIFT_OFF, now)
        else:
            now, ending = fly(work, notes, walls, now, exit_, False, end_time)
            if ending == Ending.STRUCK:
                now, touching, sound = _behind_impact(notes, walls, now)
                if not sound:
                    return now, Ending.JAM
        if ending == Ending.DONE:
            # the next pin starts at the wall of this side if this pin touches it here
            wall = now.wall if abs(_gap(walls, now)) < 1e-12 else 0.0
            return altered(now, "wall", wall), ending
        if has_ended(ending):
            return now, ending
    return now, Ending.RESTLESS


@inner_jit
def fly(work, notes, walls, now, end, locked, end_time):
    """Follow a flight to a wall or to the driver angle `end`; returns the state, and an `Ending`.

    `launch` gives the flight in parts, one at a time. In a dwell the follower is `locked`, and
    there is no wall to strike.
    """
    scene, frame = walls.plus, frame_of(walls.plus)
    while True:
        # the pin of a driver that turns back leaves the slot where it has entered it
        if now.speed < 0.0 and now.theta <= scene.edges[0] + 1e-12:
            return now, thrown_out(now.theta, scene)
        flight = launch(work, scene, now.theta, now.speed, now.phi, now.turning, end)
        if notes.wanted:
            now = follow_trend(notes, now, np.sign(flight.rate))
        if not flight.length < np.inf or is_calm(scene, now.theta, now.speed, now.turning):
            return now, stopped(now.theta, scene)
        time, struck = flight.length, 0.0
        if not locked:
            time, struck = arrival(work, frame, walls.clearance.half_clearance, flight, now.wall)
        theta, speed, phi, turning = state_after(work, flight, time)
        if struck == 0.0 and abs(theta - end) < 1e-12:
            theta = end
        now = RigidState(
            theta=theta, speed=speed, phi=phi, turning=turning, time=now.time + time, wall=struck,
            trend=now.trend,
        )  # fmt: skip
        if struck != 0.0:
            return now, Ending.STRUCK
        if theta == end:
            return now, Ending.DONE
        if now.time > end_time:
            return now, Ending.OVER
        if takes_too_many(notes):
            return now, Ending.TOO_LONG


@inner_jit
def _behind_impact(notes, walls, now):
    """Compute the impact on the wall that the pin has reached.

    Returns
    -------
    now, touching, sound : the state behind the impact; whether the pin then stays at the wall; and
        whether the impact, and the contact behind it if there is one, have a solution.
    """
    impact = strike(walls, now.wall, now.theta, now.speed, now.turning)
    if not impact.sound:
        return now, False, False
    before = now.speed, now.turning
    if notes.wanted:
        now = follow_trend(notes, now, np.sign(impact.speed - now.speed))
    now = altered(now, "speed", impact.speed, "turning", impact.turning)
    if notes.wanted:
        _note_impact(notes, walls, now, before, impact)
    # a pin that rebounds flies on, whatever the force at the wall would be
    if impact.rebounds:
        return now, False, True
    touching, sound = holds(walls, now)
    if touching and sound:
        now = on_wall(walls, now, now.theta, now.speed, now.time)
    return now, touching, sound or not touching


@inner_jit
def _note_impact(notes, walls, now, before, impact):
    """Note an impact; `before` are the speeds of driver and follower before it."""
    speed, turning = before
    note(notes, Event.IMPACT, now)
    row = last_row(notes)
    row.before, row.approach, row.impulse = speed, impact.approach, impact.impulse
    # as products the differences of squares keep their digits where little energy is lost
    row.energy = 0.5 * walls.plus.rho * (speed - impact.speed) * (speed + impact.speed)
    row.energy += 0.5 * (turning - impact.turning) * (turning + impact.turning)


@inner_jit
def rests(scene, now):
    """Whether both bodies count as at rest at a pin entry: see `escapement.simulate`.

    They do if nothing drives them and they hardly move, because drag alone might never stop them.
    """
    energy = scene.rho * now.speed * now.speed + now.turning * now.turning
    return energy <= scene.rho * REST and is_undriven(now.theta, scene)


@inner_jit
def holds(walls, now):
    """Whether the wall that the pin touches carries a force, and whether J_s is positive.

    The wall s carries a force if X has the sign of s.
    """
    sense, w = 1.0 if now.speed >= 0.0 else -1.0, now.speed * now.speed
    scene = wall_scene(walls, now.wall, now.theta, sense, w, UNKNOWN)
    there = wall_state(now.theta, w, now.wall, scene)
    return now.wall * there.moment > 0.0, there.inertia > 0.0


@inner_jit
def _gap(walls, now):
    """Offset of the pin less the one at which it touches the wall `now.wall`; 0 in contact."""
    across = pin_offset(frame_of(walls.plus), now.theta, 0.0, now.phi, 0.0)[0]
    return across - now.wall * walls.clearance.half_clearance


@inner_jit
def turn_on(work, notes, walls, now, end_time):
    """Go from an exit to the entry of the next pin, through the dwell if there is one.

    At that entry driver and follower angle are counted from the dead centre of the next pin and
    slot.
    """
    scene, ending = walls.plus, Ending.DONE
    if scene.dwell > 0.0:
        locked = altered(now, "turning", 0.0, "wall", 0.0)
        if notes.wanted and now.turning != 0.0:
            _note_lock(notes, scene, now, locked)
        if notes.wanted:
            note(notes, Event.DWELL, locked)
        end = scene.edges[-1] + scene.dwell
        locked, ending = fly(work, notes, walls, locked, end, True, end_time)
        now = altered(locked, "wall", now.wall)
    if ending == Ending.DONE:
        now = altered(now, "theta", scene.edges[0], "phi", now.phi - walls.clearance.step)
    return now, ending


@inner_jit
def _note_lock(notes, scene, now, locked):
    """Note the impact with which the lock stops the follower.

    Its speed of approach and its impulse are given as at the distance of the pin from the axis.
    """
    radius, moved = pose_at(scene.path, now.theta)[3], abs(now.turning)
    note(notes, Event.IMPACT, locked)
    row = last_row(notes)
    row.before, row.energy = now.speed, 0.5 * moved * moved
    # the shaft behind a lossy train gives back only a share of its angular momentum
    inertia = 1.0 + (scene.load_train_efficiency - 1.0) * scene.load_train
    row.approach, row.impulse = moved * radius, inertia * moved / radius
