"""Geneva wheels: Filemon's closed forms (2) to (5) and (7) to (10), and a million drives at once.

With c = sin(pi/n), the crank radius over the centre distance, and s = -1 for an
external and +1 for an internal wheel,

    g  = c (cos b + s c) / L,    L = 1 + c^2 + 2 s c cos b
    g' = -c (1 - c^2) sin b / L^2

over |b| <= pi/2 + s pi/n. All functions take one number of slots or an array of
them; angles are in rad.
"""

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.text import Shown
from escapement.mechanisms import Geneva
from escapement.mechanisms.geneva import MOST_SLOTS
from escapement.mechanisms.path import HALF_RATE, RATE_SUM, Path
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import transmission_at
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.roots import newton_in_bracket

_ROUNDING = 8.0 * np.finfo(np.float64).eps  # an F this close to a limit is the limit


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
    return np.asarray(-c * (1.0 - c * c) * np.sin(b) / length**2)


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
    return np.asarray(-np.arccos(2.0 * size * np.cos(turn) - a / 3.0))


def fewest_slots(inertia_ratio: float, internal: bool = False) -> int:
    """Least number of slots of a Geneva wheel without a pin reversal at F.

    Parameters
    ----------
    inertia_ratio : float
        F = I_f omega^2/M_load [-], >= 0.
    internal : bool
        Whether the wheel is an internal one.

    Raises
    ------
    InvalidValue
        When F is below 0, or too great even for a million slots, the most that a
        `Geneva` has.
    """
    remedy = "give F = I_f omega^2/M_load"
    ratio = validate.non_negative("inertia_ratio", inertia_ratio, remedy)
    # F12 grows with the number of slots, so bisection over the numbers finds the first
    fewest = 3 + bisect_left(
        range(3, MOST_SLOTS + 1), ratio, key=lambda n: float(reversal_limits(n, internal)[0])
    )
    if fewest > MOST_SLOTS:
        raise InvalidValue(
            f"inertia_ratio must be below the limit of all wheels with up to {MOST_SLOTS:,} "
            f"slots, got {ratio!r}; lower the speed or the inertia, or brake the follower"
        )
    return fewest


@dataclass(frozen=True, repr=False)
class ReversalStudy(Shown):
    """Filemon's figures over numbers of slots n and inertia ratios F.

    All except `reversals` have the shape to which n and F broadcast. Torques are those of a drive
    without losses, over the load torque.

    slots, inertia_ratio : n and F [-].
    zone : 1, 2 or 3 (u1).
    reversals : driver angles from dead centre [rad], shape (..., 2); NaN for
        one that is not there.
    torque_max, torque_max_angle : greatest torque [-] and its angle [rad].
    torque_mean : mean from pin entry to dead centre (10) [-].
    """

    slots: np.ndarray
    inertia_ratio: FloatArray
    zone: np.ndarray
    reversals: FloatArray
    torque_max: FloatArray
    torque_max_angle: FloatArray
    torque_mean: FloatArray

    @property
    def reversal_count(self) -> np.ndarray:
        """Pin reversals an engagement: 0, 2 or 1 in zone 1, 2 or 3."""
        return np.asarray(np.array([0, 0, 2, 1])[self.zone])

    @property
    def peak_to_mean(self) -> FloatArray:
        """Filemon's s, greatest over mean torque [-]."""
        return self.torque_max / self.torque_mean


