"""A nose and a track: their gap, its directions, and how near they are.

Everything is told in the frame of the track, with points as complex numbers. With r_A and r_B from
the axes of both bodies to the nose's centre, and angles q of nose and track,

    gap' = G.q',   gap'' = G.q'' + kappa,   slip = H.q'
    kappa = n.a + curvature (t.v)^2,   v = i (q_A' r_A - q_B' r_B),
    a = -q_A'^2 r_A - 2 i q_B' v + q_B'^2 r_B
"""

import cmath
from collections import namedtuple

import numpy as np

from escapement.mechanisms.features import CONVEX, LINE
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit, jit

ALLOWED = 1e-9
"""A contact that begins deeper than this came from behind."""
FAR = 0.3
"""From an arc farther than this share of its radius, the nearest of its points may jump."""


Place = namedtuple("Place", "arm at v a turned")
"""Where a nose is: its centre from both axes, its velocity and acceleration as far as it does
not depend on those of the bodies, and the direction in which its body has turned."""


Touch = namedtuple("Touch", "gap g0 g1 h0 h1 kappa on_track on_nose")
"""A nose at a track: gap, rates G and H by the angles of driver and follower, kappa, and what
is left to the ends of the track (length or angle) and of the nose's sector, negative outside."""


Near = namedtuple("Near", "distance direction bend jumps behind")
"""How near a nose is to the points of a track: the distance and its direction.

Towards the centre of an arc the distance bends by `bend` less than the motion along that
direction, elsewhere not less than it. If the nearest point `jumps`, only the speed bounds it. The
nose may be `behind` the track, deeper than a contact can be."""


@inner_jit(merged=True)
def dot(a, b):
    """Scalar product of two vectors."""
    return a.real * b.real + a.imag * b.imag


@inner_jit
def _chosen(towards, angle, fold, first, count, number):
    """The image among those around a direction that always belongs to this number."""
    start = int(np.floor((cmath.phase(towards) - angle) * fold / (2.0 * np.pi))) + first
    return start + (number - start) % count


@inner_jit
def images(pair, centre, y):
    """Numbers of the images of nose and track that a pair means in a state."""
    q_nose, q_track = y[pair.nose], y[1 - pair.nose]
    side, nose, track = complex(-centre if pair.nose == 0 else centre), 0, 0
    if pair.nose_fold > 1:
        # towards the middle of the track, or the other axis if both bodies repeat
        to = -side if pair.track_fold > 1 else pair.middle * cmath.rect(1.0, q_track) - side
        angle = q_nose + pair.nose_angle
        count = pair.nose_count
        nose = _chosen(to, angle, pair.nose_fold, pair.nose_first, count, pair.nose_number)
    if pair.track_fold > 1:
        turn = q_nose + nose * 2.0 * np.pi / pair.nose_fold
        to, angle = side + pair.nose_at * cmath.rect(1.0, turn), q_track + pair.middle_angle
        count = pair.track_count
        track = _chosen(to, angle, pair.track_fold, pair.track_first, count, pair.track_number)
    return nose, track


@inner_jit(merged=True)
def length_of(z):
    """Length of a vector."""
    return np.sqrt(z.real * z.real + z.imag * z.imag)


@inner_jit
def image_turn(image, fold):
    """The direction into which an image of a body is turned."""
    return cmath.rect(1.0, image * 2.0 * np.pi / fold)


@jit(merged=True)
def place(pair, centre, y, nose_image, track_image):
    """Where the nose of a pair is, for a state that begins with angles and speeds."""
    turn = cmath.rect(1.0, y[pair.nose] + nose_image * 2.0 * np.pi / pair.nose_fold)
    track_turn = cmath.rect(1.0, y[1 - pair.nose] + track_image * 2.0 * np.pi / pair.track_fold)
    return posed(pair, centre, y, turn, track_turn)


@inner_jit(merged=True)
def posed(pair, centre, y, nose_turn, track_turn):
    """Where the nose of a pair is whose images are turned into these directions."""
    wa, wb = y[2 + pair.nose], y[3 - pair.nose]
    back = track_turn.conjugate()
    turned = nose_turn * back
    arm = pair.nose_at * turned
    at = arm + (-centre if pair.nose == 0 else centre) * back
    v = 1j * (wa * arm - wb * at)
    return Place(arm, at, v, wb * wb * at - wa * wa * arm - 2j * wb * v, turned)


