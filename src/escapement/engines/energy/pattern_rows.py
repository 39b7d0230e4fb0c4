"""Figures of merit of many scenes with imperfect parts, each with its own pattern."""

from typing import Any

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.figures_of_merit import RISE_BAND, SETTLING_BAND
from escapement.engines.energy import cycle
from escapement.engines.energy.calls import kernel_addresses
from escapement.engines.energy.cells import NO_CELLS
from escapement.engines.energy.figures import Extent, note_fall
from escapement.engines.energy.march import OK
from escapement.engines.energy.panels import tolerances
from escapement.engines.energy.passage import Detail, Request
from escapement.engines.energy.pattern import LONGEST_TRANSIENT, case_of, engage, memory
from escapement.engines.energy.pattern_cycle import (
    extrema_of,
    find_cycle,
    is_top,
    is_turn,
    outermost,
    rising_after,
    speed_at,
)
from escapement.mechanisms.path import writeable
from escapement.mechanisms.pattern import FITS, MEETING, lay_pattern, path_in
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import transmission_at
from escapement.model.scene import Scene
from escapement.numerics.jit import inner_jit, jit, row_tuple

COLUMNS = (*cycle.COLUMNS, "beat_error", "blow_max")
"""Figures of merit that these kernels compute."""
FIGURES = len(COLUMNS)
BEAT_ERROR, BLOW_MAX = FIGURES - 2, FIGURES - 1
_FIRST = Scene._fields.index("rho")
_NUMBERS = len(Scene._fields) - _FIRST
_PIN = Scene._fields.index("pin") - _FIRST
_INVALID = int(Status.INVALID)


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
    table, status : results, with `FIGURES` columns; NaN if there is none, except for the place of
        a stall, see `_figures`.
    """
    m, n = pins.shape[1], slots.shape[1]
    size = m * n // _divisor(m, n)
    meetings, (store, counts, events) = np.empty(size, MEETING), memory(size)
    torque = np.array([0.0, 0.0, 1.0])
    for i in range(status.size):
        table[i, :] = np.nan
        own = row_tuple(numbers[i], _NUMBERS)
        shared = (path, longer, 0.0, torque, 0.0, *own)
        if lay_pattern(arms, turns, longer[i], own[_PIN], pins[i], slots[i], meetings) != FITS:
            status[i] = _INVALID
            continue
        case, status[i] = case_of(addresses, shared, none, meetings, store, counts, events)
        if status[i] == OK:
            status[i] = _figures(case, numbers[i, _NUMBERS], rtol, extent, table[i])


@inner_jit
def _divisor(a, b):
    """Greatest common divisor."""
    while b > 0:
        a, b = b, a % b
    return a


@jit(allocates=True)
def solve_pattern(addresses, shared, none, meetings, w, rtol, extent, out):
    """Figures of one pattern into `out`; returns its status. Arguments as in `solve_patterns`."""
    case, status = case_of(addresses, shared, none, meetings, *memory(meetings.size))
    return _figures(case, w, rtol, extent, out) if status == OK else status


@inner_jit
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
    size, finals = case.meetings.size, case.finals
    fast, slow, blow, time, shortest, longest = w, w, 0.0, 0.0, np.inf, 0.0
    for place in range(size):
        beat = finals.time[place]
        time, shortest, longest = time + beat, min(shortest, beat), max(longest, beat)
        fast, slow = max(fast, finals.before[place]), min(slow, finals.after[place])
        # a comparison with NaN, where there is none, is false
        fast = finals.top[place] ** 2 if finals.top[place] ** 2 > fast else fast
        slow = finals.low[place] ** 2 if finals.low[place] ** 2 < slow else slow
        if case.shares[place] < 1.0:
            rho, g = case.shared[5], _start_ratio(case.meetings[(place + 1) % size])
            left = (rho + g * g) * finals.after[place]
            blow = max(blow, 0.5 * (rho * finals.before[place] - left))
    out[cycle.V_MAX], out[cycle.V_MIN] = np.sqrt(fast), np.sqrt(slow)
    out[cycle.PERIOD] = time / size
    out[BEAT_ERROR], out[BLOW_MAX] = longest - shortest, blow


@inner_jit
def _start_ratio(meeting):
    """g where an engagement begins."""
    return transmission_at(path_in(meeting), meeting.edges[0])[0]


@inner_jit
def _read_transient(case, start, rtol, extent, out):
    """Times of the motion that starts with w = `start`, as `metrics` reads them off a motion."""
    loose, strict = tolerances(rtol)
    request = Request(np.int64(Detail.EXTREMA), loose, strict)
    size, w, rising, time, calm = case.meetings.size, start, 0.0, 0.0, 0
    handoffs, finals = case.handoffs, case.finals
    handoffs[0, 0], handoffs[0, 1] = 0.0, start
    for k in range(LONGEST_TRANSIENT):
        place = k % size
        found = engage(case, place, w, rising, request)
        if _judge(case, place, found, time, out):
            calm += 1
        else:
            calm = 0
        w, time = found.w * case.shares[place] ** 2, time + found.time
        rising = rising_after(case, place, found)
        # the speed is compared with that of the cycle at the same handoff
        handoffs[(k + 1) % 2, 0], handoffs[(k + 1) % 2, 1] = time, w
        last, following = np.sqrt(finals.after[place - 1]), np.sqrt(finals.after[place])
        note_fall(start, handoffs, k, last, following, rtol, out)
        # two motions never cross: when a whole round is in the band, all later ones are
        settled = calm >= size and not np.isnan(out[cycle.SETTLING])
        if settled and (extent < Extent.FALLEN or not np.isnan(out[cycle.RISE_98])):
            return
    if calm < size:
        out[cycle.SETTLING] = np.nan


@inner_jit
def _judge(case, place, found, time, out):
    """Compare an engagement that starts at `time` with that of the cycle; returns whether its
    extremes are in the settling band.
    """
    share, good = case.shares[place], True
    top, low = outermost(case, found, share)
    for i in range(extrema_of(found, share)):
        if not is_turn(case, found, i):
            continue
        highest = is_top(case, found, i)
        final = case.finals.top[place] if highest else case.finals.low[place]
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
        rtol, np.int64(extent), table, status,
    )  # fmt: skip
    table[status != OK] = np.nan
    return table, status
