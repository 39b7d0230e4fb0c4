"""What lies between the handoffs: events, and states at given times.

Nothing here is on the path of the figures of merit. A piece is solved again on
panels of its own, fine enough to be interpolated, and its time is inverted.
"""

import numpy as np

from escapement.dynamics import bend
from escapement.engines.energy.calls import march, place
from escapement.engines.energy.events import ANGLE, EVENTS, KIND, NONE, REVERSAL, SQUARE, TIME
from escapement.engines.energy.gauss import WEIGHTS, N, cumulate, dot
from escapement.engines.energy.locate import weights_to
from escapement.engines.energy.march import EVERYTHING
from escapement.engines.energy.panels import (
    DG,
    ENDS,
    HEAD,
    MAX_PANELS,
    NO_PANELS,
    NOISE,
    RIGHT,
    TAIL,
    E,
    F,
    G,
    K,
    Q,
    U,
    V,
    W,
    at_gauss_points,
    new_store,
    place_of,
    solution_of,
    survey,
    tolerances,
)
from escapement.engines.energy.sampling import duration, run_over
from escapement.engines.energy.solve import solve_side
from escapement.jit import jit
from escapement.mechanisms.slotted import transmission_at

EVENT_COLUMNS = 5  # engagement, kind, angle, time from the start, w
ONE = np.int64(1)
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
def _copy(table, to, filled):
    # not by slices, whose error messages take a tenth of all compilation
    for i in range(filled):
        for j in range(EVENT_COLUMNS):
            to[i, j] = table[i, j]


@jit(allocates=True)
def events_of(calls, cells, path, breaks, dwell, rho, mu, load, starts, squares, rtol):
    """All events of the engagements that start at `starts` with `squares`.

    Returns
    -------
    ndarray, shape (events, 5)
        Engagement, kind, angle, time and w; per engagement a row of kind -1
        with the side at entry (in the angle's place) comes first.
    """
    loose, strict = tolerances(rtol)
    store = new_store(MAX_PANELS)
    events = np.empty((_MOST + 4 * breaks.size, EVENTS))
    count = NO_PANELS
    table = np.empty((8 * starts.size + 64, EVENT_COLUMNS))
    filled = NONE
    rising = 0.0
    record = EVERYTHING
    for k in range(starts.size):
        status, out, length, _x, _s, side, rising, count, used = march(
            calls, store, count, path, breaks, cells, rho, mu, load, squares[k], 0.0, rising,
            loose, strict, record, events, NONE,
        )  # fmt: skip
        if filled + used + 2 > table.shape[0]:
            larger = np.empty((2 * table.shape[0] + used, EVENT_COLUMNS))
            _copy(table, larger, filled)
            table = larger
        flips = 0
        for i in range(used):
            flips += events[i, KIND] == REVERSAL
        first = side if flips % 2 == 0 else -side
        filled = _put(table, filled, k, -1.0, first, starts[k], squares[k])
        for i in range(used):
            place(calls, events, i, store, path, rho, mu, load)
            angle, time, w = events[i, ANGLE], events[i, TIME], events[i, SQUARE]
            filled = _put(table, filled, k, events[i, KIND], angle, starts[k] + time, w)
        if status != 0:
            break
        if dwell > 0.0:
            if rising < 0.0:
                filled = _put(table, filled, k, 1.0, breaks[-1], starts[k] + length, out)
            filled = _put(table, filled, k, 4.0, breaks[-1], starts[k] + length, out)
            rising = 1.0
    found = np.empty((filled, EVENT_COLUMNS))
    _copy(table, found, filled)
    return found


