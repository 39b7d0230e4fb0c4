"""The law of a pin between two walls that yield, with two degrees of freedom.

In natural units, lengths in crank radii. The pin's centre C = c + beta exp(i beta theta) turns
with the driver; e points outwards along the slot and n = i e ahead of it. With the follower
angle phi, counted from where the slot lies on the line of centres, and gamma = beta theta - phi

    D = n.C = beta sin(gamma) - c sin(phi),        R = e.C = beta cos(gamma) + c cos(phi)
    D' = cos(gamma) theta_dot - R phi_dot          speed across the slot
    d = s D - play                                 penetration of the wall s = +1 or -1
    v = -sin(gamma) theta_dot + (D + s r_p) phi_dot - s beta r_p theta_dot        sliding speed

The wall pushes the pin with

    N = k d + b d'  or, after Hunt and Crossley,  N = k d^1.5 (1 + chi d')

and never pulls it: it lets go where N would fall below zero. Friction is
F = mu N v/sqrt(v^2 + eps^2). Load, bearings and journals fade likewise where a body is slower
than eps, so that they hold it still. There is contact where d > 0 and N > 0, so that within
contact, and without, the law is smooth.

Source: Hunt and Crossley (1975), Journal of Applied Mechanics 42, 440-445; chi from a restitution
e and the speed d'_0 of the touch, 8 (1 - e)/(5 e d'_0), after Flores, Machado, Silva and Martins
(2011), Multibody System Dynamics 25, 357-375.
"""

from typing import NamedTuple

import numpy as np

from escapement.drive import torque_after
from escapement.jit import inner_jit
from escapement.scene import Joint, Scene

STATE = 12
"""Numbers of a state: theta, phi, theta_dot, phi_dot, and since the start the work that the load
takes, what is lost in each of `dynamics.LOSSES` and in the walls, and the impulse of the walls."""
LOAD, LOST, WALLS, IMPULSE = 4, 5, 10, 11
"""Places in it."""
FREE, LOCKED = 0, 2
"""Contact with none of the walls, and the follower locked in a dwell; +1 and -1 are the walls."""


class Engagement(NamedTuple):
    """A pin in its slot: what the law needs beside the state.

    turned : driver angle turned before this cell [rad].
    touch : speed of the pin across the slot where it touched the wall last.
    """

    scene: Scene
    joint: Joint
    turned: float
    touch: float


@inner_jit
def place(y, scene):
    """D, R, sin(gamma), cos(gamma) and D' of a state."""
    sense, centre = scene.path.numbers[9], 0.25 * abs(scene.path.numbers[2])
    angle = sense * y[0] - y[1]
    sine, cosine = np.sin(angle), np.cos(angle)
    across = sense * sine - centre * np.sin(y[1])
    radius = sense * cosine + centre * np.cos(y[1])
    return across, radius, sine, cosine, cosine * y[2] - radius * y[3]


@inner_jit
def fading(speed, least):
    """Sign of a speed, which fades where it is below `least`."""
    return speed / np.sqrt(speed * speed + least * least)


@inner_jit
def chi_of(case):
    """Damping of Hunt and Crossley over the stiffness: given, or by restitution and touch."""
    joint = case.joint
    if joint.damping > 0.0:
        return joint.damping / joint.stiffness
    e = joint.restitution
    return 1.6 * (1.0 - e) / (e * max(case.touch, joint.slip))


@inner_jit
def elastic(depth, joint):
    """Force of a wall's spring, and the energy that it holds."""
    depth = max(depth, 0.0)
    if joint.hertz:
        force = joint.stiffness * depth * np.sqrt(depth)
        return force, 0.4 * force * depth
    force = joint.stiffness * depth
    return force, 0.5 * force * depth


@inner_jit
def push(depth, rate, case):
    """Force N of a wall. It goes on smoothly behind its zero, where a trial step may lie."""
    joint = case.joint
    if joint.hertz:
        return joint.stiffness * depth * np.sqrt(abs(depth)) * (1.0 + chi_of(case) * rate)
    return joint.stiffness * depth + joint.damping * rate


@inner_jit
def resistance(speed, scene, least):
    """What load and drag hold the follower back with."""
    air = scene.follower_drag * abs(speed) + scene.follower_viscous
    return scene.load * fading(speed, least) + air * speed


@inner_jit
def slide_of(y, side, scene):
    """Sliding speed v of the contact point along the wall of a side."""
    across, _radius, sine, _cosine, _speed = place(y, scene)
    arm = side * scene.pin
    return (across + arm) * y[3] - (sine + scene.path.numbers[9] * arm) * y[2]


