"""One step of a motion in one mode, and the first event within it.

In a step the accelerations of both bodies are polynomials, which obey the law at the points of
Gauss. They are found by iteration. Speeds and angles are their integrals, so that states within the
step are as exact as at its end. In a flight with constant torques all of them are exact.
"""

from collections import namedtuple

import numpy as np
from numpy.polynomial import legendre

from escapement.engines.two_bodies.law import MOTION, free, losses, push_at, pushed, touching
from escapement.numerics.jit import inner_jit

ERROR = 2e-14
"""Greatest last coefficient of a step's speeds."""
NODES = 12
_MOST_SWEEPS, _SETTLED, SHRINKS = 20, 1e-14, 0.2
"""Iterations of a step, the change of speeds at which they end, and the greatest share of the last
change that the next one may be where a shorter step can be tried."""
_DIVERGES = 1e9
"""A change of speeds from which on iterations diverge."""
MARGINS = 9
"""Numbers that are positive in a mode: distance to the handoff, speeds in their senses, force,
slip in its sense, what is left of track and nose, A, and the driver's acceleration in its sense."""
(HANDOFF, DRIVER_STOPS, FOLLOWER_STOPS, LIFTS, SLIPS, TRACK_ENDS, NOSE_ENDS, JAMS, TURNS) = range(9)
NOTHING = -1

_POINTS, _WEIGHTS = legendre.leggauss(NODES)
_SERIES = np.ascontiguousarray(
    (np.arange(NODES) + 0.5)[:, None] * legendre.legvander(_POINTS, NODES - 1).T * _WEIGHTS
)
_ONCE, _TWICE = (
    np.ascontiguousarray(legendre.legint(_SERIES, times, lbnd=-1, scl=0.5)) for times in (1, 2)
)
"""Legendre series of a polynomial and of its integrals, from its values at the points."""
_TO_SPEEDS = np.ascontiguousarray((legendre.legvander(_POINTS, NODES) @ _ONCE).T)
_TO_ANGLES = np.ascontiguousarray((legendre.legvander(_POINTS, NODES + 1) @ _TWICE).T)
_BACK = np.arange(1.0, NODES + 3.0) / np.arange(2.0, NODES + 4.0)
_AHEAD = 1.0 + _BACK
"""Factors in the recurrence of Legendre polynomials."""
_SHARES = 0.5 * (1.0 + _POINTS)
_LOOKS = 4  # times in a step at which events are looked for


Path = namedtuple("Path", "rates points speeds angles here marks known span")
"""The rates of speeds and lost work at the points, the series of their integrals and of the
angles; a state within the step and the `MARGINS` there; the series of the accelerations of the step
before in the same mode, the time since it began and its length, which is 0 if there is none."""


@inner_jit(allocates=True)
def path_for(size):
    """Memory for steps with states of a size."""
    rates, speeds = np.empty((size - 2, NODES)), np.empty((size - 2, NODES + 1))
    points, angles = np.empty((4, NODES)), np.empty((2, NODES + 2))
    here, marks, known = np.empty(size), np.empty(MARGINS), np.empty((2, NODES))
    return Path(
        rates=rates, points=points, speeds=speeds, angles=angles, here=here, marks=marks,
        known=known, span=np.zeros(2),
    )  # fmt: skip


@inner_jit
def advance(law, pairs, mode, y, push, length, shrinks, path):
    """Find the path of a step that begins with a state and its accelerations; returns its error.

    It is infinite if iterations do not settle while each changes less than this share of the last.
    """
    rates, points, here, settled = path.rates, path.points, path.here, True
    for j in range(NODES):
        s = length * _SHARES[j]
        for i in range(2):
            rate = push.driver if i == 0 else push.follower
            points[i, j] = y[i] + s * (y[2 + i] + 0.5 * s * rate)
            points[2 + i, j] = y[2 + i] + s * rate
            rates[i, j] = rate
    if mode.pair >= 0 or not law.plain:
        _go_on(path, length)
        change = np.inf
        for _ in range(_MOST_SWEEPS):
            before, change = change, 0.0
            for j in range(NODES):
                for i in range(4):
                    here[i] = points[i, j]
                push = push_at(law, pairs, mode, here)
                driver, follower = push.driver - rates[0, j], push.follower - rates[1, j]
                if not length * (abs(driver) + abs(follower)) < _DIVERGES:
                    return np.inf
                rates[0, j], rates[1, j] = push.driver, push.follower
                change += abs(driver) + abs(follower)
                _correct(points, j, length, driver, follower)
            change *= length
            if not _SETTLED < change < shrinks * before:
                break
        settled = change <= ERROR
        if settled:
            for i in range(2):
                _series(_SERIES, rates[i], 1.0, path.known[i])
            path.span[0], path.span[1] = 0.0, length
    if len(y) > MOTION:
        for j in range(NODES):
            for i in range(4):
                here[i] = points[i, j]
            losses(law, mode, push_at(law, pairs, mode, here), here, rates[2:, j])
    change = 0.0
    for i in range(len(rates)):
        _series(_ONCE, rates[i], length, path.speeds[i])
        if i < 2:
            _series(_TWICE, rates[i], length * length, path.angles[i])
            last = abs(path.speeds[i, NODES]) + 0.1 * abs(path.speeds[i, NODES - 1])
            change = max(change, last)
    return change if settled else np.inf


@inner_jit
def _go_on(path, length):
    """Let the accelerations at the points of a step go on as in the step before."""
    rates, span = path.rates, path.span
    if span[1] == 0.0:
        return
    for j in range(NODES):
        x, driver, follower = 2.0 * (span[0] + length * _SHARES[j]) / span[1] - 1.0, 0.0, 0.0
        here, ahead = 1.0, x  # Legendre polynomials
        for k in range(NODES):
            driver += path.known[0, k] * here
            follower += path.known[1, k] * here
            here, ahead = ahead, _AHEAD[k] * x * ahead - _BACK[k] * here
        _correct(path.points, j, length, driver - rates[0, j], follower - rates[1, j])
        rates[0, j], rates[1, j] = driver, follower