@jit
def touch_at(pair, at):
    """The gap of a pair and what belongs to it, whether it is closed or not."""
    touch, x = contact_at(pair, at), at.at - pair.at
    foot, on_track, on_nose = x * pair.along.conjugate(), 1.0, 1.0
    if pair.kind == LINE:
        on_track = min(foot.real, pair.extent - foot.real)
    elif pair.extent < np.pi:
        on_track = pair.extent - abs(cmath.phase(foot))
    if pair.nose_half < np.pi:
        middle = pair.nose_along * at.turned
        on_nose = pair.nose_half - abs(cmath.phase(-normal(pair, at) * middle.conjugate()))
    return altered(touch, "on_track", on_track, "on_nose", on_nose)


@inner_jit(merged=True)
def contact_at(pair, at):
    """The same of a pair that touches within the ends of both features."""
    x, curvature = at.at - pair.at, 0.0
    if pair.kind == LINE:
        n = -1j * pair.along
        gap = dot(x, n) - pair.rho
    else:
        distance, sign = length_of(x), float(pair.kind)
        n, curvature = sign / distance * x, sign / distance
        gap = sign * (distance - pair.radius) - pair.rho
    kappa = dot(n, at.a) + curvature * dot(1j * n, at.v) ** 2
    # a vector product is the scalar product with the other vector turned back
    g_a, g_b = dot(at.arm, -1j * n), dot(at.at, 1j * n)
    h_a, h_b = dot(at.arm, n) - pair.rho, pair.rho - dot(at.at, n)
    if pair.nose != 0:
        g_a, g_b, h_a, h_b = g_b, g_a, h_b, h_a
    return Touch(gap=gap, g0=g_a, g1=g_b, h0=h_a, h1=h_b, kappa=kappa, on_track=1.0, on_nose=1.0)


@inner_jit
def nearness(pair, at):
    """Distance from the disc of the nose to the points of the track.

    Where the disc covers such points although its sector does not, or lies behind the track, it is
    the distance from the surface of which the track is a part.
    """
    x = at.at - pair.at
    distance, foot = max(length_of(x), 1e-300), x * pair.along.conjugate()
    if pair.kind == LINE:
        on_track = 0.0 <= foot.real <= pair.extent
        near = _from(x - min(max(foot.real, 0.0), pair.extent) * pair.along, pair.rho, False)
        gap, n, bend = -foot.imag - pair.rho, -1j * pair.along, 0.0
    else:
        angle, sign = cmath.phase(foot), float(pair.kind)
        on_track = abs(angle) <= pair.extent
        gap, n = sign * (distance - pair.radius) - pair.rho, sign / distance * x
        bend = 1.5 * dot(at.v, at.v) / distance
        if pair.kind == CONVEX and gap > -ALLOWED:
            return Near(gap, n, 0.0, False, False)
        if not on_track:
            # the nearer end of the arc
            end = pair.along * cmath.rect(pair.radius, pair.extent if angle > 0.0 else -pair.extent)
            near = _from(x - end, pair.rho, abs(x - end) > FAR * pair.radius)
        else:
            away = distance - pair.radius
            outwards = x / distance if away > 0.0 else -x / distance
            near = Near(abs(away) - pair.rho, outwards, bend, abs(away) > FAR * pair.radius, False)
    behind = on_track and gap < -ALLOWED
    if on_track and -ALLOWED <= gap <= 0.0:
        return Near(gap, n, bend, False, False)
    if near.distance >= -ALLOWED:
        return Near(near.distance, near.direction, near.bend, near.jumps, behind)
    return Near(abs(gap), n if gap > 0.0 else -n, bend, False, behind)


@inner_jit
def _from(x, rho, jumps):
    """Distance of a disc, whose centre is at x from a point."""
    distance = max(length_of(x), 1e-300)
    return Near(distance - rho, x / distance, 0.0, jumps, False)


@inner_jit(merged=True)
def normal(pair, at):
    """Normal of a track towards a nose."""
    x = at.at - pair.at
    return -1j * pair.along if pair.kind == LINE else float(pair.kind) / max(abs(x), 1e-300) * x
