"""Constant driver speed: indexing drives, and torque and pin reversals (Filemon 1960).

Modules are loaded when they are first used, because a case can be described without them. Read
`index_case` and `indexing` first.

- `index_case`: what is given of an indexing drive; `index_torque`, `index_loads`: the formulas of
  its figures, for one drive or many
- `indexing`, `index_rows`: one drive, and many; `cam_drive`: a cam to compare with
- `wall_changes`, `cycle_figures`, `knock`, `ringing`, `row_kernel`: the kernels
- `index_record`: what is told of a drive, in the order in which it is read
- `extrema`, `geneva`: extremes of the transmission functions, and Filemon's formulas
"""

from typing import TYPE_CHECKING, Any

from escapement.base.lazy import offered

if TYPE_CHECKING:
    from escapement.constant_speed.extrema import (
        TransmissionExtrema,
        jerk_function,
        transmission_extrema,
    )
    from escapement.constant_speed.geneva import ReversalStudy, fewest_slots, reversal_study
    from escapement.constant_speed.indexing import IndexingDrive, IndexState, index
    from escapement.numerics.chebyshev import Extremum

__all__ = [
    "Extremum", "IndexState", "IndexingDrive", "ReversalStudy", "TransmissionExtrema",
    "fewest_slots", "index", "jerk_function", "reversal_study", "transmission_extrema",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    return offered(__name__, __all__, ("extrema", "geneva", "indexing"), name)
