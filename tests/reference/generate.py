"""Reference motions of Geneva escapements in 40-digit arithmetic.

``python tests/reference/generate.py [OUT.json]`` writes ``motions.json`` next to this file.

Written from the Lagrangian, without the package, to judge its engines.  With W = theta_dot^2 I_f/tau,
rho = I_d/I_f, m = M_f/tau and p = g + s mu |u|, Meyer's energy T = (I_d + I_f g^2) theta_dot^2/2
(Meyer 1973, eq. 1-16), the virtual work of torque, load and pin friction and
theta_ddot = d(theta_dot^2/2)/dtheta give on every piece of constant s

    (rho + g p) W' + 2 p g' W = 2 (1 - p m),        s = sign K,   K = rho (g' W + m) + g.

Method: Taylor series of W in the driver angle, panel after panel; the step is where the last
coefficients of every series in use fall below a tolerance.  Time is the integral of the series of
W^(-1/2); a start from rest has W ~ x, so its half-integer powers are integrated term by term and no
singularity is left.  Reversals are roots of K, smooth speed extrema roots of W', both taken from the
panel's own polynomials; corners of the speed are sign changes of W' between panels.  The terminal
cycle is Newton's fixed point of W_in -> W_out with the slope from the homogeneous equation.

Every case is solved at two precisions, orders and tolerances; their largest relative difference is
stored as ``error``.  Inputs are the binary doubles that the JSON numbers stand for.  Units: any
coherent set (N m, kg m^2, s; or Meyer's in-lbf, in-lbf-s^2, s), since only I/tau = s^2 enters.
"""

import json
import random
import sys
from pathlib import Path
from typing import NamedTuple

from mpmath import mp, mpf

COARSE = {"digits": 34, "order": 26, "tolerance": "1e-23"}
FINE = {"digits": 42, "order": 32, "tolerance": "1e-29"}


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


def product(x, y):
    return [mp.fdot(x[: k + 1], y[k::-1]) for k in range(len(x))]


def quotient(x, y):
    z = [x[0] / y[0]]
    for k in range(1, len(x)):
        z.append((x[k] - mp.fdot(z, y[k:0:-1])) / y[0])
    return z


def inverse_root(w):
    """Series of w^(-1/2) from w y' = -w' y / 2."""
    y = [1 / mp.sqrt(w[0])]
    scaled = [j * c for j, c in enumerate(w)]
    for k in range(1, len(w)):
        tail = y[::-1]
        y.append((mp.fdot(scaled[1 : k + 1], tail) / 2 - k * mp.fdot(w[1 : k + 1], tail)) / (k * w[0]))
    return y


def derivative(x):
    return [k * c for k, c in enumerate(x)][1:]


def value(x, h):
    return mp.polyval(x[::-1], h)


def linear_solution(j, q, r, start):
    """Series of y in j y' + q y = r, and of y'."""
    y, slope = [start], []
    for k in range(len(r) - 1):
        known = mp.fdot(q[: k + 1], y[k::-1]) + mp.fdot(j[1 : k + 1], slope[::-1])
        slope.append((r[k] - known) / j[0])
        y.append(slope[k] / (k + 1))
    return y, slope


def transmission(case, angle, order):
    """Series of g, g' and u: the pin at polar angle phi and squared radius L from the wheel."""
    c, s = mp.cos(angle), mp.sin(angle)
    cos = [d / mp.factorial(k) for k, d in zip(range(order + 2), [c, -s, -c, s] * order, strict=False)]
    square = [-2 * case.kind * case.a * x for x in cos]
    square[0] += 1 + case.a**2
    g = [case.a * x for x in cos]
    g[0] -= case.kind
    g = quotient(g, square)
    u = [x / 2 for x in quotient(derivative(square), square[:-1])]
    return g[:-1], derivative(g), u


def reach(series, tolerance):
    """Distance at which the last two coefficients still fall below the tolerance."""
    scale = max(abs(series[0]), abs(series[1]) * mpf("1e-3"))
    orders = [k for k in (len(series) - 1, len(series) - 2) if series[k] != 0]
    return min([(tolerance * scale / abs(series[k])) ** (mpf(1) / k) for k in orders], default=mpf(9))


