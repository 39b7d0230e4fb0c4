"""The law of two bodies whose outlines yield where they touch, at several points at once.

Each contact is that of a nose on a track, which is pressed in by the depth d = -gap. Its force N
and the friction ratio f are those of `dynamics.compliance`. It pushes the angles of the bodies by
N (G - f H), with the directions of `touch`. A contact whose force has ended pushes no more, until
its force begins anew or its gap opens. The mode is the number of contacts.
"""

from collections import namedtuple

from escapement.dynamics.compliance import (
    IMPULSE,
    LOAD,
    LOST,
    WALLS,
    elastic,
    fading,
    friction_ratio,
    push,
    reach,
    swing,
)
from escapement.engines.two_bodies.law import torques, touching
from escapement.numerics.by_type import give_kernels
from escapement.numerics.jit import inner_jit
from escapement.numerics.records import record_dtype

CONTACT = record_dtype({
    **dict.fromkeys(("pair", "nose", "track", "active"), int), "touch": float
})  # fmt: skip
"""A pair with its images, the speed at which it closed, and whether it pushes, or may close."""
MOST = 4
"""Contacts at once."""
HANDOFF, LIFTS, LEAVES, PUSHES, CLOSES, NOTHING = range(6)
"""Events: the driver has turned by a pitch, a force ends or a gap opens behind it, a foot leaves
its feature, a force begins anew, and a gap closes."""


Yielding = namedtuple("Yielding", "law pairs joints joint held seen")
"""A law, the pairs of features and which features meet, see `two_bodies.scene`; the joint; and
arrays of `CONTACT`: those that are closed, and every pair as it is at the start of a step."""


Goal = namedtuple("Goal", "kind index angle")
"""An event, which contact it means in its array, and the driver angle of the handoff."""


Pressed = namedtuple("Pressed", "depth rate slip touch foot")
"""How a contact is pressed in: depth and its rate, slip, the touch, and what is left to the end of
its features."""


@inner_jit
def pressed(case, contact, y):
    """How a contact is pressed in."""
    touch = touching(case.law, case.pairs, contact, y)
    rate, slip = touch.g0 * y[2] + touch.g1 * y[3], touch.h0 * y[2] + touch.h1 * y[3]
    return Pressed(-touch.gap, -rate, slip, touch, min(touch.on_track, touch.on_nose))


@inner_jit
def rates(case, y, mode, out):
    """Write the rates of a state; returns the moment on the follower, less that of its journal."""
    law, joint = case.law, case.joint
    on_driver = on_follower = force = out[LOST] = out[WALLS] = 0.0
    for k in range(mode):
        if case.held[k].active == 0:
            continue
        at = pressed(case, case.held[k], y)
        n = push(at.depth, at.rate, joint, case.held[k].touch)
        f = friction_ratio(law.mu_plus, at.slip, joint)
        on_driver += n * (at.touch.g0 - f * at.touch.h0)
        on_follower += n * (at.touch.g1 - f * at.touch.h1)
        out[LOST] += f * n * at.slip
        out[WALLS] += (n - elastic(at.depth, joint)[0]) * at.rate
        force += n
    driver, follower = torques(law, y)
    first, second = fading(y[2], joint.slip), fading(y[3], joint.slip)
    held, load = first * (law.bearing + force * law.driver_journal), second * law.load
    rubbed = second * force * law.follower_journal
    out[0], out[1] = y[2], y[3]
    out[2], out[3] = (driver + on_driver - held) / law.rho, follower + on_follower - rubbed - load
    out[LOAD], out[LOST + 1], out[LOST + 2] = load * y[3], held * y[2], rubbed * y[3]
    out[LOST + 3] = (law.driver_drag * abs(y[2]) + law.driver_viscous) * y[2] * y[2]
    out[LOST + 4] = (law.follower_drag * abs(y[3]) + law.follower_viscous) * y[3] * y[3]
    out[LOST + 5], out[LOST + 6], out[IMPULSE] = 0.0, 0.0, force
    return on_follower - rubbed


@inner_jit
def stored(case, y, mode):
    """Energy stored in the contacts."""
    found = 0.0
    for k in range(mode):
        if case.held[k].active != 0:
            found += elastic(pressed(case, case.held[k], y).depth, case.joint)[1]
    return found


@inner_jit
def frequency(case, y, mode):
    """Frequency of the fastest swing on a contact; 1 in flight."""
    most = 1.0
    for k in range(mode):
        at = pressed(case, case.held[k], y)
        lightness = at.touch.g0 * at.touch.g0 / case.law.rho + at.touch.g1 * at.touch.g1
        fast = swing(at.depth, at.rate, lightness, case.joint, case.held[k].touch)
        most = max(most, fast)
    return most


@inner_jit
def left(case, y, mode, out, goal):
    """A number that is positive before an event."""
    if goal.kind == HANDOFF:
        return goal.angle - y[0]
    contact = case.seen[goal.index] if goal.kind == CLOSES else case.held[goal.index]
    at = pressed(case, contact, y)
    found = reach(at.depth, at.rate, 0.0, case.joint, contact.touch)[0]
    if goal.kind == CLOSES:
        return abs(at.depth) if at.foot < 0.0 else -at.depth
    if goal.kind == LEAVES:
        return at.foot
    if goal.kind == LIFTS:
        return found if contact.active != 0 else at.depth
    return -found if contact.active == 0 else 1.0


give_kernels(Yielding, rates=rates, frequency=frequency, left=left)
