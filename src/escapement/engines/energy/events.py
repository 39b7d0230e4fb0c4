"""What a march notes of an engagement: reversals, extrema, breaks.

An extremum is noted with the values at its panel's points: the speed there is known
roughly at once, exactly only when asked for. Most extrema of a transient never are.
"""

from enum import IntEnum

import numpy as np

from escapement.dynamics import driving, effective_ratio, reduced_inertia
from escapement.engines.energy.gauss import POINTS, N, cumulate, dot
from escapement.engines.energy.locate import locate, weights_to
from escapement.engines.energy.panels import at_gauss_points, points_of, solution_of, survey
from escapement.engines.energy.records import NUMBER, ROW, TRUTH, WHOLE, copy_row, record
from escapement.engines.energy.sampling import duration, run_over
from escapement.engines.energy.solve import solve_side
from escapement.jit import inner_jit
from escapement.mechanisms.slotted import transmission_at


class EventKind(IntEnum):
    """What happens at an event; ENTRY and EXIT of a pin are of finished motions only."""

    REVERSAL = 0
    MINIMUM = 1
    MAXIMUM = 2
    BREAK = 3
    ENTRY = 4
    EXIT = 5


EVENT = record(
    {
        "kind": WHOLE,
        # driver angle from dead centre and time since the entry; of an extremum that is not
        # placed those of the left end of its panel
        **dict.fromkeys(("angle", "time"), NUMBER),
        "w": NUMBER,  # rough where the event is not placed
        "placed": TRUTH,
        # of an extremum, by what it is placed: half the width of its panel, whether that is too
        # coarse to be interpolated, the side of the slot, E at the left end, the point behind
        # the extremum, J theta_ddot at the left end and at x = high
        **{"half": NUMBER, "coarse": TRUTH, "side": NUMBER, "left_energy": NUMBER},
        **{"point": WHOLE, "first": NUMBER, "final": NUMBER, "high": NUMBER},
        # rows of the workspace
        **dict.fromkeys(("energy", "rate", "slowness"), ROW),
        # of the transient: when its engagement began, whether no other extremum of its kind
        # goes further in it
        **{"since": NUMBER, "leading": TRUTH},
    }
)
"""An event of an engagement."""

NONE = np.int64(0)  # so many events yet
ROUGH = 2e-3  # relative error of a rough w; at most 3e-4 in 2400 random cases
NEAR = 1e-2  # of a panel: a last step of Newton's beyond this is not trusted


@inner_jit
def most_events(edges):
    """Room for the events of an engagement."""
    return 16 + 4 * edges.size


@inner_jit
def is_extremum(event):
    """Whether an event is an extremum of the driver speed."""
    return EventKind.MINIMUM <= event.kind <= EventKind.MAXIMUM


@inner_jit
def extremum_kind(rising):
    """Kind of the extremum behind a stretch on which the speed rises, or falls."""
    return np.int64(EventKind.MAXIMUM if rising > 0.0 else EventKind.MINIMUM)


@inner_jit
def note(events, used, kind, angle, time, w):
    """Add an event that is known exactly; returns how many there are."""
    if used < events.shape[0]:
        event = events[used]
        event.kind = kind
        event.angle, event.time, event.w = angle, time, w
        event.placed = True
        used += 1
    return used


@inner_jit
def note_extremum(scene, events, used, kind, work, panel, found, high):
    """Add an extremum between a panel's points `found.point` - 1 and it; returns how many.

    `found` is a `passage.Extremum`; its `final` is the value at x = `high`.
    """
    if used >= events.shape[0]:
        return used
    event = events[used]
    event.kind = kind
    event.angle, event.time, event.half = panel.left, found.time, panel.half
    event.placed, event.coarse, event.point = False, found.coarse, found.point
    event.side, event.left_energy = found.side, found.energy
    event.first, event.final, event.high = found.first, found.final, high
    count = points_of(work)
    copy_row(event.energy, work.energy, count)
    copy_row(event.rate, work.rate, count)
    copy_row(event.slowness, work.slowness, count)
    point = found.point
    if point == 0 or point == N or POINTS[point] >= high:
        # not between two points: nothing is known without placing it
        event.w = np.nan
    else:
        event.w = _rough_square(scene, work, panel, found.side, point)
    return used + 1


@inner_jit
def _rough_square(scene, work, panel, side, point):
    """w at an extremum between two points, on the cubic through both points and slopes."""
    one, two = point - 1, point
    width = 2.0 * panel.half * (POINTS[two] - POINTS[one])
    # slopes of w by share of the way between the points
    before = width * work.rate[one] / reduced_inertia(panel.g[one], panel.u[one], side, scene)
    behind = width * work.rate[two] / reduced_inertia(panel.g[two], panel.u[two], side, scene)
    # the place is where the chord of the slopes vanishes
    x = before / (before - behind)
    y = 1.0 - x
    w = work.w[one] * (1.0 + 2.0 * x) * y * y + work.w[two] * (3.0 - 2.0 * x) * x * x
    return w + (before * y - behind * x) * x * y


@inner_jit
def place(scene, store, events, i):
    """Make angle, time and w of event i exact.

    The acceleration is rougher than what its panel was made for: last steps of Newton's
    have the transmission evaluated. A coarse panel is solved again up to the extremum.
    """
    work, event = store.workspace[0], events[i]
    if event.placed:
        return
    x, slope = locate(work, event.rate, event.point, event.first, event.final, event.high)
    angle = event.angle + event.half * (1.0 + x)
    elapsed, energy = _up_to(scene, work, event, x, angle)
    g, u, dg = transmission_at(scene.path, angle)
    p, w = effective_ratio(g, u, event.side, scene), energy / (scene.rho + g * g)
    rate = driving(g, u, dg, w, event.side, scene)
    way = -rate * event.half / slope
    way = way if abs(way) < NEAR * event.half else 0.0
    w += way * rate / (scene.rho + g * p)
    if event.coarse and way != 0.0:
        g, u, dg = transmission_at(scene.path, angle + way)
        left_over = driving(g, u, dg, w, event.side, scene)
        # where next to nothing was left before, it is rounding
        way *= rate / (rate - left_over) if abs(left_over) < 0.5 * abs(rate) else 1.0
    event.angle, event.w = angle + way, w
    event.time += elapsed + way / np.sqrt(w)
    event.placed = True


@inner_jit
def _up_to(scene, work, event, x, angle):
    """Time and E from the left end of an event's panel to the place x, at driver angle `angle`."""
    if not event.coarse:
        weights_to(work, x)
        cumulate(event.slowness, work.series)
        count = points_of(work)
        return dot(work.from_left, work.series, count), dot(work.at_x, event.energy, count)
    panel = work.start
    at_gauss_points(work)
    survey(work, panel, scene.path, scene.rho, event.angle, angle)
    solve_side(scene, work, panel, event.side)
    solution = solution_of(panel, event.side)
    run_over(scene, work, panel, solution, event.side, event.left_energy)
    return duration(work)[0], solution.alpha_end * event.left_energy + solution.beta_end


@inner_jit
def turned(events, first, used):
    """Whether the events from `first` on hold a pin reversal."""
    count = 0
    for i in range(first, used):
        count += events[i].kind == EventKind.REVERSAL
    return count > 0
