"""The equation of motion, dimensionless.

The units of inertia, torque and time are the follower's inertia I_f, the driving torque and
sqrt(I_f/torque). Lengths are in the unit of the mechanism's path, such as the crank radius. A
`Scene` holds the mechanism's path and these dimensionless numbers:

    rho           driver's inertia over the follower's
    T             torque of the drive, linear between given driver angles
    mu            friction of each side, mu_plus and mu_minus
    load, bearing load torque, and constant torque of the driver's bearing
    c_d, c_f      drag of driver and follower that grows with the square of the speed
    nu_d, nu_f    viscous drag of driver and follower
    r_p           radius of the pin, whose body turns by beta per driver radian
    b_d, b_f      torque of friction in each journal over the contact force
    delta         distance of the slot's centre line from the follower's axis, in the sense of phi

With w = theta_dot^2 and the side s = +1 or -1 of the slot that carries the force, the drive D
and the resistance F of the follower are

    D = pull - c_d w - nu_d sqrt(w),                            pull = T - bearing
    F = k w + load + nu_f g sqrt(w),                            k = g' + c_f g |g|

The pin is at the distance R from the follower's axis and moves along the slot at V = u R per
driver radian. The sliding speed v of the contact, the lever arm h of the contact force and the
effective ratio p are

    v = V + s r_p (g - beta),    h = R - sign(v) mu (r_p + s delta) - s b_f sign(g)
    p = g + c,                   c = s (mu |v| + b_d + b_f |g|)/h
    (rho + g p) theta_ddot = D - p F

The moment with which the contact turns the follower, after the friction of the pin and of the
follower's journal is subtracted, is

    N h = X/(rho + g p),         X = rho F + g D

An ideal pin has c = s mu |u|. A mesh of efficiency eta has p = g eta^(-s), because power that
flows back is multiplied by eta. That is the same law with |u| = g, mu_+ = 1/eta - 1 and
mu_- = 1 - eta. In a dwell the follower is locked, so that g, u and g' are zero.

With load = 0 the law of an ideal pin is Meyer's eq. 1-18/1-19, where his S is s sign(sin theta).
An engine integrates the functions of this file over time (`net_torque` divided by
`reduced_inertia`) or over the driver angle (`energy_rates`); `painleve` finds where
J_s = rho + g p vanishes.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.load import load_at, whole_load
from escapement.dynamics.torque import (
    REST,
    depends_on_speed,
    drive_torque,
    is_undriven,
    same_angle_gap,
)
from escapement.mechanisms.path import PIN_RATE, Path
from escapement.mechanisms.slotted import offset_of, pose_at
from escapement.model.scene import (
    ARRAYS,
    DRIVER_ANGLE,
    DWELL,
    EDGES_END,
    LOAD_END,
    PATH_END,
    TABLE,
    TORQUE_END,
    Scene,
)
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.known import where_known

LOSSES = (
    *("friction", "driver_bearing", "follower_bearing", "driver_drag", "follower_drag"),
    *("barrel", "load_train"),
)
"""Where work is lost: in the slot or the mesh, in the bearings, to the air or to oil, in trains."""
# A force below this share of its terms may vanish near by, and is looked at a little behind [rad].
_SMALL, _BEHIND = 1e-6, 1e-7
# Where a mesh stops, g and g' of a table are rounding errors below this.
_TABLE_ROUNDING = 1e-9

SLIGHTEST_IMPACT = 1e-4
"""An impact that takes a smaller share of the speed is no extremum of it [-]."""


@inner_jit(inlined=True)
def scene_with(shared, edges, row):
    """The scene `shared` with other edges, and with the numbers in a row."""
    return _numbered(
        shared.path, edges, shared.dwell, shared.torque, shared.driver_angle, shared.load_curve,
        shared.fall, row,
    )  # fmt: skip


@inner_jit(inlined=True)
def _numbered(path, edges, dwell, torque, driver_angle, load_curve, fall, row):
    """The scene with the numbers in a row."""
    return Scene(
        path, edges, dwell, torque, driver_angle, load_curve, fall,
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10],
        row[11], row[12], row[13], row[14], row[15], row[16], row[17], row[18], row[19],
    )  # fmt: skip


@inner_jit(allocates=True, inlined=True)
def scene_of(packed):
    """The scene that `model.scene.packed` has laid out in an array."""
    path, edges = int(packed[PATH_END]), int(packed[EDGES_END])
    torque, load = int(packed[TORQUE_END]), int(packed[LOAD_END])
    return _numbered(
        Path(packed[TABLE] != 0.0, packed[ARRAYS:path]), packed[path:edges], packed[DWELL],
        packed[edges:torque], packed[DRIVER_ANGLE], packed[torque:load], packed[load:], packed,
    )  # fmt: skip


@inner_jit
def signed_loss(side, scene):
    """The signed friction s mu_s of the side that carries the force."""
    return scene.mu_plus if side > 0.0 else -scene.mu_minus


@inner_jit
def is_ideal(scene):
    """Whether the pin is thin and slides towards the axis, and the journals have no friction."""
    plain = scene.pin == 0.0 and scene.driver_journal == 0.0 and scene.follower_journal == 0.0
    return plain and offset_of(scene.path) == 0.0


@inner_jit
def is_viscous(scene):
    """Whether drag or the torque depends on the speed, which makes the law nonlinear in w."""
    dragged = scene.driver_viscous != 0.0 or scene.follower_viscous != 0.0
    return dragged or depends_on_speed(scene)


@inner_jit
def is_drag_free(scene):
    """Whether there is no drag, neither of air nor of oil."""
    return scene.driver_drag + scene.follower_drag == 0.0 and not is_viscous(scene)


@jit
def is_lossless(scene):
    """Whether no loss grows with the speed: every engagement then adds the same energy."""
    losses = scene.mu_plus + scene.driver_journal + scene.follower_journal
    # a train without an inertia behind it passes on a constant torque
    barrel = scene.barrel_efficiency == 1.0 or scene.barrel == 0.0
    trains = barrel and (scene.load_train_efficiency == 1.0 or scene.load_train == 0.0)
    return losses == 0.0 and is_drag_free(scene) and trains


@inner_jit
def sign_of(value, known=0.0):
    """Sign of a value, or the `known` sign, which continues |value| smoothly beyond its zero."""
    return known if known != 0.0 else np.copysign(1.0, value)


@inner_jit
def slide_at(g, u, radius, side, scene):
    """Sliding speed v per driver radian of the contact point along the wall."""
    return radius * u + side * scene.pin * (g - scene.path.numbers[PIN_RATE])


@inner_jit
def grip(g, u, radius, side, scene, slide_sign=0.0, ratio_sign=0.0):
    """Sliding speed |v| per driver radian, and lever h of the contact force.

    `slide_sign` and `ratio_sign` are the signs of v and g, if they are known; see `sign_of`.
    """
    if is_ideal(scene):
        return sign_of(u, slide_sign) * radius * u, radius
    slide = slide_at(g, u, radius, side, scene)
    slide_sign, ratio_sign = sign_of(slide, slide_sign), sign_of(g, ratio_sign)
    arm = scene.pin + side * offset_of(scene.path)
    lever = radius - side * signed_loss(side, scene) * slide_sign * arm
    return slide_sign * slide, lever - side * ratio_sign * scene.follower_journal


@inner_jit
def friction_ratio(g, u, radius, side, scene, slide_sign=0.0, ratio_sign=0.0):
    """What friction adds to the effective ratio, c = p - g; signs are as in `grip`."""
    friction = signed_loss(side, scene)
    # in a dwell u and R are given as zero
    if is_ideal(scene) or radius == 0.0:
        return friction * sign_of(u, slide_sign) * u
    slide, lever = grip(g, u, radius, side, scene, slide_sign, ratio_sign)
    lost = scene.driver_journal + scene.follower_journal * sign_of(g, ratio_sign) * g
    return (friction * slide + side * lost) / lever


@inner_jit
def dragged_slope(g, dg, scene, ratio_sign=0.0):
    """k = g' + c_f g |g|."""
    return dg + scene.follower_drag * (g * sign_of(g, ratio_sign) * g)


