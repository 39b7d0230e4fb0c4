"""Results of a study on disk: one HDF5 file, complete or not there at all."""

from escapement.store._reader import read_study
from escapement.store._study import RESULTS, SCHEMA_VERSION, Result, Study, count_failed
from escapement.store._target import check_target
from escapement.store._writer import StudyWriter, write_study

__all__ = [
    "RESULTS",
    "SCHEMA_VERSION",
    "Result",
    "Study",
    "StudyWriter",
    "check_target",
    "count_failed",
    "read_study",
    "write_study",
]
