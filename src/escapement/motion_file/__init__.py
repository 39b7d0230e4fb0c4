"""A motion on disk: samples, events and pieces in one HDF5 file, and back.

Datasets are named as in `escapement.Motion`: `t` with every column of `State` over it;
`handoff_times` with `handoff_velocities`; `reversal_*` and `extremum_*`; `piece_*`, the
spans in which one side of the slot carries the force. The first of each group is its
dimension scale. Everything is in the user's units.
"""

import json
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from itertools import chain
from os import PathLike
from typing import Any

import numpy as np

from escapement import __version__
from escapement.base.errors import EscapementError, InputFileError
from escapement.base.files import MOTIONS, check_target, file_format, pending_hdf5, write_file
from escapement.base.status import Status
from escapement.base.text import csv_lines
from escapement.base.units import factor
from escapement.dynamics.motion import Motion
from escapement.dynamics.variables import (
    SAMPLES,
    attributes,
    attributes_of,
    groups_of,
    values_of,
)
from escapement.engines.simulate import simulate
from escapement.mechanisms import KINDS
from escapement.mechanisms.protocol import FloatArray
from escapement.model.torque_curve import TorqueCurve
from escapement.study.hdf5 import FILTERS
from escapement.study.parse import parse_plan, plan_from
from escapement.study.reader import configuration_of
from escapement.study.stored import LAYOUT, SCHEMA_VERSION, open_hdf5, opened

CONTENT = "motion"
"""Root attribute `content`, which distinguishes a motion from a study."""
_BLOCK = 65536  # samples computed and written at a time, and the greatest length of a chunk
_LEAST = 64  # least length of a chunk
_ALIKE = 1e-6  # greatest relative difference of handoff times that are the same
Progress = Callable[[int, int, int], None]
"""Called with the engagements written, their number and 0."""
_Lines = dict[str, tuple[tuple[str, str, str], FloatArray]]
"""Datasets of one length by their names: the column, and a block of values."""
_Blocks = Iterator[tuple[str, _Lines]]
"""Of each block of a motion the prefix of its names and its values."""


def write_motion(
    motion: Motion,
    path: str | PathLike[str],
    *,
    units: str = "SI",
    force: bool = False,
    progress: Progress | None = None,
) -> None:
    """Write a motion to HDF5, or its samples to CSV where the name ends in .csv.

    A long motion by "energy" is computed while it is written, some engagements at a time, so that
    memory does not grow with it.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns. The times written are its default grid.
    path : path
        File to create; its suffix is one of `files.MOTIONS`.
    units : str
        Unit system of torques, forces and energies in the file, "SI" or "in-lbf-s".
    force : bool
        Replace an existing file, once the new one is complete.
    progress : callable, optional
        Called with the engagements written, their number and 0, block by block.

    Raises
    ------
    CannotCreate
        When the file may not be created.
    StorageError
        When the disk is full or fails.
    InvalidValue
        For a motion without length, or another suffix.
    """
    check_target(path, force)
    table = file_format(path, MOTIONS) == ".csv"
    blocks = _blocks(motion, not table, progress)
    if table:
        write_file(path, _lines(blocks, units), force)
        return
    # HDF5 may crash if memory runs out while a file is open; later blocks need no more
    first = next(blocks)
    with pending_hdf5(path, force) as (hdf5, disk):
        _write_root(hdf5, motion)
        made: dict[str, Any] = {}
        for prefix, columns in chain([first], blocks):
            if disk.error is None:
                _append(hdf5, made, prefix, columns, units)


def _write_root(hdf5: Any, motion: Motion) -> None:
    scene = motion.escapement
    run: dict[str, Any] = {"initial_speed": float(motion.at(0.0).theta_dot), "rtol": motion.rtol}
    # with these attributes the file has everything needed to simulate the motion again
    axis = "load_torque" if isinstance(scene.torque, TorqueCurve) else "torque"
    study = plan_from(scene, {axis: [getattr(scene, axis)]}, engine=motion.engine, **run)
    hdf5.attrs.update(
        content=CONTENT,
        title=f"motion of an escapement, {motion.handoff_times.size} engagements",
        **LAYOUT,
        package_version=__version__,
        **attributes(motion),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        configuration=json.dumps(study.configuration, allow_nan=False),
    )