@inner_jit
def root_of(w, scene):
    """Speed sqrt(w) if viscous drag needs it, otherwise 0."""
    return np.sqrt(max(w, 0.0)) if is_viscous(scene) else 0.0


@inner_jit
def drive(pull, w, root, scene):
    """D: torque of the drive minus the driver's drag at the squared speed w; see `root_of`."""
    return pull - scene.driver_drag * w - scene.driver_viscous * root


@inner_jit
def drive_sign(pull, w, scene):
    """1 if the driver gains speed where there is no contact force, -1 if it loses speed."""
    return np.sign(drive(pull, w, root_of(w, scene), scene))


@where_known("follower_viscous", lambda g, k, w, root, scene, load=0.0: k * w + scene.load)
def resistance(g, k, w, root, scene, load=0.0):
    """F: moment of the follower's inertia at constant speed, of its load and its drag.

    `load` is the part of the load that changes with the follower's angle, see `dynamics.load`.
    """
    return k * w + whole_load(load, scene) + scene.follower_viscous * g * root


@inner_jit
def contact(g, k, pull, w, root, scene, load=0.0):
    """X = N h (rho + g p): its sign is the side of the slot that carries the force.

    It depends neither on the side itself nor on losses that grow with the contact force, so
    the side is explicit and unique below the Painleve limit. The pin changes sides where it is
    zero; at constant driver speed F = 0 takes its place, which is Filemon's pin reversal.
    """
    return scene.rho * resistance(g, k, w, root, scene, load) + g * drive(pull, w, root, scene)


