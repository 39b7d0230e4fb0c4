"""Impacts of a pin in a slot with clearance, in a drive at constant speed, compiled.

The driver is not slowed by one, so all of it is explicit. In units of the crank radius, and of
time in which the driver's speed is one, the wall s stands at

    phi_s(theta) = Phi(theta) - s asin(q),    q = c/R

with half the clearance c and the distance R of the pin from the follower's axis. With a = asin(q)
and u = R'/R its derivatives follow from q' = -q u:

    a' = -y u,    y = q/sqrt(1 - q^2),    a'' = y (u^2/(1 - q^2) - u')

At the entry the follower stands with its slot centred. Between the walls it obeys

    phi'' = -(curve(phi) + load sign(phi'))

with the load that changes with its angle, until it meets a wall. A follower that stops is held
where the curve is not above the constant load. It leaves the wall where the moment that phi_s''
needs has changed its sign, and flies to where it meets a wall again. Nystrom's method of the fourth
order integrates the flight; it is exact without a curve.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.law import scene_of
from escapement.dynamics.load import has_load_curve, load_over
from escapement.dynamics.torque import cell_of
from escapement.mechanisms.path import HALF_RATE, RATE_SUM
from escapement.mechanisms.slotted import angle_in_slot, pose_at
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.roots import newton_in_bracket

_STEPS = 64  # between two angles, in which a first zero is looked for
_FINER = 8  # times as many of them on a wall under a load that changes
_STRIDES = 16  # of a step, over which the motion under such a load is integrated
_OPENING = 8  # steps in which the gap to the wall that was left is not yet looked at
_HALVINGS = 50  # of a step, until a zero is known to rounding
_FOUND = 1e-15  # rad, how exactly a zero is known
FRONT, REAR, NOWHERE = 1.0, -1.0, 0.0
"""Which wall the follower meets after its flight."""


class Knock(NamedTuple):
    """Impacts of an engagement; NaN for what does not happen. Angles from dead centre [rad].

    entry_angle, entry_speed : driver angle at which the pin meets a wall, mostly the front one, and
        the relative speed, times the driver's.
    entry_distance : distance of the pin from the follower's axis there, in crank radii.
    lift_off : driver angle at which the pin leaves this wall.
    wall : `FRONT` or `REAR`, the wall that the follower meets next; `NOWHERE` until the exit.
    reversal_angle, reversal_speed, reversal_distance : driver angle, relative speed and distance
        of that impact.
    """

    entry_angle: float
    entry_speed: float
    entry_distance: float
    lift_off: float
    wall: float
    reversal_angle: float
    reversal_speed: float
    reversal_distance: float


_NAN = float("nan")
NO_KNOCK = Knock(_NAN, _NAN, _NAN, _NAN, NOWHERE, _NAN, _NAN, _NAN)
"""Of a drive whose pins fit their slots."""


@inner_jit
def _lead(path, c, theta):
    """a = asin(c/R), a' and a'' at a driver angle, and g, g' and R there."""
    numbers = path.numbers
    g, u, dg, radius = pose_at(path, theta)
    q = min(c / radius, 1.0)
    cosine = np.sqrt(1.0 - q * q)
    y = q / cosine
    product = 0.25 * numbers[RATE_SUM] ** 2 - numbers[HALF_RATE] ** 2
    du = product - numbers[RATE_SUM] * g + g * g - u * u
    bend = y * (u * u / (cosine * cosine) - du)
    return np.arcsin(q), -y * u, bend, g, dg, radius


@inner_jit
def _landed(first, speed, radius, start, wall, reversal=(np.nan, np.nan, np.nan)):
    """The impacts, of which the last ones may not happen."""
    at, met, radius_at = reversal
    return Knock(
        entry_angle=first, entry_speed=speed, entry_distance=radius, lift_off=start, wall=wall,
        reversal_angle=at, reversal_speed=met, reversal_distance=radius_at,
    )  # fmt: skip


@inner_jit
def _curve(phi, begin, scene):
    """The load that changes, at a follower angle of the cell that begins at a driver angle."""
    return load_over(phi, 0.0, begin, scene)[0] if has_load_curve(scene) else 0.0


@inner_jit
def _stride(phi, speed, time, sense, begin, scene):
    """Angle and speed after a time in which the follower does not stop."""
    held = sense * scene.load
    first = -_curve(phi, begin, scene) - held
    middle = phi + 0.5 * time * (speed + 0.25 * time * first)
    second = -_curve(middle, begin, scene) - held
    last = -_curve(phi + time * (speed + 0.5 * time * second), begin, scene) - held
    angle = phi + time * (speed + time * (first + 2.0 * second) / 6.0)
    return angle, speed + time * (first + 4.0 * second + last) / 6.0


@inner_jit
def _started(phi, begin, scene):
    """Sense in which the curve moves a follower at rest; 0 where the constant load holds it."""
    pushed = -_curve(phi, begin, scene)
    return np.sign(pushed) if abs(pushed) > scene.load else 0.0


@inner_jit
def _moved(phi, speed, time, begin, scene):
    """Angle and speed of the free follower after a time."""
    strides = _STRIDES if has_load_curve(scene) else 1
    part = time / strides
    for _ in range(strides):
        sense = np.sign(speed) if speed != 0.0 else _started(phi, begin, scene)
        if sense == 0.0:
            return phi, 0.0
        angle, after = _stride(phi, speed, part, sense, begin, scene)
        if scene.load > 0.0 and sense * after < 0.0:
            low, high = 0.0, part
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                if sense * _stride(phi, speed, middle, sense, begin, scene)[1] < 0.0:
                    high = middle
                else:
                    low = middle
            phi = _stride(phi, speed, low, sense, begin, scene)[0]
            sense = _started(phi, begin, scene)
            angle, after = phi, 0.0
            if sense != 0.0:
                angle, after = _stride(phi, 0.0, part - low, sense, begin, scene)
        phi, speed = angle, after
    return phi, speed


@inner_jit
def _flight(start, phi, speed, left, c, begin, scene):
    """The wall that a free follower meets first, where, and its speed there.

    left : the wall that it has left, `NOWHERE` at the entry.
    """
    path, exit_ = scene.path, scene.edges[-1]
    for i in range(_STEPS):
        # the way is short if the clearance is small, so the steps grow from its beginning
        low = start + (exit_ - start) * (i / _STEPS) ** 3
        high = start + (exit_ - start) * ((i + 1) / _STEPS) ** 3
        angle, after = _moved(phi, speed, high - low, begin, scene)
        ahead, lead = angle - angle_in_slot(path, high), _lead(path, c, high)[0]
        for wall in (REAR, FRONT):
            gap = wall * ahead + lead
            if gap > 0.0 or (wall == left and i < _OPENING):
                continue
            origin, theta = low, high
            for _ in range(_HALVINGS):
                angle, after = _moved(phi, speed, theta - origin, begin, scene)
                lead, slope, _bend, g, _dg, _radius = _lead(path, c, theta)
                gap = wall * (angle - angle_in_slot(path, theta)) + lead
                closing = wall * (after - g) + slope
                guess, low, high = newton_in_bracket(theta, gap, closing, low, high, False)
                step = abs(guess - theta)
                theta = guess
                if step <= _FOUND:
                    break
            return wall, theta, after
        phi, speed = angle, after
    return NOWHERE, np.nan, np.nan


@inner_jit
def _pressed(theta, wall, c, begin, scene):
    """Moment by which a wall carries the follower that moves with it; below zero it does not."""
    lead, slope, bend, g, dg, _radius = _lead(scene.path, c, theta)
    held = scene.load * np.sign(g - wall * slope)
    if has_load_curve(scene):
        held += _curve(angle_in_slot(scene.path, theta) - wall * lead, begin, scene)
    return wall * (dg - wall * bend + held)


@inner_jit
def _leaves(start, wall, c, begin, scene):
    """Driver angle at which the follower leaves a wall; NaN if it does not before the exit."""
    steps = _FINER * _STEPS if has_load_curve(scene) else _STEPS
    step = (scene.edges[-1] - start) / steps
    for i in range(steps + 1):
        if _pressed(start + i * step, wall, c, begin, scene) < 0.0:
            low, high = start + max(i - 1, 0) * step, start + i * step
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                if _pressed(middle, wall, c, begin, scene) < 0.0:
                    high = middle
                else:
                    low = middle
            return high
    return np.nan


@inner_jit
def _of_index(c, begin, scene):
    """The impacts of the index that begins at a driver angle, without those that do not happen."""
    path, entry = scene.path, scene.edges[0]
    wall, first, speed = _flight(entry, angle_in_slot(path, entry), 0.0, NOWHERE, c, begin, scene)
    if wall == NOWHERE:
        return _landed(np.nan, np.nan, np.nan, np.nan, NOWHERE)
    _a, slope, _bend, g, _dg, radius = _lead(path, c, first)
    met, start = abs(speed - (g - wall * slope)), _leaves(first, wall, c, begin, scene)
    if np.isnan(start):
        return _landed(first, met, radius, start, NOWHERE)
    lead, slope, _bend, g, _dg, _radius = _lead(path, c, start)
    phi = angle_in_slot(path, start) - wall * lead
    other, at, speed = _flight(start, phi, g - wall * slope, wall, c, begin, scene)
    if other == NOWHERE:
        return _landed(first, met, radius, start, NOWHERE)
    _a, slope, _bend, g, _dg, there = _lead(path, c, at)
    last = abs(speed - (g - other * slope))
    return _landed(first, met, radius, start, other, reversal=(at, last, there))


@jit(allocates=True)
def knock(packed, c, count):
    """The hardest impacts of the indexes after which a load over the follower angle repeats.

    Parameters
    ----------
    packed : of a scene, in units of I_f, I_f W^2 and 1/W, as `model.scene.packed` makes it.
    c : half the clearance, in crank radii; > 0.
    count : number of indexes, 1 without such a load.

    Returns
    -------
    Knock
        The entry is that of the index with the hardest one, and so are the reversal and what is
        before it. Angles count from the first dead centre.
    """
    return hardest_knock(scene_of(packed), c, count)


@inner_jit
def hardest_knock(scene, c, count):
    """As `knock`, of a scene."""
    entry = back = _of_index(c, 0.0, scene)
    of_entry = of_back = 0.0
    for k in range(1, count):
        begin = k * cell_of(scene)
        found = _of_index(c, begin, scene)
        if found.entry_speed > entry.entry_speed or np.isnan(entry.entry_speed):
            entry, of_entry = found, begin
        if found.reversal_speed > back.reversal_speed or np.isnan(back.reversal_speed):
            back, of_back = found, begin
    return _landed(
        entry.entry_angle + of_entry, entry.entry_speed, entry.entry_distance,
        back.lift_off + of_back, back.wall,
        reversal=(back.reversal_angle + of_back, back.reversal_speed, back.reversal_distance),
    )  # fmt: skip
