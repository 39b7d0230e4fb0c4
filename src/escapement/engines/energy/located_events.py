"""The events of an engagement that a march notes: reversals, extrema and breaks.

An extremum is noted together with the values at the points of its panel. Its rough speed is known
at once; `refine` makes it exact, which is not needed for most extrema of a transient.
"""

import numpy as np

from escapement.dynamics.codes import Event
from escapement.dynamics.law import bent_pose, net_torque, reduced_inertia, root_of
from escapement.dynamics.load import load_at
from escapement.dynamics.needs import needed_scene
from escapement.dynamics.torque import drive_torque
from escapement.dynamics.train_losses import in_flow
from escapement.engines.energy import panels
from escapement.engines.energy.locate import locate, weights_to
from escapement.engines.energy.panels import (
    FLAG,
    NUMBER,
    ROW,
    WHOLE,
    copy_row,
    solution_of,
)
from escapement.engines.energy.sampling import duration, sample_panel
from escapement.engines.energy.solve import solve_side
from escapement.numerics.gauss import POINTS, N, cumulate, dot
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.records import record_dtype

EVENT = record_dtype(
    {
        "kind": WHOLE,  # an `Event`, but no entry, which `pieces.events_of` adds
        # the driver angle and the time since the entry; of an extremum that is not exact yet
        # these are those of the left end of its panel
        **dict.fromkeys(("angle", "time"), NUMBER),
        # theta_dot^2; of an extremum rough or NaN where the event is not exact yet
        "w": NUMBER,
        "exact": FLAG,
        # what `refine` needs of an extremum: half the width of its panel, whether the panel is
        # too coarse for interpolation, s, E at the left end, the point behind the extremum,
        # and J theta_ddot at the left end and at x = high
        **{"half": NUMBER, "coarse": FLAG, "side": NUMBER, "left_energy": NUMBER},
        "flow": NUMBER,  # flow of the scene, see `dynamics.train_losses`
        **{"point": WHOLE, "first": NUMBER, "final": NUMBER, "high": NUMBER},
        # copies of these rows of the workspace
        **dict.fromkeys(("energy", "net_torque", "slowness"), ROW),
        # for `figures`: the pair of its engagement, when this began in the transient, and whether
        # it is the greatest maximum or the least minimum of that engagement
        **{"index": WHOLE, "engagement_start": NUMBER, "outermost": FLAG},
    }
)
"""An event of an engagement."""

NO_EVENTS = 0
# This bounds the relative error of a rough w, which was at most 3e-4 in 2400 random cases.
ROUGH_ERROR = 2e-3
# A last step of Newton's method for an extremum that is longer than this, in x, is due to
# rounding and left out.
LARGEST_CORRECTION = 1e-2


@inner_jit
def most_events(edges):
    """Number of events of one engagement for which there must be room."""
    return 16 + 4 * edges.size


@inner_jit
def extremum_kind(rising):
    """Kind of the extremum that follows where the speed rises (`rising` > 0) or falls."""
    return Event.MAXIMUM if rising > 0.0 else Event.MINIMUM


@inner_jit
def note(events, used, kind, angle, time, w):
    """Add an event that needs no `refine`; returns the number of events.

    A reversal comes with NaN for angle, time and w unless all details are asked for.
    """
    if used < events.shape[0]:
        event = events[used]
        event.kind = kind
        event.angle, event.time, event.w = angle, time, w
        event.exact = True
        used += 1
    return used


@inner_jit
def note_extremum(scene, events, used, kind, work, panel, found, high):
    """Add an extremum just before the point `found.point`; returns the number of events.

    `found` is a `passage.SpeedExtremum`; its `final` is the value at x = `high`.
    """
    if used >= events.shape[0]:
        return used
    event = events[used]
    event.kind = kind
    event.angle, event.time, event.half = panel.left, found.time, panel.half
    event.exact, event.coarse, event.point = False, found.coarse, found.point
    # as everywhere, 0 stands for a dwell
    event.side = 0.0 if panel.locked else found.side
    event.left_energy, event.flow = found.energy, scene.flow
    event.first, event.final, event.high = found.first, found.final, high
    count = panels.points_of(work)
    copy_row(event.energy, work.energy, count)
    copy_row(event.net_torque, work.net_torque, count)
    copy_row(event.slowness, work.slowness, count)
    point = found.point
    if point == 0 or point == N or POINTS[point] >= high:
        # it lies beside an end and not between two points, so that there is no cubic
        event.w = np.nan
    else:
        event.w = _rough_square(scene, work, panel, solution_of(panel, found.side), point)
    return used + 1