def reversal_study(
    slots: ArrayLike, inertia_ratio: ArrayLike, internal: bool = False
) -> ReversalStudy:
    """Zones, reversal angles, greatest and mean torque of many Geneva drives.

    Without friction, under a constant load; about a microsecond a case.

    Parameters
    ----------
    slots : array_like of int
        Numbers of slots n, >= 3.
    inertia_ratio : array_like
        F = I_f omega^2/M_load [-], >= 0; broadcast against `slots`.
    internal : bool
        Whether the wheels are internal ones.

    Raises
    ------
    InvalidValue
        When a number of slots or an F breaks its rule.
    ValueError
        When the shapes of both do not fit.

    Source: Filemon (1960), eqs. 7 to 11.
    """
    ratio = validate.numbers("inertia_ratio", inertia_ratio, "give F = I_f omega^2/M_load")
    n = validate.numbers("slots", slots, "give numbers of slots")
    for name, values, wrong, rule in (
        ("slots", n, (n < 3) | (n != np.rint(n)), "whole numbers of at least 3"),
        ("inertia_ratio", ratio, ratio < 0.0, "at least 0"),
    ):
        if wrong.any():
            raise validate.fail(name, rule, values[wrong][0].item(), "correct it")
    n, ratio = np.broadcast_arrays(n.astype(int), ratio)
    # each wheel is made once, however many cases it has
    wheels, which = np.unique(n, return_inverse=True)
    which = which.reshape(n.shape)
    paths = [Geneva(int(count), pins=1, internal=internal).path.numbers for count in wheels]
    angles = acceleration_max_angle(wheels, internal), engagement_half(wheels, internal)
    lower, upper = (limit[which] for limit in reversal_limits(wheels, internal))
    # F12 and F23 themselves belong to the zones without a second reversal
    zones = np.where(ratio >= upper * (1.0 - _ROUNDING), 3, 2)
    zone = np.where(ratio <= lower * (1.0 + _ROUNDING), 1, zones).astype(np.uint8)
    reversals, top, at_top = np.full((n.size, 2), np.nan), np.empty(n.size), np.empty(n.size)
    every = which.flatten(), ratio.flatten(), zone.flatten()
    _fill(np.array(paths, dtype=float, ndmin=2), *angles, *every, reversals, top, at_top)
    d, a = (factor[which] for factor in mean_factors(wheels, internal))
    return ReversalStudy(
        slots=n, inertia_ratio=ratio, zone=zone, reversals=reversals.reshape(*n.shape, 2),
        torque_max=top.reshape(n.shape), torque_max_angle=at_top.reshape(n.shape),
        torque_mean=d * (1.0 + ratio * a),
    )  # fmt: skip


@inner_jit
def _derivatives_at(path, theta):
    """(g, g', g'', g''') of a slotted path, from u' = a b - (a + b) g - u^2 + g^2."""
    (g, u, dg), both = transmission_at(path, theta), path.numbers[RATE_SUM]
    total, product = both - 2.0 * g, 0.25 * both * both - path.numbers[HALF_RATE] ** 2
    du = product - both * g - u * u + g * g
    ddg, ddu = du * total - 2.0 * u * dg, -dg * total - 2.0 * u * du
    return g, dg, ddg, ddu * total - 4.0 * du * dg - 2.0 * u * ddg


@inner_jit
def _root(path, ratio, low, high, rising, of_torque):
    """Root between two angles of 1 + F g', or of the slope of the torque g (1 + F g')."""
    theta = 0.5 * (low + high)
    for _ in range(100):
        g, dg, ddg, dddg = _derivatives_at(path, theta)
        value, slope = 1.0 + ratio * dg, ratio * ddg
        if of_torque:
            value = dg + ratio * (dg * dg + g * ddg)
            slope = ddg + ratio * (3.0 * dg * ddg + g * dddg)
        guess, low, high = newton_in_bracket(theta, value, slope, low, high, rising)
        if abs(guess - theta) <= 1e-16 * abs(theta):
            break
        theta = guess
    return theta


@jit
def _fill(paths, steepest, exits, wheel, ratio, zone, reversals, top, at_top):
    """Reversal angles and torque maxima of many wheels and inertia ratios.

    paths, steepest, exits hold one row a wheel: numbers of its path, angle of greatest
    deceleration and pin exit; wheel, ratio and zone, one entry a case, say which wheel, at what
    F and in which zone. Filled are the two reversal angles of each case, which are NaN
    where there is none, the greatest g (1 + F g'), and its angle.
    """
    for i in range(ratio.size):
        k, f = wheel[i], ratio[i]
        path = Path(False, paths[k])
        # g' falls from dead centre to its least value and rises again towards the exit
        if zone[i] > 1:
            reversals[i, 0] = _root(path, f, 0.0, steepest[k], False, False)
        if zone[i] == 2:
            reversals[i, 1] = _root(path, f, steepest[k], exits[k], True, False)
        at_top[i] = _root(path, f, -exits[k], 0.0, False, True)
        g, dg, _ddg, _dddg = _derivatives_at(path, at_top[i])
        top[i] = g * (1.0 + f * dg)
