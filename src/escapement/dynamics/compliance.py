"""A wall that yields: its force, and the states of a motion with such walls.

In natural units a wall that is pressed in by the depth d pushes back with the force

    N = k d + b d'  or, after Hunt and Crossley,  N = k d^1.5 (1 + chi d')

and never pulls: the contact ends where N would fall below zero. Friction is
F = mu N v/sqrt(v^2 + eps^2), which is smooth where the sliding reverses. The friction of bearings
fades as well if a body is slower than the slip speed eps, so that it holds the body at rest. There
is contact where d > 0 and N > 0; the law is smooth during contact, and without it.

Source: Hunt and Crossley (1975), Journal of Applied Mechanics 42, 440-445; chi from a restitution
e and the speed d'_0 of the touch, 8 (1 - e)/(5 e d'_0), after Flores, Machado, Silva and Martins
(2011), Multibody System Dynamics 25, 357-375.
"""

import numpy as np

from escapement.numerics.jit import inner_jit

STATE = 14
"""Length of a state: two coordinates, their rates, and, summed since the start, the work that the
load takes, the work lost in each of `dynamics.law.LOSSES` and in the walls, and the impulse of the
walls."""
DRIVER_SPEED, LOAD, LOST, WALLS, IMPULSE = 2, 4, 5, 12, 13
"""Indices in it."""
FREE, LOCKED = 0, 2
"""Modes: no contact with a wall, and a follower that is locked in a dwell; +1 and -1 are contacts
with either wall."""


@inner_jit
def fading(speed, least):
    """Smooth sign of a speed, which fades to 0 if the speed is below `least`."""
    x = speed / least
    if abs(x) >= 1.0:
        return np.sign(x)
    return x * (15.0 - x * x * (10.0 - 3.0 * x * x)) / 8.0


@inner_jit
def friction_ratio(mu, sliding, joint):
    """Friction over force of a wall at a sliding speed."""
    return mu * sliding / np.sqrt(sliding * sliding + joint.slip * joint.slip)


@inner_jit
def chi_of(joint, touch):
    """Hunt and Crossley's chi: from the damping, or from restitution and speed of the touch."""
    if joint.damping > 0.0:
        return joint.damping / joint.stiffness
    e = joint.restitution
    return 1.6 * (1.0 - e) / (e * max(touch, joint.slip))


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
def push(depth, rate, joint, touch):
    """Force N of a wall; it continues smoothly below zero, where a trial step may lie."""
    if joint.hertz:
        return joint.stiffness * depth * np.sqrt(abs(depth)) * (1.0 + chi_of(joint, touch) * rate)
    return joint.stiffness * depth + joint.damping * rate


@inner_jit
def reach(depth, rate, bend, joint, touch):
    """A number that is zero where a contact begins or ends and else has the sign of N, and its
    slope in time.

    bend : d'' of the depth.
    """
    if rate >= 0.0 or depth < 0.0:
        return depth, rate
    if joint.hertz:
        chi = chi_of(joint, touch)
        return depth * (1.0 + chi * rate), rate * (1.0 + chi * rate) + depth * chi * bend
    delay = joint.damping / joint.stiffness
    return depth + delay * rate, rate + delay * bend


@inner_jit
def swing(depth, rate, lightness, joint, touch):
    """Frequency at which bodies swing on a wall's spring: the root of stiffness times lightness."""
    stiffness = joint.stiffness
    if joint.hertz:
        stiffness *= 1.5 * np.sqrt(max(depth, 0.0)) * max(1.0 + chi_of(joint, touch) * rate, 0.0)
    return np.sqrt(stiffness * lightness)
