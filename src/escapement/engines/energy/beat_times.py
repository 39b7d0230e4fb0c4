"""The times of the engagements of a terminal cycle, and nothing else of it."""

from typing import Any

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.needs import FIXED
from escapement.engines.energy.batch import mark_jammed, solve_rows
from escapement.engines.energy.calls import prepared
from escapement.engines.energy.case_figures import Extent
from escapement.engines.energy.cells import NO_CELLS
from escapement.engines.energy.cycle import FIGURES, HANDOFF
from escapement.engines.energy.handoffs import handoffs
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement


def pattern_beats(escapement: Escapement, rtol: float) -> FloatArray | None:
    """Beats of the terminal cycle of a Geneva wheel [s], None where there is no such cycle.

    They are those of `escapement.terminal`, without its other figures: a fit asks for hundreds.
    A wheel without errors has a pattern as well, of engagements that are all alike.
    """
    mechanism: Any = escapement.mechanism
    if mechanism.misfit:
        return None
    addresses, scene, cells, pattern = prepared(escapement)
    if escapement.load_curve is None:
        cells, pattern = NO_CELLS, mechanism.pattern
    given = addresses, scene, cells, pattern
    numbers, codes = np.array([[*escapement.scene[FIXED:], 0.0]]), np.zeros(1, dtype=np.uint8)
    table, extent = np.empty((1, FIGURES)), int(Extent.CYCLE)
    mark_jammed(scene, given[3][None], numbers, codes)
    solve_rows(*given[:3], given[3][None], numbers, rtol, extent, table, codes)
    if codes[0] != Status.OK:
        return None
    w = float(table[0, HANDOFF]) ** 2
    times, speeds = np.empty((2, max(pattern.size, 1)))
    status, *_ = handoffs(*given, w, np.inf, rtol, escapement.time_unit, times, speeds)
    beats = np.resize(np.diff(times, prepend=0.0), mechanism.pattern.size)
    return beats if status == Status.OK else None
