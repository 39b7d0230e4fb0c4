"""Figures of merit of many scenes with imperfect parts, each with its own pattern."""

from typing import Any

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.figures_of_merit import RISE_BAND, SETTLING_BAND
from escapement.dynamics.law import scene_of
from escapement.engines.energy import cycle
from escapement.engines.energy.calls import kernel_addresses
from escapement.engines.energy.case_figures import RETRY, Extent, next_fall, note_fall
from escapement.engines.energy.cells import NO_CELLS
from escapement.engines.energy.leap import (
    GAIN,
    GAP,
    GENTLE,
    ROWS,
    SLOPE,
    TIME,
    Leap,
    half_way,
    is_worth_it,
    pass_over,
    point_of,
)
from escapement.engines.energy.march import OK
from escapement.engines.energy.passage import Detail, request_of
from escapement.engines.energy.pattern_cycle import (
    extrema_of,
    find_cycle,
    is_top,
    is_turn,
    outermost,
    pass_round,
    rising_after,
    speed_at,
)
from escapement.engines.energy.pattern_march import LONGEST_TRANSIENT, case_of, engage, memory
from escapement.mechanisms.path import Path, writeable
from escapement.mechanisms.pattern import PAIR, POSSIBLE, lay_pattern, path_in
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import transmission_at
from escapement.model.scene import Scene
from escapement.numerics.gauss import N
from escapement.numerics.jit import inner_jit, jit, row_tuple

COLUMNS = (*cycle.COLUMNS, "beat_error", "blow_max")
"""Figures of merit that these kernels compute."""
FIGURES = len(COLUMNS)
BEAT_ERROR, BLOW_MAX = FIGURES - 2, FIGURES - 1
_FIRST = Scene._fields.index("rho")
_NUMBERS = len(Scene._fields) - _FIRST
_PIN = Scene._fields.index("pin") - _FIRST
_INVALID = int(Status.INVALID)
# Where a round of the cycle contracts w by less than the first share, engagements whose w differs
# by more than the second share, and four times the contraction, have no extremum in a band of 2 %.
SLOW, NEAR = 0.05, 0.06


@jit(allocates=True)
def solve_patterns(
    addresses, path, arms, turns, longer, pins, slots, numbers, none, rtol, extent, table, status
):
    """Fill table[i] and status[i] for every scene i, in natural units.

    Parameters
    ----------
    addresses, none : of the long kernels, and no cells.
    path : any path of a pin, as a plain tuple.
    arms, turns : of the wheel, as `mechanisms.pattern.lay_pattern` takes them.
    longer, pins, slots : of each scene, as it takes them.
    numbers : array of shape (scenes, k): the numbers of each scene, and its squared speed at
        the first entry.
    extent : a `figures.Extent`, how far the transient is followed.
    table, status : results, with `FIGURES` columns; NaN if there is none, except for the index of
        a stall, see `_figures`.
    """
    m, n = pins.shape[1], slots.shape[1]
    size = m * n // _divisor(m, n)
    pairs, (store, counts, events) = np.empty(size, PAIR), memory(size)
    # path, edges and dwell of a scene are those of its engagements
    torque, no_edges = np.array([0.0, 0.0, 1.0]), np.empty(0)
    for i in range(status.size):
        table[i, :] = np.nan
        constants = row_tuple(numbers[i], _NUMBERS)
        shared = Scene(Path(path[0], path[1]), no_edges, 0.0, torque, 0.0, *constants)
        if (
            lay_pattern(arms, turns, longer[i], constants[_PIN], pins[i], slots[i], pairs)
            != POSSIBLE
        ):
            status[i] = _INVALID
            continue
        case, status[i] = case_of(addresses, shared, none, pairs, store, counts, events)
        if status[i] == OK:
            status[i] = _figures(case, numbers[i, _NUMBERS], rtol, extent, table[i])


@inner_jit
def _divisor(a, b):
    """Greatest common divisor."""
    while b > 0:
        a, b = b, a % b
    return a


