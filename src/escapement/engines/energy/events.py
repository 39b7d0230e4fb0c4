"""What a march notes of an engagement: reversals, extrema, breaks.

An extremum is noted with the values at its panel's points: the speed there is known
roughly at once, exactly only when asked for. Most extrema of a transient never are.
"""

import numpy as np

from escapement.dynamics import bend, effective_ratio
from escapement.engines.energy.gauss import POINTS, N, cumulate, dot, points_of
from escapement.engines.energy.locate import locate, weights_to
from escapement.engines.energy.panels import (
    HALF,
    INVERSE,
    LEFT,
    RIGHT,
    START,
    A,
    E,
    F,
    G,
    K,
    Q,
    U,
    V,
    W,
    at_gauss_points,
    solution_of,
    survey,
)
from escapement.engines.energy.sampling import duration, run_over
from escapement.engines.energy.solve import solve_side
from escapement.jit import jit
from escapement.mechanisms.slotted import PLACES, transmission_at

REVERSAL, MINIMUM, MAXIMUM, BREAK = 0.0, 1.0, 2.0, 3.0
# columns of an event. ANGLE, TIME: from dead centre, since the entry; of an extremum that is
# not PLACED those of its panel's left end, SQUARE being rough. The rest: by what it is placed
KIND, ANGLE, TIME, SQUARE, PLACED = range(5)
COARSE, WIDTH, SIDE, ENERGY, POINT, FIRST, FINAL, HIGH = range(5, 13)
VALUES = 16  # F, C, A and E at the points, as in the scratch
EVENTS = VALUES + 4 * N
NONE = np.int64(0)  # so many events yet
ROUGH = 2e-3  # relative error of a rough square; at most 3e-4 in 2400 random cases


@jit
def most_events(breaks):
    """Room for the events of an engagement."""
    return 16 + 4 * breaks.size


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
def note_extremum(
    events, used, kind, s, at, side, time, energy, point, first, final, high, coarse, mu
):  # fmt: skip
    """Add an extremum between a panel's points `point` - 1 and `point`; returns how many.

    `time` and `energy` are those of the panel's left end, `first` and `final` the
    acceleration there and at x = `high`; a `coarse` panel is not to be interpolated.
    """
    if used >= events.shape[0]:
        return used
    events[used, KIND], events[used, ANGLE], events[used, TIME] = kind, s[at + LEFT], time
    events[used, PLACED], events[used, COARSE], events[used, POINT] = 0.0, coarse, point
    events[used, WIDTH], events[used, SIDE], events[used, ENERGY] = s[at + HALF], side, energy
    events[used, FIRST], events[used, FINAL], events[used, HIGH] = first, final, high
    row = used & PLACES
    for i in range(4 * points_of(s)):
        events[row, VALUES + i] = s[F + i]
    if point == 0 or point == N or POINTS[point] >= high:
        # not between two points: nothing is known without placing it
        events[used, SQUARE] = np.nan
        return used + 1
    # on the cubic through both points and slopes, where the chord of the slopes vanishes
    one, two = point - 1, point
    width, lost = 2.0 * s[at + HALF] * (POINTS[two] - POINTS[one]), bend(side, mu)
    j_one = 1.0 / s[at + INVERSE + one] + lost * s[at + G + one] * s[at + U + one]
    j_two = 1.0 / s[at + INVERSE + two] + lost * s[at + G + two] * s[at + U + two]
    before, behind = width * s[A + one] / j_one, width * s[A + two] / j_two
    x = before / (before - behind)
    y = 1.0 - x
    w = s[W + one] * (1.0 + 2.0 * x) * y * y + s[W + two] * (3.0 - 2.0 * x) * x * x
    events[used, SQUARE] = w + (before * y - behind * x) * x * y
    return used + 1


@jit
def place(events, i, s, path, rho, mu, load):
    """Make angle, time and w of an event exact.

    The acceleration is rougher than what its panel was made for: last steps of Newton's
    have the transmission evaluated. A coarse panel is solved again up to the extremum.
    """
    if events[i, PLACED] > 0.0:
        return
    row = i & PLACES
    for j in range(4 * points_of(s)):
        s[F + j] = events[row, VALUES + j]
    left, half, side = events[i, ANGLE], events[i, WIDTH], events[i, SIDE]
    point, coarse = int(events[i, POINT]), events[i, COARSE] > 0.0
    x, slope = locate(s, A, point, events[i, FIRST], events[i, FINAL], events[i, HIGH])
    angle = left + half * (1.0 + x)
    if coarse:
        energy = events[i, ENERGY]
        at_gauss_points(s)
        survey(s, START, path, rho, left, angle)
        solve_side(s, START, side, rho, mu, load)
        run_over(s, START, side, energy, rho, mu, load)
        elapsed = duration(s)[0]
        to = solution_of(START, side)
        energy = s[to + RIGHT] * energy + s[to + RIGHT + 1]
    else:
        weights_to(s, x)
        cumulate(s, F, K)
        elapsed, energy = dot(s, Q, K), dot(s, V, E)
    g, u, dg = transmission_at(path, angle)
    p, w = effective_ratio(g, u, side, mu), energy / (rho + g * g)
    rate = 1.0 - p * (dg * w + load)
    way = -rate * half / slope
    way = way if abs(way) < 1e-2 * half else 0.0
    w += way * rate / (rho + g * p)
    if coarse and way != 0.0:
        g, u, dg = transmission_at(path, angle + way)
        left_over = 1.0 - effective_ratio(g, u, side, mu) * (dg * w + load)
        # where next to nothing was left before, it is rounding
        way *= rate / (rate - left_over) if abs(left_over) < 0.5 * abs(rate) else 1.0
    events[i, ANGLE], events[i, SQUARE] = angle + way, w
    events[i, TIME] += elapsed + way / np.sqrt(w)
    events[i, PLACED] = 1.0


@jit
def turned(events, first, used):
    """Whether the events from `first` on hold a pin reversal."""
    count = 0
    for i in range(first, used):
        count += events[i, KIND] == REVERSAL
    return count > 0
