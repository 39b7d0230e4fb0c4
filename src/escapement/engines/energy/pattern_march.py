"""Engagements that differ: a motion with imperfect parts.

Each engagement of the pattern has its own scene, over which `march` goes from the entry to the
exit and over the dwell. If the next pin strikes, a part of the speed is left: an impact is a linear
map of w.
"""

from typing import Any, NamedTuple

import numpy as np

from escapement.dynamics.law import left_by_impact, scene_of
from escapement.dynamics.painleve import beyond_painleve
from escapement.dynamics.torque import is_constant, is_spent
from escapement.engines.energy.calls import march, refine
from escapement.engines.energy.located_events import EVENT, NO_EVENTS
from escapement.engines.energy.march import OK, PAINLEVE, SPENT, STALL
from escapement.engines.energy.panels import MAX_PANELS, NO_PANELS, Store, new_store
from escapement.engines.energy.passage import Detail, request_of
from escapement.mechanisms.pattern import Handoff, path_in
from escapement.mechanisms.slotted import transmission_at
from escapement.model.scene import Scene
from escapement.numerics.jit import inner_jit, jit

# The panels of this many engagements are kept; those of a longer pattern are laid out every time.
MOST_CHAINS = 16
# An engagement of a pin has at most four edges, see `events.most_events`.
MOST_EVENTS = 32
# A motion that has not settled after this many engagements gets no settling time.
LONGEST_TRANSIENT = 10_000


class Finals(NamedTuple):
    """Results of a passage for each engagement, one column each.

    low, top : least minimum and greatest maximum of the driver speed, NaN without one.
    time : from its start to the start of the next one.
    before, after : w at its end, before and after an impact.
    """

    low: Any
    top: Any
    time: Any
    before: Any
    after: Any


class PatternInputs(NamedTuple):
    """Data that the marches of one pattern share.

    addresses, none : of the long kernels, and no cells.
    shared : the `Scene` of any engagement.
    pairs : array of `mechanisms.pattern.PAIR`.
    store, counts : memory for the panels, and how many there are of each engagement.
    events : memory that a march asks for.
    finals : of the last passage whose extrema were noted.
    handoffs : time and w at the start and the end of an engagement, shape (2, 2).
    shares : of each engagement, share of the speed that the handoff at its end leaves.
    slopes, gains : of the map w_out = exp(slope - exponent) w_in + gain source of each.
    """

    addresses: np.ndarray
    shared: Scene
    none: Any
    pairs: Any
    store: Store
    counts: Any
    events: Any
    finals: Finals
    handoffs: Any
    shares: Any
    slopes: Any
    gains: Any


@inner_jit(allocates=True, inlined=True)
def scene_in(shared, pair, driver_angle=0.0):
    """The scene of an engagement, after a driver angle turned.

    All but path, edges and dwell is that of `shared`, the scene of any engagement.
    """
    return Scene(
        path=path_in(pair), edges=pair.edges[: pair.used], dwell=pair.dwell,
        torque=shared.torque, driver_angle=driver_angle, rho=shared.rho, mu_plus=shared.mu_plus,
        mu_minus=shared.mu_minus, load=shared.load, bearing=shared.bearing,
        driver_drag=shared.driver_drag, follower_drag=shared.follower_drag,
        driver_viscous=shared.driver_viscous, follower_viscous=shared.follower_viscous,
        pin=shared.pin, driver_journal=shared.driver_journal,
        follower_journal=shared.follower_journal, gain=shared.gain, flow=shared.flow,
        barrel=shared.barrel, barrel_efficiency=shared.barrel_efficiency,
        load_train=shared.load_train, load_train_efficiency=shared.load_train_efficiency,
    )  # fmt: skip


@inner_jit(allocates=True)
def memory(size):
    """Panels, how many there are of each engagement of a pattern of that size, and events."""
    chains = min(size, MOST_CHAINS)
    store = new_store(chains * MAX_PANELS)
    return store, np.empty(chains, np.int64), np.empty(MOST_EVENTS, EVENT)