@jit(allocates=True)
def solve_pattern(addresses, scene_tuple, none, pairs, w, rtol, extent, out):
    """Figures of one pattern into `out`; returns its status. Arguments as in `solve_patterns`."""
    shared = scene_of(scene_tuple)
    case, status = case_of(addresses, shared, none, pairs, *memory(pairs.size))
    return _figures(case, w, rtol, extent, out) if status == OK else status


@inner_jit(allocates=True)
def _figures(case, w, rtol, extent, out):
    """Figures of one pattern into `out`; returns the status.

    On a stall out[0] is the driver angle and out[1] the engagement.
    """
    out[:] = np.nan
    status, better, slope, out[0], out[1] = find_cycle(case, w, rtol)
    if status != OK:
        return status
    _read_cycle(case, better, out)
    out[cycle.HANDOFF], out[cycle.CONTRACTION] = np.sqrt(better), np.exp(slope)
    if extent > Extent.CYCLE:
        _read_transient(case, w, rtol, extent, out)
    return OK


@inner_jit
def _read_cycle(case, w, out):
    """Figures of the cycle that starts with w, whose engagements `case.finals` has."""
    size, finals = case.pairs.size, case.finals
    fast, slow, impact, time, shortest, longest = w, w, 0.0, 0.0, np.inf, 0.0
    for index in range(size):
        beat = finals.time[index]
        time, shortest, longest = time + beat, min(shortest, beat), max(longest, beat)
        fast, slow = max(fast, finals.before[index]), min(slow, finals.after[index])
        # a comparison with NaN, where there is none, is false
        fast = finals.top[index] ** 2 if finals.top[index] ** 2 > fast else fast
        slow = finals.low[index] ** 2 if finals.low[index] ** 2 < slow else slow
        if case.shares[index] < 1.0:
            rho, g = case.shared.rho, _start_ratio(case.pairs[(index + 1) % size])
            left = (rho + g * g) * finals.after[index]
            impact = max(impact, 0.5 * (rho * finals.before[index] - left))
    out[cycle.V_MAX], out[cycle.V_MIN] = np.sqrt(fast), np.sqrt(slow)
    out[cycle.PERIOD] = time / size
    out[BEAT_ERROR], out[BLOW_MAX] = longest - shortest, impact


@inner_jit
def _start_ratio(pair):
    """g where an engagement begins."""
    return transmission_at(path_in(pair), pair.edges[0])[0]


@inner_jit(allocates=True)
def _read_transient(case, start, rtol, extent, out):
    """Times of the motion that starts with w = `start`, as `metrics` reads them off a motion."""
    near, far = request_of(Detail.EXTREMA, rtol), request_of(Detail.TIME, rtol)
    size, w, rising, time, calm = case.pairs.size, start, 0.0, 0.0, 0
    handoffs, finals, rows = case.handoffs, case.finals, np.empty((ROWS, N))
    handoffs[0, 0], handoffs[0, 1] = 0.0, start
    k, attempt = 0, 0
    while k < LONGEST_TRANSIENT:
        index = k % size
        if index == 0 and k >= attempt:
            most = (LONGEST_TRANSIENT - k) // size
            passed = _leap_rounds(case, start, w, most, rtol, extent, rows, out)
            attempt = k if passed.number > 0 else k + RETRY * size
            k, w, time = k + passed.number * size, passed.w, time + passed.time
            handoffs[k % 2, 0], handoffs[k % 2, 1] = time, w
            if k >= LONGEST_TRANSIENT:
                break
        distant = _is_distant(w, finals.after[index - 1], out[cycle.CONTRACTION])
        found = engage(case, index, w, rising, far if distant else near)
        if not distant and _judge(case, index, found, time, out):
            calm += 1
        else:
            calm = 0
        w, time = found.w * case.shares[index] ** 2, time + found.time
        # without extrema the trend is not known
        rising = 0.0 if distant else rising_after(case, index, found)
        # the speed is compared with that of the cycle at the same handoff
        handoffs[(k + 1) % 2, 0], handoffs[(k + 1) % 2, 1] = time, w
        last, following = np.sqrt(finals.after[index - 1]), np.sqrt(finals.after[index])
        note_fall(start, handoffs, k, last, following, rtol, out)
        k += 1
        # two motions never cross: when a whole round is in the band, all later ones are
        settled = calm >= size and not np.isnan(out[cycle.SETTLING])
        if settled and (extent < Extent.FALLEN or not np.isnan(out[cycle.RISE_98])):
            return
    if calm < size:
        out[cycle.SETTLING] = np.nan


