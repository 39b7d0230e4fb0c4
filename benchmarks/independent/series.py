"""Arithmetic of truncated power series: arrays of SIZE coefficients, lowest first."""

import math

from .compiling import compiled

ORDER = 28
SIZE = ORDER + 1
NEGLIGIBLE = 1e-17


@compiled
def product(x, y, z):
    for k in range(x.size):
        total = 0.0
        for i in range(k + 1):
            total += x[i] * y[k - i]
        z[k] = total


@compiled
def quotient(x, y, z):
    for k in range(x.size):
        total = x[k]
        for i in range(k):
            total -= z[i] * y[k - i]
        z[k] = total / y[0]


@compiled
def inverse_root(x, count, y):
    """y = x^(-1/2) from 2 x y' = -x' y."""
    y[0] = 1.0 / math.sqrt(x[0])
    for k in range(1, count):
        total = 0.0
        for i in range(1, k + 1):
            total -= (0.5 * i + (k - i)) * x[i] * y[k - i]
        y[k] = total / (k * x[0])


@compiled
def value(x, h):
    total = 0.0
    for k in range(x.size - 1, -1, -1):
        total = total * h + x[k]
    return total


@compiled
def slope(x, h):
    total = 0.0
    for k in range(x.size - 1, 0, -1):
        total = total * h + k * x[k]
    return total


@compiled
def reach(x, last):
    """Distance at which the last two of the coefficients 0..last are negligible."""
    scale = max(abs(x[0]), 1e-3 * abs(x[1]))
    far = 4.0
    for k in (last, last - 1):
        if x[k] != 0.0:
            far = min(far, (NEGLIGIBLE * scale / abs(x[k])) ** (1.0 / k))
    return far


@compiled
def integral(x, h):
    total = 0.0
    for k in range(x.size - 2, -1, -1):
        total = total * h + x[k] / (k + 1)
    return total * h


@compiled
def root_integral(x, h, sense):
    """Integral of (sense x)^(-1/2) times a series over (0, h), sense = -1: over (-h, 0)."""
    total = 0.0
    for k in range(x.size - 3, -1, -1):
        total = total * (sense * h) + x[k] / (k + 0.5)
    return total * math.sqrt(h)


@compiled
def root(x, low, high, at_low, derivative):
    """Root of a series (or of its derivative) in a bracket: Newton kept in by bisection."""
    h = 0.5 * (low + high)
    for _ in range(200):
        if derivative:
            f = slope(x, h)
            step = 1e-7 * (high - low)
            df = (slope(x, h + step) - f) / step if step > 0.0 else 0.0
        else:
            f, df = value(x, h), slope(x, h)
        if f == 0.0:
            return h
        if (f > 0.0) == (at_low > 0.0):
            low = h
        else:
            high = h
        guess = h - f / df
        if not low < guess < high:
            guess = 0.5 * (low + high)
        if abs(guess - h) <= 1e-16 * (abs(h) + abs(guess)) or high - low <= 2e-16 * high:
            return guess
        h = guess
    return h


@compiled
def turning_points(x, h, out):
    """Roots in (0, h) of the derivative of a series; returns their number."""
    found, before = 0, slope(x, 0.0)
    for k in range(8):
        after = slope(x, h * (k + 1) / 8.0)
        if before * after < 0.0 and found < out.size:
            out[found] = root(x, h * k / 8.0, h * (k + 1) / 8.0, before, True)
            found += 1
        before = after if after != 0.0 else before
    return found


@compiled
def first_fall(x, h, sense, turns):
    """First place in (0, h] where sense * series goes from above zero to below, or -1."""
    found = turning_points(x, h, turns)
    low, at_low = 0.0, sense * value(x, 0.0)
    for k in range(found + 1):
        high = turns[k] if k < found else h
        at_high = sense * value(x, high)
        if at_high < 0.0 and at_low >= 0.0 and (at_low > 0.0 or sense * slope(x, 0.0) > 0.0):
            place = root(x, low, high, sense, False)
            if sense * slope(x, place) < 0.0:
                return place
        low, at_low = high, at_high
    return -1.0
