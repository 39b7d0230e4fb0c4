"""The two walls of a slot: a slotted path for each, and the angles at which it is not smooth."""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.load import has_load_curve, load_knot
from escapement.dynamics.power_flow import UNKNOWN
from escapement.dynamics.torque import KNOT_GAP, last_knot, next_knot
from escapement.dynamics.train_losses import flowing, in_flow
from escapement.mechanisms.path import OFFSET, Path
from escapement.mechanisms.slotted import angle_in_slot, pose_at, slide_change
from escapement.model.scene import Scene
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit
from escapement.numerics.roots import newton_in_bracket


class Clearance(NamedTuple):
    """Numbers of a wheel with clearance, which `march.march` takes; lengths in crank radii.

    half_clearance : half the difference between the width of the slot and the diameter of the pin.
    restitution : impulse of rebound over that of compression.
    step : angle by which the follower turns from pin to pin [rad].
    """

    half_clearance: float
    restitution: float
    step: float


class Breaks(NamedTuple):
    """Driver angles at which the law of contact with a wall is not smooth; NaN for none.

    slide_change : there the contact point changes its sense of sliding.
    first_standstill, last_standstill : there the follower, and with it its losses, change their
        sense, behind the entry and before the exit.
    """

    slide_change: float
    first_standstill: float
    last_standstill: float


class Walls(NamedTuple):
    """Both walls of the slots of an escapement.

    plus, minus : scenes of contact with either wall, whose paths have the offset of the wall.
    plus_breaks, minus_breaks : breaks of either wall.
    clearance : the numbers of the wheel.
    rtol : relative error asked for.
    """

    plus: Scene
    minus: Scene
    plus_breaks: Breaks
    minus_breaks: Breaks
    clearance: Clearance
    rtol: float


@inner_jit
def wall_of(walls, side):
    """The scene of contact with the wall s = `side`."""
    return walls.plus if side > 0.0 else walls.minus


@inner_jit
def breaks_of(walls, side):
    """The breaks of the wall s = `side`."""
    return walls.plus_breaks if side > 0.0 else walls.minus_breaks


@inner_jit(allocates=True)
def walls_of(scene, clearance, rtol):
    """The walls of an escapement with the scene of a pin that fits its slot."""
    plus = altered(scene, "path", _beside(scene.path, clearance.half_clearance))
    minus = altered(scene, "path", _beside(scene.path, -clearance.half_clearance))
    return Walls(
        plus=plus, minus=minus, plus_breaks=_breaks_on(plus, 1.0),
        minus_breaks=_breaks_on(minus, -1.0), clearance=clearance, rtol=rtol,
    )  # fmt: skip


@inner_jit
def _breaks_on(scene, side):
    """The breaks of the wall s = `side`, whose scene is given."""
    entry, exit_ = scene.edges[0], scene.edges[-1]
    turns = scene.load + scene.follower_drag + scene.follower_journal > 0.0
    turns = turns or scene.load_train_efficiency != 1.0 or has_load_curve(scene)
    return Breaks(
        slide_change=slide_change(scene.path, scene.pin, side, entry, exit_),
        first_standstill=_standstill(scene.path, entry, 0.0) if turns else np.nan,
        last_standstill=_standstill(scene.path, exit_, 0.0) if turns else np.nan,
    )


@inner_jit(allocates=True)
def _beside(path, offset):
    """The path in a slot whose line passes the follower's axis at this distance."""
    numbers = path.numbers.copy()
    numbers[OFFSET] = offset
    return Path(table=path.table, numbers=numbers)


@inner_jit
def _standstill(path, outer, inner):
    """Driver angle at which g is zero, NaN if it is not between an end and dead centre."""
    low, high, theta = outer, inner, outer
    if not pose_at(path, outer)[0] < 0.0:
        return np.nan
    for _ in range(100):
        g, _u, dg, _radius = pose_at(path, theta)
        if outer < inner:
            guess, low, high = newton_in_bracket(theta, g, dg, low, high, True)
        else:
            guess, high, low = newton_in_bracket(theta, g, dg, high, low, False)
        step, theta = abs(guess - theta), guess
        if step <= 1e-15:
            break
    return theta


