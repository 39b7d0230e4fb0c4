"""The pairs of pin and slot of a wheel, which engage one after the other.

Each pair has its own scene, its own chain of panels, and its own map from w at the start of its
engagement to w at the start of the next one (docs/theory.md, section 5). In a perfect wheel all
pins and all slots are alike, so one pair, with the scene of the escapement, stands for all of them.
With imperfect parts `mechanisms.pattern` gives every pair a path of its own, and a late pin may
strike its slot. The impact multiplies w by a constant factor. `engage` follows the engagement of
one pair and the handoff to the next pair; `pass_round` does this for all pairs in turn, a round.
"""

from typing import Any, NamedTuple

import numpy as np

from escapement.dynamics.codes import Event
from escapement.dynamics.law import is_felt, left_by_impact
from escapement.dynamics.load import cell_of_round, has_load_curve
from escapement.dynamics.torque import is_constant
from escapement.engines.energy.calls import march, refine
from escapement.engines.energy.located_events import EVENT, most_events, note
from escapement.engines.energy.march import OK
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
        # share of the speed that is left behind the handoff at its end, 1 without an impact
        "share": NUMBER,
        # two constants of its map: w behind the handoff is exp(slope - exponent) w + source/inertia
        # with exponent and source of the `MarchResult`
        **dict.fromkeys(("slope", "inertia"), NUMBER),
        # driver angle from the start of a round to the start of its engagement, and that of a whole
        # round
        **dict.fromkeys(("begin", "lap"), NUMBER),
        # of the last round: its time, and w at its end and behind the handoff
        **dict.fromkeys(("time", "before", "after"), NUMBER),
        # of its engagement in the terminal cycle: greatest maximum and least minimum of the speed,
        # NaN where there is none, and the speed behind the handoff
        **dict.fromkeys(("top", "low", "final"), NUMBER),
    }
)
"""What is known of one pair of a wheel."""

# There is memory for the panels of this many pairs. In a longer pattern several pairs share it, and
# the panels are laid out anew for each engagement.
MOST_CHAINS = 16
# Number of events of one engagement of a pair, see `located_events.most_events`.
MOST_EVENTS = 32


class MarchInputs(NamedTuple):
    """The arguments that all marches of one case share; kernels hand on its address, `held`.

    addresses : as `calls.kernel_addresses` returns them.
    scene : a `Scene`; with a pattern each pair has its own path, edges and dwell in place of those.
    cells : tabulated geometry of the scene's path; with a pattern nothing is tabulated.
    pattern : array of `mechanisms.pattern.PAIR`, empty where all engagements are alike.
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
    """How a march begins: w, the sign of theta_ddot before it, and the row for its first event."""

    w: float
    rising: float
    first: int


class Engaged(NamedTuple):
    """The result of an engagement and the handoff behind it, or of a round of them.

    status : a value of `Status`.
    w : theta_dot^2 behind the last handoff.
    angle, pair : driver angle of a stall [rad], and the index of the last pair.
    time : from the start of the engagement or round to the start of the next one, or to a stall.
    slope, source : of the map from w at the start to exp(slope) w + source behind the last handoff,
        which holds as long as the reversals stay at their angles.
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
    """The scene of a pair, after a driver angle turned; without a pattern it is `scene`."""
    scene = altered(scene, "driver_angle", driver_angle)
    if pattern.size > 0:
        pair, path = pattern[index], scene.path
        edges, load = pair.edges[: pair.used], scene.load_curve
        if pair.used == 0:
            edges = scene.edges
        if has_load_curve(scene):
            edges, load = cell_of_round(load, index)
        if not path.table:
            path = path_in(pair)
        scene = altered(
            scene, "path", path, "edges", edges, "dwell", pair.dwell, "load_curve", load
        )
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
    """The inputs of a case, with memory for `room` events."""
    count = max(pattern.size, 1)
    data, events = np.empty(count, PAIR_DATA), np.empty(room, EVENT)
    return MarchInputs(
        addresses=addresses, scene=scene, cells=cells, pattern=pattern, data=data,
        store=new_store(min(count, MOST_CHAINS) * MAX_PANELS), events=events,
    )  # fmt: skip


