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
from escapement.base.units import SYSTEMS, factor, ratio_of, unit_name
from escapement.dynamics.motion import Motion
from escapement.dynamics.trajectory import Events, Extrema
from escapement.dynamics.variables import (
    ATTRIBUTES,
    GROUPS,
    LOST,
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
from escapement.motion_file.sampled import SampledTrajectory
from escapement.study.hdf5 import FILTERS
from escapement.study.parse import parse_plan, plan_from
from escapement.study.reader import configuration_of
from escapement.study.stored import LAYOUT, SCHEMA_VERSION, open_hdf5, opened

CONTENT = "motion"
"""Root attribute `content`, which distinguishes a motion from a study."""
_BLOCK = 65536  # samples computed, written or read at a time, and the greatest length of a chunk
_LEAST = 64  # least length of a chunk
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

    Handoffs and events are those in the file. The state at any time is computed again from the
    samples at reversals and handoffs. A motion with clearance is simulated again.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it holds no motion, is damaged, has a newer layout than this version can read, or has
        a mechanism of an unknown kind.
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
            return _read(hdf5)
        except EscapementError as error:
            raise ValueError(error) from None


def _read(hdf5: Any) -> Motion:
    plan = parse_plan(configuration_of(hdf5))
    escapement = plan.escapement(0)
    attributes = {name: kind(hdf5.attrs[name]) for name, kind in ATTRIBUTES.items()}
    if escapement.contact:
        # only the engine can compute the motion of a free follower between two samples
        start = {"initial_speed": plan.values(0)["initial_speed"], "rtol": attributes["rtol"]}
        return simulate(escapement, duration=attributes["end_time"], **start)
    groups = [
        # files of the first versions hold only the loss in friction
        {
            key: _in_si(hdf5[prefix + key], column[0])
            for key, column in columns.items()
            if key not in LOST or prefix + key in hdf5
        }
        for _, prefix, columns in GROUPS
    ]
    handoffs, reversals, extrema, pieces = groups
    # a damaged file may be read without an error of HDF5
    for columns in groups:
        _check_columns(columns, attributes["end_time"])
    theta, speed = _at_starts(hdf5, pieces["start"], attributes["end_time"])
    extrema["maximum"] = extrema["maximum"].astype(bool)
    none = np.zeros_like(pieces["start"])
    pieces["losses"] = np.array([pieces.pop(key, none) for key in LOST])
    pieces |= {"reversals": Events(**reversals), "extrema": Extrema(**extrema)}
    motion = Motion(
        escapement=escapement,
        trajectory=SampledTrajectory(escapement, **pieces, theta=theta, theta_dot=speed),
        status=Status[str(hdf5.attrs["status"]).upper()],
        **attributes,
        **handoffs,
    )
    # its status was decided before it was written
    motion.judged = True
    return motion


def _in_si(dataset: Any, kind: str, part: Any = ()) -> Any:
    """Values of a dataset, which says in which unit it has them."""
    stored, wanted = dataset.attrs.get("units"), unit_name(kind, SYSTEMS[0])
    found = dataset[part]
    return found if stored in (None, wanted) else ratio_of(str(stored), wanted) * found


def _at_starts(hdf5: Any, start: FloatArray, end: float) -> FloatArray:
    """Driver angles and speeds at the starts of pieces; all samples are read, block by block."""
    names = "t", "theta", "theta_dot"
    sizes = [hdf5[name].shape for name in names]
    found, done, last = np.empty((2, start.size)), 0, -np.inf
    if not start.size or sizes[0] == (0,) or sizes.count(sizes[0]) < 3 or len(sizes[0]) != 1:
        raise ValueError("t, theta and theta_dot must be equally long lists, with at least a piece")
    for first in range(0, sizes[0][0], _BLOCK):
        part = slice(first, first + _BLOCK)
        block = {name: _in_si(hdf5[name], SAMPLES[name][0], part) for name in names}
        _check_columns(block, end)
        t, *values = block.values()
        ascends = (np.diff(t, prepend=last) > 0.0).all() and (first > 0 or t[0] == 0.0)
        if not ascends or (first + _BLOCK >= sizes[0][0] and t[-1] != end):
            raise ValueError(f"t must ascend from 0 to the end_time, {end:g} s")
        # a piece of zero length may end the motion
        upto = int(np.searchsorted(start, t[-1], side="right")) if t[-1] < end else start.size
        sample = np.minimum(np.searchsorted(t, start[done:upto]), t.size - 1)
        found[:, done:upto] = np.array(values)[:, sample]
        done, last = upto, t[-1]
    return found


def _check_columns(columns: dict[str, Any], end: float) -> None:
    """Raise ValueError unless these are lists of equal length, the first with ascending times."""
    scale, times = next(iter(columns.items()))
    for name, values in columns.items():
        numbers = values.ndim == 1 and values.dtype.kind in "fiu"
        if not numbers or values.size != times.size or not np.isfinite(values).all():
            raise ValueError(f"{name} must be a list of finite numbers, as long as {scale}")
    if (np.diff(times) < 0.0).any() or (times < 0.0).any() or (times > end).any():
        raise ValueError(f"{scale} must ascend between 0 and the end_time, {end:g} s")
