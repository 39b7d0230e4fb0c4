"""Filemon (1960): Table I, equations and figures of Geneva wheels at constant speed."""

from escapement.sources.filemon.cells import COLUMNS, TableCell, mean_torque_error, table_1
from escapement.sources.filemon.slips import equations

__all__ = ["COLUMNS", "TableCell", "equations", "mean_torque_error", "table_1"]
