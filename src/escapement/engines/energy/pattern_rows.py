"""Figures of merit of many scenes with imperfect parts, each a pattern of its own."""

from typing import Any

import numpy as np
from numba.np.unsafe.ndarray import to_fixed_tuple

from escapement.engines.energy import cycle
from escapement.engines.energy.calls import kernel_addresses
from escapement.engines.energy.cells import NO_CELLS
from escapement.engines.energy.events import EventKind, is_extremum
from escapement.engines.energy.march import OK
from escapement.engines.energy.panels import tolerances
from escapement.engines.energy.passage import Detail, Request
from escapement.engines.energy.pattern import LONGEST_TRANSIENT, case_of, engage, find_cycle, memory
from escapement.jit import inner_jit, jit
from escapement.mechanism import FloatArray
from escapement.mechanisms.pattern import FITS, MEETING, lay_pattern, path_in
from escapement.mechanisms.slotted import transmission_at
from escapement.metrics import RISE_BAND, SETTLING_BAND
from escapement.scene import Scene, writeable
from escapement.status import Status

COLUMNS = (*cycle.COLUMNS, "beat_error", "blow_max")
"""Figures of merit that these kernels compute; the times of a fall are left NaN."""
FIGURES = len(COLUMNS)
BEAT_ERROR, BLOW_MAX = FIGURES - 2, FIGURES - 1
_FIRST = Scene._fields.index("rho")
_NUMBERS = len(Scene._fields) - _FIRST
_PIN = Scene._fields.index("pin") - _FIRST
_INVALID = int(Status.INVALID)