@inner_jit
def rates(y, mode, case, out):
    """Fill `out` with the derivative of a state by time; the result is the contact force N."""
    scene, joint = case.scene, case.joint
    eps, mu, pin, sense = joint.slip, scene.mu_plus, scene.pin, scene.path.numbers[9]
    driver, follower = y[2], y[3]
    on_driver = on_follower = force = friction = reaction = slide = wall = 0.0
    if abs(mode) == 1:
        across, radius, sine, cosine, speed = place(y, scene)
        side = float(mode)
        depth, rate, arm = side * across - joint.play, side * speed, side * pin
        force = push(depth, rate, case)
        slide = (across + arm) * follower - (sine + sense * arm) * driver
        bent = mu * fading(slide, eps)
        friction = bent * force
        if scene.driver_journal + scene.follower_journal > 0.0:
            # the journals' numbers hold where the pin slides with full friction
            reaction = np.sqrt((1.0 + bent * bent) / (1.0 + mu * mu)) * force
        on_driver = friction * (sine + sense * arm) - side * force * cosine
        on_follower = side * force * radius - (across + arm) * friction
        wall = (force - elastic(depth, joint)[0]) * rate
    pull = torque_after(case.turned + (y[0] - scene.edges[0]), scene)[0]
    at_driver = scene.bearing + scene.driver_journal * reaction
    at_follower, held = scene.follower_journal * reaction, scene.load
    if at_driver + at_follower + held != 0.0:
        at_driver *= fading(driver, eps)
        turn = fading(follower, eps)
        at_follower, held = at_follower * turn, held * turn
    drag = (scene.driver_drag * abs(driver) + scene.driver_viscous) * driver
    air = (scene.follower_drag * abs(follower) + scene.follower_viscous) * follower
    out[0], out[1] = driver, follower
    out[2] = (pull + on_driver - at_driver - drag) / scene.rho
    out[3] = on_follower - held - at_follower - air
    if mode == LOCKED:
        out[3] = 0.0
    out[LOAD] = held * follower
    out[LOST] = friction * slide
    out[LOST + 1] = at_driver * driver
    out[LOST + 2] = at_follower * follower
    out[LOST + 3] = drag * driver
    out[LOST + 4] = air * follower
    out[WALLS] = wall
    out[IMPULSE] = force
    return force


@inner_jit
def _reach(y, out, side, case):
    """How far a wall is from letting go, as a number with the sign of N, and its slope in time."""
    scene, joint = case.scene, case.joint
    across, radius, sine, cosine, speed = place(y, scene)
    depth, rate = side * across - joint.play, side * speed
    if rate >= 0.0 or depth < 0.0:
        return depth, rate
    along = y[3] * across - sine * y[2]
    turn = scene.path.numbers[9] * y[2] - y[3]
    bend = side * (cosine * out[2] - sine * turn * y[2] - radius * out[3] - along * y[3])
    if joint.hertz:
        chi = chi_of(case)
        return depth * (1.0 + chi * rate), rate * (1.0 + chi * rate) + depth * chi * bend
    delay = joint.damping / joint.stiffness
    return depth + delay * rate, rate + delay * bend


@inner_jit
def room(y, out, mode, case):
    """A number that is positive while a contact, or a flight, goes on, and its slope in time.

    `out` are the `rates` of the state.
    """
    if mode == LOCKED:
        return 1.0, 0.0
    if mode != FREE:
        return _reach(y, out, float(mode), case)
    ahead, behind = _reach(y, out, 1.0, case), _reach(y, out, -1.0, case)
    nearest = ahead if ahead[0] > behind[0] else behind
    return -nearest[0], -nearest[1]


@inner_jit
def stiffest(y, mode, case):
    """Frequency of the contact, and the fastest rate of decay that its damping gives."""
    if abs(mode) != 1:
        return 1.0, 0.0
    scene, joint = case.scene, case.joint
    across, radius, _sine, cosine, speed = place(y, scene)
    lightness = radius * radius + cosine * cosine / scene.rho
    stiffness, damping = joint.stiffness, joint.damping
    if joint.hertz:
        depth = max(mode * across - joint.play, 0.0)
        force = elastic(depth, joint)[0]
        stiffness, damping = 1.5 * joint.stiffness * np.sqrt(depth), chi_of(case) * force
        stiffness *= max(1.0 + chi_of(case) * mode * speed, 0.0)
    return max(np.sqrt(stiffness * lightness), 1.0), damping * lightness


@inner_jit
def stored(y, mode, case):
    """Energy that a wall holds while the pin touches it."""
    if abs(mode) != 1:
        return 0.0
    across = place(y, case.scene)[0]
    return elastic(abs(across) - case.joint.play, case.joint)[1]