@inner_jit(merged=True)
def _correct(points, j, length, driver, follower):
    """Correct the states at all points for a change of the accelerations at one."""
    for k in range(NODES):
        by = length * _TO_SPEEDS[j, k]
        points[2, k] += by * driver
        points[3, k] += by * follower
        by = length * length * _TO_ANGLES[j, k]
        points[0, k] += by * driver
        points[1, k] += by * follower


@inner_jit
def growth(error):
    """By how much a step may be longer than one with this error."""
    return 0.9 * min(max((ERROR / max(error, 1e-100)) ** (1.0 / NODES), 0.2), 4.0)


@inner_jit
def _series(integral, values, scale, out):
    for k in range(len(out)):
        total = 0.0
        for j in range(NODES):
            total += integral[k, j] * values[j]
        out[k] = scale * total


@inner_jit
def state_at(path, y, length, s, out):
    """Write the state at a time s within a step of a length that begins with y."""
    if s == 0.0:  # the series would add rounding to the start
        for i in range(len(y)):
            out[i] = y[i]
        return
    x = 2.0 * s / length - 1.0
    here, ahead = 1.0, x  # Legendre polynomials
    for i in range(len(y)):
        out[i] = y[i] + s * y[2 + i] if i < 2 else y[i]
    for k in range(NODES + 2):
        out[0] += path.angles[0, k] * here
        out[1] += path.angles[1, k] * here
        if k <= NODES:
            for i in range(2, len(y)):
                out[i] += path.speeds[i - 2, k] * here
        here, ahead = ahead, _AHEAD[k] * x * ahead - _BACK[k] * here


@inner_jit
def bring_back(law, pairs, mode, y):
    """Bring a kept contact back to a gap of zero, and its rate too, along I^-1 G."""
    touch = touching(law, pairs, mode, y)
    weak = touch.g0 * touch.g0 / law.rho + touch.g1 * touch.g1
    rate = (touch.g0 * y[2] + touch.g1 * y[3]) / weak
    for i in range(2):
        part = touch.g0 / law.rho if i == 0 else touch.g1
        y[i] -= part * touch.gap / weak
        y[2 + i] -= part * rate


@inner_jit
def margins(law, pairs, mode, y, goal, trend, out):
    """Write the numbers that are positive in a mode; `trend` is the sign of the acceleration."""
    out[:] = 1.0
    out[HANDOFF] = goal - y[0]
    if mode.driver_sense != 0.0 and law.bearing + law.driver_journal + law.driver_drag > 0.0:
        out[DRIVER_STOPS] = mode.driver_sense * y[2]
    if mode.follower_sense != 0.0 and law.load + law.follower_journal + law.follower_drag > 0.0:
        out[FOLLOWER_STOPS] = mode.follower_sense * y[3]
    if mode.pair >= 0:
        touch = touching(law, pairs, mode, y)
        push = pushed(law, mode, touch, y)
        out[LIFTS], out[SLIPS], out[JAMS] = push.force, mode.sigma * push.slip, push.yielding
        out[TRACK_ENDS], out[NOSE_ENDS] = touch.on_track, touch.on_nose
        out[TURNS] = trend * push.driver if trend != 0.0 else 1.0
    elif not law.plain:
        out[TURNS] = trend * free(law, mode, y).driver


@inner_jit
def first_event(law, pairs, mode, y, length, goal, trend, path):
    """The time in a step of its first event, or its length, and which of `MARGINS` that is."""
    here, before = path.marks, 0.0
    for k in range(1, _LOOKS + 1):
        first, found, after = length * k / _LOOKS, NOTHING, length * k / _LOOKS
        state_at(path, y, length, after, path.here)
        margins(law, pairs, mode, path.here, goal, trend, here)
        for kind in range(MARGINS):
            if here[kind] < 0.0:
                first = _root(law, pairs, mode, y, length, goal, trend, path, kind, before, first)
                found = kind
                state_at(path, y, length, first, path.here)
                margins(law, pairs, mode, path.here, goal, trend, here)
        if found != NOTHING:
            return first, found
        before = after
    return length, NOTHING


@inner_jit
def _margin(law, pairs, mode, y, length, goal, trend, path, kind, s):
    state_at(path, y, length, s, path.here)
    margins(law, pairs, mode, path.here, goal, trend, path.marks)
    return path.marks[kind]


@inner_jit
def _root(law, pairs, mode, y, length, goal, trend, path, kind, low, high):
    """The time between two others at which a margin is zero, or just behind."""
    given, side, start = (law, pairs, mode, y, length, goal, trend, path, kind), 0.0, low
    first, last = _margin(*given, low), _margin(*given, high)
    for _ in range(100):
        # the method of Illinois: a false position that halves the value of an end that stays
        part = (low * last - high * first) / (last - first)
        if not first > 0.0:
            part = low + 0.25 * (high - low)  # it begins at zero, and may be positive for a while
        elif not low < part < high:
            part = 0.5 * (low + high)
        value = _margin(*given, part)
        if value < 0.0:
            high, last = part, value
            first = 0.5 * first if side < 0.0 else first
            side = -1.0
        else:
            low, first = part, value
            last = 0.5 * last if side > 0.0 else last
            side = 1.0
        done = high - low <= 1e-15 * length or abs(value) <= 1e-15
        if (done and first > 0.0) or high - start < 1e-12:
            break
    return part
