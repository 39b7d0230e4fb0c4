"""Kernels of constant driver speed: pin reversals and greatest torques of many Geneva drives."""

import numpy as np

from escapement.jit import inner_jit, jit
from escapement.mechanisms.slotted import transmission_at
from escapement.roots import newton_in_bracket
from escapement.scene import Path

_ROUNDING = 8.0 * np.finfo(np.float64).eps  # an F this close to a limit is the limit


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


@inner_jit
def _reversal_between(path, ratio, low, high, rising):
    """Root of 1 + F g' between two angles where it changes sign."""
    theta = 0.5 * (low + high)
    for _ in range(100):
        _g, dg, ddg, _dddg = derivatives_at(path, theta)
        guess, low, high = newton_in_bracket(
            theta, 1.0 + ratio * dg, ratio * ddg, low, high, rising
        )
        if abs(guess - theta) <= 1e-16 * abs(theta):
            break
        theta = guess
    return theta


@inner_jit
def _maximum_after(path, ratio, entry):
    """Where g (1 + F g') is greatest before dead centre: the one root of its slope."""
    low, high, theta = entry, 0.0, 0.5 * entry
    for _ in range(100):
        g, dg, ddg, dddg = derivatives_at(path, theta)
        value = dg + ratio * (dg * dg + g * ddg)
        slope = ddg + ratio * (3.0 * dg * ddg + g * dddg)
        guess, low, high = newton_in_bracket(theta, value, slope, low, high, False)
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
            reversals[i, 0] = _reversal_between(path, f, 0.0, steepest[k], False)
        if zone[i] == 2:
            reversals[i, 1] = _reversal_between(path, f, steepest[k], -entry[k], True)
        place[i] = _maximum_after(path, f, entry[k])
        g, dg, _ddg, _dddg = derivatives_at(path, place[i])
        top[i] = g * (1.0 + f * dg)
