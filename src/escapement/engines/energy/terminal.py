"""Terminal cycle and figures of merit of the fast engine."""

import math
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
from escapement.engines.energy.simulate import simulate, steady_engagement
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement, once_per_escapement

_TIMES = {name: cycle.COLUMNS.index(name) for name in TRANSIENT}


@once_per_escapement
def _numbers_of(escapement: Escapement) -> FloatArray:
    """The row of `batch.solve_rows` for an escapement, with room for w."""
    return np.array([[*escapement.scene[FIXED:], 0.0]])


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit without following the motion in time; see `escapement.terminal`."""
    clock, count, extent = escapement.time_unit, len(escapement.scenes), int(Extent.FALLEN)
    numbers, codes = _numbers_of(escapement).copy(), np.zeros(1, dtype=np.uint8)
    numbers[0, -1] = (initial_speed * clock) ** 2
    addresses, scene, cells, pattern = prepared(escapement)
    table = np.empty((1, cycle.FIGURES))
    solve_rows(addresses, scene, cells, pattern[None], numbers, rtol, extent, table, codes)
    # numbers of Python are faster here than those of NumPy
    out, status = table[0].tolist(), Status(int(codes[0]))
    if status is not Status.OK:
        stalled = status is Status.STALL
        message = stall_message(out[0], int(out[1])) if stalled else MESSAGES[status]
        return base.having(status=status, message=message)
    handoff, period = out[cycle.HANDOFF] / clock, out[cycle.PERIOD] * clock
    if count == 1:
        motion = steady_engagement(escapement, rtol, handoff, period)
    else:
        motion = simulate(
            escapement, engagements=count, duration=None, initial_speed=handoff, rtol=rtol
        )
        # so that the end time of the motion has the same digits
        period = float(motion.end_time) / count
    times: dict[str, Any] = {name: out[column] * clock for name, column in _TIMES.items()}
    missing = [name for name, time in times.items() if math.isnan(time)]
    if missing:
        count_text = f"{MAX_ENGAGEMENTS if count == 1 else LONGEST_PATTERN:_}".replace("_", " ")
        times["message"] = (
            f"these figures take more than {count_text} engagements and are not given: "
            f"{', '.join(missing)}"
        )
    return base.having(
        **times,
        velocity_max=out[cycle.V_MAX] / clock,
        velocity_min=out[cycle.V_MIN] / clock,
        velocity_mean=escapement.mechanism.cell_angle / period,
        period=period,
        handoff_velocity=handoff,
        contraction=out[cycle.CONTRACTION],
        motion=motion,
    )
