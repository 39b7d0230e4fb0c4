"""The pairs of a wheel, which take turns: each has its scene, its panels and its map of w.

The parts of a perfect wheel are alike. It has one pair, whose scene is that of the escapement. Of
imperfect parts `mechanisms.pattern` lays out every pair with a path of its own. If a pin strikes, a
part of the speed is left: an impact is a linear map of w. `engage` goes over the engagement of a
pair, and over the handoff to the next one; `pass_round` goes over all pairs in turn.
"""

from typing import Any, NamedTuple

import numpy as np

from escapement.dynamics.codes import Event
from escapement.dynamics.law import is_felt, left_by_impact
from escapement.dynamics.painleve import beyond_painleve
from escapement.engines.energy.calls import march, refine
from escapement.engines.energy.located_events import EVENT, most_events, note
from escapement.engines.energy.march import OK, PAINLEVE
from escapement.engines.energy.panels import MAX_PANELS, NO_PANELS, NUMBER, WHOLE, Store, new_store
from escapement.engines.energy.passage import Detail
from escapement.mechanisms.pattern import Handoff, path_in
from escapement.mechanisms.slotted import transmission_at
from escapement.model.scene import Scene
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit
from escapement.numerics.records import record_dtype

PAIR_DATA = record_dtype(
    {
        "panels": WHOLE,  # how many panels its chain has
        "share": NUMBER,  # share of the speed that the handoff at its end leaves
        # w behind the handoff is exp(slope - exponent) w + source/inertia, see `MarchResult`
        **dict.fromkeys(("slope", "inertia"), NUMBER),
        # driver angle from the start of a round to that of its engagement, and to the next round
        **dict.fromkeys(("begin", "lap"), NUMBER),
        # of the last round: its time, and w at its end and behind the handoff
        **dict.fromkeys(("time", "before", "after"), NUMBER),
        # of the terminal cycle: greatest maximum and least minimum of the speed, NaN where there is
        # none, and the speed behind the handoff
        **dict.fromkeys(("top", "low", "final"), NUMBER),
    }
)
"""What is known of one pair of a wheel."""

# The panels of this many pairs are kept; those of a longer pattern are laid out every time.
MOST_CHAINS = 16
# Number of events of one engagement of a pair, see `located_events.most_events`.
MOST_EVENTS = 32


class MarchInputs(NamedTuple):
    """The arguments that all marches of one case share.

    addresses : as `calls.kernel_addresses` returns them.
    scene : a `Scene`. Of a pattern each pair has its own path, edges and dwell.
    cells : of the mechanism's path; none of a pattern.
    pattern : array of `mechanisms.pattern.PAIR`, empty for perfect parts.
    data : array of `PAIR_DATA`, one for each pair.
    store, events : memory that the marches fill, a `Store` and an array of `EVENT`.
    """

    addresses: np.ndarray
    scene: Scene
    cells: Any
    pattern: Any
    data: Any
    store: Store
    events: Any


class Start(NamedTuple):
    """How a march begins: w, the sign of theta_ddot before it, and the row of its first event."""

    w: float
    rising: float
    first: int


class Engaged(NamedTuple):
    """What an engagement and the handoff behind it, or a round of them, have led to.

    status : a value of `Status`.
    w : behind the handoff.
    angle, pair : driver angle of a stall [rad], and the index of the pair.
    time : from the start to the start of the next one, or to a stall.
    slope, source : of the map exp(slope) w + source, which holds as long as the reversals stay at
        their angles.
    side, rising, used : s at the exit, sign of theta_ddot at the end, and number of events noted.
    """

    status: int
    w: float
    angle: float
    pair: int
    time: float
    slope: float
    source: float
    side: float
    rising: float
    used: int


@inner_jit(allocates=True, inlined=True)
def scene_of_pair(scene, pattern, index, driver_angle):
    """The scene of a pair of a pattern, after a driver angle turned; of perfect parts the same."""
    scene = altered(scene, "driver_angle", driver_angle)
    if pattern.size > 0:
        pair = pattern[index]
        edges = pair.edges[: pair.used]
        scene = altered(scene, "path", path_in(pair), "edges", edges, "dwell", pair.dwell)
    return scene


@inner_jit(allocates=True, inlined=True)
def scene_at(case, index, driver_angle):
    """The scene of a pair of a case, after a driver angle turned."""
    return scene_of_pair(case.scene, case.pattern, index, driver_angle)


@inner_jit(inlined=True)
def store_of(case, index):
    """Memory for the panels of a pair."""
    first = index % MOST_CHAINS * MAX_PANELS
    return Store(case.store.panels[first : first + MAX_PANELS], case.store.workspace)


