"""The torque of the drive, linear between knots, over the driver angle turned.

A constant torque has one knot. A spring has two: the full torque at the start of the motion,
and none where it is spent. Beyond the last knot the torque stays, unless the knots repeat. In
natural units the greatest torque is 1.

`Scene.torque` holds the angle after which n knots repeat, or 0, then the angles of the knots
[rad], ascending, and then the torques.

Where the torque depends on the speed as well, these are the torques at rest. `Scene.fall` holds how
much less the drive gives at a speed: the number of speeds, the speeds over the last one, and for
each knot, or once for all angles, the coefficients of a cubic spline between any two speeds.
"""

import numpy as np

from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.known import where_known

# Where nothing drives it a driver of this squared speed, in units of torque/I_f, is at rest.
REST = 1e-6
# Knots of the torque, and breaks or events as close to one [rad], are at one angle.
KNOT_GAP = 1e-9
# Without knots breaks and events so close together [rad] are.
SAME_ANGLE = 1e-12


@inner_jit
def knots_of(scene):
    """Number of knots."""
    return len(scene.torque) // 2


@inner_jit
def is_constant(scene):
    """Whether the torque is the same at all angles."""
    return len(scene.torque) == 3


@inner_jit
def same_angle_gap(scene):
    """Distance up to which breaks and events are at one angle [rad]."""
    return SAME_ANGLE if is_constant(scene) else KNOT_GAP


@inner_jit
def cell_of(scene):
    """Driver angle of a cell, dwell included."""
    return scene.edges[-1] - scene.edges[0] + scene.dwell


@inner_jit(inlined=True)
def cell_after(driver_angle, scene):
    """The scene in the cell after a driver angle turned."""
    return altered(scene, "driver_angle", driver_angle)


@inner_jit
def _lap(driver_angle, scene):
    """Angle at which the knots that repeat start again before an angle turned, or 0."""
    period = scene.torque[0]
    return np.floor((driver_angle - scene.torque[1]) / period) * period if period > 0.0 else 0.0


@inner_jit
def _first_behind(driver_angle, scene):
    """Index of the first knot after an angle; the number of knots if there is none."""
    low, high = 0, knots_of(scene)
    while low < high:
        middle = (low + high) // 2
        if scene.torque[1 + middle] <= driver_angle:
            low = middle + 1
        else:
            high = middle
    return low


@jit
def torque_after(driver_angle, scene):
    """Torque after an angle turned since the start, and its slope by the angle."""
    if is_constant(scene):
        return scene.gain * scene.torque[2], 0.0
    count = knots_of(scene)
    driver_angle -= _lap(driver_angle, scene)
    k = _first_behind(driver_angle, scene)
    if k == 0 or k == count:
        return scene.gain * scene.torque[1 + count + max(k - 1, 0)], 0.0
    angle, before = scene.torque[k], scene.torque[count + k]
    slope = (scene.torque[1 + count + k] - before) / (scene.torque[1 + k] - angle)
    torque = before + slope * (driver_angle - angle)
    return scene.gain * torque, scene.gain * slope


@inner_jit
def torque_at(theta, scene):
    """Torque at a driver angle of the cell after `scene.driver_angle`, and its slope by the
    angle."""
    return torque_after(scene.driver_angle + (theta - scene.edges[0]), scene)


@where_known("pace", lambda scene: False)
def depends_on_speed(scene):
    """Whether the torque depends on the speed of the driver, besides a motor's straight line."""
    return scene.pace > 0.0


@where_known("pace", lambda scene: True)
def is_alike(scene):
    """Whether the fall of the torque with the speed is the same at all angles."""
    speeds = int(scene.fall[0])
    return scene.pace == 0.0 or len(scene.fall) == 1 + speeds + 4 * (speeds - 1)


@inner_jit
def _fall_of_row(row, x, scene):
    """The fall of one row at a share x of the last speed, and its slope; a line beyond 1."""
    speeds = int(scene.fall[0])
    low, high = 1, speeds
    while high - low > 1:
        middle = (low + high) // 2
        if scene.fall[middle] <= x:
            low = middle
        else:
            high = middle
    first = 1 + speeds + 4 * (row * (speeds - 1) + low - 1)
    inside = min(x, 1.0)
    t = inside - scene.fall[low]
    a, b, c, d = (
        scene.fall[first],
        scene.fall[first + 1],
        scene.fall[first + 2],
        scene.fall[first + 3],
    )
    slope = (3.0 * a * t + 2.0 * b) * t + c
    return ((a * t + b) * t + c) * t + d + (x - inside) * slope, slope


