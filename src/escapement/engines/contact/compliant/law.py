"""The equations of compliant contact between pin and slot, with two degrees of freedom.

In natural units, with the coordinates of `slot`, the pin presses the wall s = +1 or -1 in by the
depth d = s D - c with half the clearance c. The wall pushes the pin with the force

    N = k d + b d'  or, after Hunt and Crossley,  N = k d^1.5 (1 + chi d')

and never pulls it: the contact ends where N would fall below zero. Friction is
F = mu N v/sqrt(v^2 + eps^2), which is smooth where the sliding reverses. Load, bearings and
journals fade as well if a body is slower than the slip speed eps, so that they hold it at rest;
above it they act in full, so that a drive that they equal drives nothing. There is contact where
d > 0 and N > 0; the law is smooth during contact, and without it.

Source: Hunt and Crossley (1975), Journal of Applied Mechanics 42, 440-445; chi from a restitution
e and the speed d'_0 of the touch, 8 (1 - e)/(5 e d'_0), after Flores, Machado, Silva and Martins
(2011), Multibody System Dynamics 25, 357-375.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.free_bodies import driver_of, follower_of, move
from escapement.dynamics.load import has_load_curve, load_over
from escapement.dynamics.torque import torque_after
from escapement.dynamics.train_losses import is_lossy
from escapement.engines.contact.slot import (
    FREE,
    LOCKED,
    acceleration_across,
    follower_angle,
    frame_of,
    journal_share,
    pose,
    pushes,
    slide,
    touches,
)
from escapement.model.scene import Joint, Scene
from escapement.numerics.jit import inner_jit

STATE = 14
"""Length of a state: theta, phi or D, their rates, and, summed since the start, the work that the
load takes, the work lost in each of `dynamics.law.LOSSES` and in the walls, and the impulse of the
walls."""
DRIVER_SPEED, LOAD, LOST, WALLS, IMPULSE = 2, 4, 5, 12, 13
"""Indices in it."""


class PinInSlot(NamedTuple):
    """A pin in its slot: what the law needs in addition to the state.

    driver_angle : driver angle turned before this cell [rad].
    touch : speed of the pin across the slot when it last touched a wall.
    """

    scene: Scene
    joint: Joint
    driver_angle: float
    touch: float


@inner_jit
def fading(speed, least):
    """Smooth sign of a speed, which fades to 0 if the speed is below `least`."""
    x = speed / least
    if abs(x) >= 1.0:
        return np.sign(x)
    return x * (15.0 - x * x * (10.0 - 3.0 * x * x)) / 8.0


@inner_jit
def chi_of(case):
    """Hunt and Crossley's chi: from the damping, or from restitution and speed of the touch."""
    joint = case.joint
    if joint.damping > 0.0:
        return joint.damping / joint.stiffness
    e = joint.restitution
    return 1.6 * (1.0 - e) / (e * max(case.touch, joint.slip))


@inner_jit
def elastic(depth, joint):
    """Force of a wall's spring, and the energy stored in it."""
    depth = max(depth, 0.0)
    if joint.hertz:
        force = joint.stiffness * depth * np.sqrt(depth)
        return force, 0.4 * force * depth
    force = joint.stiffness * depth
    return force, 0.5 * force * depth


@inner_jit
def push(depth, rate, case):
    """Force N of a wall; it continues smoothly below zero, where a trial step may lie."""
    joint = case.joint
    if joint.hertz:
        return joint.stiffness * depth * np.sqrt(abs(depth)) * (1.0 + chi_of(case) * rate)
    return joint.stiffness * depth + joint.damping * rate


@inner_jit
def angle_of_follower(y, at, mode, scene):
    """phi of a state whose pose this is."""
    return follower_angle(frame_of(scene), y[0], at) if touches(mode) else y[1]