@inner_jit(allocates=True, inlined=True)
def new_case(addresses, scene, cells, pattern, room):
    """The inputs of a case, with memory for so many events."""
    count = max(pattern.size, 1)
    data, events = np.empty(count, PAIR_DATA), np.empty(room, EVENT)
    return MarchInputs(
        addresses=addresses, scene=scene, cells=cells, pattern=pattern, data=data,
        store=new_store(min(count, MOST_CHAINS) * MAX_PANELS), events=events,
    )  # fmt: skip


@inner_jit
def round_events(edges, size):
    """Number of events of one round for which there must be room."""
    # an engagement of a pair has four edges at most
    return most_events(edges) if size == 0 else size * MOST_EVENTS


@inner_jit
def prepare(case):
    """Fill what is known of the pairs before any motion; returns OK, or PAINLEVE."""
    status, size, begin = OK, case.data.size, 0.0
    for index in range(size):
        data, scene = case.data[index], scene_at(case, index, 0.0)
        # at the Painleve limit J_s reaches zero, and the march would divide by it
        if beyond_painleve(scene):
            status = PAINLEVE
        data.panels, data.share, data.begin = NO_PANELS, 1.0, begin
        begin += scene.edges[-1] - scene.edges[0] + scene.dwell
        following = (index + 1) % size
        if case.pattern.size > 0 and case.pattern[following].kind == Handoff.STRIKE:
            data.share = left_by_impact(scene_at(case, following, 0.0))
        # in a published cell g differs between entry and exit; then the map has the slope
        # exp(-exponent) (1 - unequal), in which equal ends leave no rounding
        g_in = transmission_at(scene.path, scene.edges[0])[0]
        g_out = 0.0 if scene.dwell > 0.0 else transmission_at(scene.path, scene.edges[-1])[0]
        inertia = scene.rho + g_out * g_out
        unequal = (g_out - g_in) * (g_out + g_in) / inertia
        data.slope, data.inertia = 0.0, inertia / data.share**2
        if unequal != 0.0 or data.share < 1.0:
            data.slope = np.log1p(-unequal) + 2.0 * np.log(data.share)
    for index in range(size):
        case.data[index].lap = begin
    return status


@inner_jit
def start_inertia(case, index):
    """rho + g^2 where the engagement of a pair begins."""
    scene = scene_at(case, index, 0.0)
    return scene.rho + transmission_at(scene.path, scene.edges[0])[0] ** 2


@inner_jit
def lay_out_again(case):
    """Drop the panels of all pairs."""
    for index in range(case.data.size):
        case.data[index].panels = NO_PANELS


@inner_jit
def engage(case, index, start, request, driver_angle):
    """March over the engagement of a pair, after a driver angle turned, to the next handoff."""
    data = case.data[index]
    if case.data.size > MOST_CHAINS:
        data.panels = NO_PANELS
    scene, store = scene_at(case, index, driver_angle), store_of(case, index)
    found = march(
        case.addresses, scene, case.cells, store, data.panels, request, start.w, start.rising,
        case.events, start.first,
    )  # fmt: skip
    data.panels = found.panels
    w, rising, used = found.w, found.rising, found.used
    if data.share < 1.0:
        w *= data.share**2
        # the speed falls at once, from a maximum if it rose
        if is_felt(data.share) and found.status == OK and request.detail > Detail.TIME:
            if rising > 0.0:
                end = scene.edges[-1] + scene.dwell
                used = note(case.events, used, Event.MAXIMUM, end, found.time, found.w)
            rising = -1.0
    data.time, data.before, data.after = found.time, found.w, w
    return Engaged(
        status=found.status, w=w, angle=found.angle, pair=index, time=found.time,
        slope=data.slope - found.exponent, source=found.source / data.inertia, side=found.side,
        rising=rising, used=used,
    )  # fmt: skip


@inner_jit
def pass_round(case, start, request):
    """Pass the engagements of all pairs in turn; a round after which the same ones follow.

    Its events are marked with their pair and with the time from the start of the round.
    """
    w, rising, used, slope, source, time = start.w, start.rising, start.first, 0.0, 0.0, 0.0
    for index in range(case.data.size):
        found = engage(case, index, Start(w, rising, used), request, 0.0)
        for i in range(used, found.used):
            case.events[i].index, case.events[i].engagement_start = index, time
        w, rising, used, time = found.w, found.rising, found.used, time + found.time
        source = np.exp(found.slope) * source + found.source if index > 0 else found.source
        slope += found.slope
        if found.status != OK:
            break
    return Engaged(
        status=found.status, w=w, angle=found.angle, pair=found.pair, time=time, slope=slope,
        source=source, side=found.side, rising=rising, used=used,
    )  # fmt: skip


@inner_jit
def make_exact(case, i, driver_angle):
    """Make event i exact, see `located_events.refine`."""
    event = case.events[i]
    if not event.exact:
        scene = scene_at(case, event.index, driver_angle)
        refine(case.addresses, scene, case.store, case.events, i)