@inner_jit
def round_events(edges, size):
    """Number of events of one round for which there must be room; `size` is that of the pattern."""
    # `MOST_EVENTS` is `most_events` for four edges, which a pair of a pattern has at most without
    # a load that changes; with one `edges` are those of the pair that has most of them
    most = most_events(edges)
    return most if size == 0 else size * max(most, MOST_EVENTS)


@inner_jit
def prepare(case):
    """Fill the data of the pairs that do not depend on the motion."""
    size, begin = case.data.size, 0.0
    for index in range(size):
        data, scene = case.data[index], scene_at(case, index, 0.0)
        data.panels, data.share, data.begin = NO_PANELS, 1.0, begin
        begin += scene.edges[-1] - scene.edges[0] + scene.dwell
        following = (index + 1) % size
        # the handoff at the end of this pair is an impact if the pin of the next pair strikes
        if case.pattern.size > 0 and case.pattern[following].kind == Handoff.STRIKE:
            data.share = left_by_impact(scene_at(case, following, 0.0))
        # With 1 - unequal = (rho + g_in^2)/(rho + g_out^2) the map has the slope
        # share^2 (1 - unequal) exp(-exponent). Only in a cell that Meyer published does g differ
        # between entry and exit; for equal ends `unequal` is 0 without rounding error.
        g_in = transmission_at(scene.path, scene.edges[0])[0]
        g_out = 0.0 if scene.dwell > 0.0 else transmission_at(scene.path, scene.edges[-1])[0]
        inertia = scene.rho + g_out * g_out
        unequal = (g_out - g_in) * (g_out + g_in) / inertia
        data.slope, data.inertia = 0.0, inertia / data.share**2
        if unequal != 0.0 or data.share < 1.0:
            data.slope = np.log1p(-unequal) + 2.0 * np.log(data.share)
    for index in range(size):
        case.data[index].lap = begin


@inner_jit
def start_inertia(case, index):
    """rho + g^2 at the start of the engagement of a pair."""
    scene = scene_at(case, index, 0.0)
    return scene.rho + transmission_at(scene.path, scene.edges[0])[0] ** 2


@inner_jit
def lay_out_again(case):
    """Drop the panels of all pairs, so that the next march lays them out again."""
    for index in range(case.data.size):
        case.data[index].panels = NO_PANELS


@inner_jit(merged=True)
def engage(case, index, start, request, driver_angle):
    """March over the engagement of a pair and the handoff behind it.

    The engagement begins after the driver has turned by `driver_angle`, on which the torque may
    depend.
    """
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
        # the impact makes the speed fall suddenly, so it is at a maximum there if it rose before
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
def angle_in_round(case, index):
    """Driver angle turned from the start of a round to a pair, 0 under a constant torque."""
    return 0.0 if is_constant(case.scene) else case.data[index].begin


@inner_jit
def pass_round(case, start, request):
    """Pass one round: the engagements of all pairs in turn, up to the first that fails.

    For the torque, the round begins as if the driver had not turned before. Each event is marked
    with the index of its pair and with the time from the start of the round to that of its
    engagement.
    """
    w, rising, used, slope, source, time = start.w, start.rising, start.first, 0.0, 0.0, 0.0
    for index in range(case.data.size):
        begin = angle_in_round(case, index)
        found = engage(case, index, Start(w, rising, used), request, begin)
        for i in range(used, found.used):
            case.events[i].index, case.events[i].engagement_start = index, time
        w, rising, used, time = found.w, found.rising, found.used, time + found.time
        # the map of this pair is applied to the result of the map so far
        source = np.exp(found.slope) * source + found.source if index > 0 else found.source
        slope += found.slope
        if found.status != OK:
            break
    return Engaged(
        status=found.status, w=w, angle=found.angle, pair=found.pair, time=time, slope=slope,
        source=source, side=found.side, rising=rising, used=used,
    )  # fmt: skip


@inner_jit
def make_exact_in_round(case, i):
    """As `make_exact`, of an event of a round."""
    make_exact(case, i, angle_in_round(case, case.events[i].index))


@inner_jit
def make_exact(case, i, driver_angle):
    """Make the angle, time and w of event i exact, see `located_events.refine`."""
    event = case.events[i]
    if not event.exact:
        scene = scene_at(case, event.index, driver_angle)
        refine(case.addresses, scene, case.store, case.events, i)
