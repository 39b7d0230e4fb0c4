"""A load that changes with the follower's angle, over the driver angle of a cell.

It is a torque against the follower's forward sense, whichever way it turns. `Scene.load_curve`
tabulates it over the driver angle by the series of `mechanisms.table`, in units of the driving
torque; its knots are among the edges of the scene. A single number stands for no such load.
"""

from escapement.mechanisms.table import ratio_at
from escapement.numerics.known import where_known


@where_known("motor", lambda scene: False)
def has_load_curve(scene):
    """Whether a load changes with the follower's angle."""
    return len(scene.load_curve) > 1


@where_known("motor", lambda theta, side, scene: 0.0)
def load_at(theta, side, scene):
    """The part of the load that changes, at a driver angle; the side is 0 in a dwell."""
    if side == 0.0 or len(scene.load_curve) < 2:
        return 0.0
    return ratio_at(scene.load_curve, theta)[0]


@where_known("motor", lambda load, scene: scene.load)
def whole_load(load, scene):
    """The constant load and, if there is one, the part that changes."""
    return scene.load + load if len(scene.load_curve) > 1 else scene.load