@inner_jit
def net_torque(g, c, k, pull, w, root, scene, load=0.0):
    """Torque that is left to accelerate the driver, J_s theta_ddot = D - p F."""
    return drive(pull, w, root, scene) - (g + c) * resistance(g, k, w, root, scene, load)


@inner_jit
def reduced_inertia(g, c, scene):
    """J_s = rho + g p; it vanishes at the Painleve limit."""
    return scene.rho + g * (g + c)


class WallState(NamedTuple):
    """The law at a driver angle while a side of the slot carries the force.

    g, u, dg, radius : g, u, g' and R of the path; they are 0 in a dwell, as c, k and X are.
    c, k, pull, root : p - g, and what `contact` and `net_torque` take.
    inertia, rate, moment : J_s, theta_ddot, and X.
    """

    g: float
    u: float
    dg: float
    radius: float
    c: float
    k: float
    pull: float
    root: float
    inertia: float
    rate: float
    moment: float


@inner_jit
def wall_state(theta, w, side, scene, slide_sign=0.0, ratio_sign=0.0):
    """`WallState` at a driver angle; the side is 0 in a dwell, and signs are as in `grip`."""
    pose = pose_at(scene.path, theta) if side != 0.0 else (0.0, 0.0, 0.0, 0.0)
    torque, load = drive_torque(theta, w, scene), load_at(theta, side, scene)
    return state_of_pose(pose, torque, w, side, scene, slide_sign, ratio_sign, load)


@inner_jit(inlined=True)
def state_of_pose(pose, torque, w, side, scene, slide_sign=0.0, ratio_sign=0.0, load=0.0):
    """`WallState` at a `pose_at` and a torque of the drive."""
    g, u, dg, radius = pose
    c = friction_ratio(g, u, radius, side, scene, slide_sign, ratio_sign)
    k = dragged_slope(g, dg, scene, ratio_sign)
    pull, root, moment = torque - scene.bearing, root_of(w, scene), 0.0
    inertia = reduced_inertia(g, c, scene)
    rate = net_torque(g, c, k, pull, w, root, scene, load) / inertia
    if side != 0.0:
        moment = contact(g, k, pull, w, root, scene, load)
    return WallState(
        g=g, u=u, dg=dg, radius=radius, c=c, k=k, pull=pull, root=root, inertia=inertia, rate=rate,
        moment=moment,
    )  # fmt: skip


@inner_jit
def free_gain(angle, pull, w, scene):
    """Increase of w over a small angle while the driver turns without the follower."""
    return 2.0 * angle * drive(pull, w, root_of(w, scene), scene) / scene.rho


@jit
def left_by_impact(scene):
    """Share of the driver's speed that is left where a pin strikes a follower at rest.

    The impact is plastic, on the side s = +1, with friction: the follower takes the angular impulse
    P = I_d I_f g theta_dot/(I_d + I_f g p), and the driver loses p P. The pin strikes where the
    engagement begins; after the impact the follower has the speed that the pin prescribes there.
    """
    g, c, _k = bent_pose(scene.edges[0], 1.0, scene)
    return scene.rho / reduced_inertia(g, c, scene)


@jit
def is_felt(share):
    """Whether an impact that leaves this share of the speed counts as an extremum of the speed.

    A slighter one comes of errors of the parts far below what can be made, some 1e-11 of a length,
    and passes smoothly to the handoff of perfect parts, which has none.
    """
    return share < 1.0 - SLIGHTEST_IMPACT


