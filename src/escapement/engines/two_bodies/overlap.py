"""Whether bodies overlap: a nose that lies within the other body."""

import cmath

import numpy as np

from escapement.engines.two_bodies.touch import ALLOWED, images, normal, place, touch_at
from escapement.mechanisms.features import LINE
from escapement.numerics.jit import inner_jit


@inner_jit
def enclosed(law, pairs, i, nose, track, y):
    """Whether the foremost point of a nose, which is behind a track, lies within its body.

    It does if no other track of that body is nearer.
    """
    one = pairs[i]
    at = place(one, law.centre, y, nose, track)
    touch = touch_at(one, at)
    if touch.on_nose < 0.0 or touch.on_track < 0.0 or touch.gap > -ALLOWED:
        return False
    point = -one.rho * normal(one, at)
    for k in range(len(pairs)):
        two = pairs[k]
        if two.nose != one.nose or two.nose_feature != one.nose_feature:
            continue
        other, behind = images(two, law.centre, y)
        if k == i or (other - nose) % one.nose_fold != 0:
            continue
        turned = cmath.rect(1.0, (track - behind) * 2.0 * np.pi / one.track_fold)
        centre = place(two, law.centre, y, other, behind).at
        if _apart(two, centre + point * turned - two.at) < -touch.gap:
            return False
    return True


@inner_jit
def _apart(pair, x):
    """Distance of a point from a track, which is at x from the place of the track."""
    foot = x * pair.along.conjugate()
    if pair.kind == LINE:
        return abs(foot - min(max(foot.real, 0.0), pair.extent))
    angle = cmath.phase(foot)
    return abs(foot - cmath.rect(pair.radius, min(max(angle, -pair.extent), pair.extent)))
