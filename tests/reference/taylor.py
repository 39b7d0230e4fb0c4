"""Motion of a Geneva escapement in 40-digit arithmetic, by Taylor series in the driver angle.

Written from the Lagrangian, without the package, to judge its engines.  With rho = I_d/I_f,
W = theta_dot^2 I_f/tau, m = M_f/tau and p = g + s mu |u|, Meyer's kinetic energy (1973, eq. 1-16)
T = (I_d + I_f g^2) theta_dot^2/2, the virtual work of torque, load and pin friction and
theta_ddot = d(theta_dot^2/2)/dtheta give on every piece of constant s

    (rho + g p) W' + 2 p g' W = 2 (1 - p m),        s = sign K,   K = rho (g' W + m) + g.

The step is where the last coefficients of every series in use fall below a tolerance.  Time is the
integral of the series of W^(-1/2); a start from rest has W ~ x, so its half-integer powers are
integrated term by term and no singularity is left.  Reversals are roots of K, smooth speed extrema
roots of W', both taken from the panel's own polynomials; corners of the speed are sign changes of
W' between panels.  The terminal cycle is Newton's fixed point of W_in -> W_out with the slope from
the homogeneous equation.

Angles in rad from dead centre; W, time and speed are dimensionless except where ``motion``,
``terminal`` and ``solve`` put the units back.
"""

from typing import NamedTuple

from mpmath import mp, mpf
from series import (
    cosine,
    derivative,
    inverse_root,
    linear_solution,
    product,
    quotient,
    reach,
    sign_changes,
    value,
)

ROUNDING = mpf("1e-25")  # separates zero from the smallest angle or moment that means something


class Case(NamedTuple):
    """Dimensionless problem; ``kind`` is +1 for an external wheel, -1 for an internal one."""

    a: mpf
    beta: mpf
    cell: mpf
    kind: int
    rho: mpf
    mu: mpf
    load: mpf


class Panel(NamedTuple):
    """Taylor coefficients about a panel's start and how far they may be trusted."""

    w: list
    slope: list
    contact: list
    tangent: list
    inverse_speed: list
    from_rest: bool
    reach: mpf


def transmission(case, angle, order):
    """Series of g, g' and u, from the pin's squared distance L and direction seen by the wheel."""
    cos = cosine(angle, order + 1)
    square = [-2 * case.kind * case.a * x for x in cos]
    square[0] += 1 + case.a**2
    g = [case.a * x for x in cos]
    g[0] -= case.kind
    g = quotient(g, square)
    u = [x / 2 for x in quotient(derivative(square), square[:-1])]
    return g[:-1], derivative(g), u


def contact_moment(case, w, g, dg):
    """K = N R J_s / (I_f tau): neither the friction nor its sign enters."""
    k = [case.rho * x + y for x, y in zip(product(dg, w), g, strict=True)]
    return [k[0] + case.rho * case.load, *k[1:]]


def initial_sign(case, angle, w):
    g, dg, _ = transmission(case, angle, 1)
    return 1 if contact_moment(case, [w, mpf(0)], g, dg)[0] >= -ROUNDING else -1


def panel(case, angle, sign, w0, setting, end):
    g, dg, u = transmission(case, angle, setting["order"])
    side = case.kind * (1 if end > 0 else -1)  # sign of u on this side of dead centre
    p = [x + sign * case.mu * side * y for x, y in zip(g, u, strict=True)]
    inertia = product(g, p)
    inertia[0] += case.rho
    damping = [2 * x for x in product(p, dg)]
    forcing = [-2 * case.load * x for x in p]
    forcing[0] += 2
    if inertia[0] <= 0:
        raise ArithmeticError("beyond the Painleve limit")
    w, slope = linear_solution(inertia, damping, forcing, w0)
    tangent, _ = linear_solution(inertia, damping, [mpf(0)] * len(g), mpf(1))
    grown = w if w0 else w[1:]  # from rest w = x * grown
    inverse_speed = inverse_root(grown)
    tolerance = mpf(setting["tolerance"])
    far = min(reach(x, tolerance) for x in (g, dg, grown, tangent, inverse_speed))
    contact = contact_moment(case, w, g, dg)
    return Panel(w, slope, contact, tangent, inverse_speed, not w0, far)


def panels(case, start, end, w, setting):
    """March across one smooth piece: (angle, length, panel, whether it ends in a reversal)."""
    angle, sign = start, initial_sign(case, start, w)
    while angle < end:
        here = panel(case, angle, sign, w, setting, end)
        change = derivative(here.contact)
        h = min(here.reach, end - angle)
        # A restart at a reversal has a rounding-error root at 0; its direction is the other one.
        falls = [x for x in sign_changes(here.contact, h) if sign * value(change, x) < 0]
        h = min([h, *falls])
        yield angle, h, here, bool(falls)
        w = value(here.w, h)
        if w <= 0:
            raise ArithmeticError("the driver stalls")
        sign = -sign if falls else sign
        angle = end if h == end - angle else angle + h


