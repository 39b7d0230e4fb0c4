"""The times of the engagements of a terminal cycle, and nothing else of it."""

from typing import Any

import numpy as np

from escapement.base.status import Status
from escapement.engines.energy.calls import prepared_pattern
from escapement.engines.energy.case_figures import Extent
from escapement.engines.energy.cells import NO_CELLS
from escapement.engines.energy.cycle import HANDOFF
from escapement.engines.energy.pattern_march import pattern_handoffs
from escapement.engines.energy.pattern_rows import FIGURES, solve_pattern
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
    given = *prepared_pattern(escapement), NO_CELLS, mechanism.pattern
    figures = np.empty(FIGURES)
    if solve_pattern(*given, 0.0, rtol, int(Extent.CYCLE), figures) != Status.OK:
        return None
    w = float(figures[HANDOFF]) ** 2
    times, speeds = np.empty((2, mechanism.pattern.size))
    status, *_ = pattern_handoffs(*given, w, np.inf, rtol, escapement.time_unit, times, speeds)
    return np.diff(times, prepend=0.0) if status == Status.OK else None
