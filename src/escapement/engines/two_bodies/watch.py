"""How long no pair of features can close.

A nose is at the distance D from the points of a track. Neither D nor its rate can change faster
than the speeds and accelerations of the bodies allow, so that no contact can begin before a time
that follows from them. Pairs are looked at again only when their times have come, and these times
become exact as D goes to zero. No contact is missed, however short it is.
"""

from typing import NamedTuple

import numpy as np

from escapement.engines.two_bodies.pairs import TURN
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
NEAR = 0.03
"""Share of the longest step while a pair is near."""


class Bounds(NamedTuple):
    """The accelerations of driver and follower, the time for which they are known, and how much
    greater they may become then; `changes` tells whether they change.
    """

    cap: float
    driver: float
    follower: float
    share: float
    changes: float


@inner_jit
def bounds_of(law, y, push, mode):
    """The bounds for a state with these accelerations."""
    changes = 0.0 if mode.pair < 0 and law.plain else 1.0
    share = 1.0 + changes
    rate = share * max(abs(push.driver), abs(push.follower)) + 1e-100
    cap = TURN / (max(abs(y[2]), abs(y[3])) + np.sqrt(TURN * rate))
    return Bounds(cap, push.driver, push.follower, share, changes)


@inner_jit
def _free_time(pair, at, near, bounds):
    """Time for which a nose cannot reach the track.

    Up to a time t its distance is at least D + D' t + (D'' - J t/3) t^2/2 with the greatest jerk J
    of the nose's centre, as the track's body sees it: it turns about the axis of its own body by
    the difference of both angles, while that axis turns about the other one.
    """
    first, cap = pair.nose == 0, bounds.cap
    rate_a = bounds.driver if first else bounds.follower
    rate_b = bounds.follower if first else bounds.driver
    wa, wb = at.nose_speed, at.track_speed
    arm = np.sqrt(at.arm_x * at.arm_x + at.arm_y * at.arm_y)
    centre = np.sqrt((at.x - at.arm_x) ** 2 + (at.y - at.arm_y) ** 2)
    turning, swinging = bounds.share * abs(rate_a - rate_b), bounds.share * abs(rate_b)
    spin, swing = abs(wa - wb) + turning * cap, abs(wb) + swinging * cap
    if near.jumps:
        slope, jerk = -np.sqrt(at.v_x**2 + at.v_y**2), 0.0
        bend = -arm * (spin * spin + turning) - centre * (swing * swing + swinging)
    else:
        a_x = rate_b * at.y - rate_a * at.arm_y - wa * wa * at.arm_x
        a_x += 2.0 * wb * at.v_y + wb * wb * at.x
        a_y = rate_a * at.arm_x - rate_b * at.x - wa * wa * at.arm_y
        a_y += wb * wb * at.y - 2.0 * wb * at.v_x
        slope = near.x * at.v_x + near.y * at.v_y
        bend = near.x * a_x + near.y * a_y - near.bend
        more = 3.0 + bounds.changes
        jerk = arm * spin * (spin * spin + more * turning)
        jerk += centre * swing * (swing * swing + more * swinging)
    free, longest = 0.0, cap
    for _ in range(4):
        most = bend - jerk * longest / 3.0
        root = slope * slope - 2.0 * most * near.distance
        found = longest
        if root >= 0.0:
            root = np.sqrt(root)
            if slope - root < 0.0:
                found = min(2.0 * near.distance / (root - slope), longest)
        free = max(free, found)
        if found == longest:
            break
        longest = min(longest, 2.0 * found)
    return free


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
    ahead, beside = k_nose - mode.nose, k_track - mode.track
    meets = _meets(of_nose, one.nose_feature, f_nose, ahead, one.nose_images)
    return meets and _meets(of_track, one.track_feature, f_track, beside, one.track_images)


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
        seen.until = time + bounds.cap * pair.rest
        return False
    at = place(pair, law.centre, y, nose, track)
    near = nearness(pair, at)
    if near.distance > CLOSED:
        free = _free_time(pair, at, near, bounds)
        seen.until, seen.behind = time + min(free, bounds.cap * pair.rest), 0
        return False
    touch = touch_at(pair, at)
    left = min(touch.on_track, touch.on_nose)
    rate = touch.g0 * y[2] + touch.g1 * y[3]
    bend = touch.kappa + touch.g0 * push.driver + touch.g1 * push.follower
    # a nose that has just left the end of a feature would return to its continuation
    pressed = rate <= STILL and bend < -STILL and left > EDGE
    begins = abs(touch.gap) <= ALLOWED and ((rate < -STILL and left >= -EDGE) or pressed)
    seen.near, seen.until = 1, time + bounds.cap * NEAR
    seen.behind = 1 if left >= -EDGE and touch.gap < -10.0 * CLOSED else 0
    return begins


@inner_jit
def passes(law, pairs, watch, i, y):
    """Whether a near pair is behind a track in front of which it was."""
    seen, pair = watch[i], pairs[i]
    touch = touch_at(pair, place(pair, law.centre, y, seen.nose, seen.track))
    inside = touch.on_track >= 0.0 and touch.on_nose >= 0.0
    return inside and touch.gap < -10.0 * CLOSED and seen.behind == 0
