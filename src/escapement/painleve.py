"""The Painleve limit: the friction at which the equation of motion loses its solution.

Where the reduced inertia J_s = rho + g p_s vanishes the rigid problem has two solutions or
none. The side in question is the one that holds the follower back, s = -sign(g).
"""

import numpy as np

from escapement.jit import inner_jit, jit
from escapement.mechanisms.slotted import circle, transmission_at
from escapement.model import Inertia, Mechanism
from escapement.roots import newton_in_bracket


@jit
def painleve_ratio(path, theta, rho):
    """Friction at which the reduced inertia vanishes at `theta`, or inf."""
    g, u, _dg = transmission_at(path, theta)
    product = abs(g * u)
    return (rho + g * g) / product if product > 0.0 else np.inf


@inner_jit
def _stationary(g1, g2, rho, end):
    """g between 0 and `end` at which (rho + g^2)/(|g| |u|) is stationary on the circle.

    It is a root of the cubic in `critical_friction`. The cubic is negative at 0 and positive at
    g1 and g2, of which `end` is one, so Newton's method kept in that bracket cannot fail.
    """
    total, product = g1 + g2, g1 * g2
    low, high = min(0.0, end), max(0.0, end)
    g = 0.5 * end
    for _ in range(200):
        value = ((total * g + 4.0 * rho - 2.0 * product) * g - 3.0 * rho * total) * g
        value += 2.0 * rho * product
        slope = (3.0 * total * g + 8.0 * rho - 4.0 * product) * g - 3.0 * rho * total
        guess, low, high = newton_in_bracket(g, value, slope, low, high, end > 0.0)
        if abs(guess - g) <= 1e-15 * abs(g):
            break
        g = guess
    return g


@jit
def painleve_limit(path, rho, entry, exit_):
    """Least painleve_ratio over the engagement, and a driver angle that has it."""
    if path.table:
        return np.inf, entry
    limit, angle = painleve_ratio(path, entry, rho), entry
    at_exit = painleve_ratio(path, exit_, rho)
    if at_exit < limit:
        limit, angle = at_exit, exit_
    c = path.numbers
    g1, g2 = circle(path)
    for end in (g1, g2):
        g = _stationary(g1, g2, rho, end)
        # solve g = (G0 + G1 x)/(L0 + L1 x) for x, the squared sine of the half angle
        x = (g * c[1] - c[3]) / (c[4] - g * c[2])
        if not 0.0 < x <= 1.0:
            continue
        turn = np.arcsin(np.sqrt(x)) / abs(c[0])
        for theta in (-turn, turn):
            place = min(max(theta, entry), exit_)
            # the angle lies outside the engagement by more than its rounding
            if abs(place - theta) > 1e-15 * abs(theta):
                continue
            # |u| comes from the circle: with a light driver the minimum lies so close to the
            # exit that no double for the angle gives g to enough digits
            ratio = (rho + g * g) / (abs(g) * np.sqrt((g1 - g) * (g - g2)))
            if ratio < limit:
                limit, angle = ratio, place
    return limit, angle


@inner_jit
def beyond_painleve(scene):
    """Whether friction is at or above the Painleve limit.

    (rho + g^2)/|g| is at least 2 sqrt(rho), and |u| is at most the radius of the circle that
    (g, u) runs on. This bound settles most scenes. For most others the stationary g on the
    circle is enough, without the driver angle that belongs to it. A mesh has no such limit,
    because J_s = rho + g^2 eta is positive.
    """
    if scene.path.table:
        return False
    # Where g > 0 the side s = -1 may lose its J. One of Meyer's published cells also has g < 0,
    # where s = +1 may, but its pins have one mu and the limit there is higher.
    mu, rho = scene.mu_minus, scene.rho
    g1, g2 = circle(scene.path)
    if mu * abs(g1 - g2) < 4.0 * np.sqrt(rho) * (1.0 - 1e-12):
        return False
    if g2 < 0.0 < g1:
        # g rises from 0 at entry to g1 at dead centre, so the stationary g is passed
        g = _stationary(g1, g2, rho, g1)
        # the friction over its limit, mu |g u|/(rho + g^2)
        share = mu * g * np.sqrt((g1 - g) * (g - g2)) / (rho + g * g)
        if abs(share - 1.0) > 1e-9:
            return share > 1.0
    return mu >= painleve_limit(scene.path, rho, scene.edges[0], scene.edges[-1])[0]


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
    breaks = mechanism.breaks
    rho = inertia.driver / inertia.follower
    result: float = painleve_limit(mechanism.path, rho, breaks[0], breaks[-1])[0]
    return result


def critical_angle(mechanism: Mechanism, inertia: Inertia, friction: float) -> float:
    """First driver angle of a cell where `friction` meets the Painleve limit.

    Returns
    -------
    float
        Angle from dead centre [rad]; NaN when friction is below the limit.
    """
    rho = inertia.driver / inertia.follower
    path, entry, exit_ = mechanism.path, mechanism.breaks[0], mechanism.breaks[-1]
    limit, angle = painleve_limit(path, rho, entry, exit_)
    if friction < limit:
        return float("nan")
    if painleve_ratio(path, entry, rho) <= friction:
        return entry
    from scipy.optimize import brentq

    # |g u| is even about dead centre and repeats with every half turn of the half angle
    period = np.pi / abs(path.numbers[0])
    first = min(
        place
        for turn in (-abs(angle), abs(angle))
        for place in turn + period * np.arange(np.ceil((entry - turn) / period), 1.0)
        if entry <= place <= exit_
    )
    if painleve_ratio(path, first, rho) >= friction:
        return float(first)
    return float(brentq(lambda theta: painleve_ratio(path, theta, rho) - friction, entry, first))


def painleve_message(mechanism: Mechanism, inertia: Inertia, friction: float) -> str | None:
    """Why no motion can be computed, or None below the limit."""
    limit = critical_friction(mechanism, inertia)
    if friction < limit:
        return None
    angle = np.degrees(critical_angle(mechanism, inertia, friction))
    return (
        f"friction {friction:g} is at or above the Painleve limit {limit:.6g}, first met "
        f"{angle:.3f} degrees from dead centre: no unique rigid motion exists"
    )
