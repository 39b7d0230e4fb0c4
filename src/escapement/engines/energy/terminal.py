"""Terminal cycle and figures of merit of the fast engine."""

from dataclasses import replace
from typing import Any

import numpy as np

from escapement.engines.energy import cycle
from escapement.engines.energy.batch import FIXED, solve_rows
from escapement.engines.energy.calls import prepared
from escapement.engines.energy.figures import Extent
from escapement.engines.energy.simulate import simulate
from escapement.merits import TRANSIENT
from escapement.metrics import Figures
from escapement.model import Escapement
from escapement.motion import stall_message
from escapement.status import MESSAGES, Status

_TIMES = {name: cycle.COLUMNS.index(name) for name in TRANSIENT}


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit without a transient in time; see `escapement.terminal`."""
    clock, scene = escapement.time_unit, escapement.scene
    w = (initial_speed * clock) ** 2
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