@jit(allocates=True)
def solve_patterns(
    addresses, path, arms, turns, longer, pins, slots, numbers, none, rtol, table, status
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
    table, status : results, with `FIGURES` columns; NaN where there is none.
    """
    m, n = pins.shape[1], slots.shape[1]
    size = m * n // _divisor(m, n)
    meetings, (store, counts, events) = np.empty(size, MEETING), memory(size)
    finals, torque = np.empty((size, 2)), np.array([0.0, 0.0, 1.0])
    for i in range(status.size):
        table[i, :] = np.nan
        own = to_fixed_tuple(numbers[i], _NUMBERS)
        shared = (path, longer, 0.0, torque, 0.0, *own)
        if lay_pattern(arms, turns, longer[i], own[_PIN], pins[i], slots[i], meetings) != FITS:
            status[i] = _INVALID
            continue
        case, status[i] = case_of(addresses, shared, none, meetings, store, counts, events)
        if status[i] == OK:
            status[i] = _figures(case, numbers[i, _NUMBERS], rtol, finals, table[i])


@inner_jit
def _divisor(a, b):
    """Greatest common divisor."""
    while b > 0:
        a, b = b, a % b
    return a


@inner_jit
def _figures(case, w, rtol, finals, out):
    """Figures of one pattern into `out`; returns the status."""
    found = find_cycle(case, w, rtol)
    if found[0] != OK:
        return found[0]
    loose, strict = tolerances(rtol)
    request = Request(np.int64(Detail.EXTREMA), loose, strict)
    _read_cycle(case, found[1], request, finals, out)
    out[cycle.HANDOFF], out[cycle.CONTRACTION] = np.sqrt(found[1]), np.exp(found[2])
    _read_transient(case, w, request, finals, out)
    return OK


@inner_jit
def _read_cycle(case, w, request, finals, out):
    """Figures of the cycle that starts with w, and in `finals` each engagement's extremes."""
    size, rising = case.meetings.size, 0.0
    fast, slow, time, shortest, longest, blow = w, w, 0.0, np.inf, 0.0, 0.0
    # the first round tells whether the driver gains speed where the second one begins
    for k in range(2 * size):
        place = k % size
        found = engage(case, place, w, rising, request)
        share = case.shares[place]
        after = found.w * share * share
        rising = -1.0 if share < 1.0 else found.rising
        if k >= size:
            top, low = _outermost(case, found, share)
            finals[place, 0] = np.nan if low < 0 else _speed(case, found, low)
            finals[place, 1] = np.nan if top < 0 else _speed(case, found, top)
            for j in range(2):
                if finals[place, j] > 0.0:
                    fast, slow = max(fast, finals[place, j] ** 2), min(slow, finals[place, j] ** 2)
            fast, slow, time = max(fast, found.w), min(slow, after), time + found.time
            shortest, longest = min(shortest, found.time), max(longest, found.time)
            if share < 1.0:
                rho, g = case.shared[5], _start_ratio(case.meetings[(place + 1) % size])
                blow = max(blow, 0.5 * (rho * found.w - (rho + g * g) * after))
        w = after
    out[cycle.V_MAX], out[cycle.V_MIN] = np.sqrt(fast), np.sqrt(slow)
    out[cycle.PERIOD] = time / size
    out[BEAT_ERROR], out[BLOW_MAX] = longest - shortest, blow


@inner_jit
def _start_ratio(meeting):
    """g where an engagement begins."""
    return transmission_at(path_in(meeting), meeting.edges[0])[0]


@inner_jit
def _extrema_of(found, share):
    """Number of events of an engagement, a fall by a blow at its end included as the last."""
    return found.used + 1 if share < 1.0 and found.rising > 0.0 else found.used


@inner_jit
def _is_top(case, found, i):
    """Whether event i of an engagement is a maximum; the speed is one before a blow."""
    return i == found.used or case.events[i].kind == EventKind.MAXIMUM


@inner_jit
def _speed(case, found, i):
    """Driver speed at event i of an engagement."""
    return np.sqrt(found.w if i == found.used else case.events[i].w)


@inner_jit
def _outermost(case, found, share):
    """Events that are the greatest maximum and the least minimum of an engagement, -1 if none."""
    top, low = -1, -1
    for i in range(_extrema_of(found, share)):
        if i < found.used and not is_extremum(case.events[i]):
            continue
        speed = _speed(case, found, i)
        if _is_top(case, found, i):
            top = i if top < 0 or speed > _speed(case, found, top) else top
        else:
            low = i if low < 0 or speed < _speed(case, found, low) else low
    return top, low


@inner_jit
def _read_transient(case, w, request, finals, out):
    """Rise and settling time of the motion that starts with w, as `metrics.read_transient`."""
    size, rising, time, calm = case.meetings.size, 0.0, 0.0, 0
    for k in range(LONGEST_TRANSIENT):
        place = k % size
        found = engage(case, place, w, rising, request)
        share = case.shares[place]
        top, low = _outermost(case, found, share)
        calm += 1
        for i in range(_extrema_of(found, share)):
            if i < found.used and not is_extremum(case.events[i]):
                continue
            is_top = _is_top(case, found, i)
            error = abs(_speed(case, found, i) / finals[place, 1 if is_top else 0] - 1.0)
            at = time + (found.time if i == found.used else case.events[i].time)
            if np.isnan(out[cycle.RISE]) and error <= RISE_BAND:
                out[cycle.RISE] = at
            if i != (top if is_top else low):
                continue
            if error > SETTLING_BAND:
                out[cycle.SETTLING], calm = np.nan, 0
            elif np.isnan(out[cycle.SETTLING]):
                out[cycle.SETTLING] = at
        # two motions never cross: when a whole round is in the band, all later ones are
        if calm >= size and not np.isnan(out[cycle.SETTLING]):
            return
        w, time = found.w * share * share, time + found.time
        rising = -1.0 if share < 1.0 else found.rising
    out[cycle.SETTLING] = np.nan


def solve(
    wheel: Any, errors: tuple[FloatArray, ...], numbers: FloatArray, rtol: float
) -> tuple[FloatArray, np.ndarray]:
    """Figures of merit of scenes given by their errors and their dimensionless numbers.

    Parameters
    ----------
    wheel : ImperfectWheel
        The wheel that all would be without errors.
    errors : tuple of ndarray, shapes (n,), (n, m, 2) and (n, k, 2)
        `longer`, `pins` and `slots` of each scene, as `mechanisms.pattern.lay_pattern` takes them.
    numbers : ndarray, shape (k, n)
        As of `batch.solve`.

    Returns
    -------
    table : ndarray, shape (n, 9)
    status : ndarray, shape (n,)
        Values of `Status`.
    """
    rows = np.ascontiguousarray(numbers.T, dtype=float)
    table, status = np.empty((len(rows), FIGURES)), np.empty(len(rows), dtype=np.uint8)
    path = tuple(writeable(wheel.path))
    solve_patterns(
        kernel_addresses(), path, *wheel.path_numbers.values(), *errors, rows, NO_CELLS,
        rtol, table, status,
    )  # fmt: skip
    return table, status