@inner_jit
def energy_rates(g, c, k, pull, inverse_inertia, dtheta_dx, root, scene, load=0.0, slope=0.0):
    """Coefficients of dE/dx = A - B E for E = (rho + g^2) w, twice the kinetic energy.

    With J = rho + g^2 + g c

        A = 2 theta' [(D - g M) - c (rho M + g D)/J]
        B = 2 theta'/J {c rho k/(rho + g^2) + c_d + [1 + g c/(rho + g^2)] c_f g^2 |g|}

    where D and M are the torques of drive, `pull`, and load that do not depend on w. Both are
    written in c, so that without a loss B is exactly zero and A is exact. Viscous drag is
    linear about the speed `root`, sqrt(w) = root/2 + w/(2 root): it adds to both D and M, and
    to c_d and k.

    Parameters
    ----------
    inverse_inertia : 1/(rho + g^2).
    dtheta_dx : theta', the driver angle by the panel's coordinate x.
    root : speed about which viscous drag is linear; 0 without it.
    slope : of the pull by the speed, at `root`.

    Returns
    -------
    A, B, amplification
        `amplification` is (rho + g^2)/J. It is large near the Painleve limit, where J is a
        difference of nearly equal terms, and multiplies the rounding error of A and B.
    """
    torque, load, drag = pull, whole_load(load, scene), scene.driver_drag
    air = scene.follower_drag * (g * g * abs(g))
    if root > 0.0:
        half = 0.5 * root
        torque -= (scene.driver_viscous + slope) * half
        load += scene.follower_viscous * g * half
        drag += (scene.driver_viscous - slope) * (0.5 / root)
        shear = scene.follower_viscous * g * (0.5 / root)
        k += shear
        air += shear * g
    amplification = 1.0 / (1.0 + g * c * inverse_inertia)
    twice = 2.0 * dtheta_dx
    lost = c * (scene.rho * load + g * torque) * amplification * inverse_inertia
    gain = twice * ((torque - g * load) - lost)
    bent = c * scene.rho * k * inverse_inertia
    decay = twice * inverse_inertia * ((bent + drag) * amplification + air)
    return gain, decay, amplification


@inner_jit
def ends_alike(g_in, g_out, rho):
    """Whether rho + g^2 is the same at both ends of an engagement, except for a table's rounding.

    Without friction each engagement then adds the same energy, and no speed is terminal.
    Meyer's published cells are the only ones that end with another g than they begin with.
    """
    return abs((g_out - g_in) * (g_out + g_in)) <= 1e-12 * (rho + g_out * g_out)


@inner_jit
def side_at(theta, g, k, pull, slope, w, before, scene):
    """Side that carries the force just behind a driver angle where a piece begins: +1 or -1.

    It is the sign of X, as a limit from behind: X vanishes at the pin entry if the driver is at
    rest without a load, and at dead centre if there is no torque. Where it is small it is also
    evaluated a little behind, to where the driver turns free. Where a mesh stops, g and g' are
    both zero, or rounding errors of a table, and the side stays what it was `before`.

    Parameters
    ----------
    theta : driver angle [rad].
    g, k, pull, w : there.
    slope : of the pull behind it.
    before : side before it; +1 at an entry, where the driver is about to push the follower.
    """
    load = load_at(theta, 1.0, scene)
    value = contact(g, k, pull, w, root_of(w, scene), scene, load)
    size = scene.rho * w + abs(pull)
    if abs(value) <= _SMALL * size:
        g, _u, dg, _radius = pose_at(scene.path, theta + _BEHIND)
        k, w = dragged_slope(g, dg, scene), max(w + free_gain(_BEHIND, pull, w, scene), 0.0)
        pull += slope * _BEHIND
        load = load_at(theta + _BEHIND, 1.0, scene)
        behind = contact(g, k, pull, w, root_of(w, scene), scene, load)
        value = settled(value, behind, _BEHIND, same_angle_gap(scene))
        if value == 0.0:
            value = behind
        if scene.path.table and max(abs(value), abs(behind)) <= _TABLE_ROUNDING * size:
            value = before
    return 1.0 if value >= 0.0 else -1.0


@inner_jit
def settled(value, other, distance, gap):
    """A value at an angle, or 0 where it has another sign closer to it than `gap` [rad].

    `other` is the value at the distance `distance` [rad], and has the sign that counts then.
    """
    near = abs(value) * distance <= gap * abs(other - value)
    return 0.0 if near and value * other <= 0.0 else value


@inner_jit
def bent_pose(theta, side, scene):
    """g, c and k at a driver angle while the side s carries the force; all are 0 in a dwell."""
    if side == 0.0:
        return 0.0, 0.0, 0.0
    g, u, dg, radius = pose_at(scene.path, theta)
    return g, friction_ratio(g, u, radius, side, scene), dragged_slope(g, dg, scene)


@jit
def rest_speed(theta, side, scene):
    """Driver speed at which a motion counts as at rest: 0, unless viscous drag alone acts on it.

    With viscous drag and nothing that drives it the driver would slow down for ever. It counts as
    at rest once the kinetic energy of both bodies is that of a driver with the squared speed
    `REST`; the energy falls, so it never becomes faster again.
    """
    if not (is_viscous(scene) and is_undriven(theta, scene)):
        return 0.0
    g = bent_pose(theta, side, scene)[0]
    return np.sqrt(REST * scene.rho / (scene.rho + g * g))
