"""One step of a motion in one mode, and the first event within it.

A step takes extrapolated midpoint rules (Gragg, Bulirsch and Stoer), of order 8 at most, and brings
a kept contact back to a gap of zero. In a flight with constant torques it is exact.
"""

from collections import namedtuple

import numpy as np

from escapement.engines.two_bodies.law import MOTION, free, pushed, rates, touching
from escapement.numerics.jit import inner_jit

ERROR = 2e-14
"""Greatest difference of the last two columns of a step's extrapolation."""
STAGES = (2, 4, 6, 8)
MARGINS = 9
"""Numbers that are positive in a mode: distance to the handoff, speeds in their senses, force,
slip in its sense, what is left of track and nose, A, and the driver's acceleration in its sense."""
(HANDOFF, DRIVER_STOPS, FOLLOWER_STOPS, LIFTS, SLIPS, TRACK_ENDS, NOSE_ENDS, JAMS, TURNS) = range(9)
NOTHING = -1


Memory = namedtuple("Memory", "out table marks")
"""The state at the end of a step, and memory: rows as long as a state, and the `MARGINS`."""


@inner_jit(allocates=True)
def memory_for(size):
    """Memory for states of a size."""
    return Memory(np.empty(size), np.empty((len(STAGES) + 4, size)), np.empty(MARGINS))


@inner_jit
def advance(law, pairs, mode, y, length, work):
    """Write the state after a step into `work.out`; returns an estimate of its error."""
    out, begin, error = work.out, work.table[0], 0.0
    rates(law, pairs, mode, y, begin)
    if mode.pair >= 0 or not law.plain:
        error = _extrapolate(law, pairs, mode, y, length, work)
        if mode.pair >= 0:
            _close(law, pairs, mode, out)
        return error
    for i in range(2):
        out[i] = y[i] + (y[2 + i] + 0.5 * begin[2 + i] * length) * length
        out[2 + i] = y[2 + i] + begin[2 + i] * length
    for i in range(MOTION, len(out)):
        # friction of bearings, on bodies that do not turn back within a step
        turned = out[0] - y[0] if i == 5 else out[1] - y[1] if i == 9 else 0.0
        out[i] = y[i] + (law.bearing if i == 5 else law.load) * abs(turned)
    return error


@inner_jit
def _extrapolate(law, pairs, mode, y, length, work):
    """The step by midpoint rules with ever more substeps, extrapolated to infinitely many."""
    table, error = work.table, 0.0
    begin, rate, old, new = table[0], table[1], table[2], table[3]
    for k in range(len(STAGES)):
        h = length / STAGES[k]
        for i in range(len(y)):
            old[i], new[i] = y[i], y[i] + h * begin[i]
        for _ in range(1, STAGES[k]):
            rates(law, pairs, mode, new, rate)
            for i in range(len(y)):
                old[i], new[i] = new[i], old[i] + 2.0 * h * rate[i]
        rates(law, pairs, mode, new, rate)
        for i in range(len(y)):
            table[4 + k, i] = 0.5 * (new[i] + old[i] + h * rate[i])
        for j in range(k - 1, -1, -1):
            ratio, error = (STAGES[k] / STAGES[j]) ** 2 - 1.0, 0.0
            for i in range(len(y)):
                change = (table[5 + j, i] - table[4 + j, i]) / ratio
                table[4 + j, i] = table[5 + j, i] + change
                error = max(error, abs(change)) if i < MOTION else error
        if k > 0 and error <= ERROR:
            break
    for i in range(len(y)):
        work.out[i] = table[4, i]
    return error


@inner_jit
def _close(law, pairs, mode, y):
    """Bring a kept contact back to a gap of zero, and its rate too, along I^-1 G."""
    for _ in range(2):
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
    if mode.driver_sense != 0.0 and law.bearing + law.driver_journal > 0.0:
        out[DRIVER_STOPS] = mode.driver_sense * y[2]
    if mode.follower_sense != 0.0 and law.load + law.follower_journal > 0.0:
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
def first_event(law, pairs, mode, y, length, goal, trend, work):
    """The length of a step to its first event, and which of `MARGINS` that is.

    `work.out` is the state at the end of the step, and then that at the event.
    """
    found, here = NOTHING, work.marks
    margins(law, pairs, mode, work.out, goal, trend, here)
    for kind in range(MARGINS):
        if here[kind] < 0.0:
            length, found = _root(law, pairs, mode, y, length, goal, trend, work, kind), kind
            margins(law, pairs, mode, work.out, goal, trend, here)
    return length, found


@inner_jit
def _root(law, pairs, mode, y, length, goal, trend, work, kind):
    """The part of a step after which a margin is zero; `work.out` is the state there."""
    here, low, high, side, part = work.marks, 0.0, length, 0.0, length
    last = here[kind]
    margins(law, pairs, mode, y, goal, trend, here)
    first = here[kind]
    for _ in range(100):
        # the method of Illinois: a false position that halves the value of an end that stays
        part = (low * last - high * first) / (last - first)
        if not first > 0.0:
            part = 0.25 * high  # it begins at zero, and may be positive for a while
        elif not low < part < high:
            part = 0.5 * (low + high)
        advance(law, pairs, mode, y, part, work)
        margins(law, pairs, mode, work.out, goal, trend, here)
        value = here[kind]
        if value < 0.0:
            high, last = part, value
            first = 0.5 * first if side < 0.0 else first
            side = -1.0
        else:
            low, first = part, value
            last = 0.5 * last if side > 0.0 else last
            side = 1.0
        done = high - low <= 1e-15 * length or abs(value) <= 1e-15
        if (done and first > 0.0) or high < 1e-12:
            break
    return part
