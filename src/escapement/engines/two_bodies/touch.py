"""A nose and a track: their gap, its directions, and how near they are.

Everything is told in the frame of the track. With the nose's centre M, r_A and r_B are its
positions from the axes of the nose's and the track's body, and J turns by 90 degrees:

    gap' = G.q',   gap'' = G.q'' + kappa,   slip = H.q'
    kappa = n.a + curvature (t.v)^2,   v = q_A' J r_A - q_B' J r_B,
    a = -q_A'^2 r_A - 2 q_B' J v + q_B'^2 r_B
"""

from typing import NamedTuple

import numpy as np

from escapement.mechanisms.features import CONVEX, LINE
from escapement.numerics.jit import inner_jit

FAR = 0.3
"""From an arc farther than this share of its radius, the nearest of its points may jump."""


class Place(NamedTuple):
    """Where a nose is: its centre from both axes, its velocity, and how it and the track turn."""

    arm_x: float
    arm_y: float
    x: float
    y: float
    v_x: float
    v_y: float
    turn: float
    nose_speed: float
    track_speed: float


class Touch(NamedTuple):
    """A nose at a track: gap, rates by the angles of driver and follower, and what is left of both.

    g0, g1 : G of driver and follower. h0, h1 : H of both. kappa : gap'' without accelerations.
    on_track : length or angle from the foot to the nearer end of the track; on_nose : angle from
        there to the end of the nose's sector. Both are negative outside.
    """

    gap: float
    g0: float
    g1: float
    h0: float
    h1: float
    kappa: float
    on_track: float
    on_nose: float


class Near(NamedTuple):
    """How near a nose is to the points of a track: distance, its rate, and a bound of its bend.

    x, y : direction from the nearest point to the nose. Towards the centre of an arc the distance
    bends by `bend` less than the motion along that direction, elsewhere not less than it.
    jumps : whether the nearest point may jump, so that only the speed bounds the distance.
    """

    distance: float
    x: float
    y: float
    bend: float
    jumps: bool


@inner_jit
def _chosen(ahead, first, count, number):
    """The image among those around the partner that always belongs to this number."""
    start = int(np.floor(ahead)) + first
    return start + (number - start) % count


@inner_jit
def images(pair, centre, driver, follower):
    """Numbers of the images of nose and track that a pair means at angles of the bodies."""
    q_nose, q_track = (driver, follower) if pair.nose == 0 else (follower, driver)
    side = -centre if pair.nose == 0 else centre
    nose = track = 0
    if pair.nose_images > 1:
        # towards the middle of the track, or the other axis if both bodies repeat
        x, y = -side, 0.0
        if pair.track_images == 1:
            cosine, sine = np.cos(q_track), np.sin(q_track)
            x += cosine * pair.middle_x - sine * pair.middle_y
            y += sine * pair.middle_x + cosine * pair.middle_y
        ahead = (np.arctan2(y, x) - q_nose - pair.nose_polar) / pair.nose_pitch
        nose = _chosen(ahead, pair.nose_first, pair.nose_count, pair.nose_number)
    if pair.track_images > 1:
        angle = q_nose + nose * pair.nose_pitch
        cosine, sine = np.cos(angle), np.sin(angle)
        x = side + cosine * pair.nose_x - sine * pair.nose_y
        y = sine * pair.nose_x + cosine * pair.nose_y
        ahead = (np.arctan2(y, x) - q_track - pair.track_polar) / pair.track_pitch
        track = _chosen(ahead, pair.track_first, pair.track_count, pair.track_number)
    return nose, track


@inner_jit
def place(pair, centre, y, nose_image, track_image):
    """Where the nose of a pair is, for a state that begins with angles and speeds."""
    if pair.nose == 0:
        q_nose, q_track, w_nose, w_track, side = y[0], y[1], y[2], y[3], -centre
    else:
        q_nose, q_track, w_nose, w_track, side = y[1], y[0], y[3], y[2], centre
    angle = q_track + track_image * pair.track_pitch
    turn = q_nose + nose_image * pair.nose_pitch - angle
    cosine, sine = np.cos(turn), np.sin(turn)
    arm_x = cosine * pair.nose_x - sine * pair.nose_y
    arm_y = sine * pair.nose_x + cosine * pair.nose_y
    x, y_ = arm_x + side * np.cos(angle), arm_y - side * np.sin(angle)
    return Place(
        arm_x=arm_x, arm_y=arm_y, x=x, y=y_, v_x=w_track * y_ - w_nose * arm_y,
        v_y=w_nose * arm_x - w_track * x, turn=turn, nose_speed=w_nose, track_speed=w_track,
    )  # fmt: skip


