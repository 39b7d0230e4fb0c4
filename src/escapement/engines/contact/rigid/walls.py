"""The two walls of a slot: a slotted path for each, and the angles at which it is not smooth."""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.torque import last_knot, next_knot
from escapement.dynamics.train_losses import UNKNOWN, flowing, in_flow
from escapement.mechanisms.path import Path
from escapement.mechanisms.slotted import pose_at, slide_change
from escapement.model.scene import Scene
from escapement.numerics.jit import inner_jit
from escapement.numerics.roots import newton_in_bracket


class Case(NamedTuple):
    """The numbers of an escapement that the kernels of this engine need.

    plus, minus : scenes of contact with either wall, whose paths have the offset of the wall.
    breaks : driver angles at which the law of each wall is not smooth, shape (2, k).
    centre, crank : centre distance in crank radii, and +1 for an internal wheel, else -1: the
        pin is at (centre + crank cos(theta), sin(theta)).
    play, restitution : of the joint.
    rtol : relative error asked for.
    """

    plus: Scene
    minus: Scene
    breaks: np.ndarray
    centre: float
    crank: float
    play: float
    restitution: float
    rtol: float


@inner_jit(allocates=True)
def case_of(scene, joint, rtol):
    """A case; `joint` holds the centre distance, the crank, the play and the restitution."""
    centre, crank, play, restitution = joint
    one, two = scene.path.numbers.copy(), scene.path.numbers.copy()
    one[10], two[10] = play, -play
    plus = Scene(Path(scene.path.table, one), *scene[1:])
    minus = Scene(Path(scene.path.table, two), *scene[1:])
    breaks = np.empty((2, 3))
    # where the follower changes its sense, its losses change their sign
    turns = scene.load + scene.follower_drag + scene.follower_journal > 0.0
    turns = turns or scene.load_train_efficiency != 1.0
    for row, side, own in ((0, 1.0, plus), (1, -1.0, minus)):
        entry, exit_ = scene.edges[0], scene.edges[-1]
        breaks[row, 0] = slide_change(own.path, own.pin, side, entry, exit_)
        breaks[row, 1] = _standstill(own.path, entry, 0.0) if turns else np.nan
        breaks[row, 2] = _standstill(own.path, exit_, 0.0) if turns else np.nan
    return Case(plus, minus, breaks, centre, crank, play, restitution, rtol)


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
def wall_scene(case, side, theta, way, w, flow):
    """The scene of a wall at a driver angle, with signs such that all losses resist the motion.

    With trains that lose power it is that of the `flow`, or of the one that holds at the squared
    speed `w` where that is `UNKNOWN`.

    The load resists the follower, which turns back where g < 0. While the driver turns back, `way`
    is -1 and every loss has the other sign, so that the same law holds. For the same reason a train
    has the efficiency 1/eta where the body next to it turns back.
    """
    scene = case.plus if side > 0.0 else case.minus
    # exactly where g = 0, `way` decides on which side of it the motion continues
    sense, free = 1.0, scene.load == 0.0 and scene.load_train_efficiency == 1.0
    if not free and pose_at(scene.path, theta + 1e-12 * way)[0] < 0.0:
        sense = -1.0
    if way > 0.0 and sense > 0.0:
        return _flowing(scene, side, theta, w, flow)
    barrel, train = scene.barrel_efficiency, scene.load_train_efficiency
    turned = Scene(
        scene.path, scene.edges, scene.dwell, scene.torque, scene.turned, scene.rho,
        way * scene.mu_plus, way * scene.mu_minus, way * sense * scene.load, way * scene.bearing,
        way * scene.driver_drag, way * scene.follower_drag, way * scene.driver_viscous,
        way * scene.follower_viscous, scene.pin, way * scene.driver_journal,
        way * scene.follower_journal, scene.gain, scene.flow,
        scene.barrel, barrel if way > 0.0 else 1.0 / barrel,
        scene.load_train, train if way * sense > 0.0 else 1.0 / train,
    )  # fmt: skip
    return _flowing(turned, side, theta, w, flow)


@inner_jit
def _flowing(scene, side, theta, w, flow):
    """The scene of a flow, or of the one that holds; the scene itself if nothing is lost."""
    if flow == UNKNOWN:
        return flowing(theta, side, w, scene)
    return in_flow(scene, flow)


@inner_jit
def next_break(case, side, theta, way, scene):
    """The next driver angle in the sense `way` at which contact with a wall is not smooth."""
    end = scene.edges[-1] if way > 0.0 else scene.edges[0]
    row = 0 if side > 0.0 else 1
    for i in range(3):
        place = case.breaks[row, i]
        # both comparisons are false for a place that is NaN
        if way * (place - theta) > 1e-9 and way * (end - place) > 1e-9:
            end = place
    return next_knot(theta, end, scene) if way > 0.0 else last_knot(theta, end, scene)
