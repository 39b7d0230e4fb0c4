"""The equations of compliant contact between pin and slot, with two degrees of freedom.

In natural units, with the coordinates of `slot`, the pin presses the wall s = +1 or -1 in by the
depth d = s D - c with half the clearance c. `dynamics.compliance` has the force of the wall. Load,
bearings and journals fade if a body is slower than the slip speed; above it they act in full, so
that a drive that they equal drives nothing.
"""

from typing import NamedTuple

from escapement.dynamics.compliance import (
    FREE,
    IMPULSE,
    LOAD,
    LOCKED,
    LOST,
    WALLS,
    elastic,
    fading,
    friction_ratio,
    push,
    reach,
    swing,
)  # fmt: skip
from escapement.dynamics.free_bodies import driver_of, follower_of, move
from escapement.dynamics.load import has_load_curve, load_over
from escapement.dynamics.torque import torque_after
from escapement.dynamics.train_losses import is_lossy
from escapement.engines.contact.slot import (
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
def angle_of_follower(y, at, mode, scene):
    """phi of a state whose pose this is."""
    return follower_angle(frame_of(scene), y[0], at) if touches(mode) else y[1]


@inner_jit
def rates(case, y, mode, out):
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
        side = float(mode)
        depth, rate = side * at.across - joint.half_clearance, side * at.speed
        force, sliding = push(depth, rate, joint, case.touch), slide(at, side, scene)
        f = friction_ratio(scene.mu_plus, sliding, joint)
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
    held, load, varies = scene.follower_journal * reaction, turns * scene.load, 0.0
    if has_load_curve(scene):
        phi = angle_of_follower(y, at, mode, scene)
        varies = load_over(phi, 0.0, case.driver_angle, scene)[0]
    follower = move(follower_of(scene), at.follower, turns, -load, on_follower - varies, held)
    acceleration, train = (0.0, 0.0) if mode == LOCKED else (follower.rate, follower.train)
    out[0], out[1], out[2], out[3] = at.driver, y[3], driver.rate, acceleration
    if touches(mode):
        out[3] = acceleration_across(at, driver.rate, acceleration, scene)
    out[LOAD] = (load + varies) * at.follower
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
    depth, rate = side * at.across - case.joint.half_clearance, side * at.speed
    return reach(depth, rate, side * bending, case.joint, case.touch)


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
def frequency(case, y, mode):
    """Frequency at which the pin swings on a wall's spring; 1 in flight."""
    if not touches(mode):
        return 1.0
    joint, at = case.joint, pose(y, mode, case.scene)
    lightness = at.radius * at.radius + at.cosine * at.cosine / case.scene.rho
    depth, rate = mode * at.across - joint.half_clearance, mode * at.speed
    return max(swing(depth, rate, lightness, joint, case.touch), 1.0)


@inner_jit
def stored(y, mode, case):
    """Energy stored in a wall while the pin touches it."""
    if not touches(mode):
        return 0.0
    return elastic(abs(y[1]) - case.joint.half_clearance, case.joint)[1]