def panel(case, angle, sign, w0, side, setting):
    order = setting["order"]
    g, dg, u = transmission(case, angle, order)
    p = [x + sign * case.mu * side * y for x, y in zip(g, u, strict=True)]
    inertia = product(g, p)
    inertia[0] += case.rho
    damping = [2 * x for x in product(p, dg)]
    forcing = [-2 * case.load * x for x in p]
    forcing[0] += 2
    if inertia[0] <= 0:
        raise ArithmeticError("beyond the Painleve limit")
    w, slope = linear_solution(inertia, damping, forcing, w0)
    tangent, _ = linear_solution(inertia, damping, [mpf(0)] * (order + 1), mpf(1))
    contact = [case.rho * x + y for x, y in zip(product(dg, w), g, strict=True)]
    contact[0] += case.rho * case.load
    inverse_speed = inverse_root(w if w0 else slope)
    tolerance = mpf(setting["tolerance"])
    far = min(reach(x, tolerance) for x in (g, dg, w if w0 else slope, tangent, inverse_speed))
    return Panel(w, slope, contact, tangent, inverse_speed, not w0, far)


def elapsed(pan, h):
    """Time across the first h of a panel, in units of sqrt(I_f/tau)."""
    half = mpf(1) / 2 if pan.from_rest else mpf(1)
    return h**half * value([c / (k + half) for k, c in enumerate(pan.inverse_speed)], h)


def sign_changes(poly, h, depth=1):
    """Roots of a panel's polynomial in (0, h); its own stationary points part close pairs."""
    nodes = [h * k / 4 for k in range(5)]
    if depth:
        nodes = sorted(nodes + sign_changes(derivative(poly), h, 0))
    values, roots = [value(poly, x) for x in nodes], []
    for k in range(len(nodes) - 1):
        if values[k] * values[k + 1] < 0:
            roots.append(refined(poly, nodes[k], nodes[k + 1], values[k]))
    return roots


def refined(poly, low, high, at_low):
    """Newton's iteration kept inside a bracket."""
    slope, x = derivative(poly), (low + high) / 2
    for _ in range(200):
        f = value(poly, x)
        low, high = (x, high) if f * at_low > 0 else (low, x)
        step = f / value(slope, x)
        if abs(step) < mp.eps * abs(x) * 8:
            return x - step
        x = x - step if low < x - step < high else (low + high) / 2
    return x


def engage(case, w, setting, log=None, rising=None):
    """One cell, from pin entry to the handoff: W, time, dW_out/dW_in, sign of the last slope."""
    time, gain = mpf(0), mpf(1)
    for start, end in ((-case.beta, mpf(0)), (mpf(0), case.beta)):
        angle, sign = start, None
        side = case.kind * (1 if end else -1)
        while angle < end:
            if sign is None:
                g, dg, _ = transmission(case, angle, 2)
                sign = 1 if case.rho * (dg[0] * w + case.load) + g[0] >= -mpf("1e-25") else -1
            pan = panel(case, angle, sign, w, side, setting)
            h = min(pan.reach, end - angle)
            # A restart at a reversal has a rounding-error root at 0, of the direction excluded here.
            falls = [x for x in sign_changes(pan.contact, h) if sign * value(derivative(pan.contact), x) < 0]
            h = min([h, *falls])
            turns = sign_changes(pan.slope, h)
            initial = value(pan.slope, h * mpf("1e-9")) > 0
            if log is not None:
                if rising is not None and initial != rising:
                    log["extrema"].append((angle, time, mp.sqrt(w), rising))
                for x in turns:
                    up = value(derivative(pan.slope), x) < 0
                    log["extrema"].append((angle + x, time + elapsed(pan, x), mp.sqrt(value(pan.w, x)), up))
            rising = initial ^ (len(turns) % 2 == 1)
            time, gain = time + elapsed(pan, h), gain * value(pan.tangent, h)
            w = value(pan.w, h)
            if w <= 0:
                raise ArithmeticError("the driver stalls")
            if falls and h == falls[0]:
                angle, sign = angle + h, -sign
                if log is not None:
                    log["reversals"].append((angle, time))
            else:
                angle = end if h == end - angle else angle + h
    if case.cell > 2 * case.beta + mpf("1e-25"):
        dwell = case.cell - 2 * case.beta
        if log is not None and not rising:
            log["extrema"].append((case.beta, time, mp.sqrt(w), False))
        leaving = w + 2 * dwell / case.rho
        time, w, rising = time + 2 * dwell / (mp.sqrt(w) + mp.sqrt(leaving)), leaving, True
    return w, time, gain, rising


def critical_friction(case):
    """Painleve limit: least (rho + g^2)/(g |u|) over the cell, by golden section."""

    def limit(angle):
        g, _, u = (x[0] for x in transmission(case, angle, 1))
        return (case.rho + g * g) / (abs(g) * abs(u))

    angles = [case.beta * (k + 1) / 402 for k in range(400)]
    best = min(angles, key=limit)
    low, high, ratio = best - case.beta / 402, best + case.beta / 402, (mp.sqrt(5) - 1) / 2
    for _ in range(80):
        x, y = high - ratio * (high - low), low + ratio * (high - low)
        low, high = (low, y) if limit(x) < limit(y) else (x, high)
    return limit((low + high) / 2)


