"""The equation of motion, dimensionless, and the limit of its validity.

With the follower's inertia, the driving torque and sqrt(I_f/torque) as units of
inertia, torque and time, three numbers remain beside the mechanism:

    rho   driver over follower inertia         mu    friction of pin on slot
    load  load torque over driving torque

and with w = theta_dot^2, the side s = +1 or -1 of the slot that carries the
force and the ratio as friction bends it, p = g + s mu |u|,

    (rho + g p) theta_ddot + p (g' w + load) = 1
    contact moment on the follower  N R = (rho (g' w + load) + g) / (rho + g p)

With load = 0 this is Meyer's eq. 1-18/1-19, his S being s sign(sin theta).
"""

import numpy as np

from escapement._jit import jit
from escapement.mechanisms._slotted import transmission_at, transmission_extremes
from escapement.model import FloatArray, Inertia, Mechanism


@jit
def contact(g, dg, w, rho, load):  # type: ignore[no-untyped-def]
    """N R (rho + g p): its sign is the side of the slot that carries the force.

    Neither friction nor the side itself enters, so the side is explicit and
    unique below the Painleve limit. Its zero is Filemon's pin reversal.
    """
    return rho * (dg * w + load) + g


@jit
def effective_ratio(g, u, sign, mu):  # type: ignore[no-untyped-def]
    """Transmission function as friction bends it, p = g + s mu |u|."""
    return g + sign * mu * abs(u)


@jit
def acceleration(g, u, dg, w, sign, rho, mu, load):  # type: ignore[no-untyped-def]
    """Driver acceleration in units of torque / I_f."""
    p = effective_ratio(g, u, sign, mu)
    return (1.0 - p * (dg * w + load)) / (rho + g * p)


@jit
def contact_moment(g, u, dg, w, sign, rho, mu, load):  # type: ignore[no-untyped-def]
    """Moment N R on the follower in units of the driving torque."""
    return contact(g, dg, w, rho, load) / (rho + g * effective_ratio(g, u, sign, mu))


@jit
def side_at(g, dg, w, rho, load, slope_dg):  # type: ignore[no-untyped-def]
    """Side that carries the force: +1 or -1.

    On the reversal itself the contact function's change with driver angle
    decides; there theta_ddot = 1/rho whatever the side, `slope_dg` being g''.
    """
    value = contact(g, dg, w, rho, load)
    if value == 0.0:
        value = rho * slope_dg * w + 3.0 * dg
    return 1.0 if value >= 0.0 else -1.0


@jit
def tabulate(path, theta, w, sign, rho, mu, load, out):  # type: ignore[no-untyped-def]
    """Fill out[0:4] with g, g', theta_ddot and contact moment at each angle."""
    for i in range(theta.size):
        g, u, dg = transmission_at(path, theta[i])
        out[0, i] = g
        out[1, i] = dg
        out[2, i] = acceleration(g, u, dg, w[i], sign, rho, mu, load)
        out[3, i] = contact_moment(g, u, dg, w[i], sign, rho, mu, load)


def painleve_ratio(path: FloatArray, theta: float, rho: float) -> float:
    """Friction at which the reduced inertia vanishes at `theta`, or inf."""
    g, u, _ = transmission_at(path, theta)
    product = abs(g * u)
    return (rho + g * g) / product if product > 0.0 else np.inf


def critical_friction(mechanism: Mechanism, inertia: Inertia) -> float:
    """Painleve limit: least friction at which J_s reaches zero [-].

    At or above it the rigid-body problem has no solution or two. The load
    torque does not move it. Minimum over the engagement of
    (rho + g^2)/(|g| |u|); on a slotted path u^2 = (g1 - g)(g - g2), so the
    stationary points are roots of the cubic

        S g^3 + (4 rho - 2 P) g^2 - 3 rho S g + 2 rho P = 0,  S = g1 + g2, P = g1 g2,

    which for the external Geneva is T g^3 + (T + 2 rho) g^2 - 3 rho T g - rho T = 0
    with T = tan^2(pi/n).

    Returns
    -------
    float
        The limit; infinite where the pin never slides under force.
    """
    return _painleve_minimum(mechanism, inertia.driver / inertia.follower)[0]


def critical_angle(mechanism: Mechanism, inertia: Inertia, friction: float) -> float:
    """First driver angle of a cell where `friction` meets the Painleve limit.

    Returns
    -------
    float
        Angle from dead centre [rad]; NaN when friction is below the limit.
    """
    from scipy.optimize import brentq

    rho = inertia.driver / inertia.follower
    limit, angle = _painleve_minimum(mechanism, rho)
    if friction < limit:
        return float("nan")
    entry = mechanism.breaks[0]

    def margin(theta: float) -> float:
        return painleve_ratio(mechanism.path, theta, rho) - friction

    first = min(angle, -angle) if entry <= -abs(angle) else angle
    if margin(entry) <= 0.0:
        return entry
    return first if margin(first) >= 0.0 else float(brentq(margin, entry, first))


def _painleve_minimum(mechanism: Mechanism, rho: float) -> tuple[float, float]:
    """Least painleve_ratio over the engagement and a driver angle that has it."""
    path = mechanism.path
    first, second = transmission_extremes(path)
    total, product = first + second, first * second
    roots = np.roots([total, 4.0 * rho - 2.0 * product, -3.0 * rho * total, 2.0 * rho * product])
    entry, exit_ = mechanism.breaks[0], mechanism.breaks[-1]
    angles = [entry, exit_]
    for g in roots[np.abs(roots.imag) <= 1e-9 * np.abs(roots)].real:
        # g = (G0 + G1 x)/(L0 + L1 x) with x = sin^2 of the half angle
        x = (g * path[1] - path[3]) / (path[4] - g * path[2])
        if 0.0 < x <= 1.0:
            angle = np.arcsin(np.sqrt(x)) / abs(path[0])
            angles += [a for a in (-angle, angle) if entry < a < exit_]
    return min((painleve_ratio(path, a, rho), a) for a in angles)