@inner_jit
def wall_scene(walls, side, theta, sense, w, flow):
    """The scene of a wall at a driver angle, with signs such that all losses resist the motion.

    With trains that lose power it is that of the `flow`, or of the one that holds at the squared
    speed `w` where that is `UNKNOWN`.

    The load resists the follower, which turns back where g < 0. While the driver turns back,
    `sense` is -1 and every loss has the other sign, so that the same law holds. For the same reason
    a train has the efficiency 1/eta where the body next to it turns back.
    """
    scene = wall_of(walls, side)
    follower_sense, free = 1.0, scene.load == 0.0 and scene.load_train_efficiency == 1.0
    # exactly where g = 0, `sense` decides on which side of it the motion continues
    if not free and pose_at(scene.path, theta + 1e-12 * sense)[0] < 0.0:
        follower_sense = -1.0
    if sense > 0.0 and follower_sense > 0.0:
        return _flowing(scene, side, theta, w, flow)
    barrel, train = scene.barrel_efficiency, scene.load_train_efficiency
    reversed_ = altered(
        scene,
        "mu_plus", sense * scene.mu_plus,
        "mu_minus", sense * scene.mu_minus,
        "load", sense * follower_sense * scene.load,
        "bearing", sense * scene.bearing,
        "driver_drag", sense * scene.driver_drag,
        "follower_drag", sense * scene.follower_drag,
        "driver_viscous", sense * scene.driver_viscous,
        "follower_viscous", sense * scene.follower_viscous, "motor", sense * scene.motor,
        "driver_journal", sense * scene.driver_journal,
        "follower_journal", sense * scene.follower_journal,
        "barrel_efficiency", barrel if sense > 0.0 else 1.0 / barrel,
        "load_train_efficiency", train if sense * follower_sense > 0.0 else 1.0 / train,
    )  # fmt: skip
    return _flowing(reversed_, side, theta, w, flow)


@inner_jit
def _flowing(scene, side, theta, w, flow):
    """The scene of a flow, or of the one that holds; the scene itself if nothing is lost."""
    if flow == UNKNOWN:
        return flowing(theta, side, w, scene)
    return in_flow(scene, flow)


@inner_jit
def next_break(walls, side, theta, sense, scene):
    """The next driver angle in the given sense at which contact with a wall is not smooth."""
    end = scene.edges[-1] if sense > 0.0 else scene.edges[0]
    for angle in breaks_of(walls, side):
        # both comparisons are false for NaN
        if sense * (angle - theta) > 1e-9 and sense * (end - angle) > 1e-9:
            end = angle
    end = next_knot(theta, end, scene) if sense > 0.0 else last_knot(theta, end, scene)
    return _next_load_knot(theta, end, scene) if has_load_curve(scene) else end


@inner_jit
def _next_load_knot(theta, end, scene):
    """The next driver angle before an end at which the load is not smooth, or the end.

    The follower does not reverse in between.
    """
    here, there = angle_in_slot(scene.path, theta), angle_in_slot(scene.path, end)
    sense, rises = np.sign(there - here), (there - here) * (end - theta) > 0.0
    knot = load_knot(here, sense, scene.driver_angle, scene)
    if not sense * (there - knot) > KNOT_GAP:
        return end
    low, high, x = min(theta, end), max(theta, end), 0.5 * (theta + end)
    for _ in range(80):
        value, slope = angle_in_slot(scene.path, x) - knot, pose_at(scene.path, x)[0]
        guess, low, high = newton_in_bracket(x, value, slope, low, high, rises)
        step, x = abs(guess - x), guess
        if step <= 1e-15:
            break
    return x
