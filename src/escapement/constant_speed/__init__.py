"""Constant driver speed: indexing drives, and torque and pin reversals (Filemon 1960).

Modules are loaded when they are first used, because a case can be described without them. Read
`index_case` and `indexing` first.

- `index_case`: what is given of an indexing drive; `index_torque`, `index_loads`: the formulas of
  its figures, for one drive or many
- `indexing`, `index_rows`: one drive, and many; `cam_drive`: a cam to compare with
- `wall_changes`, `cycle_figures`, `knock`, `ringing`, `row_kernel`: the kernels
- `index_record`: what is told of a drive, in the order in which it is read
- `geneva`: Filemon's formulas
"""

from typing import TYPE_CHECKING, Any

from escapement.base.lazy import offered

if TYPE_CHECKING:
    from escapement.constant_speed.geneva import ReversalStudy, fewest_slots, reversal_study
    from escapement.constant_speed.indexing import IndexingDrive, IndexState, index

__all__ = [
    "IndexState", "IndexingDrive", "ReversalStudy", "fewest_slots", "index", "reversal_study",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    return offered(__name__, __all__, ("indexing", "geneva"), name)
