"""How long no pair of features can close.

A nose is at the distance D from the points of a track. Neither D nor its rate can change faster
than the speeds and accelerations of the bodies allow, so that no contact can begin before a time
that follows from them. Pairs are looked at again only when their times have come, and these times
become exact as D goes to zero. No contact is missed, however short it is.
"""

from collections import namedtuple

import numpy as np

from escapement.engines.two_bodies.pairs import TURN
from escapement.engines.two_bodies.touch import ALLOWED, dot, images, nearness, place, touch_at
from escapement.numerics.jit import inner_jit
from escapement.numerics.records import record_dtype

WATCH = record_dtype({"until": float, "nose": np.int64, "track": np.int64})
"""A pair: no contact begins until that time; the images that it means."""
CLOSED = 1e-13
"""A gap below this is closed."""
EDGE, STILL = 1e-7, 1e-12
"""A foot may be outside of a feature by this length or angle. A gap that changes at less than that
speed stays as it is."""
NEAR = 0.03
"""Share of the longest step after which a gap that stays zero is looked at again."""


Bounds = namedtuple("Bounds", "cap driver follower share changes")
"""The accelerations of driver and follower, the time for which they are known, how many times
greater they may become then, and whether they change."""


@inner_jit
def bounds_of(law, y, push, mode):
    """The bounds for a state with these accelerations."""
    changes = 0.0 if mode.pair < 0 and law.plain else 1.0
    rate = (1.0 + changes) * max(abs(push.driver), abs(push.follower)) + 1e-100
    cap = TURN / (max(abs(y[2]), abs(y[3])) + np.sqrt(TURN * rate))
    return Bounds(cap, push.driver, push.follower, 1.0 + changes, changes)


@inner_jit
def _free_time(pair, at, near, bounds, y):
    """Time for which a nose cannot reach the track.

    Up to a time t its distance is at least D + D' t + (D'' - J t/3) t^2/2 with the greatest jerk J
    of the nose's centre, as the track's body sees it: it turns about the axis of its own body by
    the difference of both angles, while that axis turns about the other one.
    """
    rate_a, rate_b = bounds.driver, bounds.follower
    if pair.nose == 1:
        rate_a, rate_b = rate_b, rate_a
    arm, centre = abs(at.arm), abs(at.at - at.arm)
    turning, swinging = bounds.share * abs(rate_a - rate_b), bounds.share * abs(rate_b)
    spin = abs(y[2] - y[3]) + turning * bounds.cap
    swing = abs(y[3 - pair.nose]) + swinging * bounds.cap
    if near.jumps:
        slope, jerk = -abs(at.v), 0.0
        bend = -arm * (spin * spin + turning) - centre * (swing * swing + swinging)
    else:
        slope, more = dot(near.direction, at.v), 3.0 + bounds.changes
        bend = dot(near.direction, at.a + 1j * (rate_a * at.arm - rate_b * at.at)) - near.bend
        jerk = arm * spin * (spin * spin + more * turning)
        jerk += centre * swing * (swing * swing + more * swinging)
    free, longest, distance = 0.0, bounds.cap, near.distance
    while longest > free:
        most, found = bend - jerk * longest / 3.0, longest
        root = np.sqrt(max(slope * slope - 2.0 * most * distance, 0.0))
        if most < 0.0 and slope > 0.0:
            found = (slope + root) / -most
        elif root > 0.0 or most < 0.0:
            found = 2.0 * distance / max(root - slope, 1e-100)
        free = max(free, min(found, longest))
        longest *= 0.4
    return free


@inner_jit
def joined(pairs, joints, mode, i, nose, track):
    """Whether a pair and its images lie beside the contact, or are it."""
    if mode.pair < 0:
        return False
    one, two = pairs[mode.pair], pairs[i]
    same, first = one.nose == two.nose, joints[one.nose]
    f_nose, k_nose = (two.nose_feature, nose) if same else (two.track_feature, track)
    f_track, k_track = (two.track_feature, track) if same else (two.nose_feature, nose)
    if not _meets(first, one.nose_feature, f_nose, k_nose - mode.nose, one.nose_fold):
        return False
    other, ahead = joints[1 - one.nose], k_track - mode.track
    return _meets(other, one.track_feature, f_track, ahead, one.track_fold)


@inner_jit
def _meets(joints, i, k, ahead, fold):
    ahead %= fold
    if ahead == 0:
        return joints[i, k, 1] != 0
    return (ahead == 1 and joints[i, k, 2] != 0) or (ahead == fold - 1 and joints[i, k, 0] != 0)


@inner_jit
def look(law, pairs, joints, watch, i, mode, y, push, bounds, time):
    """Look at a pair; returns whether a contact begins."""
    seen, pair = watch[i], pairs[i]
    nose, track = images(pair, law.centre, y)
    seen.nose, seen.track = nose, track
    seen.until = time + bounds.cap * pair.rest
    if joined(pairs, joints, mode, i, nose, track):
        return False
    at = place(pair, law.centre, y, nose, track)
    near = nearness(pair, at)
    if near.distance > CLOSED:
        seen.until = min(seen.until, time + _free_time(pair, at, near, bounds, y))
        return False
    touch = touch_at(pair, at)
    left = min(touch.on_track, touch.on_nose)
    rate = touch.g0 * y[2] + touch.g1 * y[3]
    bend = touch.kappa + touch.g0 * push.driver + touch.g1 * push.follower
    seen.until = time + bounds.cap * NEAR
    if rate > STILL and bend < 0.0:
        seen.until = min(seen.until, time - rate / bend)  # the top of a rebound
    # a nose that has just left the end of a feature would return to its continuation
    pressed = rate <= STILL and bend < -STILL and left > EDGE
    return abs(touch.gap) <= ALLOWED and ((rate < -STILL and left >= -EDGE) or pressed)
