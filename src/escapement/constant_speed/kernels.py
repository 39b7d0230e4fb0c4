"""Kernels of constant driver speed: the core's equation with theta_ddot = 0.

    g, g', u     transmission and relative sliding of the pin, see mechanisms
    N R          moment of the pin on the follower, load + I_f omega^2 g'
    p            ratio as friction bends it, g + s mu |u|, s the sign of N R
    torque       p N R / eta where the driver works, eta p N R where it is driven

With mu = 0 the torque is Filemon's (6), whose 1/eta holds for the driving part.
"""

import numpy as np

from escapement.jit import jit
from escapement.mechanisms.slotted import transmission_at
from escapement.scene import Path

_ROUNDING = 8.0 * np.finfo(np.float64).eps  # an F this close to a limit is the limit


@jit
def tabulate_torque(path, theta, load, inertial, mu, eta, out):
    """Fill out[0:3] with g, contact moment and drive torque at each angle.

    load is the load torque at each angle, inertial = I_f omega^2, both [N m].
    """
    for i in range(theta.size):
        g, u, dg = transmission_at(path, theta[i])
        moment = load[i] + inertial * dg
        side = 1.0 if moment >= 0.0 else -1.0
        torque = (g + side * mu * abs(u)) * moment
        out[0, i] = g
        out[1, i] = moment
        out[2, i] = torque / eta if torque >= 0.0 else torque * eta


@jit
def tabulate_ratio(path, theta, sign, mu, out):
    """Fill `out` with the ratio as friction bends it, for one side of the slot."""
    for i in range(theta.size):
        g, u, _dg = transmission_at(path, theta[i])
        out[i] = g + sign * mu * abs(u)


@jit
def derivatives_at(path, theta):
    """(g, g', g'', g''') of a slotted path, from u' = a b - (a + b) g - u^2 + g^2."""
    g, u, dg = transmission_at(path, theta)
    total = path.numbers[6] - 2.0 * g
    du = 0.25 * path.numbers[6] ** 2 - path.numbers[0] ** 2 - path.numbers[6] * g - u * u + g * g
    ddu = -dg * total - 2.0 * u * du
    return (
        g,
        dg,
        du * total - 2.0 * u * dg,
        ddu * total - 4.0 * du * dg - 2.0 * u * (du * total - 2.0 * u * dg),
    )


@jit
def _reversal_between(path, ratio, inner, outer):
    """Root of 1 + F g' between `inner` and `outer`, where it changes sign."""
    rising = 1.0 + ratio * derivatives_at(path, outer)[1] > 0.0
    theta = 0.5 * (inner + outer)
    for _ in range(100):
        _g, dg, ddg, _dddg = derivatives_at(path, theta)
        value = 1.0 + ratio * dg
        if (value > 0.0) == rising:
            outer = theta
        else:
            inner = theta
        guess = theta - value / (ratio * ddg)
        if not inner < guess < outer:
            guess = 0.5 * (inner + outer)
        if abs(guess - theta) <= 1e-16 * abs(theta):
            break
        theta = guess
    return theta


@jit
def _maximum_after(path, ratio, entry):
    """Where g (1 + F g') is greatest before dead centre: the one root of its slope."""
    inner, outer = entry, 0.0
    theta = 0.5 * entry
    for _ in range(100):
        g, dg, ddg, dddg = derivatives_at(path, theta)
        value = dg + ratio * (dg * dg + g * ddg)
        if value > 0.0:
            inner = theta
        else:
            outer = theta
        guess = theta - value / (ddg + ratio * (3.0 * dg * ddg + g * dddg))
        if not inner < guess < outer:
            guess = 0.5 * (inner + outer)
        if abs(guess - theta) <= 1e-16 * abs(entry):
            break
        theta = guess
    return theta


@jit
def study(
    paths, corners, entry, steepest, limit_12, limit_23, wheel, ratio, zone, reversals, top, place
):
    """Zones, reversal angles and torque maxima of many wheels and inertia ratios.

    paths, entry, steepest, limit_12, limit_23 hold one row a wheel: numbers of its path, pin
    entry, angle of greatest deceleration and Filemon's limits; wheel and ratio,
    one entry a case, say which and at what F. The last four are filled: zone 1,
    2 or 3, two reversal angles or NaN, and the greatest g (1 + F g') with its angle.
    """
    for i in range(ratio.size):
        k, f = wheel[i], ratio[i]
        path = Path(False, paths[k], corners)
        reversals[i, 0] = reversals[i, 1] = np.nan
        zone[i] = 2
        if f <= limit_12[k] * (1.0 + _ROUNDING):
            zone[i] = 1
        elif f >= limit_23[k] * (1.0 - _ROUNDING):
            zone[i] = 3
        if zone[i] > 1:
            reversals[i, 0] = _reversal_between(path, f, 0.0, steepest[k])
        if zone[i] == 2:
            reversals[i, 1] = _reversal_between(path, f, steepest[k], -entry[k])
        place[i] = _maximum_after(path, f, entry[k])
        g, dg, _ddg, _dddg = derivatives_at(path, place[i])
        top[i] = g * (1.0 + f * dg)