@jit(allocates=True)
def states_in(path, edges, left, end, w, side, rho, mu, load, rtol, times, theta, squares):
    """Angles and squared speeds at times since the start of one piece.

    Parameters
    ----------
    edges : driver angles that no panel passes over.
    left, end : driver angle where the piece starts and ends.
    w, side : squared speed at its start, side of the slot.
    times : since the start; clipped to the piece.
    theta, squares : results, as long as `times`.

    Returns
    -------
    loss, length : work lost in friction over the piece, and its duration.
    """
    _loose, strict = tolerances(rtol)
    s = new_store(ONE)
    at = place_of(HEAD)
    to = solution_of(at, side)
    ends = np.empty(80)
    waiting = 0
    right = _next(edges, left, end)
    loss = 0.0
    now = 0.0
    for j in range(times.size):
        theta[j], squares[j] = left, w
    while left < end:
        at_gauss_points(s)
        survey(s, at, path, rho, left, right)
        solve_side(s, at, side, rho, mu, load)
        half = 0.5 * (right - left)
        energy = w * (rho + s[at + ENDS] ** 2)
        _against, stopped, _slower = run_over(s, at, side, energy, rho, mu, load)
        good = s[to + TAIL] <= strict and stopped == 0
        length, roughness = duration(s)
        good = good and roughness <= max(strict, s[to + NOISE])
        even = right - left <= _EVEN
        middle = 0.5 * (left + right)
        if not good and not even and waiting < 80 and left < middle < right:
            ends[waiting] = right
            waiting += 1
            right = middle
            continue
        next_w = (s[to + RIGHT] * energy + s[to + RIGHT + 1]) / (rho + s[at + ENDS + 3] ** 2)
        next_w = max(next_w, 0.0)
        loss += half * _lost(s, at, side, rho, mu, load)
        even = even and not good
        if even:
            length = 2.0 * (right - left) / (np.sqrt(w) + np.sqrt(next_w))
        cumulate(s, F, K)
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
            x = _invert(s, t, length)
            theta[j] = middle + half * x
            g = transmission_at(path, theta[j])[0]
            squares[j] = dot(s, V, E) / (rho + g * g)
        now += length
        w = next_w
        left = right
        if w == 0.0:
            # a stop, and nothing moves later
            for j in range(times.size):
                if times[j] >= now:
                    theta[j], squares[j] = left, 0.0
            break
        right = _next(edges, left, end)
        if waiting > 0:
            waiting -= 1
            right = ends[waiting]
    return loss, now


def follow(scene, start, end, times, rtol):
    """Driver angles and squared speeds at times since the start of a piece; natural units.

    Parameters
    ----------
    scene : tuple
        As `numbers_of` returns it.
    start : (float, float, float)
        Driver angle [rad], squared speed and side of the slot, 0 in a dwell.
    end : float
        Driver angle where the piece ends at the latest [rad].
    times : ndarray, shape (n,)
        Since the start.
    rtol : float
        Relative error allowed.

    Returns
    -------
    theta, squares : ndarray, shape (n,)
    """
    _calls, _cells, path, edges, _dwell, rho, mu, load = scene
    angle, w, sign = start
    if sign == 0.0:
        speed = np.sqrt(w)
        return angle + times * (speed + times / (2.0 * rho)), (speed + times / rho) ** 2
    theta, squares = np.empty_like(times), np.empty_like(times)
    states_in(path, edges, angle, end, w, sign, rho, mu, load, rtol, times, theta, squares)
    return theta, squares


@jit
def _next(edges, left, end):
    """The first edge behind `left`, if it comes before the end."""
    for i in range(edges.size):
        if edges[i] > left:
            return min(edges[i], end)
    return end


@jit
def _lost(s, at, side, rho, mu, load):
    """Work lost in friction over a panel, by x."""
    total = 0.0
    for i in range(N):
        g, lost = s[at + G + i], bend(side, mu) * s[at + U + i]
        moment = rho * (s[at + DG + i] * s[W + i] + load) + g
        total += WEIGHTS[i] * abs(lost * moment / (rho + g * (g + lost)))
    return total


@jit
def _invert(s, target, whole_time):
    """x in [-1, 1] at a time since the left end; leaves the weights to it in V and Q."""
    x = 2.0 * target / whole_time - 1.0
    low, high = -1.0, 1.0
    for _ in range(60):
        weights_to(s, x)
        passed = dot(s, Q, K)
        if passed > target:
            high = x
        else:
            low = x
        guess = x + (target - passed) / dot(s, V, F)
        if not low <= guess <= high:
            guess = 0.5 * (low + high)
        step = abs(guess - x)
        x = guess
        if step <= 1e-8:
            break
    weights_to(s, x)
    return x