def _blocks(motion: Motion, whole: bool, progress: Progress | None) -> _Blocks:
    """Samples and, for a `whole` motion, all other data, block by block to limit the memory."""
    for part in motion.parts():
        # the end of a part is the start of the next one
        times = part.t if part.end_time == motion.end_time else part.t[:-1]
        for start in range(0, times.size, _BLOCK):
            state = part.at(times[start : start + _BLOCK])
            found = {name: (SAMPLES[name], getattr(state, name)) for name in SAMPLES}
            yield "", {name: pair for name, pair in found.items() if pair[1] is not None}
            if progress is not None:
                ends, last = motion.handoff_times, start + _BLOCK >= times.size
                reached = part.end_time if last else state.t[-1]
                progress(int(np.searchsorted(ends, reached, side="right")), ends.size, 0)
        for owner, prefix, names in groups_of(part) if whole else ():
            source: Any = getattr(part, owner) if owner else part
            yield prefix, {key: (column, values_of(source, key)) for key, column in names.items()}


def _lines(blocks: _Blocks, units: str) -> Iterator[bytes]:
    for number, (_prefix, columns) in enumerate(blocks):
        if number == 0:
            yield (",".join(columns) + "\n").encode()
        yield csv_lines([values / factor(c[0], units) for c, values in columns.values()])


def _append(hdf5: Any, made: dict[str, Any], prefix: str, columns: _Lines, units: str) -> None:
    """Append values to datasets of one length, the first the dimension scale of all.

    made : the datasets that are open, by name; the new ones are added.
    """
    for key, (column, values) in columns.items():
        name = prefix + key
        if name not in made:
            # the default cache would hold 16 chunks
            sizes: dict[str, Any] = {"maxshape": (None,), "rdcc_nbytes": 1 << 20}
            chunk = min(max(values.size, _LEAST), _BLOCK)
            made[name] = hdf5.create_dataset(
                name, (0,), column[2], chunks=(chunk,), **sizes, **FILTERS
            )
            made[name].attrs.update(attributes_of(key, column, units))
            scale = made[prefix + next(iter(columns))]
            if made[name] == scale:
                scale.make_scale(name)
            else:
                made[name].dims[0].attach_scale(scale)
        done = made[name].size
        made[name].resize((done + values.size,))
        made[name][done:] = values / factor(column[0], units)


def is_motion(path: str | PathLike[str]) -> bool:
    """Whether `path` is an HDF5 file of a motion; InputFileError where a lock is in the way."""
    # HDF5 raises one or the other for no file, a damaged one, or one that is not HDF5
    try:
        with open_hdf5(path) as hdf5:
            return bool(hdf5.attrs.get("content") == CONTENT)
    except (OSError, RuntimeError):
        return False


def read_motion(path: str | PathLike[str]) -> Motion:
    """Read a motion.

    The motion is simulated again from the configuration in the file, with the engine and the
    tolerance with which it was written; `ivp` uses its default method.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it holds no motion, has a newer layout than this version can read, a mechanism of an
        unknown kind, or handoffs that this version does not compute.
    """
    with opened(path, "motion", "run", ("configuration", "t"), SCHEMA_VERSION) as hdf5:
        machine = configuration_of(hdf5)["mechanism"]
        # a mechanism class of the user cannot be built from a file
        if machine["kind"] not in KINDS and "description" in machine:
            raise InputFileError(
                f"motion {path} must have a mechanism that a file can describe, got one of class "
                f"{machine['kind']}; take its numbers with h5py or xarray"
            )
        try:
            motion, stored = _read(hdf5)
        except EscapementError as error:
            raise ValueError(error) from None
    times, fine = motion.handoff_times, max(_ALIKE, 100.0 * motion.rtol)
    alike = times.shape == stored.shape and np.allclose(times, stored, rtol=fine, atol=0.0)
    # rounding decides on the impacts of a follower that is free
    if not (alike or motion.escapement.contact):
        raise InputFileError(
            f"motion {path} must have the handoffs that this version computes, got others; compute "
            "it again, or take its numbers with h5py or xarray"
        )
    return motion


def _read(hdf5: Any) -> tuple[Motion, FloatArray]:
    """The motion of a file, simulated again, and the times of the handoffs in the file [s]."""
    plan = parse_plan(configuration_of(hdf5))
    escapement, stored = plan.escapement(0), np.asarray(hdf5["handoff_times"][()], dtype=float)
    end, finished = float(hdf5.attrs["end_time"]), hdf5.attrs["status"] == Status.OK.label
    length: dict[str, Any] = {"engagements": stored.size + 1}
    if finished:
        whole = stored.size > 0 and stored[-1] == end
        length = {"engagements": stored.size} if whole else {"duration": end}
    start, rtol = plan.values(0)["initial_speed"], float(hdf5.attrs["rtol"])
    engine = str(hdf5.attrs["engine"])
    motion = simulate(escapement, initial_speed=start, rtol=rtol, engine=engine, **length)
    return motion, stored
