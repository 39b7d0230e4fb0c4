"""A motion on disk: samples, events and pieces in one HDF5 file, and back.

Datasets are named as in `escapement.Motion`: `t` with every column of `State` over it;
`handoff_times` with `handoff_velocities`; `reversal_*` and `extremum_*`; `piece_*`, the
spans in which one side of the slot carries the force. The first of each group is its
dimension scale. Torque and force are in the user's units, all else is in SI.
"""

import json
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from os import PathLike
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from escapement import __version__
from escapement.errors import EscapementError, InputFileError
from escapement.files import MOTIONS, check_target, file_format, pending_hdf5, write_file
from escapement.mechanism import FloatArray
from escapement.mechanisms import KINDS
from escapement.motion import Motion
from escapement.motion_file.sampled import SampledTrajectory
from escapement.simulation import simulate
from escapement.status import Status
from escapement.study.hdf5 import FILTERS
from escapement.study.parse import parse_plan, plan_from
from escapement.study.reader import configuration_of
from escapement.study.stored import LAYOUT, SCHEMA_VERSION, opened
from escapement.text import csv_lines
from escapement.trajectory import Events, Extrema
from escapement.units import factor
from escapement.variables import (
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

CONTENT = "motion"
"""Root attribute `content`, by which a motion is told from a study."""
_BLOCK = 65536  # samples computed and written at a time, and the length of a chunk
Progress = Callable[[int, int, int], None]
"""Called with the samples written, their number and 0."""


def write_motion(
    motion: Motion,
    path: str | PathLike[str],
    *,
    units: str = "SI",
    force: bool = False,
    progress: Progress | None = None,
) -> None:
    """Write a motion to HDF5, or its samples to CSV where the name ends in .csv.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns. The times written are its default grid.
    path : path
        File to create; its suffix is one of `files.MOTIONS`.
    units : str
        Unit system of torque and force in the file, "SI" or "in-lbf-s".
    force : bool
        Replace an existing file, once the new one is complete.
    progress : callable, optional
        Called with the samples written, their number and 0, block by block.

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
    # HDF5 may crash where memory ends while it has a file
    blocks = _blocks(motion, motion.t, units, progress)
    if table:
        write_file(path, _lines(blocks), force)
        return
    with pending_hdf5(path, force) as (hdf5, _):
        _write_root(hdf5, motion)
        _write_samples(hdf5, motion, blocks, units)
        for owner, prefix, columns in groups_of(motion):
            source: Any = getattr(motion, owner) if owner else motion
            size = getattr(source, next(iter(columns))).size
            for key, dataset in _create(hdf5, prefix, columns, size, units).items():
                dataset[...] = values_of(source, key)


def _write_root(hdf5: Any, motion: Motion) -> None:
    scene = motion.escapement
    run: dict[str, Any] = {"initial_speed": float(motion.at(0.0).theta_dot), "rtol": motion.rtol}
    # so written, the file says all that it takes to simulate the motion again
    axis = "torque" if scene.torque == scene.torque_unit else "load_torque"
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
    motion: Motion, times: FloatArray, units: str, progress: Progress | None
) -> Iterator[dict[str, FloatArray]]:
    """Samples in blocks, so that memory does not grow with the motion."""
    for start in range(0, times.size, _BLOCK):
        state = motion.at(times[start : start + _BLOCK])
        found = {name: (getattr(state, name), SAMPLES[name][0]) for name in SAMPLES}
        yield {name: x / factor(unit, units) for name, (x, unit) in found.items() if x is not None}
        if progress is not None:
            progress(min(start + _BLOCK, times.size), times.size, 0)


def _lines(blocks: Iterator[dict[str, FloatArray]]) -> Iterator[bytes]:
    for number, block in enumerate(blocks):
        if number == 0:
            yield (",".join(block) + "\n").encode()
        yield csv_lines(block.values())


def _write_samples(
    hdf5: Any, motion: Motion, blocks: Iterator[dict[str, FloatArray]], units: str
) -> None:
    made: dict[str, Any] = {}
    for number, block in enumerate(blocks):
        columns = {name: SAMPLES[name] for name in block}
        made = made or _create(hdf5, "", columns, motion.t.size, units)
        for name, values in block.items():
            made[name][number * _BLOCK : number * _BLOCK + values.size] = values


def _create(hdf5: Any, prefix: str, columns: Columns, size: int, units: str) -> dict[str, Any]:
    """Datasets of one length, the first of them the dimension scale of all."""
    # an empty one has no chunks that could be filtered
    options = FILTERS | {"chunks": (min(size, _BLOCK),)} if size else {}
    made = {}
    for key, column in columns.items():
        made[key] = hdf5.create_dataset(prefix + key, (size,), column[2], **options)
        made[key].attrs.update(attributes_of(key, column, units))
    scale, *rest = made.values()
    scale.make_scale(scale.name.removeprefix("/"))
    for dataset in rest:
        dataset.dims[0].attach_scale(scale)
    return made


def is_motion(path: str | PathLike[str]) -> bool:
    """Whether `path` is an HDF5 file that says it holds a motion."""
    if not Path(path).is_file():
        return False
    # HDF5 tells of a file that is none, or is damaged, by one or the other
    try:
        with h5py.File(path, "r") as hdf5:
            return bool(hdf5.attrs.get("content") == CONTENT)
    except (OSError, RuntimeError):
        return False


def read_motion(path: str | PathLike[str]) -> Motion:
    """Read a motion.

    Handoffs and events are as written. The state at any time is computed anew from
    the samples at reversals and handoffs. A motion with clearance is simulated again.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it holds no motion, is damaged, was written in a layout newer than this
        version knows, or has a mechanism that is of no kind it knows.
    """
    with opened(path, "motion", "run", ("configuration", "t"), SCHEMA_VERSION) as hdf5:
        machine = configuration_of(hdf5)["mechanism"]
        # a mechanism of somebody's own cannot be built from a file
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
        # what a free follower does between two samples only the engine knows
        start = {"initial_speed": plan.values(0)["initial_speed"], "rtol": attributes["rtol"]}
        return simulate(escapement, duration=attributes["end_time"], **start)
    samples = {name: hdf5[name][()] for name in ("t", "theta", "theta_dot")}
    groups = [
        # files of the first versions hold the loss in friction alone
        {key: hdf5[prefix + key][()] for key in columns if key not in LOST or prefix + key in hdf5}
        for _, prefix, columns in GROUPS
    ]
    handoffs, reversals, extrema, pieces = groups
    t, end = samples["t"], attributes["end_time"]
    # a damaged file may be read without an error of HDF5
    for columns in (samples, *groups):
        _check_columns(columns, end)
    whole = t.size and pieces["start"].size and (np.diff(t) > 0.0).all()
    if not (whole and t[0] == 0.0 and t[-1] == end):
        raise ValueError(f"t must ascend from 0 to the end_time, {end:g} s, and have a piece")
    extrema["maximum"] = extrema["maximum"].astype(bool)
    none = np.zeros_like(pieces["start"])
    pieces["losses"] = np.array([pieces.pop(key, none) for key in LOST])
    pieces |= {"reversals": Events(**reversals), "extrema": Extrema(**extrema)}
    return Motion(
        escapement=escapement,
        trajectory=SampledTrajectory(escapement, **pieces, **samples),
        status=Status[str(hdf5.attrs["status"]).upper()],
        **attributes,
        **handoffs,
    )


def _check_columns(columns: dict[str, Any], end: float) -> None:
    """Raise ValueError unless these are lines of one length, the first of them ascending times."""
    scale, times = next(iter(columns.items()))
    for name, values in columns.items():
        numbers = values.ndim == 1 and values.dtype.kind in "fiu"
        if not numbers or values.size != times.size or not np.isfinite(values).all():
            raise ValueError(f"{name} must be a line of finite numbers, as many as of {scale}")
    if (np.diff(times) < 0.0).any() or (times < 0.0).any() or (times > end).any():
        raise ValueError(f"{scale} must ascend between 0 and the end_time, {end:g} s")
