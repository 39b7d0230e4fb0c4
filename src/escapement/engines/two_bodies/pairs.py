"""The pairs of features of two bodies that can touch: a nose of one and a track of the other.

A nose is a convex arc, such as a pin, a tip or a corner. A track is a line or an arc. Where both
are convex arcs the one with the smaller radius is the nose. A line and a line, or a hollow arc and
a line, meet at a corner, so these are the only pairs.
"""

import math
from itertools import product

import numpy as np

from escapement.mechanisms.features import CONVEX, HOLLOW, LINE, Features
from escapement.numerics.records import record_dtype

PAIR = record_dtype({
    # the nose: its body, its feature, its centre and its sector
    **dict.fromkeys(("nose", "nose_feature", "nose_images"), np.int64),
    **dict.fromkeys(("nose_x", "nose_y", "rho", "nose_direction", "nose_half"), float),
    **dict.fromkeys(("nose_pitch", "nose_polar"), float),
    # the track: its feature, its kind and its place; the middle is what a nose looks for
    **dict.fromkeys(("track_feature", "track_images", "kind"), np.int64),
    **dict.fromkeys(("x", "y", "cosine", "sine", "extent", "radius"), float),
    **dict.fromkeys(("track_pitch", "track_polar", "middle_x", "middle_y"), float),
    # of so many images around the partner, from the first on, this is the one with the number
    **dict.fromkeys(("nose_first", "nose_count", "nose_number"), np.int64),
    **dict.fromkeys(("track_first", "track_count", "track_number"), np.int64),
    "rest": float,  # share of a step after which these images are found anew
})  # fmt: skip
"""A pair, once for each image of a body that repeats."""
MOVED = 0.25
"""Share of a pitch by which a body may turn until its images are found anew."""
TURN = 0.12
"""Greatest angle of a step [rad]."""
_SAME = 1e-9


def pairs_of(driver: Features, follower: Features) -> np.ndarray:
    """All pairs of two bodies, as an array of `PAIR`."""
    rows, bodies = [], (driver, follower)
    for nose, (one, two) in enumerate((bodies, bodies[::-1])):
        for i, k in product(range(one.kind.size), range(two.kind.size)):
            if one.kind[i] != CONVEX or not _meets(one, i, two, k, nose):
                continue
            around = (_around(one, i, two, k), _around(two, k, one, i))
            numbers = product(*(range(count) for _first, count in around))
            rows += [(nose, i, k, around, each) for each in numbers]
    table = np.zeros(len(rows), PAIR)
    for row, (nose, i, k, around, each) in zip(table, rows, strict=True):
        _fill(row, nose, bodies[nose], i, bodies[1 - nose], k)
        for body, (first, count), number in zip(("nose", "track"), around, each, strict=True):
            row[f"{body}_first"], row[f"{body}_count"], row[f"{body}_number"] = first, count, number
    return table


def _meets(one: Features, i: int, two: Features, k: int, nose: int) -> bool:
    """Whether a convex arc can be the nose on a feature of the other body."""
    rho, radius = one.radius[i], two.radius[k]
    if two.kind[k] == CONVEX:
        return bool(rho < radius or (rho == radius and nose == 0))
    return bool(two.kind[k] == LINE or rho < radius)


def _around(one: Features, i: int, two: Features, k: int) -> tuple[int, int]:
    """How many images of a feature of `one` are near a feature of the other body, and which of
    them is the first, counted from the nearest one behind its middle.
    """
    if one.fold == 1:
        return 0, 1
    ends, other = ends_of(one, i), ends_of(two, k)
    spread = float(np.ptp(np.angle(ends / ends[2])))
    wide = 0.5 * spread + 0.5 * float(abs(other[1] - other[0]) / max(abs(ends[2]), 1e-9))
    count = 2 * math.ceil(wide * one.fold / (2.0 * math.pi) + MOVED + 0.05)
    return (1 - count // 2, count) if count < one.fold else (0, one.fold)


def ends_of(body: Features, i: int) -> np.ndarray:
    """Both ends of a feature and its middle, as complex numbers."""
    centre, turn = complex(body.x[i], body.y[i]), np.array([-1.0, 1.0, 0.0]) * body.extent[i]
    if body.kind[i] == LINE:
        return np.asarray(centre + 0.5 * (turn + body.extent[i]) * np.exp(1j * body.direction[i]))
    return np.asarray(centre + body.radius[i] * np.exp(1j * (body.direction[i] + turn)))


def _fill(row: np.void, nose: int, one: Features, i: int, two: Features, k: int) -> None:
    middle = ends_of(two, k)[2]
    row["nose"], row["nose_feature"], row["nose_images"] = nose, i, one.fold
    row["nose_x"], row["nose_y"], row["rho"] = one.x[i], one.y[i], one.radius[i]
    row["nose_direction"], row["nose_half"] = one.direction[i], one.extent[i]
    row["nose_pitch"] = 2.0 * math.pi / one.fold
    row["nose_polar"] = math.atan2(one.y[i], one.x[i])
    row["track_feature"], row["track_images"], row["kind"] = k, two.fold, two.kind[k]
    row["x"], row["y"], row["extent"], row["radius"] = (
        two.x[k],
        two.y[k],
        two.extent[k],
        two.radius[k],
    )
    row["cosine"], row["sine"] = math.cos(two.direction[k]), math.sin(two.direction[k])
    row["track_pitch"] = 2.0 * math.pi / two.fold
    few = [body.fold for body in (one, two) if body.fold > 1]
    row["rest"] = min(1.0, MOVED * 2.0 * math.pi / max(few, default=1) / TURN)
    row["track_polar"], row["middle_x"], row["middle_y"] = (
        np.angle(middle),
        middle.real,
        middle.imag,
    )


def joints_of(body: Features) -> np.ndarray:
    """Which features of a body meet: shape (n, n, 3), that of the same sector and its neighbours.

    ``joints[i, k, 1 + d]`` tells whether feature i meets feature k of the sector that is d ahead.
    A feature meets itself.
    """
    count = body.kind.size
    ends = np.array([ends_of(body, i)[:2] for i in range(count)])
    size = np.abs(ends).max()
    joints = np.zeros((count, count, 3), np.int64)
    for d in (-1, 0, 1):
        turned = ends * np.exp(2j * math.pi * d / body.fold)
        apart = np.abs(ends[:, None, :, None] - turned[None, :, None, :]).min(axis=(2, 3))
        joints[:, :, 1 + d] = apart <= _SAME * size
    joints[:, :, 1] |= np.eye(count, dtype=np.int64)
    return joints


__all__ = ["CONVEX", "HOLLOW", "LINE", "PAIR", "TURN", "ends_of", "joints_of", "pairs_of"]
