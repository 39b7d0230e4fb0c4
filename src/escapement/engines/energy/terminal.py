"""Terminal cycle and figures of merit of the fast engine."""

from dataclasses import replace
from typing import Any

import numpy as np

from escapement.base.status import MESSAGES, Status
from escapement.dynamics.figure_table import TRANSIENT
from escapement.dynamics.figures_of_merit import MAX_ENGAGEMENTS, Figures
from escapement.dynamics.motion import stall_message
from escapement.dynamics.needs import FIXED
from escapement.engines.energy import cycle
from escapement.engines.energy.batch import solve_rows
from escapement.engines.energy.calls import prepared
from escapement.engines.energy.case_figures import LONGEST_PATTERN, Extent
from escapement.engines.energy.cells import NO_CELLS
from escapement.engines.energy.simulate import simulate
from escapement.model.escapement import Escapement

_TIMES = {name: cycle.COLUMNS.index(name) for name in TRANSIENT}


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit without following the motion in time; see `escapement.terminal`."""
    clock, scene, count = escapement.time_unit, escapement.scene, len(escapement.scenes)
    w, extent = (initial_speed * clock) ** 2, int(Extent.FALLEN)
    numbers, codes = np.array([[*scene[FIXED:], w]]), np.zeros(1, dtype=np.uint8)
    addresses, plain, cells, pattern = prepared(escapement)
    table = np.empty((1, cycle.FIGURES))
    given = addresses, plain, cells, pattern[None], NO_CELLS, numbers
    solve_rows(*given, rtol, extent, table, codes)
    out, code = table[0], int(codes[0])
    status = Status(code)
    if status is not Status.OK:
        stalled = status is Status.STALL
        message = stall_message(out[0], int(out[1])) if stalled else MESSAGES[status]
        return replace(base, status=status, message=message)
    handoff = float(out[cycle.HANDOFF] / clock)
    motion = simulate(
        escapement, engagements=count, duration=None, initial_speed=handoff, rtol=rtol
    )
    # the period of the motion that is returned, so that its end time has the same digits
    period = float(motion.end_time) / count
    times: dict[str, Any] = {name: float(out[column] * clock) for name, column in _TIMES.items()}
    missing = [name for name, time in times.items() if np.isnan(time)]
    message = base.message
    if missing:
        count_text = f"{MAX_ENGAGEMENTS if count == 1 else LONGEST_PATTERN:_}".replace("_", " ")
        message = (
            f"these figures take more than {count_text} engagements and are not given: "
            f"{', '.join(missing)}"
        )
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
