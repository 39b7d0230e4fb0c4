"""Results of a study on disk: one HDF5 file, complete or not there at all."""

from escapement.store._block import Block, blocks_of, encode_block
from escapement.store._chunks import Tiling
from escapement.store._reader import read_configuration, read_sample_case, read_study
from escapement.store._study import (
    RESULTS,
    SCHEMA_VERSION,
    Result,
    Study,
    count_failed,
    place_on,
)
from escapement.store._writer import StudyWriter, partial_path, write_study

__all__ = [
    "RESULTS",
    "SCHEMA_VERSION",
    "Block",
    "Result",
    "Study",
    "StudyWriter",
    "Tiling",
    "blocks_of",
    "count_failed",
    "encode_block",
    "partial_path",
    "place_on",
    "read_configuration",
    "read_sample_case",
    "read_study",
    "write_study",
]
