"""How long no pair of features can close.

A nose is at the distance D from the points of a track. Neither D nor its rate can change faster
than the speeds and accelerations of the bodies allow, so that no contact can begin before a time
that follows from them. Pairs are looked at again only when their times have come, and these times
become exact as D goes to zero. A nose right beside a track is watched at the end of each step as
well. If one is found within the other body all the same, the motion ends there.
"""

import cmath
from collections import namedtuple

import numpy as np

from escapement.engines.two_bodies.pairs import TURN
from escapement.engines.two_bodies.step import advance
from escapement.engines.two_bodies.touch import (
    ALLOWED,
    apart,
    dot,
    images,
    nearness,
    normal,
    place,
    touch_at,
)  # fmt: skip
from escapement.numerics.jit import inner_jit
from escapement.numerics.records import record_dtype

WATCH = record_dtype({
    "until": float, **dict.fromkeys(("nose", "track", "beside", "behind"), np.int64)
})  # fmt: skip
"""A pair: no contact begins until that time, unless its nose is right beside the track; the images
that it means; and whether the nose was behind the track."""
CLOSES, OVERLAPS = 1, 2
"""What a look at a pair finds, or 0: a contact begins, or the nose has entered the other body."""
CLOSED = 1e-13
"""A gap below this is closed."""
EDGE, STILL = 1e-7, 1e-12
"""A foot may be outside of a feature by this length or angle. A gap that changes at less than that
speed stays as it is."""
NEAR = 0.01
"""Share of the longest step after which a nose right beside a track is looked at again."""
SLACK = 0.1
"""An acceleration that changes may become twice as great, and by this share of the greatest of both
bodies more, until all pairs are looked at again."""


Bounds = namedtuple("Bounds", "cap driver follower more_driver more_follower")
"""The accelerations of driver and follower, the time for which they are bounded, and by how much
they may change until then."""


@inner_jit
def bounds_of(law, y, push, mode):
    """The bounds for a state with these accelerations."""
    changes = 0.0 if mode.pair < 0 and law.plain else 1.0
    driver, follower = abs(push.driver), abs(push.follower)
    most = max(driver, follower)
    rate = (1.0 + changes * (1.0 + SLACK)) * most + 1e-100
    cap = TURN / (max(abs(y[2]), abs(y[3])) + np.sqrt(TURN * rate))
    more = changes * (driver + SLACK * most), changes * (follower + SLACK * most)
    return Bounds(cap, push.driver, push.follower, more[0], more[1])


@inner_jit
def outgrown(bounds, push):
    """Whether accelerations have changed by half as much as the bounds allow."""
    driver, follower = abs(push.driver - bounds.driver), abs(push.follower - bounds.follower)
    return 2.0 * driver > bounds.more_driver or 2.0 * follower > bounds.more_follower


@inner_jit
def _free_time(pair, at, near, bounds, y):
    """Time for which a nose cannot reach the track.

    Up to a time t its distance is at least D + D' t + (D'' - J t/3) t^2/2 with the greatest jerk J
    of the nose's centre, as the track's body sees it: it turns about the axis of its own body by
    the difference of both angles, while that axis turns about the other one. D'' is less where the
    accelerations of the bodies change.
    """
    rate_a, rate_b = bounds.driver, bounds.follower
    more_a, more_b = bounds.more_driver, bounds.more_follower
    if pair.nose == 1:
        rate_a, rate_b, more_a, more_b = rate_b, rate_a, more_b, more_a
    arm, centre = abs(at.arm), abs(at.at - at.arm)
    turning, swinging = abs(rate_a - rate_b) + more_a + more_b, abs(rate_b) + more_b
    spin = abs(y[2] - y[3]) + turning * bounds.cap
    swing = abs(y[3 - pair.nose]) + swinging * bounds.cap
    if near.jumps:
        slope, jerk = -abs(at.v), 0.0
        bend = -arm * (spin * spin + turning) - centre * (swing * swing + swinging)
    else:
        slope = dot(near.direction, at.v)
        bend = dot(near.direction, at.a + 1j * (rate_a * at.arm - rate_b * at.at)) - near.bend
        bend -= arm * (more_a + more_b) + centre * more_b
        jerk = arm * spin * (spin * spin + 3.0 * turning)
        jerk += centre * swing * (swing * swing + 3.0 * swinging)
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
    """Look at a pair; returns what it finds, see `CLOSES`."""
    seen, pair = watch[i], pairs[i]
    nose, track = images(pair, law.centre, y)
    seen.nose, seen.track, seen.beside = nose, track, 0
    seen.until = time + bounds.cap * pair.rest
    if joined(pairs, joints, mode, i, nose, track):
        seen.behind = 0
        return 0
    at = place(pair, law.centre, y, nose, track)
    near = nearness(pair, at)
    was_behind, seen.behind = seen.behind, 1 if near.behind else 0
    if near.behind and was_behind == 0 and _enclosed(law, pairs, i, nose, track, y):
        return OVERLAPS
    seen.beside = 1 if near.distance <= ALLOWED else 0
    if near.distance > CLOSED:
        seen.until = min(seen.until, time + _free_time(pair, at, near, bounds, y))
        return 0
    touch = touch_at(pair, at)
    left = min(touch.on_track, touch.on_nose)
    rate = touch.g0 * y[2] + touch.g1 * y[3]
    bend = touch.kappa + touch.g0 * push.driver + touch.g1 * push.follower
    seen.until = time + bounds.cap * NEAR
    if rate > STILL and bend < 0.0:
        seen.until = min(seen.until, time - rate / bend)  # the top of a rebound
    # a nose that has just left the end of a feature would return to its continuation
    pressed = rate <= STILL and bend < -STILL and left > EDGE
    closes = abs(touch.gap) <= ALLOWED and ((rate < -STILL and left >= -EDGE) or pressed)
    return CLOSES if closes else 0


@inner_jit
def _enclosed(law, pairs, i, nose, track, y):
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
        if apart(two, centre + point * turned - two.at) < -touch.gap:
            return False
    return True


@inner_jit
def deeper(law, pairs, watch, mode, y, length, work):
    """The part of a step until a nose right beside a track begins to enter it, and its pair, or -1.

    `work.out` is the state at the end of the step, and then that at the end of the part.
    """
    found = -1
    for i in range(len(watch)):
        if watch[i].beside == 0:
            continue
        level = _depth(law, pairs, watch, i, y)
        if level < -ALLOWED or _depth(law, pairs, watch, i, work.out) >= level - CLOSED:
            continue
        low, high = 0.0, length
        for _ in range(60):
            part = 0.5 * (low + high)
            advance(law, pairs, mode, y, part, work)
            if _depth(law, pairs, watch, i, work.out) < level - CLOSED:
                high = part
            else:
                low = part
        advance(law, pairs, mode, y, high, work)
        if _depth(law, pairs, watch, i, work.out) >= level - ALLOWED:
            length, found = high, i
        else:
            # the nose comes from behind
            advance(law, pairs, mode, y, length, work)
    return length, found


@inner_jit
def _depth(law, pairs, watch, i, y):
    """A gap that is negative, else 0."""
    pair = pairs[i]
    touch = touch_at(pair, place(pair, law.centre, y, watch[i].nose, watch[i].track))
    return min(touch.gap, 0.0) if min(touch.on_track, touch.on_nose) >= 0.0 else 0.0
