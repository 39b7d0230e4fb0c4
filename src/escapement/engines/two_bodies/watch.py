"""How long no pair of features can close.

A nose is at the distance D from the points of a track. Neither D nor its rate can change faster
than the speeds and accelerations of the bodies allow, so that no contact can begin before a time
that follows from them. Pairs are looked at again only when their times have come, and these times
become exact as D goes to zero. No contact is missed, however short it is.
"""

from typing import NamedTuple

import numpy as np

from escapement.engines.two_bodies.touch import images, nearness, place, touch_at
from escapement.numerics.jit import inner_jit
from escapement.numerics.records import record_dtype

WATCH = record_dtype({
    "until": float,  # no contact begins before this time
    **dict.fromkeys(("nose", "track"), np.int64),  # images
    "near": np.int64,  # whether no such time is known, so that every step ends with a look
    "behind": np.int64,  # whether the nose is behind the track
})  # fmt: skip
CLOSED = 1e-13
"""A gap below this is closed."""
ALLOWED = 1e-9
"""A contact that begins deeper than this came from behind."""
EDGE = 1e-7
"""A foot may be outside of a feature by this length or angle."""
STILL = 1e-12
"""A gap that changes at less than this speed stays as it is."""
TURN, NEAR = 0.12, 0.004
"""Greatest angle of a step [rad], and that while a pair is near."""


class Bounds(NamedTuple):
    """Greatest speeds and accelerations over the next time, `cap`, for driver and follower."""

    cap: float
    driver: float
    follower: float
    driver_rate: float
    follower_rate: float


@inner_jit
def bounds_of(y, push, mode):
    """The bounds for a state with these accelerations, which only in flight change little."""
    share = 1.25 if mode.pair < 0 else 2.0
    a0, a1 = share * abs(push.driver), share * abs(push.follower)
    if mode.pair >= 0:
        a0, a1 = a0 + y[2] * y[2], a1 + y[3] * y[3]
    speed = max(abs(y[2]), abs(y[3]))
    cap = TURN / (speed + np.sqrt(TURN * max(a0, a1)) + 1e-100)
    return Bounds(cap, abs(y[2]) + a0 * cap, abs(y[3]) + a1 * cap, a0, a1)


@inner_jit
def _free_time(pair, at, near, bounds):
    """Time for which a nose cannot reach the track."""
    if pair.nose == 0:
        w_a, w_b, rate_a, rate_b = (
            bounds.driver,
            bounds.follower,
            bounds.driver_rate,
            bounds.follower_rate,
        )
    else:
        w_a, w_b, rate_a, rate_b = (
            bounds.follower,
            bounds.driver,
            bounds.follower_rate,
            bounds.driver_rate,
        )
    arm, x = np.sqrt(at.arm_x**2 + at.arm_y**2), np.sqrt(at.x**2 + at.y**2)
    bend = w_a * w_a * arm + 2.0 * w_b * (w_a * arm + w_b * x) + w_b * w_b * x
    bend = 1.1 * (bend + rate_a * arm + rate_b * x) + near.bend + 1e-100
    rate = -np.sqrt(at.v_x**2 + at.v_y**2) if near.jumps else near.rate
    root = np.sqrt(rate * rate + 2.0 * bend * near.distance)
    return (rate + root) / bend if rate > 0.0 else 2.0 * near.distance / (root - rate)


@inner_jit
def joined(pairs, joints, mode, i, nose, track):
    """Whether a pair and its images lie beside the contact, or are it."""
    if mode.pair < 0:
        return False
    one, two = pairs[mode.pair], pairs[i]
    same = one.nose == two.nose
    f_nose, k_nose = (two.nose_feature, nose) if same else (two.track_feature, track)
    f_track, k_track = (two.track_feature, track) if same else (two.nose_feature, nose)
    of_nose, of_track = joints if one.nose == 0 else (joints[1], joints[0])
    return _meets(
        of_nose, one.nose_feature, f_nose, k_nose - mode.nose, one.nose_images
    ) and _meets(of_track, one.track_feature, f_track, k_track - mode.track, one.track_images)


@inner_jit
def _meets(joints, i, k, ahead, count):
    ahead %= count
    if ahead == 0:
        return joints[i, k, 1] != 0
    return (ahead == 1 and joints[i, k, 2] != 0) or (ahead == count - 1 and joints[i, k, 0] != 0)


@inner_jit
def look(law, pairs, joints, watch, i, mode, y, push, bounds, time):
    """Look at a pair; returns whether a contact begins."""
    seen, pair = watch[i], pairs[i]
    nose, track = images(pair, law.centre, y[0], y[1])
    seen.nose, seen.track, seen.near = nose, track, 0
    if joined(pairs, joints, mode, i, nose, track):
        seen.until = time + bounds.cap
        return False
    at = place(pair, law.centre, y, nose, track)
    near = nearness(pair, at)
    if near.distance > CLOSED:
        seen.until, seen.behind = time + min(_free_time(pair, at, near, bounds), bounds.cap), 0
        return False
    touch = touch_at(pair, at)
    left = min(touch.on_track, touch.on_nose)
    rate = touch.g0 * y[2] + touch.g1 * y[3]
    bend = touch.kappa + touch.g0 * push.driver + touch.g1 * push.follower
    # a nose that has just left the end of a feature would return to its continuation
    pressed = rate <= STILL and bend < -STILL and left > EDGE
    begins = abs(touch.gap) <= ALLOWED and ((rate < -STILL and left >= -EDGE) or pressed)
    seen.near, seen.until = 1, time + bounds.cap * NEAR / TURN
    seen.behind = 1 if left >= -EDGE and touch.gap < -10.0 * CLOSED else 0
    return begins


@inner_jit
def passes(law, pairs, watch, i, y):
    """Whether a near pair is behind a track in front of which it was."""
    seen, pair = watch[i], pairs[i]
    touch = touch_at(pair, place(pair, law.centre, y, seen.nose, seen.track))
    inside = touch.on_track >= 0.0 and touch.on_nose >= 0.0
    return inside and touch.gap < -10.0 * CLOSED and seen.behind == 0
