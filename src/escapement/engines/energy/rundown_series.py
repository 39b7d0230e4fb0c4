"""A long run-down: its engagements as smooth functions of the angle turned.

If the torque falls linearly and the influence of the start has died out, the time of an
engagement and the w after it depend only on the torque, and smoothly. A Chebyshev series through
a few engagements then gives thousands. The march to each of these few begins some engagements
earlier, over which friction removes the error of the first w.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.torque import cell_after, cell_of, next_knot, torque_after
from escapement.engines.energy.located_events import NO_EVENTS
from escapement.engines.energy.march import OK
from escapement.engines.energy.pairs import Start, engage, lay_out_again
from escapement.engines.energy.passage import Detail
from escapement.numerics.altered import altered
from escapement.numerics.gauss import N
from escapement.numerics.jit import inner_jit

NODES = N
# A deviation of w has no influence left once the exponents of the engagements add up to this.
FORGOTTEN = 36.0
# A series must give at least WORTH engagements for each that is marched; a march for the map
# alone takes 1/MAP_SHARE of the time.
WORTH, MAP_SHARE = 2, 3
# A point between two nodes, at which the series are checked.
BETWEEN = 0.3
# The share of its torque that a drive may lose over the engagements of a series.
MOST_FALL = 0.9
# A relative error of a series below this is rounding.
ROUNDING = 5e-14


class Stretch(NamedTuple):
    """Engagements of a series: the first one, their number, and how many lead to a node."""

    first: int
    length: int
    lead: int


@inner_jit
def line_length(first, scene):
    """Number of engagements from `first` on before a knot or before little torque is left."""
    cell = cell_of(scene)
    driver_angle = first * cell
    torque, slope = torque_after(driver_angle, scene)
    if not slope < 0.0:
        return 0
    knot = next_knot(scene.edges[0], np.inf, cell_after(driver_angle, scene)) - scene.edges[0]
    return int(min(knot, -MOST_FALL * torque / slope) / cell) - 1


@inner_jit
def least_length(lead):
    """The fewest engagements that are worth a series."""
    return WORTH * (NODES + 1) * (lead // MAP_SHARE + 1)


@inner_jit
def sample(case, request, at, lead, detail, w):
    """March to the engagement `at`, a real number, from w at `lead` engagements before it.

    Returns the engagement, and the sum of the exponents of those before it.
    """
    cell, forgotten, alone = cell_of(case.scene), 0.0, case.data.size - 1
    before = altered(request, "detail", detail)
    for j in range(lead + 1):
        asked, start = before if j < lead else request, Start(w, 0.0, NO_EVENTS)
        found = engage(case, alone, start, asked, (at - lead + j) * cell)
        w = found.w
        if found.status != OK:
            break
        forgotten -= found.slope
    return found, forgotten + found.slope


@inner_jit
def fit(case, request, stretch, w, rtol, series):
    """Fill row 1 of `series` for the w after an engagement, and row 0 for its time times sqrt(w).

    Without a load w is proportional to the torque, and the other does not depend on it. x is -1
    at the first engagement and 1 at the last. Returns whether the series hold.
    """
    lay_out_again(case)
    for i in range(NODES + 1):
        # after the nodes comes a point between two of them, at which the series are checked
        x = np.cos(np.pi * (i + 0.5) / NODES) if i < NODES else BETWEEN
        at = stretch.first + 0.5 * (stretch.length - 1) * (1.0 + x)
        # events that the map alone may miss show there
        detail = Detail.MAP if i < NODES else Detail.TIME
        found, forgotten = sample(case, request, at, stretch.lead, detail, w)
        if found.status != OK or forgotten < FORGOTTEN:
            return False
        if i < NODES:
            series[2, i], series[3, i] = found.time * np.sqrt(found.w), found.w
    for row in range(2):
        for n in range(NODES):
            series[row, n] = 0.0
            for i in range(NODES):
                weight = np.cos(np.pi * n * (i + 0.5) / NODES)
                series[row, n] += weight * series[row + 2, i] * (2.0 if n > 0 else 1.0) / NODES
    allowed, good = max(0.1 * rtol, ROUNDING), 0
    distance = found.time * np.sqrt(found.w)
    good += abs(value_at(series, 0, BETWEEN) - distance) <= allowed * distance
    good += abs(value_at(series, 1, BETWEEN) - found.w) <= allowed * found.w
    for row in range(2):
        tail = abs(series[row, NODES - 1]) + abs(series[row, NODES - 2])
        good += tail <= allowed * abs(series[row, 0])
    return good == 4


@inner_jit
def value_at(series, row, x):
    """Sum of a Chebyshev series at x, by Clenshaw's recurrence."""
    b1 = b2 = 0.0
    for n in range(NODES - 1, 0, -1):
        b1, b2 = series[row, n] + 2.0 * x * b1 - b2, b1
    return series[row, 0] + x * b1 - b2


@inner_jit
def longest_stretch(case, request, first, most, lead, w, rtol, series):
    """The longest stretch of engagements from number `first` on for which series hold.

    Its length is 0 if a series is not worth while; `most` is the requested number.
    """
    length = min(line_length(first, case.scene), most)
    while length >= least_length(lead):
        stretch = Stretch(first, length, lead)
        if fit(case, request, stretch, w, rtol, series):
            return stretch
        length //= 4
    return Stretch(first, 0, lead)


@inner_jit
def fill(stretch, w, elapsed, limit, clock, series, times, speeds):
    """Fill times and speeds of the handoffs of a stretch.

    `elapsed` is that of the handoff before. Returns the number of handoffs, and w and the time
    elapsed at the last one.
    """
    for j in range(stretch.length):
        x = 2.0 * j / (stretch.length - 1) - 1.0
        w = value_at(series, 1, x)
        elapsed = later(elapsed, value_at(series, 0, x) / np.sqrt(w))
        times[stretch.first + j] = elapsed.total * clock
        speeds[stretch.first + j] = np.sqrt(w) / clock
        if elapsed.total >= limit:
            return j + 1, w, elapsed
    return stretch.length, w, elapsed


class Elapsed(NamedTuple):
    """The time since the start of a motion, and what Kahan's sum has left of it."""

    total: float
    left: float


@inner_jit
def later(elapsed, length):
    """The time after another engagement: a million rounding errors must not add up."""
    step = length - elapsed.left
    total = elapsed.total + step
    return Elapsed(total, (total - elapsed.total) - step)
