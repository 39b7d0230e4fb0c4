"""Closed forms of Geneva wheels: Filemon's (2) to (5) and (7) to (10).

With c = sin(pi/n), the crank radius over the centre distance, and s = -1 for an
external and +1 for an internal wheel,

    g  = c (cos b + s c) / L,    L = 1 + c^2 + 2 s c cos b
    g' = -c (1 - c^2) sin b / L^2

over |b| <= pi/2 + s pi/n. All functions take one number of slots or an array of
them; angles are in rad.
"""

import numpy as np
from numpy.typing import ArrayLike

from escapement.model import FloatArray


def crank_ratio(slots: ArrayLike) -> FloatArray:
    """Filemon's c, crank radius over centre distance [-]."""
    return np.sin(np.pi / np.asarray(slots, dtype=float))


def engagement_half(slots: ArrayLike, internal: bool = False) -> FloatArray:
    """Driver angle from dead centre to the pin's exit, Filemon's beta_0."""
    turn = np.pi / np.asarray(slots, dtype=float)
    return 0.5 * np.pi + (turn if internal else -turn)


def ratio_max(slots: ArrayLike, internal: bool = False) -> FloatArray:
    """Greatest transmission, at dead centre: c/(1 - c), internal c/(1 + c) [-]."""
    c = crank_ratio(slots)
    return c / (1.0 + c) if internal else c / (1.0 - c)


def acceleration_start(slots: ArrayLike) -> FloatArray:
    """g' at pin entry, tan(pi/n) for either kind (Filemon 4) [-]."""
    return np.tan(np.pi / np.asarray(slots, dtype=float))


def acceleration_max_angle(slots: ArrayLike, internal: bool = False) -> FloatArray:
    """Distance from dead centre where |g'| is greatest (Filemon 5).

    An internal wheel's |g'| grows all the way to the exit: the root of g'' lies
    beyond it for every n, since sqrt((1 + c^2)^2 + 32 c^2) > 1 + 5 c^2.
    """
    if internal:
        return engagement_half(slots, internal)
    c = crank_ratio(slots)
    k = (1.0 + c * c) / (4.0 * c)
    return np.arccos(2.0 / (k + np.sqrt(k * k + 2.0)))


def acceleration(slots: ArrayLike, angle: ArrayLike, internal: bool = False) -> FloatArray:
    """g' at driver angles from dead centre (Filemon 3) [-]."""
    c, b = crank_ratio(slots), np.asarray(angle, dtype=float)
    square = np.sin(0.5 * b) ** 2
    # in half angles L keeps its accuracy at dead centre, where it is smallest
    length = (1.0 + c) ** 2 - 4.0 * c * square if internal else (1.0 - c) ** 2 + 4.0 * c * square
    result: FloatArray = -c * (1.0 - c * c) * np.sin(b) / length**2
    return result


def acceleration_max(slots: ArrayLike, internal: bool = False) -> FloatArray:
    """Greatest g' over the engagement, before dead centre [-]."""
    if internal:
        return acceleration_start(slots)
    return acceleration(slots, -acceleration_max_angle(slots))


def reversal_limits(slots: ArrayLike, internal: bool = False) -> tuple[FloatArray, FloatArray]:
    """F12 = 1/max g' and F23 = cot(pi/n) (Filemon 8 and 9) [-].

    Up to F12 the pin stays on one side of its slot; between F12 and F23 it
    changes sides twice, from F23 on once. Internal wheels have F12 = F23.
    """
    return 1.0 / acceleration_max(slots, internal), 1.0 / acceleration_start(slots)


def mean_factors(slots: ArrayLike, internal: bool = False) -> tuple[FloatArray, FloatArray]:
    """D and A of the mean torque over the first half, D (1 + F A) (Filemon 10).

    D = (pi/n)/beta_0, A = n g_max^2/(2 pi): work on the load, and kinetic energy.
    """
    n = np.asarray(slots, dtype=float)
    d = 2.0 / (n + 2.0) if internal else 2.0 / (n - 2.0)
    return d, n / (2.0 * np.pi) * ratio_max(slots, internal) ** 2


def limit_angle(slots: ArrayLike) -> FloatArray:
    """Angle of the greatest torque as F grows beyond bounds, external wheel [rad].

    The middle root cos b of the cubic (12), x^3 + a x^2 - b x + d = 0 with
    a = (1 - c^2)/c, b = (5 + c^2)/2, d = (5 c^2 - 1)/(2 c), in its trigonometric
    form; the unknown of the reduced cubic is x + a/3, not x as printed.
    """
    c = crank_ratio(slots)
    a, b, d = (1.0 - c * c) / c, 0.5 * (5.0 + c * c), (5.0 * c * c - 1.0) / (2.0 * c)
    p = -a * a / 3.0 - b
    q = 2.0 * a**3 / 27.0 + a * b / 3.0 + d
    size = np.sqrt(-p / 3.0)
    turn = np.arccos(np.clip(-0.5 * q / size**3, -1.0, 1.0)) / 3.0
    result: FloatArray = -np.arccos(2.0 * size * np.cos(turn) - a / 3.0)
    return result
