"""Which pair of features closes first within a step.

A nose is at the distance D from the points of a track. D changes no faster than the bodies turn, so
that a pair is looked at only where they have turned by so much. Then neither D nor its rate can
change faster than speeds and accelerations in the step allow, so that no contact can begin before a
time that follows from them; there the pair is looked at again. These times become exact as D goes
to zero. Of a nose right beside a track the depth is compared as well. If one is found within the
other body all the same, the motion ends there.
"""

import cmath
from collections import namedtuple

import numpy as np

from escapement.engines.two_bodies.law import push_at
from escapement.engines.two_bodies.overlap import enclosed
from escapement.engines.two_bodies.pairs import TURN, WIDE
from escapement.engines.two_bodies.step import NODES, state_at
from escapement.engines.two_bodies.touch import (
    ALLOWED,
    dot,
    image_turn,
    images,
    length_of,
    nearness,
    place,
    posed,
    touch_at,
)  # fmt: skip
from escapement.numerics.jit import inner_jit
from escapement.numerics.records import record_dtype

WATCH = record_dtype({
    **dict.fromkeys(("distance", "theta", "phi", "reach", "theta_first", "phi_first"), float),
    **dict.fromkeys(("nose_turn", "track_turn"), complex),
    **dict.fromkeys(("nose", "track", "beside", "behind"), np.int64),
})  # fmt: skip
"""A pair when it was last looked at: the distance, or -1 beside the contact, the angles of both
bodies, and how far the nose was from the axis of the track; the images that it means, and the
angles at which they were found; whether the nose was right beside the track, or behind it."""
CLOSES, OVERLAPS = 1, 2
"""What a look at a pair finds, or 0: a contact begins, or the nose has entered the other body."""
CLOSED = 1e-13
"""A gap below this is closed."""
EDGE, STILL = 1e-7, 1e-12
"""A foot may be outside of a feature by this length or angle. A gap that changes at less than that
speed stays as it is."""
NEAR = 0.01
"""Share of the longest step after which a nose right beside a track is looked at again."""


Limits = namedtuple("Limits", "driver follower turns follower_turns")
"""Bounds within a step: of the accelerations of driver and follower, and of what they turn by."""


@inner_jit
def longest_step(y, push):
    """The time in which the bodies turn by `TURN` at most, if accelerations stay as they are."""
    most = max(abs(push.driver), abs(push.follower)) + 1e-100
    return TURN / (max(abs(y[2]), abs(y[3])) + np.sqrt(TURN * most))


@inner_jit
def _limits(path, y, length, end):
    driver, follower = 0.0, 0.0
    for k in range(NODES + 1):
        slope = k * (k + 1) / length  # twice that of a Legendre polynomial is no greater
        driver += slope * abs(path.speeds[0, k])
        follower += slope * abs(path.speeds[1, k])
    turns = (abs(y[2]) + driver * end) * end, (abs(y[3]) + follower * end) * end
    return Limits(driver, follower, turns[0], turns[1])


@inner_jit
def _stays_away(pair, seen, y, limits):
    """Whether a nose is too far from its track to reach it within a step."""
    turn_a = abs(y[0] - seen.theta) + limits.turns
    turn_b = abs(y[1] - seen.phi) + limits.follower_turns
    if max(turn_a, turn_b) > WIDE:
        return False
    if pair.nose == 1:
        turn_a, turn_b = turn_b, turn_a
    across = length_of(pair.nose_at) * turn_a
    return across + (seen.reach + across) * turn_b < seen.distance


@inner_jit
def _free_time(pair, at, near, limits, y, end):
    """Time for which a nose cannot reach the track.

    Up to a time t its distance is at least D + D' t - M t^2/2 with the greatest acceleration M of
    the nose's centre, as the track's body sees it: it turns about the axis of its own body by the
    difference of both angles, while that axis turns about the other one.
    """
    arm, centre = length_of(at.arm), length_of(at.at - at.arm)
    turning, swinging = limits.driver + limits.follower, limits.follower
    if pair.nose == 1:
        swinging = limits.driver
    spin, swing = abs(y[2] - y[3]) + turning * end, abs(y[3 - pair.nose]) + swinging * end
    most = arm * (spin * spin + turning) + centre * (swing * swing + swinging) + 1e-100
    slope = dot(near.direction, at.v)
    if near.jumps:
        slope = -length_of(at.v)
    else:
        most += near.bend
    root = np.sqrt(slope * slope + 2.0 * most * near.distance)
    return (slope + root) / most if slope > 0.0 else 2.0 * near.distance / (root - slope)


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
def first_closed(law, pairs, joints, watch, mode, y, length, end, path):
    """The pair that closes first in a step before its end; returns the time, the pair or -1, and
    what was found, see `CLOSES`."""
    limits, closed, found = _limits(path, y, length, end), -1, 0
    turns = cmath.rect(1.0, y[0]), cmath.rect(1.0, y[1])
    most = max(limits.turns, limits.follower_turns)
    for i in range(len(watch)):
        pair, seen, s = pairs[i], watch[i], 0.0
        if _stays_away(pair, seen, y, limits):
            continue
        while True:
            here, turned = y, turns
            if s > 0.0:
                here = path.here
                state_at(path, y, length, s, here)
                turned = cmath.rect(1.0, here[0]), cmath.rect(1.0, here[1])
            free, what = _look(law, pairs, joints, watch, i, mode, here, turned, limits, end)
            if what != 0:
                end, closed, found = s, i, what
                break
            if most > WIDE:
                free = min(free, length * WIDE / most)
            ahead = min(s + max(free, 1e-15 * length), end)
            if seen.beside != 0:
                enters = _enters(law, pairs, watch, i, y, length, s, ahead, path)
                if enters < np.inf:
                    end, closed, found = enters, i, CLOSES
                    break
            s = ahead
            if s >= end:
                break
    return end, closed, found


