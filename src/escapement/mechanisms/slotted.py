"""The core of every slotted mechanism: a pin path of two rotating vectors.

With the origin on the follower's axis the pin moves along
C(theta) = P exp(i a theta) + Q exp(i b theta). A radial slot makes the follower
turn with arg C while the pin slides along R = |C|; with q = C'/C

    g  = Im q        transmission function                (Meyer 1-7, Filemon 2)
    u  = Re q        relative sliding speed R'/R
    g' = u (a+b-2g)  second-order transmission function   (Meyer 1-8, Filemon 3)

All three depend only on the half angle h = (a-b) theta/2. Writing them in sin(h)^2 keeps full
relative accuracy where |C| is small. C'/C is a Moebius function of exp(2ih), so (g, u) runs on a
circle between g1 at sin(h) = 0 and g2 at cos(h) = 0: u^2 = (g1 - g)(g - g2).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement.mechanisms.path import (
    EXIT,
    G0,
    G1,
    G2,
    HALF_RATE,
    L0,
    L1,
    OFFSET,
    PIN_RATE,
    RATE_SUM,
    TERMS,
    U1,
    Path,
    PinNumbers,
)
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.table import distance_at, ratio_at
from escapement.numerics.gauss import BLOCK
from escapement.numerics.jit import as_python, inner_jit, jit
from escapement.numerics.roots import newton_in_bracket


@inner_jit
def beside_axis(numbers, g, u, square):
    """g, u, g' and R in a slot whose line passes the axis at a distance delta, ahead of it.

    Given are g and u of a slot through the axis, and |C|^2. With q = C'/C and two rates a and b
    the slope of u is Re q' = a b - (a + b) g + g^2 - u^2.
    """
    total, offset = numbers[RATE_SUM], numbers[OFFSET]
    slope = 0.25 * total**2 - numbers[HALF_RATE] ** 2 - total * g + g * g - u * u
    radius = np.sqrt(square - offset * offset)
    slide = square * u / (radius * radius)
    dg = u * (total - 2.0 * g) + offset / radius * (slope - u * slide)
    return g + offset * u / radius, slide, dg, radius


@inner_jit
def is_meshed(path):
    """As `Path.meshed`, for kernels."""
    return path.table and path.numbers[TERMS] > 0.0


@jit
def offset_of(path):
    """Distance of the slot's line from the follower's axis."""
    return 0.0 if path.table else path.numbers[OFFSET]


@jit
def pose_at(path, theta):
    """Transmission (g, u, g') and distance R of the pin at one driver angle, from a path.

    Of a pin path, with its `PinNumbers`: L = L0 + L1 sin^2 h, g = (G0 + G1 sin^2 h)/L,
    u = U1 sin h cos h/L, g' = u (a + b - 2 g) and R^2 = L, unless the slot's line passes the
    follower's axis at a distance. Where g is zero at the exit r and at the entry -r, its numerator
    is G1 sin(h - h_r) sin(h + h_r), as accurate as the distance from there; this matters most if
    the follower's inertia is many times the driver's. Otherwise r is 0 and G2 = G0.

    Of a table: g and g' from its series, and R and u = R'/R where it has a second one. Otherwise
    u = g, because the loss in gears is proportional to g, and R = 1.
    """
    c = path.numbers
    if path.table:
        g, dg = ratio_at(c, theta)
        if is_meshed(path):
            return g, g, dg, 1.0
        radius, slope = distance_at(c, theta)
        return g, slope / radius, dg, radius
    half = c[HALF_RATE] * theta
    sine = np.sin(half)
    square = sine * sine
    length = c[L0] + c[L1] * square
    before, behind = c[HALF_RATE] * (theta - c[EXIT]), c[HALF_RATE] * (theta + c[EXIT])
    g = (c[G2] + c[G1] * (np.sin(before) * np.sin(behind))) / length
    u = c[U1] * sine * np.cos(half) / length
    if c[OFFSET] != 0.0:
        return beside_axis(c, g, u, length)
    return g, u, u * (c[RATE_SUM] - 2.0 * g), np.sqrt(length)


@inner_jit
def angle_in_slot(path, theta):
    """Follower angle of a Geneva wheel at a driver angle, 0 at dead centre of a slot through the
    axis."""
    c, sense = path.numbers, path.numbers[PIN_RATE]
    centre, sine, cosine = 0.25 * abs(c[L1]), np.sin(theta), np.cos(theta)
    square = 1.0 + centre * (centre + 2.0 * sense * cosine)
    radius = np.sqrt(square - c[OFFSET] * c[OFFSET])
    return np.arctan2(sine, centre + sense * cosine) - np.arctan2(c[OFFSET], radius)


@jit
def transmission_at(path, theta):
    """Transmission (g, u, g') at one driver angle, from a mechanism's path."""
    g, u, dg, _radius = pose_at(path, theta)
    return g, u, dg


@jit
def slide_change(path, pin, side, entry, exit_):
    """Driver angle at which a pin of radius `pin` reverses its direction of sliding on a wall.

    There v = V + s pin (g - beta) is zero: the contact point crosses the line of centres. An
    ideal pin does so at dead centre on either side s. The result is NaN where v does not change
    its sign between the entry and the exit.
    """
    c = path.numbers
    low, high, theta = entry, exit_, 0.0
    product = 0.25 * c[RATE_SUM] ** 2 - c[HALF_RATE] ** 2
    g, u, _dg, radius = pose_at(path, entry)
    at_entry = radius * u + side * pin * (g - c[PIN_RATE])
    g, u, _dg, radius = pose_at(path, exit_)
    at_exit = radius * u + side * pin * (g - c[PIN_RATE])
    if not at_entry * at_exit < 0.0:
        return np.nan
    for _ in range(100):
        g, u, dg, radius = pose_at(path, theta)
        value = radius * u + side * pin * (g - c[PIN_RATE])
        # V' = Re C''/C R, of a path with two rates a and b
        slope = radius * (product - c[RATE_SUM] * g + g * g) + side * pin * dg
        guess, low, high = newton_in_bracket(theta, value, slope, low, high, at_exit > 0.0)
        step = abs(guess - theta)
        theta = guess
        if step <= 1e-15:
            break
    return theta


@jit(allocates=True)
def slide_edges(path, pin, edges):
    """Entry, slide changes on either wall and exit: driver angles between which p is smooth."""
    entry, exit_ = edges[0], edges[-1]
    one = slide_change(path, pin, 1.0, entry, exit_)
    two = slide_change(path, pin, -1.0, entry, exit_)
    if one > two:
        one, two = two, one
    found = np.empty(4)
    found[0], used = entry, 1
    for angle in (one, two):
        # both are the same where the pin is thin
        if angle - found[used - 1] > 1e-9 and exit_ - angle > 1e-9:
            found[used] = angle
            used += 1
    found[used] = exit_
    return found[: used + 1]


@jit
def circle(path):
    """g1 and g2 of a pin path: where the circle that (g, u) runs on meets u = 0.

    At a pin exit g is zero and u^2 = -g1 g2. For a pin that almost meets the follower's axis the
    numbers of the path would give this as a difference without valid digits.
    """
    c = path.numbers
    first = c[G0] / c[L0]
    if c[EXIT] > 0.0:
        slide = transmission_at(path, c[EXIT])[1]
        return first, -slide * slide / first
    return first, (c[G0] + c[G1]) / (c[L0] + c[L1])


@inner_jit
def transmission_on(path, left, half, points, count, g, u, dg, radius):
    """Fill g, u, g' and R at the driver angles left + half (1 + points[i]), i < count.

    `count` is `BLOCK`, but the compiler must not know it: it makes vector code only of a
    loop whose length it does not know. The sine and cosine of the steps come from their
    power series, accurate to rounding for half angles of up to 0.75; those of the sums from
    the addition theorem.
    """
    c = path.numbers
    step = c[HALF_RATE] * half
    if path.table or abs(step) > 0.75:
        for i in range(BLOCK):
            theta = left + half * (1.0 + points[i])
            g[i], u[i], dg[i], radius[i] = pose_at(path, theta)
        return
    middle = c[HALF_RATE] * (left + half)
    sine_m, cosine_m = np.sin(middle), np.cos(middle)
    # the distance to an exit next to `left` is exact; the angle of the middle is not
    before, behind = (
        c[HALF_RATE] * ((left - c[EXIT]) + half),
        c[HALF_RATE] * ((left + c[EXIT]) + half),
    )
    sine_b, cosine_b = np.sin(before), np.cos(before)
    sine_a, cosine_a = np.sin(behind), np.cos(behind)
    l0, l1, g1, u1, total, g2 = c[L0], c[L1], c[G1], c[U1], c[RATE_SUM], c[G2]
    for i in range(count & BLOCK):
        d = step * points[i]
        z = d * d
        odd = 1.0 - z * (1.0 / 210.0) * (1.0 - z * (1.0 / 272.0) * (1.0 - z * (1.0 / 342.0)))
        odd = 1.0 - z * (1.0 / 72.0) * (1.0 - z * (1.0 / 110.0) * (1.0 - z * (1.0 / 156.0) * odd))
        odd = d * (
            1.0 - z * (1.0 / 6.0) * (1.0 - z * (1.0 / 20.0) * (1.0 - z * (1.0 / 42.0) * odd))
        )
        even = 1.0 - z * (1.0 / 182.0) * (1.0 - z * (1.0 / 240.0) * (1.0 - z * (1.0 / 306.0)))
        even = 1.0 - z * (1.0 / 56.0) * (1.0 - z * (1.0 / 90.0) * (1.0 - z * (1.0 / 132.0) * even))
        even = 1.0 - z * 0.5 * (1.0 - z * (1.0 / 12.0) * (1.0 - z * (1.0 / 30.0) * even))
        sine = sine_m * even + cosine_m * odd
        cosine = cosine_m * even - sine_m * odd
        length = l0 + l1 * sine * sine
        inverse = 1.0 / length
        product = (sine_b * even + cosine_b * odd) * (sine_a * even + cosine_a * odd)
        ratio = (g2 + g1 * product) * inverse
        slide = u1 * sine * cosine * inverse
        g[i], u[i], dg[i] = ratio, slide, slide * (total - 2.0 * ratio)
        radius[i] = np.sqrt(length)
    if c[OFFSET] != 0.0:
        for i in range(count & BLOCK):
            pose = beside_axis(c, g[i], u[i], radius[i] * radius[i])
            g[i], u[i], dg[i], radius[i] = pose


@jit
def _tabulate(path, theta, g, u, dg):
    for i in range(theta.size):
        g[i], u[i], dg[i] = transmission_at(path, theta[i])


@dataclass(frozen=True)
class Transmission:
    """Transmission over driver angle: arrays of one shape.

    g : first-order transmission function, follower over driver speed [-].
    u : relative sliding of the pin along the slot, R'/R [-].
    dg : derivative of g by driver angle [-].
    """

    g: FloatArray
    u: FloatArray
    dg: FloatArray


def two_vector_path(
    p: float, a: float, q: float, b: float, forward: float, rest: float = 0.0
) -> Path:
    """Path of a pin that moves along C = p exp(i a theta) + q exp(i b theta).

    Parameters
    ----------
    p, q : float
        Vector lengths, in crank radii [-].
    a, b : float
        Their turns per turn of the driver [-].
    forward : float
        +1 or -1: the sense in which the follower angle is counted.
    rest : float
        Pin exit, where g is zero [rad]; 0 for a pin whose exit is elsewhere.

    Returns
    -------
    Path
        With the `PinNumbers` that `pose_at` reads.
    """
    numbers = as_python(path_numbers)(p, a, q, b, forward, rest, 0.0)
    return Path(False, np.array(numbers))


@inner_jit
def path_numbers(p, a, q, b, forward, rest, offset):
    """`PinNumbers` of the arguments of `two_vector_path` and a slot's offset, see `beside_axis`."""
    total, product = p + q, p * q
    ratio = forward * total * (a * p + b * q)
    return PinNumbers(
        half_rate=(a - b) / 2.0, l0=total * total, l1=-4.0 * product, g0=ratio,
        g1=-2.0 * forward * product * (a + b), u1=-2.0 * product * (a - b),
        rate_sum=forward * (a + b), exit=rest, g2=0.0 if rest else ratio, pin_rate=forward * b,
        offset=offset,
    )  # fmt: skip


def transmission(path: Path, theta: ArrayLike) -> Transmission:
    """Transmission of a path at driver angles of any shape [rad]."""
    angles = np.asarray(theta, dtype=float)
    flat = np.ascontiguousarray(angles).reshape(-1)
    g, u, dg = np.empty_like(flat), np.empty_like(flat), np.empty_like(flat)
    _tabulate(path, flat, g, u, dg)
    return Transmission(*(values.reshape(angles.shape) for values in (g, u, dg)))


def jerk(path: Path, found: Transmission) -> FloatArray:
    """g'' where the transmission is known: q' = a b + i (a + b) q - q^2 and g' = u (a+b-2g)."""
    total = path.numbers[RATE_SUM]
    slope = (
        0.25 * total**2 - path.numbers[HALF_RATE] ** 2 - total * found.g - found.u**2 + found.g**2
    )
    result: FloatArray = slope * (total - 2.0 * found.g) - 2.0 * found.u * found.dg
    return result


def radius(path: Path, theta: ArrayLike) -> FloatArray:
    """Distance of the pin from the follower's axis, in crank radii; NaN without a pin."""
    if path.table:
        return np.full(np.shape(theta), np.nan)
    c = path.numbers
    sine = np.sin(c[HALF_RATE] * np.asarray(theta, dtype=float))
    result: FloatArray = np.sqrt(c[L0] + c[L1] * sine * sine)
    return result
