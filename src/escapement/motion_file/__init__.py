"""A motion on disk: samples, events and pieces in one HDF5 file, and back.

Datasets are named as in `escapement.Motion`: `t` with every column of `State` over it;
`handoff_times` with `handoff_velocities`; `reversal_*` and `extremum_*`; `piece_*`, the
spans in which one side of the slot carries the force. The first of each group is its
dimension scale. Torque and force are in the user's units, all else is in SI.
"""

from escapement.motion_file.read import is_motion, read_motion
from escapement.motion_file.write import write_motion

__all__ = ["is_motion", "read_motion", "write_motion"]