@inner_jit
def touch_at(pair, at):
    """The gap of a pair and what belongs to it, whether it is closed or not."""
    x, y = at.x - pair.x, at.y - pair.y
    if pair.kind == LINE:
        n_x, n_y, curvature = pair.sine, -pair.cosine, 0.0
        gap = x * n_x + y * n_y - pair.rho
        foot = x * pair.cosine + y * pair.sine
        on_track = min(foot, pair.extent - foot)
    else:
        distance = np.sqrt(x * x + y * y)
        sign = 1.0 if pair.kind == CONVEX else -1.0
        n_x, n_y, curvature = sign * x / distance, sign * y / distance, sign / distance
        gap = sign * (distance - pair.radius) - pair.rho
        on_track = 1.0
        if pair.extent < np.pi:
            across, along = pair.cosine * y - pair.sine * x, pair.cosine * x + pair.sine * y
            on_track = pair.extent - abs(np.arctan2(across, along))
    on_nose = 1.0
    if pair.nose_half < np.pi:
        middle = at.turn + pair.nose_direction
        cosine, sine = np.cos(middle), np.sin(middle)
        across, along = sine * n_x - cosine * n_y, -cosine * n_x - sine * n_y
        on_nose = pair.nose_half - abs(np.arctan2(across, along))
    wa, wb = at.nose_speed, at.track_speed
    a_x = -wa * wa * at.arm_x + 2.0 * wb * at.v_y + wb * wb * at.x
    a_y = -wa * wa * at.arm_y - 2.0 * wb * at.v_x + wb * wb * at.y
    along = n_x * at.v_y - n_y * at.v_x
    kappa = n_x * a_x + n_y * a_y + curvature * along * along
    g_a, g_b = at.arm_x * n_y - at.arm_y * n_x, at.y * n_x - at.x * n_y
    h_a = at.arm_x * n_x + at.arm_y * n_y - pair.rho
    h_b = pair.rho - at.x * n_x - at.y * n_y
    first = pair.nose == 0
    return Touch(
        gap=gap, g0=g_a if first else g_b, g1=g_b if first else g_a,
        h0=h_a if first else h_b, h1=h_b if first else h_a,
        kappa=kappa, on_track=on_track, on_nose=on_nose,
    )  # fmt: skip


@inner_jit
def nearness(pair, at):
    """Distance from the disc of the nose to the points of the track."""
    x, y = at.x - pair.x, at.y - pair.y
    if pair.kind == LINE:
        foot = min(max(x * pair.cosine + y * pair.sine, 0.0), pair.extent)
        return _from(x - foot * pair.cosine, y - foot * pair.sine, pair.rho, False)
    distance = max(np.sqrt(x * x + y * y), 1e-300)
    if pair.kind == CONVEX and distance - pair.radius - pair.rho > -1e-12:
        return _from(x, y, pair.rho + pair.radius, False)
    across, along = pair.cosine * y - pair.sine * x, pair.cosine * x + pair.sine * y
    if abs(np.arctan2(across, along)) <= pair.extent:
        gap, sign = abs(distance - pair.radius) - pair.rho, 1.0 if distance > pair.radius else -1.0
        bend = 1.5 * (at.v_x * at.v_x + at.v_y * at.v_y) / distance
        jumps = gap > FAR * pair.radius
        return Near(gap, sign * x / distance, sign * y / distance, bend, jumps)
    # the nearer end of the arc
    turn = pair.extent if across > 0.0 else -pair.extent
    cosine, sine = np.cos(turn), np.sin(turn)
    x -= pair.radius * (pair.cosine * cosine - pair.sine * sine)
    y -= pair.radius * (pair.sine * cosine + pair.cosine * sine)
    return _from(x, y, pair.rho, x * x + y * y > (FAR * pair.radius) ** 2)


@inner_jit
def _from(x, y, rho, jumps):
    """Distance of a disc, whose centre is at x and y from a point."""
    distance = max(np.sqrt(x * x + y * y), 1e-300)
    return Near(distance - rho, x / distance, y / distance, 0.0, jumps)
