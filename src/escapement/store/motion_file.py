"""A motion on disk: its samples, its events and what fixes its pieces, in HDF5.

Datasets are named as in `escapement.Motion`: `t` and every column of `State` over it;
`handoff_times` and `handoff_velocities`; `reversal_*` and `extremum_*`; `piece_*`, the
pieces between which the force changes side. The first of each group is its dimension
scale. Torques are in the user's units, everything else is in SI.
"""

import json
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement import __version__
from escapement.dynamics import tabulate
from escapement.errors import EscapementError, InputFileError, MissingInput
from escapement.mechanisms import Geneva
from escapement.model import Escapement, FloatArray, Inertia
from escapement.motion import Events, Extrema, Motion
from escapement.status import Status
from escapement.store._steady_file import SteadyFile
from escapement.store._target import PendingFile, storage_error
from escapement.units import factor, unit_name

CONTENT = "motion"
"""Value of the root attribute `content`, by which a motion is told from a study."""
SCHEMA_VERSION = 1
_BLOCK = 65536  # samples computed and written at a time