def elapsed(here, h):
    """Time across the first h of a panel, in units of sqrt(I_f/tau)."""
    half = mpf(1) / 2 if here.from_rest else mpf(1)
    return h**half * value([c / (k + half) for k, c in enumerate(here.inverse_speed)], h)


def note_extrema(log, rising, angle, h, here, time):
    """Log the panel's speed extrema (angle, time, speed, maximum); return if speed last rose."""
    turns = sign_changes(here.slope, h)
    initially = value(here.slope, h * mpf("1e-9")) > 0
    if rising is not None and initially != rising:
        log.append((angle, time, mp.sqrt(here.w[0]), rising))
    up = initially
    for x in turns:
        log.append((angle + x, time + elapsed(here, x), mp.sqrt(value(here.w, x)), up))
        up = not up
    return up


def engage(case, w, setting, rising=None):
    """One cell from pin entry to the handoff.

    Returns W, the time, dW_out/dW_in, the lists of reversals (angle, time) and extrema, and whether
    the speed last rose; ``rising`` is what the cell before returned.
    """
    time, gain, reversals, extrema = mpf(0), mpf(1), [], []
    for start, end in ((-case.beta, mpf(0)), (mpf(0), case.beta)):
        for angle, h, here, reverses in panels(case, start, end, w, setting):
            rising = note_extrema(extrema, rising, angle, h, here, time)
            time, gain, w = time + elapsed(here, h), gain * value(here.tangent, h), value(here.w, h)
            if reverses:
                reversals.append((angle + h, time))
    dwell = case.cell - 2 * case.beta
    if dwell > ROUNDING:
        if not rising:
            extrema.append((case.beta, time, mp.sqrt(w), False))
        leaving = w + 2 * dwell / case.rho
        time += 2 * dwell / (mp.sqrt(w) + mp.sqrt(leaving))
        w, rising = leaving, True
    return w, time, gain, reversals, extrema, rising


def dimensionless(data):
    """The problem and its units of speed and time, at the current precision."""
    kind = -1 if data["internal"] else 1
    names = ("driver_inertia", "follower_inertia", "torque", "friction", "load_torque")
    driver, follower, torque, mu, load = (mpf(data[name]) for name in names)
    step = mp.pi / data["slots"]
    beta, cell = mp.pi / 2 - kind * step, 2 * mp.pi / data["pins"]
    case = Case(1 / mp.sin(step), beta, cell, kind, driver / follower, mu, load / torque)
    return case, mp.sqrt(torque / follower), mp.sqrt(follower / torque)


def motion(case, data, setting, speed, second):
    """Handoffs, reversals and extrema in the units of the data, and the last W."""
    w, time, rising = (mpf(data["initial_speed"]) / speed) ** 2, mpf(0), None
    times, velocities, reversals, extrema = [], [], [], []
    for k in range(data["engagements"]):
        w, spent, _, turned, peaks, rising = engage(case, w, setting, rising)
        reversals += [(k, x, (time + t) * second) for x, t in turned]
        extrema += [(k, x, (time + t) * second, v * speed, up) for x, t, v, up in peaks]
        time += spent
        times.append(time * second)
        velocities.append(mp.sqrt(w) * speed)
    names = ("engagement", "angle", "time", "velocity", "maximum")
    found = {
        "handoff_times": times,
        "handoff_velocities": velocities,
        "reversals": columns(names[:3], reversals),
        "extrema": columns(names, extrema),
    }
    return found, w


def columns(names, rows):
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}


def terminal(case, setting, w, speed, second):
    """The cycle that repeats, from a W near it."""
    for _ in range(60):
        out, _, gain, _, _, rising = engage(case, w, setting)
        better = w - (out - w) / (gain - 1)
        settled = abs(better - w) < w * mpf(10) ** (8 - mp.dps)
        w = better if better > 0 else out
        if settled:
            break
    else:
        raise ArithmeticError("no terminal cycle found")
    _, time, gain, reversals, extrema, _ = engage(case, w, setting, rising)
    speeds = [mp.sqrt(w), *(peak[2] for peak in extrema)]
    return {
        "handoff_velocity": mp.sqrt(w) * speed,
        "velocity_max": max(speeds) * speed,
        "velocity_min": min(speeds) * speed,
        "period": time * second,
        "contraction": gain,
        "reversal_angles": [angle for angle, _ in reversals],
    }


def solve(data, setting):
    """Motion and terminal cycle of one case with ``digits``, ``order`` and ``tolerance``."""
    with mp.workdps(setting["digits"]):
        case, speed, second = dimensionless(data)
        result, w = motion(case, data, setting, speed, second)
        cycle = terminal(case, setting, w, speed, second) if data["friction"] > 0 else None
        return result | {"terminal": cycle}
