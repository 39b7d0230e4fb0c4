"""The pairs of features of two bodies that can touch: a nose of one and a track of the other.

A nose is a convex arc, such as a pin, a tip or a corner. A track is a line or an arc. Where both
are convex arcs the one with the smaller radius is the nose. A line and a line, or a hollow arc and
a line, meet at a corner, so these are the only pairs. Points and directions are complex numbers.
"""

import cmath
import math
from itertools import product

import numpy as np

from escapement.mechanisms.features import CONVEX, HOLLOW, LINE, Features
from escapement.numerics.records import record_dtype

PAIR = record_dtype({
    # bodies and numbers of the features; the kind of the track, and radius and size of both; the
    # length from the middle of the track to its ends; the directions of nose and middle
    **dict.fromkeys(("nose", "nose_feature", "track_feature", "kind"), np.int64),
    **dict.fromkeys(("rho", "nose_half", "extent", "radius", "reach"), float),
    **dict.fromkeys(("nose_angle", "middle_angle"), float),
    **dict.fromkeys(("nose_at", "nose_along", "at", "along", "middle"), complex),
    # of so many images around the partner, from the first on, this is the one with the number
    **dict.fromkeys(("nose_fold", "nose_first", "nose_count", "nose_number"), np.int64),
    **dict.fromkeys(("track_fold", "track_first", "track_count", "track_number"), np.int64),
})  # fmt: skip
"""A pair, once for each image of a body that repeats. The middle is that of the track."""
TURN = 0.12
"""Greatest angle of a step [rad]."""
WIDE = 1.5 * TURN
"""Angle by which a body may turn until its images are found anew [rad]."""
_SAME = 1e-9


def pairs_of(driver: Features, follower: Features) -> np.ndarray:
    """All pairs of two bodies, as an array of `PAIR`."""
    rows, bodies = [], (driver, follower)
    for nose, (one, two) in enumerate((bodies, bodies[::-1])):
        for i, k in product(range(one.kind.size), range(two.kind.size)):
            if one.kind[i] == CONVEX and _meets(one.radius[i], two.kind[k], two.radius[k], nose):
                (first, count), (start, size) = _around(one, i, two, k), _around(two, k, one, i)
                for a, b in product(range(count), range(size)):
                    images = one.fold, first, count, a, two.fold, start, size, b
                    rows.append((nose, i, k, *_numbers(one, i, two, k), *images))
    return np.array(rows, PAIR)


def _meets(rho: float, kind: int, radius: float, nose: int) -> bool:
    """Whether a convex arc of the radius rho can be the nose on a feature of the other body."""
    return kind == LINE or rho < radius or (kind == CONVEX and rho == radius and nose == 0)


def _around(one: Features, i: int, two: Features, k: int) -> tuple[int, int]:
    """Which image of a feature is the first that may be near a feature of the other body, counted
    from the nearest one behind its middle, and how many are.
    """
    if one.fold == 1:
        return 0, 1
    ends, other = ends_of(one, i), ends_of(two, k)
    wide = 0.5 * float(np.ptp(np.angle(ends / ends[2])))
    wide += 0.5 * float(abs(other[1] - other[0]) / max(abs(ends[2]), 1e-9))
    count = 2 * math.ceil((wide + WIDE) * one.fold / (2.0 * math.pi) + 0.05)
    return (1 - count // 2, count) if count < one.fold else (0, one.fold)


def _numbers(one: Features, i: int, two: Features, k: int) -> tuple[complex, ...]:
    nose = complex(one.x[i], one.y[i]), cmath.rect(1.0, one.direction[i])
    track = complex(two.x[k], two.y[k]), cmath.rect(1.0, two.direction[k]), ends_of(two, k)[2]
    reach = float(np.ptp(np.abs(ends_of(two, k) - track[2])))
    sizes = one.radius[i], one.extent[i], two.extent[k], two.radius[k], reach
    angles = cmath.phase(nose[0]), cmath.phase(track[2])
    return two.kind[k], *sizes, *angles, *nose, *track


def ends_of(body: Features, i: int) -> np.ndarray:
    """Both ends of a feature and its middle."""
    centre, turn = complex(body.x[i], body.y[i]), np.array([-1.0, 1.0, 0.0]) * body.extent[i]
    if body.kind[i] == LINE:
        return np.asarray(centre + 0.5 * (turn + body.extent[i]) * np.exp(1j * body.direction[i]))
    return np.asarray(centre + body.radius[i] * np.exp(1j * (body.direction[i] + turn)))


def joints_of(body: Features) -> np.ndarray:
    """Which features of a body meet in a joint that is tangent or sticks out, so that a nose or a
    track of the other body touches only one of them: shape (n, n, 3).

    ``joints[i, k, 1 + d]`` is that of feature i with feature k of the sector that is d ahead. A
    feature meets itself.
    """
    lines, sign = body.kind == LINE, np.where(body.kind == HOLLOW, -1.0, 1.0)
    half = np.where(lines, 0.0, sign * body.extent)
    normal = body.direction - np.where(lines, 0.5 * math.pi, 0.5 * math.pi * (1.0 - sign))
    ends = np.array([ends_of(body, i)[:2] for i in range(body.kind.size)])
    ends[body.kind == HOLLOW] = ends[body.kind == HOLLOW, ::-1]
    joints = np.zeros((body.kind.size, body.kind.size, 3), np.int64)
    for d in (-1, 0, 1):
        turn = 2.0 * math.pi * d / body.fold
        apart = np.abs(ends[:, None, 1] - ends[None, :, 0] * np.exp(1j * turn))
        bend = (normal - half)[None] + turn - (normal + half)[:, None]
        outwards = np.remainder(bend + 1e-6, 2.0 * math.pi) < math.pi
        follows = (apart <= _SAME * np.abs(ends).max()) & outwards
        joints[:, :, 1 + d] |= follows
        joints[:, :, 1 - d] |= follows.T
    joints[:, :, 1] |= np.eye(body.kind.size, dtype=np.int64)
    return joints
