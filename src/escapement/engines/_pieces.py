"""What lies between the handoffs: events, and states at given times.

Nothing here is on the path of the figures of merit. A piece is solved again on
panels of its own, fine enough to be interpolated, and its time is inverted.
"""

import numpy as np

from escapement._jit import jit
from escapement.dynamics import bend
from escapement.engines._cycle import tolerances
from escapement.engines._inside import SCRATCH
from escapement.engines._march import EVENTS, lay_out, march
from escapement.engines._panels import (
    ALPHA,
    BETA,
    COLUMNS,
    DG,
    DOWN,
    ENDS,
    GEOMETRY,
    INVERSE,
    MAX_PANELS,
    NOISE,
    RIGHT,
    SPREAD,
    TAIL,
    UP,
    WEIGHTS,
    G,
    N,
    U,
    combine,
    evaluate,
    part_of,
    solve_side,
    survey,
    tail_of,
)
from escapement.mechanisms._slotted import transmission_at

EVENT_COLUMNS = 5  # engagement, kind, angle, time from the start, w
_MOST = 64  # events of one engagement
_EVEN = 1e-12  # width below which the acceleration is constant [rad]


@jit
def _put(table, filled, engagement, kind, angle, time, w):
    table[filled, 0] = engagement
    table[filled, 1] = kind
    table[filled, 2] = angle
    table[filled, 3] = time
    table[filled, 4] = w
    return filled + 1


@jit
def events_of(path, breaks, dwell, rho, mu, load, starts, squares, rtol):
    """All events of the engagements that start at `starts` with `squares`.

    Returns
    -------
    ndarray, shape (events, 5)
        Engagement, kind, angle, time and w; per engagement a row of kind -1
        with the side at entry (in the angle's place) comes first.
    """
    loose, strict = tolerances(rtol)
    store = np.empty((MAX_PANELS, 3, COLUMNS))
    events = np.empty((_MOST, EVENTS))
    scratch = np.empty(SCRATCH)
    count = lay_out(store, breaks, path, rho, loose)
    table = np.empty((8 * starts.size + 64, EVENT_COLUMNS))
    filled = 0
    rising = 0.0
    for k in range(starts.size):
        status, out, length, _x, _s, side, rising, count, used = march(
            store, count, path, rho, mu, load, squares[k], 0.0, rising,
            loose, strict, True, events, scratch,
        )  # fmt: skip
        if filled + used + 2 > table.shape[0]:
            larger = np.empty((2 * table.shape[0] + used, EVENT_COLUMNS))
            larger[:filled] = table[:filled]
            table = larger
        flips = 0
        for i in range(used):
            flips += events[i, 0] == 0.0
        first = side if flips % 2 == 0 else -side
        filled = _put(table, filled, k, -1.0, first, starts[k], squares[k])
        for i in range(used):
            kind, angle, time, w = events[i]
            filled = _put(table, filled, k, kind, angle, starts[k] + time, w)
        if status != 0:
            break
        if dwell > 0.0:
            if rising < 0.0:
                filled = _put(table, filled, k, 1.0, breaks[-1], starts[k] + length, out)
            filled = _put(table, filled, k, 4.0, breaks[-1], starts[k] + length, out)
            rising = 1.0
    return table[:filled].copy()


@jit
def states_in(path, left, end, w, side, rho, mu, load, rtol, times, theta, squares):
    """Angles and squared speeds at times since the start of one piece.

    Parameters
    ----------
    left, end : driver angle where the piece starts and ends.
    w, side : squared speed at its start, side of the slot.
    times : since the start; clipped to the piece.
    theta, squares : results, as long as `times`.

    Returns
    -------
    loss, length : work lost in friction over the piece, and its duration.
    """
    _loose, strict = tolerances(rtol)
    panel = np.empty((3, COLUMNS))
    row = panel[GEOMETRY]
    solution = panel[part_of(side)]
    scratch = np.empty(2 * N)
    energies = np.empty(N)
    slowness = np.empty(N)
    e_series = np.empty(N)
    s_series = np.empty(N)
    ends = np.empty(80)
    waiting = 0
    right = end
    loss = 0.0
    now = 0.0
    theta[:] = left
    squares[:] = w
    while left < end:
        survey(panel, path, rho, left, right)
        solve_side(row, solution, side, rho, mu, load, scratch)
        half = 0.5 * (right - left)
        energy = w * (rho + row[ENDS] ** 2)
        good = solution[TAIL] <= strict
        for i in range(N):
            energies[i] = solution[ALPHA + i] * energy + solution[BETA + i]
            slowness[i] = 1.0 / np.sqrt(energies[i] * row[INVERSE + i])
            good = good and energies[i] > 0.0
        limit = max(strict, solution[NOISE])
        good = good and tail_of(slowness, 0) <= limit * slowness[N // 2]
        even = right - left <= _EVEN
        middle = 0.5 * (left + right)
        if not good and not even and waiting < 80 and left < middle < right:
            ends[waiting] = right
            waiting += 1
            right = middle
            continue
        next_w = (solution[RIGHT] * energy + solution[RIGHT + 1]) / (rho + row[ENDS + 3] ** 2)
        next_w = max(next_w, 0.0)
        length = 0.0
        for i in range(N):
            length += WEIGHTS[i] * half * slowness[i]
            g, v = row[G + i], energies[i] * row[INVERSE + i]
            moment = rho * (row[DG + i] * v + load) + g
            moment /= rho + g * (g + bend(side, mu) * row[U + i])
            loss += WEIGHTS[i] * half * abs(bend(side, mu) * row[U + i] * moment)
        even = even and not good
        if even:
            length = 2.0 * (right - left) / (np.sqrt(w) + np.sqrt(next_w))
        combine(SPREAD, energies, 0, e_series, 0)
        combine(SPREAD, slowness, 0, s_series, 0)
        for j in range(times.size):
            t = times[j] - now
            if t < 0.0 or (t > length and right < end):
                continue
            t = min(t, length)
            if even:
                speed = np.sqrt(w) + t * (np.sqrt(next_w) - np.sqrt(w)) / length
                theta[j] = left + 0.5 * t * (np.sqrt(w) + speed)
                squares[j] = speed * speed
                continue
            x = _invert(s_series, t / half, length / half)
            theta[j] = middle + half * x
            g = transmission_at(path, theta[j])[0]
            squares[j] = evaluate(e_series, 0, x)[0] / (rho + g * g)
        now += length
        w = next_w
        left = right
        if w == 0.0:
            break  # a stop
        if waiting > 0:
            waiting -= 1
            right = ends[waiting]
    return loss, now


@jit
def _integral(coefficients, x):
    """Integral of a Legendre series from -1 to x, and its value at x."""
    before, now = 1.0, x
    total = coefficients[0] * (1.0 + x)
    value = coefficients[0]
    for k in range(1, N):
        after = UP[k] * x * now - DOWN[k] * before
        total += coefficients[k] * (after - before) / (2 * k + 1)
        value += coefficients[k] * now
        before, now = now, after
    return total, value


@jit
def _invert(coefficients, target, whole):
    """x in [-1, 1] where the integral of a positive series reaches a target."""
    x = 2.0 * target / whole - 1.0
    low, high = -1.0, 1.0
    for _ in range(60):
        total, value = _integral(coefficients, x)
        if total > target:
            high = x
        else:
            low = x
        guess = x + (target - total) / value
        if not low <= guess <= high:
            guess = 0.5 * (low + high)
        step = abs(guess - x)
        x = guess
        if step <= 1e-8:
            break
    return x
