"""The equation of motion, dimensionless.

With the follower's inertia, the driving torque and sqrt(I_f/torque) as units of
inertia, torque and time, a `Scene` holds what remains beside the mechanism:

    rho   driver over follower inertia         mu    loss of each side, mu_plus and mu_minus
    load  load torque over driving torque

and with w = theta_dot^2, the side s = +1 or -1 of the slot that carries the
force and the ratio as friction bends it, p = g + s mu_s |u|,

    (rho + g p) theta_ddot + p (g' w + load) = 1
    contact moment on the follower  N R = (rho (g' w + load) + g) / (rho + g p)

A pin loses by sliding: both mu_s are its coefficient of friction. A mesh of
efficiency eta has p = g eta^(-s), because power that flows back is multiplied by eta. That
is the same law with |u| = g, mu_+ = 1/eta - 1 and mu_- = 1 - eta.

With load = 0 this is Meyer's eq. 1-18/1-19, his S being s sign(sin theta). An
engine integrates the functions of this file over the time (`acceleration`) or over
the angle (`energy_rates`); `painleve` asks where J_s vanishes.
"""

import numpy as np

from escapement.jit import inner_jit, jit
from escapement.mechanisms.slotted import transmission_at
from escapement.scene import Path, Scene


@inner_jit(allocates=True, inlined=True)
def scene_of(scene_tuple):
    """Scene from the nested tuples that `scene.scene_tuple` makes."""
    path = scene_tuple[0]
    return Scene(Path(path[0], path[1], path[2]), *scene_tuple[1:])


@inner_jit
def signed_loss(side, scene):
    """The signed loss s mu_s of the side that carries the force."""
    return scene.mu_plus if side > 0.0 else -scene.mu_minus


@jit
def drive(scene):
    """Torque that drives the driver, in units of the driving torque: all of it."""
    return 1.0


@inner_jit
def free_gain(angle, scene):
    """What a driver that turns free of the follower gains in w over an angle."""
    return 2.0 * angle * drive(scene) / scene.rho


@inner_jit
def effective_ratio(g, u, side, scene):
    """Transmission function as friction bends it, p = g + s mu_s |u|."""
    return g + signed_loss(side, scene) * abs(u)


@inner_jit
def contact(g, dg, w, scene):
    """X = N R (rho + g p): its sign is the side of the slot that carries the force.

    Neither friction nor the side itself enters, so the side is explicit and
    unique below the Painleve limit. Its zero is Filemon's pin reversal.
    """
    return scene.rho * (dg * w + scene.load) + g * drive(scene)


@inner_jit
def net_torque(g, u, dg, w, side, scene):
    """Torque that is left to accelerate the driver, J_s theta_ddot = 1 - p_s (g' w + load)."""
    return drive(scene) - effective_ratio(g, u, side, scene) * (dg * w + scene.load)


@inner_jit
def reduced_inertia(g, u, side, scene):
    """J_s = rho + g p_s; it vanishes at the Painleve limit."""
    return scene.rho + g * effective_ratio(g, u, side, scene)


@inner_jit
def acceleration(g, u, dg, w, side, scene):
    """Driver acceleration in units of torque / I_f."""
    return net_torque(g, u, dg, w, side, scene) / reduced_inertia(g, u, side, scene)


@inner_jit
def contact_moment(g, u, dg, w, side, scene):
    """Moment N R on the follower in units of the driving torque."""
    return contact(g, dg, w, scene) / reduced_inertia(g, u, side, scene)


@inner_jit
def energy_rates(g, u, dg, inverse_inertia, dtheta_dx, side, scene):
    """Coefficients of dE/dx = A - B E for E = (rho + g^2) w, twice the kinetic energy.

    With c = p - g and J = rho + g^2 + g c

        A = 2 theta' [(1 - g load) - c (rho load + g)/J],   B = 2 theta' c rho g'/(J (rho + g^2)).

    Both are written in c, so that without a loss B is exactly zero and A is exact.

    Parameters
    ----------
    u : |u|, which is never negative here.
    inverse_inertia : 1/(rho + g^2).
    dtheta_dx : theta', the driver angle by the panel's coordinate x.

    Returns
    -------
    A, B, amplification
        `amplification` is (rho + g^2)/J. It is large near the Painleve limit, where J is a
        difference of nearly equal terms, and multiplies the rounding error of A and B.
    """
    c = signed_loss(side, scene) * u
    amplification = 1.0 / (1.0 + g * c * inverse_inertia)
    twice = 2.0 * dtheta_dx
    lost = c * (scene.rho * scene.load + g * drive(scene)) * amplification * inverse_inertia
    gain = twice * ((drive(scene) - g * scene.load) - lost)
    decay = twice * c * scene.rho * dg * amplification * inverse_inertia * inverse_inertia
    return gain, decay, amplification


@inner_jit
def loss_per_angle(g, u, dg, w, side, scene):
    """Work lost in the contact per driver angle, mu_s |u| |N R|; `u` is |u|."""
    lost = signed_loss(side, scene) * u
    return abs(lost * contact(g, dg, w, scene) / (scene.rho + g * (g + lost)))


@inner_jit
def dwell_gain(scene):
    """What a dwell adds to the squared speed."""
    return free_gain(scene.dwell, scene)


@inner_jit
def free_turn(w, scene):
    """Squared speed after the dwell, and the time that the dwell takes.

    The driver turns free in it: rho theta_ddot = 1, so w grows by 2 dwell/rho.
    """
    after = w + dwell_gain(scene)
    return after, 2.0 * scene.dwell / (np.sqrt(w) + np.sqrt(after)) if scene.dwell > 0.0 else 0.0


@inner_jit
def ends_alike(g_in, g_out, rho):
    """Whether rho + g^2 is the same at both ends of an engagement, but for a table's rounding.

    Without friction each engagement then adds the same energy, and no speed is terminal.
    Meyer's published cells are the only ones that end with another g than they begin with.
    """
    return abs((g_out - g_in) * (g_out + g_in)) <= 1e-12 * (rho + g_out * g_out)


@inner_jit
def side_at(g, dg, w, scene):
    """Side that carries the force where a piece begins: +1 or -1.

    It is the sign of X. At pin entry g is zero up to rounding, and X is too when the driver
    is at rest without a load: then the sign of g' decides, which is that of X just behind the
    entry. At the stop of a mesh g and g' are both zero, or the rounding errors of a table;
    the driver is then about to push the follower, and the side is +1.
    """
    value = contact(g, dg, w, scene)
    # g' below 1e-9 is taken for a table's rounding
    if abs(value) <= 1e-12 * (1.0 + abs(scene.rho * dg * w)):
        value = dg if abs(dg) > 1e-9 else 1.0
    return 1.0 if value >= 0.0 else -1.0


@jit
def tabulate(scene, theta, w, side, out):
    """Fill out[0:5] with g, g', theta_ddot, contact moment and X at each angle."""
    for i in range(theta.size):
        g, u, dg = transmission_at(scene.path, theta[i])
        out[0, i] = g
        out[1, i] = dg
        out[2, i] = acceleration(g, u, dg, w[i], side, scene)
        out[3, i] = contact_moment(g, u, dg, w[i], side, scene)
        out[4, i] = contact(g, dg, w[i], scene)