@inner_jit
def _look(law, pairs, joints, watch, i, mode, y, turns, limits, end):
    """Look at a pair; returns for how long it cannot close, and what was found."""
    seen, pair = watch[i], pairs[i]
    turned = max(abs(y[0] - seen.theta_first), abs(y[1] - seen.phi_first))
    most = max(limits.turns, limits.follower_turns)
    if turned + most > WIDE:
        nose, track = images(pair, law.centre, y)
        if nose != seen.nose:
            seen.nose, seen.nose_turn = nose, image_turn(nose, pair.nose_fold)
        if track != seen.track:
            seen.track, seen.track_turn = track, image_turn(track, pair.track_fold)
        seen.theta_first, seen.phi_first = y[0], y[1]
    nose, track = seen.nose, seen.track
    seen.beside, seen.distance = 0, -1.0
    if joined(pairs, joints, mode, i, nose, track):
        seen.behind = 0
        return np.inf, 0
    turn, track_turn = turns[pair.nose] * seen.nose_turn, turns[1 - pair.nose] * seen.track_turn
    at = posed(pair, law.centre, y, turn, track_turn)
    seen.theta, seen.phi, seen.reach = y[0], y[1], length_of(at.at)
    seen.distance = length_of(at.at - pair.middle) - pair.reach - pair.rho
    if _stays_away(pair, seen, y, limits):
        return np.inf, 0
    near = nearness(pair, at)
    seen.distance = near.distance
    was_behind, seen.behind = seen.behind, 1 if near.behind else 0
    if near.behind and was_behind == 0 and enclosed(law, pairs, i, nose, track, y):
        return 0.0, OVERLAPS
    seen.beside = 1 if near.distance <= ALLOWED else 0
    if near.distance > CLOSED:
        return _free_time(pair, at, near, limits, y, end), 0
    # as those that take the contact see it, so that they judge alike
    touch = touch_at(pair, place(pair, law.centre, y, nose, track))
    push = push_at(law, pairs, mode, y)
    left = min(touch.on_track, touch.on_nose)
    rate = touch.g0 * y[2] + touch.g1 * y[3]
    bend = touch.kappa + touch.g0 * push.driver + touch.g1 * push.follower
    # a nose that has just left the end of a feature would return to its continuation
    still = STILL * (1.0 + abs(push.driver) + abs(push.follower))
    pressed = rate <= STILL and bend < -still and left > EDGE
    if abs(touch.gap) <= ALLOWED and ((rate < -STILL and left >= -EDGE) or pressed):
        return 0.0, CLOSES
    free = NEAR * longest_step(y, push)
    if rate > STILL and bend < 0.0:
        free = min(free, -rate / bend)  # the top of a rebound
    return free, 0


@inner_jit
def _enters(law, pairs, watch, i, y, length, low, high, path):
    """The time between two others at which a nose right beside a track begins to enter it, or
    infinity."""
    level = _depth_at(law, pairs, watch, i, y, length, low, path)
    last = _depth_at(law, pairs, watch, i, y, length, high, path)
    if level < -ALLOWED or last >= level - CLOSED:
        return np.inf
    for _ in range(60):
        s = 0.5 * (low + high)
        if _depth_at(law, pairs, watch, i, y, length, s, path) < level - CLOSED:
            high = s
        else:
            low = s
    comes_in = _depth_at(law, pairs, watch, i, y, length, high, path) >= level - ALLOWED
    return high if comes_in else np.inf  # else it comes from behind


@inner_jit
def _depth_at(law, pairs, watch, i, y, length, s, path):
    """A gap that is negative at a time in a step, else 0."""
    state_at(path, y, length, s, path.here)
    pair, seen = pairs[i], watch[i]
    touch = touch_at(pair, place(pair, law.centre, path.here, seen.nose, seen.track))
    return min(touch.gap, 0.0) if min(touch.on_track, touch.on_nose) >= 0.0 else 0.0
