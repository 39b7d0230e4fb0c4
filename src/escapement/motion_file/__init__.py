"""A motion on disk: samples, events and pieces in one HDF5 file, and back.

Datasets are named as in `escapement.Motion`: `t` with every column of `State` over it;
`handoff_times` with `handoff_velocities`; `reversal_*` and `extremum_*`; `piece_*`, the
spans in which one side of the slot carries the force. The first of each group is its
dimension scale. Torque, force and energy are in the user's units, all else is in SI.
"""

import json
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from itertools import chain
from os import PathLike
from pathlib import Path
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
    Columns,
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
_BLOCK = 65536  # samples computed and written at a time, and the greatest length of a chunk
_READ = 1 << 20  # samples read at a time
Progress = Callable[[int, int, int], None]
"""Called with the engagements written, their number and 0."""
_Lines = dict[str, tuple[tuple[str, str, str], FloatArray]]
"""Datasets of one length by their names: the column, and a block of values."""


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
        for prefix, columns, total in chain([first], blocks):
            if disk.error is None:
                _append(hdf5, made, prefix, columns, total, units)


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


def _blocks(
    motion: Motion, whole: bool, progress: Progress | None
) -> Iterator[tuple[str, _Lines, int | None]]:
    """Samples and, for a `whole` motion, all other data, block by block to limit the memory.

    In addition to prefix and values, the final length of some datasets is given, or None.
    """
    for part in motion.parts():
        # the end of a part is the start of the next one
        times = part.t if part.end_time == motion.end_time else part.t[:-1]
        for start in range(0, times.size, _BLOCK):
            state = part.at(times[start : start + _BLOCK])
            found = {name: (SAMPLES[name], getattr(state, name)) for name in SAMPLES}
            columns = {name: pair for name, pair in found.items() if pair[1] is not None}
            yield "", columns, times.size if part is motion else None
            if progress is not None:
                ends, last = motion.handoff_times, start + _BLOCK >= times.size
                reached = part.end_time if last else state.t[-1]
                progress(int(np.searchsorted(ends, reached, side="right")), ends.size, 0)
        for owner, prefix, names in groups_of(part) if whole else ():
            source: Any = getattr(part, owner) if owner else part
            columns = {key: (column, values_of(source, key)) for key, column in names.items()}
            size = next(iter(columns.values()))[1].size
            yield prefix, columns, size if part is motion else None


def _lines(blocks: Iterator[tuple[str, _Lines, int | None]], units: str) -> Iterator[bytes]:
    for number, (_prefix, columns, _total) in enumerate(blocks):
        if number == 0:
            yield (",".join(columns) + "\n").encode()
        yield csv_lines([values / factor(c[0], units) for c, values in columns.values()])


def _append(
    hdf5: Any, made: dict[str, Any], prefix: str, columns: _Lines, total: int | None, units: str
) -> None:
    """Append values to datasets of one length, which are created first."""
    names = [prefix + key for key in columns]
    if names[0] not in made:
        settings = {key: column for key, (column, _values) in columns.items()}
        made |= _create(hdf5, prefix, settings, total, units)
        made[f"filled {names[0]}"] = 0
    first = made[f"filled {names[0]}"]
    for name, (column, values) in zip(names, columns.values(), strict=True):
        if total is None:
            made[name].resize((first + values.size,))
        made[name][first : first + values.size] = values / factor(column[0], units)
    made[f"filled {names[0]}"] = first + values.size


def _create(
    hdf5: Any, prefix: str, columns: Columns, size: int | None, units: str
) -> dict[str, Any]:
    """Datasets of one length, the first the dimension scale of all; with None they can grow."""
    # an empty one has no chunks that could be filtered; the default cache would hold 16 chunks
    options: dict[str, Any] = FILTERS | {"rdcc_nbytes": 1 << 20}
    options = {} if size == 0 else options | {"chunks": (min(size or _BLOCK, _BLOCK),)}
    made = {}
    for key, column in columns.items():
        name, most = prefix + key, (size,)
        made[name] = hdf5.create_dataset(name, (size or 0,), column[2], maxshape=most, **options)
        made[name].attrs.update(attributes_of(key, column, units))
    scale, *rest = made.values()
    scale.make_scale(scale.name.removeprefix("/"))
    for dataset in rest:
        dataset.dims[0].attach_scale(scale)
    return made


def is_motion(path: str | PathLike[str]) -> bool:
    """Whether `path` is an HDF5 file of a motion; InputFileError where a lock is in the way."""
    if not Path(path).is_file():
        return False
    # HDF5 raises one or the other for a damaged file, or one that is not HDF5
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


def _in_si(dataset: Any, kind: str) -> Any:
    """The values of a dataset, which says in which unit it has them."""
    stored_unit, wanted = dataset.attrs.get("units"), unit_name(kind, SYSTEMS[0])
    return (
        dataset[()]
        if stored_unit in (None, wanted)
        else ratio_of(str(stored_unit), wanted) * dataset[()]
    )


def _at_starts(hdf5: Any, start: FloatArray, end: float) -> FloatArray:
    """Driver angles and speeds at the starts of pieces; all samples are read, block by block."""
    names = "t", "theta", "theta_dot"
    sizes = [hdf5[name].shape for name in names]
    found, done, last = np.empty((2, start.size)), 0, -np.inf
    if not start.size or sizes[0] == (0,) or sizes.count(sizes[0]) < 3 or len(sizes[0]) != 1:
        raise ValueError("t, theta and theta_dot must be equally long lists, with at least a piece")
    for first in range(0, sizes[0][0], _READ):
        block = {name: hdf5[name][first : first + _READ] for name in names}
        _check_columns(block, end)
        t, *values = block.values()
        if not (np.diff(t, prepend=last) > 0.0).all() or (first == 0 and t[0] != 0.0):
            raise ValueError(f"t must ascend from 0 to the end_time, {end:g} s")
        # a piece of zero length may end the motion
        upto = int(np.searchsorted(start, t[-1], side="right")) if t[-1] < end else start.size
        sample = np.minimum(np.searchsorted(t, start[done:upto]), t.size - 1)
        found[:, done:upto] = np.array(values)[:, sample]
        done, last = upto, t[-1]
    if last != end:
        raise ValueError(f"t must ascend from 0 to the end_time, {end:g} s")
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