@where_known("pace", lambda driver_angle, speed, scene: (0.0, 0.0))
def fall_after(driver_angle, speed, scene):
    """How much less torque the drive gives at a speed than at rest, and its slope by the speed."""
    if scene.pace == 0.0:
        return 0.0, 0.0
    x = speed * scene.pace
    if is_alike(scene):
        fall, slope = _fall_of_row(0, x, scene)
        return fall, slope * scene.pace
    driver_angle -= _lap(driver_angle, scene)
    k, count = _first_behind(driver_angle, scene), knots_of(scene)
    fall, slope = _fall_of_row(max(k - 1, 0), x, scene)
    if 0 < k < count:
        share = (driver_angle - scene.torque[k]) / (scene.torque[1 + k] - scene.torque[k])
        other, steeper = _fall_of_row(k, x, scene)
        fall, slope = fall + share * (other - fall), slope + share * (steeper - slope)
    return fall, slope * scene.pace


@where_known("pace", lambda theta, w, scene: 0.0)
def fall_at(theta, w, scene):
    """As `fall_after`, at a driver angle of the cell and a squared speed, without the slope."""
    return fall_after(angle_turned(theta, scene), np.sqrt(max(w, 0.0)), scene)[0]


@inner_jit
def angle_turned(theta, scene):
    """Driver angle turned since the start, at one of the cell after `scene.driver_angle`."""
    return scene.driver_angle + (theta - scene.edges[0])


@where_known("pace", lambda pull, driver_angle, w, scene: pull)
def at_speed(pull, driver_angle, w, scene):
    """The pull of the drive at a squared speed, from that at rest."""
    if scene.pace == 0.0:
        return pull
    return pull - scene.gain * fall_after(driver_angle, np.sqrt(max(w, 0.0)), scene)[0]


@inner_jit
def drive_torque(theta, w, scene):
    """Torque at a driver angle of the cell and a squared speed."""
    return at_speed(torque_at(theta, scene)[0], angle_turned(theta, scene), w, scene)


@jit
def next_knot(theta, end, scene):
    """Driver angle of the first knot after `theta` in the cell, or the end if that is nearer."""
    if is_constant(scene):
        return end
    start = scene.driver_angle - scene.edges[0]
    driver_angle = start + theta + KNOT_GAP
    lap = _lap(driver_angle, scene)
    k = _first_behind(driver_angle - lap, scene)
    if k == knots_of(scene):
        return end
    knot = lap + scene.torque[1 + k] - start
    return knot if knot < end - KNOT_GAP else end


@inner_jit
def last_knot(theta, start, scene):
    """Driver angle of the last knot before `theta`, or the start if that is nearer."""
    if is_constant(scene):
        return start
    shift = scene.driver_angle - scene.edges[0]
    driver_angle = shift + theta - KNOT_GAP
    lap = _lap(driver_angle, scene)
    k = _first_behind(driver_angle - lap, scene)
    knot = lap + scene.torque[k] - shift
    return knot if k > 0 and knot > start + KNOT_GAP else start


@inner_jit
def has_knot(scene):
    """Whether a knot lies inside the cell after `scene.driver_angle`."""
    end = scene.edges[-1] + scene.dwell
    return next_knot(scene.edges[0], end, scene) < end


@jit
def is_spent(theta, scene):
    """Whether no torque is left after a driver angle of the cell, as with a spent spring."""
    torque, slope = torque_at(theta + KNOT_GAP, scene)
    return torque <= 0.0 and slope == 0.0


@inner_jit
def _held(torque, scene):
    """Whether the bearing holds a torque of the drive."""
    # a scene of one flow of power has the loss of the barrel's train in its gain already
    passed = scene.barrel_efficiency if scene.flow < 0.0 else 1.0
    return passed * torque <= scene.bearing


@inner_jit
def is_held(theta, scene):
    """Whether the bearing holds a driver that is at rest at a driver angle of the cell."""
    return _held(torque_at(theta, scene)[0], scene)


@jit
def is_undriven(theta, scene):
    """Whether the torque after a driver angle of the cell stays at no more than the bearing holds.

    Nothing drives the mechanism there, as after the spring is spent.
    """
    torque, slope = torque_at(theta + KNOT_GAP, scene)
    return slope == 0.0 and _held(torque, scene)
