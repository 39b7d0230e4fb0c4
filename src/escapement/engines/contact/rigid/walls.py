"""The two walls of a slot: a slotted path for each, and where it is not smooth."""

from typing import NamedTuple

import numpy as np

from escapement.drive import last_knot, next_knot
from escapement.jit import inner_jit
from escapement.mechanisms.slotted import pose_at, slide_change
from escapement.roots import newton_in_bracket
from escapement.scene import Path, Scene


class Case(NamedTuple):
    """What the kernels of this engine are given of an escapement.

    plus, minus : scenes of contact with either wall, whose paths have the offset of the wall.
    breaks : shape (2, k): of either wall the driver angles at which its law is not smooth.
    centre, crank : centre distance in crank radii, and +1 for an internal wheel, else -1: the
        pin stands at (centre + crank cos(theta), sin(theta)).
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
    # where the follower stands still its losses change their sense
    turns = scene.load + scene.follower_drag + scene.follower_journal > 0.0
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
def wall_scene(case, side, theta, way):
    """The scene of a wall at a driver angle, with all losses turned round where they drive.

    The load opposes the follower, which goes back where g < 0. While the driver goes back, `way`
    is -1 and every loss takes the other sign, so that the same law holds.
    """
    scene = case.plus if side > 0.0 else case.minus
    load = scene.load
    # at a standstill itself the way decides on which side of it the motion goes on
    if load > 0.0 and pose_at(scene.path, theta + 1e-12 * way)[0] < 0.0:
        load = -load
    if way > 0.0 and load == scene.load:
        return scene
    return Scene(
        scene.path, scene.edges, scene.dwell, scene.torque, scene.turned, scene.rho,
        way * scene.mu_plus, way * scene.mu_minus, way * load, way * scene.bearing,
        way * scene.driver_drag, way * scene.follower_drag, way * scene.driver_viscous,
        way * scene.follower_viscous, scene.pin, way * scene.driver_journal,
        way * scene.follower_journal, *scene[17:],
    )  # fmt: skip


@inner_jit
def next_break(case, side, theta, way, scene):
    """The next driver angle in the sense `way` at which contact with a wall is not smooth."""
    end = scene.edges[-1] if way > 0.0 else scene.edges[0]
    row = 0 if side > 0.0 else 1
    for i in range(3):
        place = case.breaks[row, i]
        # NaN lies nowhere
        if way * (place - theta) > 1e-9 and way * (end - place) > 1e-9:
            end = place
    return next_knot(theta, end, scene) if way > 0.0 else last_knot(theta, end, scene)
