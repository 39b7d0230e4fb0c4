"""Terminal cycle and figures of merit of the fast engine."""

from dataclasses import replace
from typing import Any

import numpy as np

from escapement.engines.energy import cycle
from escapement.engines.energy.batch import FIXED, solve_rows
from escapement.engines.energy.calls import prepared
from escapement.engines.energy.cells import NO_CELLS
from escapement.engines.energy.figures import Extent
from escapement.engines.energy.pattern import pattern_cycle
from escapement.engines.energy.simulate import simulate
from escapement.merits import TRANSIENT
from escapement.metrics import Figures, fall_times, read_cycle, read_transient, transient_length
from escapement.model import Escapement
from escapement.motion import Motion, stall_message
from escapement.status import MESSAGES, Status

_TIMES = {name: cycle.COLUMNS.index(name) for name in TRANSIENT}

LONGEST_TRANSIENT = 10_000
"""Engagements of imperfect parts whose extrema are looked for."""


def _of_pattern(escapement: Escapement, base: Figures, w: float, rtol: float) -> Figures:
    """Figures of imperfect parts: the cycle is that of all engagements of the pattern."""
    clock = escapement.time_unit
    addresses, plain, _ = prepared(escapement)
    mechanism: Any = escapement.mechanism
    pattern = mechanism.pattern
    found = pattern_cycle(addresses, plain, NO_CELLS, pattern, w, rtol)
    status, better, slope, angle, engagement = found
    if status != Status.OK:
        message = stall_message(angle, engagement) if status == Status.STALL else ""
        return replace(base, status=Status(status), message=message or MESSAGES[Status(status)])

    def run(engagements: int, speed: float) -> Motion:
        start: dict[str, Any] = {"duration": None, "initial_speed": speed, "rtol": rtol}
        return simulate(escapement, engagements=engagements, **start)

    cycle = run(pattern.size, float(np.sqrt(better) / clock))
    figures = replace(read_cycle(cycle, base), contraction=float(np.exp(slope)))
    start = float(np.sqrt(w / better))
    # as long as if every engagement took its share, in whole rounds
    count = transient_length(float(np.exp(slope / pattern.size)), start)
    count = pattern.size * (2 + count // pattern.size)
    if count > LONGEST_TRANSIENT:
        message = f"rise and settling time are not given: beyond {LONGEST_TRANSIENT} engagements"
        return replace(figures, message=message)
    first = start * figures.handoff_velocity
    transient = run(count, first)
    rise, settled = read_transient(transient, figures)
    most, nearly = fall_times(transient, first, figures.handoff_velocity)
    return replace(
        figures, rise_time=rise, settling_time=settled, rise_time_63=most, rise_time_98=nearly
    )


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit without a transient in time; see `escapement.terminal`."""
    clock, scene = escapement.time_unit, escapement.scene
    w = (initial_speed * clock) ** 2
    if len(escapement.scenes) > 1:
        return _of_pattern(escapement, base, w, rtol)
    numbers = np.array([[*scene[FIXED:], w]])
    table, codes = np.empty((1, cycle.FIGURES)), np.empty(1, dtype=np.uint8)
    addresses, plain, cells = prepared(escapement)
    extent = np.int64(Extent.FALLEN)
    solve_rows(addresses, plain, cells, cells, numbers, rtol, extent, table, codes)
    out, code = table[0], int(codes[0])
    status = Status(code)
    if status is Status.STALL:
        message = stall_message(out[0], int(out[1]))
        return replace(base, status=status, message=message)
    if status is not Status.OK:
        return replace(base, status=status, message=MESSAGES[status])
    handoff = float(out[cycle.HANDOFF] / clock)
    motion = simulate(escapement, engagements=1, duration=None, initial_speed=handoff, rtol=rtol)
    # the period of the motion that is returned, so that its end time has the same digits
    period = float(motion.end_time)
    times: dict[str, Any] = {name: float(out[place] * clock) for name, place in _TIMES.items()}
    late = [name for name, time in times.items() if np.isnan(time)]
    message = base.message
    if late:
        message = f"{', '.join(late)} not given: beyond 1 000 000 engagements"
    return replace(
        base,
        **times,
        velocity_max=float(out[cycle.V_MAX] / clock),
        velocity_min=float(out[cycle.V_MIN] / clock),
        velocity_mean=escapement.mechanism.cell_angle / period,
        period=period,
        handoff_velocity=handoff,
        contraction=float(out[cycle.CONTRACTION]),
        motion=motion,
        message=message,
    )
