"""Truncated power series as lists of mpf coefficients, lowest order first."""

from mpmath import mp, mpf


def product(x, y):
    return [mp.fdot(x[: k + 1], y[k::-1]) for k in range(len(x))]


def quotient(x, y):
    z = [x[0] / y[0]]
    for k in range(1, len(x)):
        z.append((x[k] - mp.fdot(z, y[k:0:-1])) / y[0])
    return z


def inverse_root(x):
    """Series of y = x^(-1/2), from 2 x y' = -x' y."""
    y = [1 / mp.sqrt(x[0])]
    slope = [j * c for j, c in enumerate(x)]
    for k in range(1, len(x)):
        tail = y[::-1]
        y.append((mp.fdot(slope[1 : k + 1], tail) / 2 - k * mp.fdot(x[1 : k + 1], tail)) / k / x[0])
    return y


def cosine(angle, order):
    """Series of cos about an angle."""
    c, s = mp.cos(angle), mp.sin(angle)
    return [(c, -s, -c, s)[k % 4] / mp.factorial(k) for k in range(order + 1)]


def linear_solution(j, q, r, start):
    """Series of y and y' with j y' + q y = r, y(0) = start."""
    y, slope = [start], []
    for k in range(len(r) - 1):
        known = mp.fdot(q[: k + 1], y[k::-1]) + mp.fdot(j[1 : k + 1], slope[::-1])
        slope.append((r[k] - known) / j[0])
        y.append(slope[k] / (k + 1))
    return y, slope


def derivative(x):
    return [k * c for k, c in enumerate(x)][1:]


def value(x, h):
    return mp.polyval(x[::-1], h)


def reach(x, tolerance):
    """Distance at which the last two coefficients still fall below the tolerance."""
    scale = max(abs(x[0]), abs(x[1]) / 1000)
    last = [k for k in (len(x) - 1, len(x) - 2) if x[k] != 0]
    return min([(tolerance * scale / abs(x[k])) ** (mpf(1) / k) for k in last], default=mpf(9))


def sign_changes(x, h, depth=1):
    """Roots in (0, h) of a series used well inside its reach, ascending.

    The roots of the derivative join the nodes, so that a close pair is parted.
    """
    nodes = [h * k / 4 for k in range(5)]
    if depth:
        nodes = sorted(nodes + sign_changes(derivative(x), h, 0))
    values, roots = [value(x, node) for node in nodes], []
    for k in range(len(nodes) - 1):
        if values[k] * values[k + 1] < 0:
            roots.append(_root(x, nodes[k], nodes[k + 1], values[k]))
    return roots


def _root(x, low, high, at_low):
    """Newton's iteration kept inside a bracket."""
    slope, h = derivative(x), (low + high) / 2
    for _ in range(200):
        f = value(x, h)
        low, high = (h, high) if f * at_low > 0 else (low, h)
        step = f / value(slope, h)
        if abs(step) < mp.eps * abs(h) * 8:
            return h - step
        h = h - step if low < h - step < high else (low + high) / 2
    return h
