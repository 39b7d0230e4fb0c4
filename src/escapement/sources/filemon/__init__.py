"""Filemon (1960): Table I, equations and figures of Geneva wheels at constant speed."""

from escapement.sources.filemon.cells import COLUMNS, Cell, mean_torque_error, table_1
from escapement.sources.filemon.slips import equations

__all__ = ["COLUMNS", "Cell", "equations", "mean_torque_error", "table_1"]