@inner_jit
def _leap_rounds(case, start, w, most, rtol, extent, rows, out):
    """Leap over at most so many rounds while all extrema are far from those of the cycle."""
    final, none = out[cycle.HANDOFF] ** 2, Leap(0, w, 0.0)
    gap = 1.0 - out[cycle.CONTRACTION]
    gentle = gap < GENTLE and gap * abs(final - w) < GENTLE * w
    if not gentle or not _is_distant(w, final, out[cycle.CONTRACTION]):
        return none
    near = (NEAR + 4.0 * gap) * final
    goal = next_fall(final + near if w > final else final - near, start, w, extent, out)
    if not is_worth_it(w, gap, final, goal):
        return none
    half, request = half_way(w, final, goal), request_of(Detail.TIME, rtol)
    for i in range(N):
        here, rows[SLOPE, i] = point_of(i, w, final, half)
        found = pass_round(case, here, request)
        shrinks = -np.expm1(found.slope)
        if found.status != OK or not shrinks > 0.0:
            return none
        rows[GAIN, i], rows[GAP, i] = found.source - shrinks * here, shrinks
        rows[TIME, i] = found.time
    return pass_over(case.store.workspace[0], w, final, half, most, rows)


@inner_jit
def _is_distant(w, final, contraction):
    """Whether an engagement from w has no extremum near one of the cycle, which begins at `final`.

    Where a round hardly changes the energy, all speeds of an engagement are as far from those of
    the cycle as the first one, but for a share of the order of this change.
    """
    gap = 1.0 - contraction
    return gap < SLOW and abs(w - final) > (NEAR + 4.0 * gap) * final


@inner_jit
def _judge(case, index, found, time, out):
    """Compare an engagement that starts at `time` with that of the cycle; returns whether its
    extremes are in the settling band.
    """
    share, good = case.shares[index], True
    top, low = outermost(case, found, share)
    for i in range(extrema_of(found, share)):
        if not is_turn(case, found, i):
            continue
        highest = is_top(case, found, i)
        final = case.finals.top[index] if highest else case.finals.low[index]
        error = abs(speed_at(case, found, i) / final - 1.0)
        at = time + (found.time if i == found.used else case.events[i].time)
        if np.isnan(out[cycle.RISE]) and error <= RISE_BAND:
            out[cycle.RISE] = at
        if i != (top if highest else low):
            continue
        if error > SETTLING_BAND:
            out[cycle.SETTLING], good = np.nan, False
        elif np.isnan(out[cycle.SETTLING]):
            out[cycle.SETTLING] = at
    return good


def solve(
    wheel: Any, errors: tuple[FloatArray, ...], numbers: FloatArray, rtol: float, extent: int
) -> tuple[FloatArray, np.ndarray]:
    """Figures of merit of scenes given by their errors and their dimensionless numbers.

    Parameters
    ----------
    wheel : ImperfectWheel
        The wheel of all scenes, without errors.
    errors : tuple of ndarray, shapes (n,), (n, m, 2) and (n, k, 2)
        `longer`, `pins` and `slots` of each scene, as `mechanisms.pattern.lay_pattern` takes them.
    numbers, rtol, extent
        As of `batch.solve`.

    Returns
    -------
    table : ndarray, shape (n, 11)
        Columns as in `COLUMNS`.
    status : ndarray, shape (n,)
        Values of `Status`.
    """
    rows = np.ascontiguousarray(numbers.T, dtype=float)
    table, status = np.empty((len(rows), FIGURES)), np.empty(len(rows), dtype=np.uint8)
    path = tuple(writeable(wheel.path))
    solve_patterns(
        kernel_addresses(), path, *wheel.path_numbers.values(), *errors, rows, NO_CELLS,
        rtol, int(extent), table, status,
    )  # fmt: skip
    table[status != OK] = np.nan
    return table, status