@inner_jit
def rates(y, mode, case, out):
    """Fill `out` with the derivative of a state by time.

    Returns
    -------
    phi_ddot, moment
        `moment` is that of the contact on the follower, less the friction of its journal.
    """
    scene, joint = case.scene, case.joint
    at = pose(y, mode, scene)
    on_driver = on_follower = force = reaction = out[LOST] = out[WALLS] = 0.0
    if touches(mode):
        side, mu = float(mode), scene.mu_plus
        depth, rate = side * at.across - joint.half_clearance, side * at.speed
        force, sliding = push(depth, rate, case), slide(at, side, scene)
        f = mu * sliding / np.sqrt(sliding * sliding + joint.slip * joint.slip)
        on_driver, on_follower = pushes(at, side, f, scene)
        on_driver, on_follower = on_driver * force, on_follower * force
        if scene.driver_journal + scene.follower_journal > 0.0:
            reaction = journal_share(f, scene) * force
        out[LOST], out[WALLS] = f * force * sliding, (force - elastic(depth, joint)[0]) * rate
    pull = torque_after(case.driver_angle + (y[0] - scene.edges[0]), scene)[0]
    held, turn, turns = scene.bearing + scene.driver_journal * reaction, 0.0, 0.0
    # all that depends on the sense in which a body turns
    if held + scene.follower_journal * reaction + scene.load != 0.0 or is_lossy(scene):
        turn, turns = fading(at.driver, joint.slip), fading(at.follower, joint.slip)
    driver = move(driver_of(scene), at.driver, turn, pull, on_driver, held)
    held, load, swing = scene.follower_journal * reaction, turns * scene.load, 0.0
    if has_load_curve(scene):
        phi = angle_of_follower(y, at, mode, scene)
        swing = load_over(phi, 0.0, case.driver_angle, scene)[0]
    follower = move(follower_of(scene), at.follower, turns, -load, on_follower - swing, held)
    acceleration, train = (0.0, 0.0) if mode == LOCKED else (follower.rate, follower.train)
    out[0], out[1], out[2], out[3] = at.driver, y[3], driver.rate, acceleration
    if touches(mode):
        out[3] = acceleration_across(at, driver.rate, acceleration, scene)
    out[LOAD] = (load + swing) * at.follower
    out[LOST + 1], out[LOST + 2] = driver.friction * at.driver, follower.friction * at.follower
    out[LOST + 3], out[LOST + 4] = driver.drag * at.driver, follower.drag * at.follower
    out[LOST + 5], out[LOST + 6] = driver.train * at.driver, train * at.follower
    out[IMPULSE] = force
    return acceleration, on_follower - follower.friction


@inner_jit
def _reach(at, bending, side, case):
    """A number that is zero where the contact ends and has the sign of N, and its slope in time.

    bending : D'' of the pose.
    """
    joint = case.joint
    depth, rate = side * at.across - joint.half_clearance, side * at.speed
    if rate >= 0.0 or depth < 0.0:
        return depth, rate
    if joint.hertz:
        chi = chi_of(case)
        return depth * (1.0 + chi * rate), rate * (1.0 + chi * rate) + depth * chi * side * bending
    delay = joint.damping / joint.stiffness
    return depth + delay * rate, rate + delay * side * bending


@inner_jit
def room(y, out, mode, case):
    """A number that is positive while a contact, or a flight, lasts, and its slope in time.

    `out` are the `rates` of the state.
    """
    if mode == LOCKED:
        return 1.0, 0.0
    at = pose(y, mode, case.scene)
    if mode != FREE:
        return _reach(at, out[3], float(mode), case)
    bending = acceleration_across(at, out[2], out[3], case.scene)
    forward, behind = _reach(at, bending, 1.0, case), _reach(at, bending, -1.0, case)
    nearest = forward if forward[0] > behind[0] else behind
    return -nearest[0], -nearest[1]


@inner_jit
def frequency(y, mode, case):
    """Frequency at which the pin swings on a wall's spring; 1 in flight."""
    if not touches(mode):
        return 1.0
    joint, at = case.joint, pose(y, mode, case.scene)
    lightness = at.radius * at.radius + at.cosine * at.cosine / case.scene.rho
    stiffness = joint.stiffness
    if joint.hertz:
        depth = max(mode * at.across - joint.half_clearance, 0.0)
        stiffness *= 1.5 * np.sqrt(depth) * max(1.0 + chi_of(case) * mode * at.speed, 0.0)
    return max(np.sqrt(stiffness * lightness), 1.0)


@inner_jit
def stored(y, mode, case):
    """Energy stored in a wall while the pin touches it."""
    if not touches(mode):
        return 0.0
    return elastic(abs(y[1]) - case.joint.half_clearance, case.joint)[1]