@inner_jit
def _rough_square(scene, work, panel, solution, point):
    """w at an extremum between two points, from the cubic with their values and slopes."""
    one, two = point - 1, point
    width = 2.0 * panel.half * (POINTS[two] - POINTS[one])
    # dw/dtheta = 2 theta_ddot, here by the share x of the distance between the points
    before = (
        width
        * work.net_torque[one]
        / reduced_inertia(panel.g[one], solution.friction_ratio[one], scene)
    )
    behind = (
        width
        * work.net_torque[two]
        / reduced_inertia(panel.g[two], solution.friction_ratio[two], scene)
    )
    # the extremum lies where the chord of the slopes vanishes
    x = before / (before - behind)
    y = 1.0 - x
    w = work.w[one] * (1.0 + 2.0 * x) * y * y + work.w[two] * (3.0 - 2.0 * x) * x * x
    return w + (before * y - behind * x) * x * y


@jit(addressed=True)
def refine(kind, scene, store, events, i):
    """Make the angle, time and w of event i exact.

    J theta_ddot is rougher than E, for which the panel was made fine enough. Its root at the
    points is therefore improved by Newton's method with g, u and g' evaluated there. A panel
    too coarse for interpolation is solved again from its left end to the extremum.
    """
    work, event = store.workspace[0], events[i]
    if event.exact:
        return
    if scene.flow != event.flow:
        scene = in_flow(scene, event.flow)
    here = needed_scene(scene, kind)
    x, slope = locate(work, event.net_torque, event.point, event.first, event.final, event.high)
    angle = event.angle + event.half * (1.0 + x)
    elapsed, energy = _up_to(here, work, event, x, angle)
    g, c, k = bent_pose(angle, event.side, here)
    w = energy / (here.rho + g * g)
    pull = drive_torque(angle, w, here) - here.bearing
    # the first step of Newton's method: `slope` is d(J theta_ddot)/dx
    load = load_at(angle, event.side, here)
    torque = net_torque(g, c, k, pull, w, root_of(w, here), here, load)
    correction = -torque * event.half / slope
    correction = correction if abs(correction) < LARGEST_CORRECTION * event.half else 0.0
    # over the step theta_ddot falls linearly to zero, so dw = 2 theta_ddot correction/2
    w += correction * torque / reduced_inertia(g, c, here)
    if event.coarse and correction != 0.0:
        g, c, k = bent_pose(angle + correction, event.side, here)
        pull = drive_torque(angle + correction, w, here) - here.bearing
        load = load_at(angle + correction, event.side, here)
        left_over = net_torque(g, c, k, pull, w, root_of(w, here), here, load)
        # a secant step; where the first step did not halve the torque, that was only rounding
        correction *= torque / (torque - left_over) if abs(left_over) < 0.5 * abs(torque) else 1.0
    event.angle, event.w = angle + correction, w
    event.time += elapsed + correction / np.sqrt(w)
    event.exact = True


@inner_jit
def _up_to(scene, work, event, x, angle):
    """Time from the left end of an event's panel to x, where the driver angle is `angle`; and E."""
    if not event.coarse:
        weights_to(work, x)
        cumulate(event.slowness, work.scratch)
        count = panels.points_of(work)
        return dot(work.from_left, work.scratch, count), dot(work.at_x, event.energy, count)
    # the panel is solved again between its left end and the extremum, outside the chain
    panel = work.spare
    panel.locked = event.side == 0.0
    panels.evaluate_geometry(work, panel, scene, event.angle, angle)
    solve_side(scene, work, panel, event.side, event.left_energy)
    solution = solution_of(panel, event.side)
    sample_panel(scene, work, panel, solution, event.side, event.left_energy)
    return duration(work)[0], solution.alpha_end * event.left_energy + solution.beta_end


@inner_jit
def has_reversal(events, first, used):
    """Whether there is a pin reversal among the events from row `first` to before `used`."""
    count = 0
    for i in range(first, used):
        count += events[i].kind == Event.REVERSAL
    return count > 0