@inner_jit(allocates=True)
def case_of(addresses, shared, none, pairs, store, counts, events):
    """Shares of w that the handoffs of a pattern leave, in the memory of `memory`; and a status."""
    size = pairs.size
    for i in range(counts.size):
        counts[i] = NO_PANELS
    shares, slopes, gains = np.ones(size), np.empty(size), np.empty(size)
    status = OK
    for k in range(size):
        scene, following = scene_in(shared, pairs[k]), pairs[(k + 1) % size]
        if beyond_painleve(scene):
            status = PAINLEVE
        if following.kind == Handoff.STRIKE:
            shares[k] = left_by_impact(scene_in(shared, following))
        g_in = transmission_at(scene.path, scene.edges[0])[0]
        g_out = transmission_at(scene.path, scene.edges[-1])[0] if scene.dwell == 0.0 else 0.0
        gains[k] = shares[k] * shares[k] / (scene.rho + g_out * g_out)
        slopes[k] = np.log((scene.rho + g_in * g_in) * gains[k])
    finals = Finals(np.empty(size), np.empty(size), np.empty(size), np.empty(size), np.empty(size))
    case = PatternInputs(
        addresses=addresses, shared=shared, none=none, pairs=pairs, store=store,
        counts=counts, events=events, finals=finals, handoffs=np.empty((2, 2)), shares=shares,
        slopes=slopes, gains=gains,
    )  # fmt: skip
    return case, status


@inner_jit(allocates=True)
def begins_of(pairs):
    """Driver angles from the start of the pattern to each of its engagements, and to its end."""
    begins = np.zeros(pairs.size + 1)
    for k in range(pairs.size):
        pair = pairs[k]
        cell = pair.edges[pair.used - 1] - pair.edges[0] + pair.dwell
        begins[k + 1] = begins[k] + cell
    return begins


@inner_jit
def engage(case, index, w, rising, request, driver_angle=0.0):
    """March over one engagement of the pattern, and make the extrema it notes exact."""
    chains = case.counts.size
    chain = index % chains
    count = case.counts[chain] if case.pairs.size == chains else NO_PANELS
    rows = case.store.panels[chain * MAX_PANELS : (chain + 1) * MAX_PANELS]
    store = Store(rows, case.store.workspace)
    scene = scene_in(case.shared, case.pairs[index], driver_angle)
    found = march(
        case.addresses, scene, case.none, store, count, request, w, rising, case.events, NO_EVENTS
    )
    case.counts[chain] = found.panels
    for i in range(found.used):
        refine(case.addresses, scene, store, case.events, i)
    return found


@jit(allocates=True)
def pattern_handoffs(addresses, scene_tuple, none, pairs, w, limit, rtol, clock, times, speeds):
    """As `handoffs.handoffs`; speeds are those after an impact."""
    shared = scene_of(scene_tuple)
    case, status = case_of(addresses, shared, none, pairs, *memory(pairs.size))
    if status != OK:
        return status, 0, 0.0
    request = request_of(Detail.TIME, rtol)
    size, time, carry, slope, start, began = pairs.size, 0.0, 0.0, 0.0, w, 0.0
    begins, constant = begins_of(pairs), is_constant(scene_in(shared, pairs[0]))
    for k in range(times.size):
        index = k % size
        driver_angle = 0.0 if constant else k // size * begins[size] + begins[index]
        found = engage(case, index, w, 0.0, request, driver_angle)
        if found.status != OK:
            times[k] = (time + found.time) * clock
            here = scene_in(shared, pairs[index], driver_angle)
            spent = found.status == STALL and is_spent(found.angle, here)
            return SPENT if spent else found.status, k, found.angle
        w = found.w * case.shares[index] ** 2
        slope += case.slopes[index] - found.exponent
        # Kahan's sum: the rounding errors of a million engagements must not add up
        step = found.time - carry
        total = time + step
        carry = (total - time) - step
        time = total
        times[k], speeds[k] = time * clock, np.sqrt(w) / clock
        if time >= limit:
            return OK, k + 1, 0.0
        if constant and index == size - 1:
            # see `handoffs.handoffs`: where the changes still to come are negligible, the pattern
            # repeats itself
            gap = -np.expm1(slope)
            if abs(w - start) <= 0.05 * rtol * gap * gap * start:
                return OK, _repeat(k, size, began, time, limit, clock, times, speeds), 0.0
            slope, start, began = 0.0, w, time
    return OK, times.size, 0.0


@inner_jit
def _repeat(k, size, began, time, limit, clock, times, speeds):
    """Repeat the pattern that ends with engagement k; returns the number of engagements."""
    for j in range(k + 1, times.size):
        rounds, index = (j - k - 1) // size, (j - k - 1) % size
        since = times[k - size + 1 + index] / clock - began
        passed = time + rounds * (time - began) + since
        times[j] = passed * clock
        speeds[j] = speeds[k - size + 1 + index]
        if passed >= limit:
            return j + 1
    return times.size
