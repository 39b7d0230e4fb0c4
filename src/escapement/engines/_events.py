"""What a march notes of an engagement: reversals, extrema, breaks.

An extremum is noted with the values at its panel's points: the speed there is known
roughly at once, exactly only when asked for. Most extrema of a transient never are.
"""

import numpy as np

from escapement._jit import jit
from escapement.dynamics import bend
from escapement.engines._gauss import POINTS, N, cumulate, dot, points_of
from escapement.engines._locate import locate, weights_to
from escapement.engines._panels import (
    HALF,
    INVERSE,
    LEFT,
    A,
    E,
    F,
    G,
    K,
    Q,
    U,
    V,
    W,
)
from escapement.mechanisms._slotted import PLACES, transmission_at

REVERSAL, MINIMUM, MAXIMUM, BREAK = 0.0, 1.0, 2.0, 3.0
# columns of an event. ANGLE, TIME: from dead centre, since the entry; of an extremum that is
# not PLACED those of its panel's left end, SQUARE being rough. The rest: by what it is placed
KIND, ANGLE, TIME, SQUARE, PLACED, WIDTH, SIDE, POINT, FIRST, FINAL, HIGH = range(11)
VALUES = 16
EVENTS = VALUES + 4 * N
EVENTS_OF_ONE = 16  # room for those of an engagement, beside its breaks
NONE = np.int64(0)  # so many events yet
ROUGH = 1e-3  # relative error of a rough square; a hundredth of it is usual


@jit
def note(events, used, kind, angle, time, w):
    """Add an event that is known exactly; returns how many there are."""
    if used < events.shape[0]:
        events[used, KIND], events[used, ANGLE] = kind, angle
        events[used, TIME], events[used, SQUARE] = time, w
        events[used, PLACED] = 1.0
        used += 1
    return used


@jit
def note_extremum(events, used, kind, s, at, side, time, point, first, final, high, rho, mu):
    """Add an extremum between a panel's points `point` - 1 and `point`; returns how many.

    `first` and `final` are the acceleration at the panel's left end and at x = `high`.
    """
    if used >= events.shape[0]:
        return used
    events[used, KIND], events[used, ANGLE], events[used, TIME] = kind, s[at + LEFT], time
    events[used, PLACED] = 0.0
    events[used, WIDTH], events[used, SIDE], events[used, POINT] = s[at + HALF], side, point
    events[used, FIRST], events[used, FINAL], events[used, HIGH] = first, final, high
    row = used & PLACES
    for i in range(4 * points_of(s)):
        events[row, VALUES + i] = s[F + i]
    # where the acceleration's chord vanishes, by the slope of w at the nearer point
    near = min(max(point, 1), N - 1)
    before, behind = s[A + near - 1], s[A + near]
    share = before / (before - behind)
    step = POINTS[near] - POINTS[near - 1]
    way = share * step
    if share > 0.5:
        way -= step
    else:
        near -= 1
    j = 1.0 / s[at + INVERSE + near] + bend(side, mu) * s[at + G + near] * s[at + U + near]
    events[used, SQUARE] = s[W + near] + way * s[at + HALF] * s[A + near] / j
    if point == 0 or point == N or POINTS[point] >= high:
        # not between two points
        events[used, SQUARE] = np.nan
    return used + 1


@jit
def place(events, i, s, path, rho, mu, load):
    """Make angle, time and w of an event exact.

    The acceleration is rougher than what its panel was made for: a last step of
    Newton's has the transmission evaluated. The speed does not change on it.
    """
    if events[i, PLACED] > 0.0:
        return
    row = i & PLACES
    for j in range(4 * points_of(s)):
        s[F + j] = events[row, VALUES + j]
    point = int(events[i, POINT])
    x, slope = locate(s, A, point, events[i, FIRST], events[i, FINAL], events[i, HIGH])
    weights_to(s, x)
    cumulate(s, F, K)
    half, lost = events[i, WIDTH], bend(events[i, SIDE], mu)
    angle = events[i, ANGLE] + half * (1.0 + x)
    g, u, dg = transmission_at(path, angle)
    w = dot(s, V, E) / (rho + g * g)
    way = (1.0 - (g + lost * abs(u)) * (dg * w + load)) / -slope
    way = half * (way if abs(way) < 1e-4 else 0.0)
    events[i, ANGLE] = angle + way
    events[i, TIME] += dot(s, Q, K) + way / np.sqrt(w)
    events[i, SQUARE] = w
    events[i, PLACED] = 1.0


@jit
def turned(events, first, used):
    """Whether the events from `first` on hold a pin reversal."""
    count = 0
    for i in range(first, used):
        count += events[i, KIND] == REVERSAL
    return count > 0