def dimensionless(data):
    """Problem and its units of speed and time (at the current precision)."""
    kind = -1 if data["internal"] else 1
    driver, follower, torque = (mpf(data[k]) for k in ("driver_inertia", "follower_inertia", "torque"))
    step = mp.pi / data["slots"]
    shape = (1 / mp.sin(step), mp.pi / 2 - kind * step, 2 * mp.pi / data["pins"], kind)
    losses = (driver / follower, mpf(data["friction"]), mpf(data["load_torque"]) / torque)
    return Case(*shape, *losses), mp.sqrt(torque / follower), mp.sqrt(follower / torque)


def motion(case, data, setting, speed, second):
    w, time, rising = (mpf(data["initial_speed"]) / speed) ** 2, mpf(0), None
    out = {"handoff_times": [], "handoff_velocities": []}
    reversals, extrema = [], []
    for k in range(data["engagements"]):
        log = {"reversals": [], "extrema": []}
        w, spent, _, rising = engage(case, w, setting, log, rising)
        reversals += [(k, x, (time + t) * second) for x, t in log["reversals"]]
        extrema += [(k, x, (time + t) * second, v * speed, up) for x, t, v, up in log["extrema"]]
        time += spent
        out["handoff_times"].append(time * second)
        out["handoff_velocities"].append(mp.sqrt(w) * speed)
    out["reversals"] = columns(("engagement", "angle", "time"), reversals)
    names = ("engagement", "angle", "time", "velocity", "maximum")
    out["extrema"] = columns(names, extrema)
    return out, w


def columns(names, rows):
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}


def terminal(case, setting, w, speed, second):
    for _ in range(60):
        out, _, gain, rising = engage(case, w, setting)
        better = w - (out - w) / (gain - 1)
        done = abs(better - w) < w * mpf(10) ** (8 - mp.dps)
        w = better if better > 0 else out
        if done:
            break
    else:
        raise ArithmeticError("no terminal cycle found")
    log = {"reversals": [], "extrema": []}
    _, time, gain, _ = engage(case, w, setting, log, rising)
    speeds = [mp.sqrt(w), *(x[2] for x in log["extrema"])]
    return {
        "handoff_velocity": mp.sqrt(w) * speed,
        "velocity_max": max(speeds) * speed,
        "velocity_min": min(speeds) * speed,
        "period": time * second,
        "contraction": gain,
        "reversal_angles": [x[0] for x in log["reversals"]],
    }


def solve(data, setting):
    with mp.workdps(setting["digits"]):
        case, speed, second = dimensionless(data)
        result, w = motion(case, data, setting, speed, second)
        has_cycle = data["friction"] > 0
        result["terminal"] = terminal(case, setting, w, speed, second) if has_cycle else None
        return result


def leaves(tree):
    if isinstance(tree, dict | list):
        for item in tree.values() if isinstance(tree, dict) else tree:
            yield from leaves(item)
    else:
        yield tree


def printable(tree):
    if isinstance(tree, dict):
        return {k: printable(v) for k, v in tree.items()}
    if isinstance(tree, list):
        return [printable(v) for v in tree]
    return mp.nstr(tree, 20) if isinstance(tree, mpf) else tree


def reference(data):
    rough, fine = solve(data, COARSE), solve(data, FINE)
    error = mpf(0)
    for x, y in zip(leaves(rough), leaves(fine), strict=True):
        if isinstance(y, mpf):
            error = max(error, abs(x - y) / abs(y))
        elif x != y:
            raise ArithmeticError("the two resolutions see different events")
    return data | {"error": mp.nstr(error, 3)} | printable(fine)


def problem(name, slots, pins, mu, rho_or_inertias, torque, **more):
    """Input of one case; ``limit`` gives friction as a fraction of the Painleve limit."""
    driver, follower = rho_or_inertias
    limit = more.pop("limit", None)
    data = {"name": name, "slots": slots, "pins": pins, "internal": False, "friction": mu}
    data |= {"driver_inertia": driver, "follower_inertia": follower, "torque": torque}
    data |= {"load_torque": 0.0, "initial_speed": 0.0, "engagements": 6} | more
    case = dimensionless(data)[0]
    critical = critical_friction(case)
    if limit is not None:
        data["friction"] = float(critical * mpf(limit))
    if data["friction"] >= critical:
        raise ValueError(f"{name}: friction {mu} is at or above the Painleve limit {critical}")
    return data


def chosen():
    four, six, three = (3e-6, 50e-6), (6e-6, 10e-6), (3e-6, 40e-6)
    yield problem("meyer four pins", 4, 4, 0.35, four, 0.10, engagements=20)
    yield problem("meyer four pins, low friction", 4, 4, 0.20, four, 0.20, engagements=12)
    yield problem("meyer six pins", 3, 6, 0.20, six, 0.03, engagements=12)
    yield problem("meyer six pins, high friction", 3, 6, 0.35, six, 0.03)
    yield problem("meyer three pins", 6, 3, 0.20, three, 0.08, engagements=12)
    yield problem("meyer three pins, high friction", 6, 3, 0.35, three, 0.08)
    yield problem("four pins near the limit", 4, 4, None, four, 0.10, limit="0.99")
    yield problem("four pins at the limit", 4, 4, None, four, 0.10, limit="0.9999")
    yield problem("six pins at the limit", 3, 6, None, six, 0.03, limit="0.9999")
    yield problem("three pins near the limit", 6, 3, None, three, 0.08, limit="0.99")
    yield problem("three pins at the limit", 6, 3, None, three, 0.08, limit="0.9999")
    yield problem("frictionless", 4, 4, 0.0, four, 0.10)
    yield problem("frictionless with load", 6, 3, 0.0, three, 0.08, load_torque=0.02, initial_speed=20.0)
    yield problem("faster than terminal", 4, 4, 0.25, four, 0.10, initial_speed=3000.0)
    yield problem("slower than terminal", 3, 6, 0.30, six, 0.03, initial_speed=5.0)
    yield problem("light driver", 4, 4, 0.01, (5e-9, 5e-5), 0.10)
    yield problem("heavy driver", 4, 4, 0.35, (5e-2, 5e-5), 0.10)
    yield problem("eight slots, one pin", 8, 1, 0.25, (2e-5, 4e-5), 0.15)
    yield problem("five slots, three pins", 5, 3, 0.30, (2e-5, 3e-5), 0.12)
    yield problem("internal, five slots", 5, 1, 0.15, (1e-5, 2e-5), 0.10, internal=True)
    yield problem("internal with load", 4, 1, 0.20, (3e-5, 2e-5), 0.10, internal=True, load_torque=0.03)
    yield problem("load", 4, 4, 0.35, four, 0.10, load_torque=0.02)
    # The first engagements have no reversal, the next two, the later ones one.
    yield problem("load on a heavy driver", 3, 6, 0.10, (2e-3, 1e-5), 0.02, load_torque=0.002, engagements=20)
    yield problem("load, one pin", 7, 1, 0.30, (4e-5, 2e-5), 0.05, load_torque=0.01)


def seeded(count=6, seed=1973):
    draw = random.Random(seed)
    for k in range(count):
        internal, slots = k % 3 == 2, draw.randint(3, 12)
        pins = 1 if internal else draw.randint(1, 2 * slots // (slots - 2))
        follower, torque = 10 ** draw.uniform(-7, -4), 10 ** draw.uniform(-3, 0)
        driver = follower * 10 ** draw.uniform(-2, 1.5)
        wheel, share = {"internal": internal}, f"{draw.uniform(0.1, 0.95):.2f}"
        data = problem("", slots, pins, None, (driver, follower), torque, limit=share, **wheel)
        # A load of 0.3 tau / max p cannot stall the driver; max p < max g + mu max |u| <= 2 max(1, mu)/(a-1).
        a = float(dimensionless(data)[0].a)
        load = draw.choice([0.0, 0.15 * torque * (a - 1) / max(1.0, data["friction"])])
        start = draw.choice([0.0, draw.uniform(0.2, 5.0) * (torque / follower) ** 0.5])
        short = {key: float(f"{x:.6g}") for key, x in (
            ("driver_inertia", driver), ("follower_inertia", follower), ("torque", torque),
            ("friction", data["friction"]), ("load_torque", load), ("initial_speed", start),
        )}
        yield data | short | {"name": f"seeded {k}"}


def main():
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("motions.json")
    cases = []
    with mp.workdps(FINE["digits"]):
        problems = [*chosen(), *seeded()]
    for data in problems:
        cases.append(reference(data))
        print(data["name"], cases[-1]["error"], file=sys.stderr)
    rows = ",\n".join(json.dumps(case) for case in cases)
    out.write_text(f"[\n{rows}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main()
