"""A motion on disk: samples, events and pieces in one HDF5 file, and back.

Datasets are named as in `escapement.Motion`: `t` with every column of `State` over it;
`handoff_times` with `handoff_velocities`; `reversal_*` and `extremum_*`; `piece_*`, the
spans in which one side of the slot carries the force. The first of each group is its
dimension scale. Torque and force are in the user's units, all else is in SI.
"""

import json
from collections.abc import Callable
from datetime import UTC, datetime
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from escapement import __version__
from escapement.errors import EscapementError, InputFileError
from escapement.files import DeferredErrorFile, PendingFile, check_input, storage_error
from escapement.mechanisms import KINDS
from escapement.model import FloatArray
from escapement.motion import Events, Extrema, Motion
from escapement.motion_file.sampled import SampledTrajectory
from escapement.status import Status
from escapement.study.parse import parse_plan
from escapement.study.reader import DAMAGE, configuration_of
from escapement.study.sweep import plan_from
from escapement.units import SYSTEMS, factor, unit_name

__all__ = ["is_motion", "read_motion", "write_motion"]

CONTENT = "motion"
"""Root attribute `content`, by which a motion is told from a study."""
SCHEMA_VERSION = 1
"""Version of the file layout: raised when an older reader would misread a newer file."""
_BLOCK = 65536  # samples computed and written at a time, and the length of a chunk
_FILTERS: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}
Progress = Callable[[int, int, int], None]
"""Called with the samples written, their number and 0."""
_TYPES = {"f": "<f8", "i": "<i8", "b": "u1"}


class Column(NamedTuple):
    """A dataset: its key in `escapement.units`, and its name for people."""

    quantity: str
    long_name: str


SAMPLES = {
    "t": Column("time", "time from the first pin entry"),
    "theta": Column("angle", "driver angle from the first dead centre"),
    "theta_dot": Column("speed", "driver velocity"),
    "theta_ddot": Column("acceleration", "driver acceleration"),
    "phi": Column("angle", "follower angle"),
    "phi_dot": Column("speed", "follower velocity"),
    "phi_ddot": Column("acceleration", "follower acceleration"),
    "contact_moment": Column("torque", "moment of the pin on the follower"),
    "contact_force": Column("force", "force between pin and slot, with a crank radius"),
}
"""Columns over `t`, computed block by block."""
_EVENT = {
    "time": Column("time", "time of each"),
    "engagement": Column("ratio", "engagement, from 0"),
    "theta": SAMPLES["theta"],
    "theta_dot": SAMPLES["theta_dot"],
}
GROUPS = {
    "handoff": {
        "times": Column("time", "end of each engagement"),
        "velocities": Column("speed", "driver velocity at each handoff"),
    },
    "reversal": _EVENT,
    "extremum": {**_EVENT, "maximum": Column("ratio", "kind of extremum of the driver velocity")},
    "piece": {
        "start": Column("time", "start of each piece"),
        "engagement": Column("ratio", "engagement, from 0"),
        "sign": Column("ratio", "side of the slot that carries the force, 0 while locked"),
        "friction_loss": Column("energy", "work lost in friction over each piece"),
    },
}
"""Everything else: dataset `group_name` by group and name; the first of a group is its scale."""


def write_motion(
    motion: Motion,
    path: str | PathLike[str],
    *,
    units: str = "SI",
    force: bool = False,
    progress: Progress | None = None,
) -> None:
    """Write a motion to HDF5.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns. The times written are its default
        grid and the starts of its pieces.
    path : path
        File to create.
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
        For a motion without length.
    """
    import h5py

    pending = PendingFile(path, force)
    try:
        times = _sample_times(motion)  # HDF5 may crash where memory ends while it has a file
        target = DeferredErrorFile(pending.handle)
        with h5py.File(target, "w") as hdf5:
            _write_root(hdf5, motion)
            _write_samples(hdf5, motion, times, units, progress)
            for group, columns in GROUPS.items():
                _write_group(hdf5, group, columns, motion)
        if target.error is not None:
            raise target.error
        pending.place()
    except EscapementError:
        raise
    except (OSError, RuntimeError) as error:  # HDF5 tells a failed device by either
        raise storage_error(path, error) from None
    finally:
        pending.discard()


def _write_root(hdf5: Any, motion: Motion) -> None:
    import h5py

    hdf5.attrs.update(
        content=CONTENT,
        title=f"motion of an escapement, {motion.handoff_times.size} engagements",
        schema_version=SCHEMA_VERSION,
        package_version=__version__,
        engine=motion.engine,
        rtol=motion.rtol,
        end_time=motion.end_time,
        status=motion.status.label,
        message=motion.message,
        created=datetime.now(UTC).isoformat(timespec="seconds"),
    )
    scene = motion.escapement
    run: dict[str, Any] = {"initial_speed": float(motion.at(0.0).theta_dot), "rtol": motion.rtol}
    # so written, the file says all that it takes to simulate the motion again
    study = plan_from(scene, {"torque": [scene.torque]}, engine=motion.engine, **run)
    text = json.dumps(study.configuration, allow_nan=False)
    configuration = hdf5.create_dataset("configuration", data=text, dtype=h5py.string_dtype())
    configuration.attrs.update(units="1", long_name="the escapement as a study of one case, JSON")


def _write_samples(
    hdf5: Any, motion: Motion, times: FloatArray, units: str, progress: Progress | None
) -> None:
    """Columns over `t` in blocks, so that memory does not grow with the motion."""
    forced = getattr(motion.escapement.mechanism, "crank_radius", None) is not None
    columns = {name: SAMPLES[name] for name in SAMPLES if forced or name != "contact_force"}
    made = [_create(hdf5, name, columns[name], times.size, "f", units) for name in columns]
    for start in range(0, times.size, _BLOCK):
        rows = slice(start, start + _BLOCK)
        state = motion.at(times[rows])
        for (name, column), dataset in zip(columns.items(), made, strict=True):
            dataset[rows] = getattr(state, name) / factor(column.quantity, units)
        if progress is not None:
            progress(min(rows.stop, times.size), times.size, 0)
    _attach(made)


def _sample_times(motion: Motion) -> FloatArray:
    times = np.concatenate([motion.t, motion.trajectory.start])
    return np.unique(times[(times >= 0.0) & (times <= motion.end_time)])


def _write_group(hdf5: Any, group: str, columns: dict[str, Column], motion: Motion) -> None:
    """The events or pieces of a motion, a dataset for each column."""
    owners = {"reversal": motion.reversals, "extremum": motion.extrema, "piece": motion.trajectory}
    made = []
    for key, column in columns.items():
        name = f"{group}_{key}"
        values = getattr(owners[group], key) if group in owners else getattr(motion, name)
        values = np.asarray(values)
        made.append(_create(hdf5, name, column, values.size, values.dtype.kind))
        made[-1][...] = values
    _attach(made)


def _create(
    hdf5: Any, name: str, column: Column, size: int, kind: str, units: str = SYSTEMS[0]
) -> Any:
    """A dataset of numbers of a NumPy kind."""
    # an empty one has no chunks that could be filtered
    options = _FILTERS | {"chunks": (min(size, _BLOCK),)} if size else {}
    dataset = hdf5.create_dataset(name, (size,), _TYPES[kind], **options)
    dataset.attrs.update(units=unit_name(column.quantity, units), long_name=column.long_name)
    if kind == "b":
        flags = np.array([0, 1], "u1")
        dataset.attrs.update(flag_values=flags, flag_meanings="minimum maximum")
    return dataset


def _attach(datasets: list[Any]) -> None:
    """Make the first dataset the dimension scale of all."""
    scale, *rest = datasets
    scale.make_scale(scale.name.removeprefix("/"))
    for dataset in rest:
        dataset.dims[0].attach_scale(scale)


def is_motion(path: str | PathLike[str]) -> bool:
    """Whether `path` is an HDF5 file that says it holds a motion."""
    import h5py

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
    the samples at reversals and handoffs.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it holds no motion, is damaged, was written in a layout newer than this
        version knows, or has a mechanism that is of no kind it knows.
    """
    import h5py

    check_input(path, "motion")
    if not is_motion(path):
        raise InputFileError(
            f"motion {path} must be an HDF5 file that holds a motion, and is none; "
            "name a file that escapement run wrote"
        )
    try:
        with h5py.File(path, "r") as hdf5:
            _check_content(path, hdf5)
            return _read(hdf5)
    except InputFileError:
        raise
    except (*DAMAGE, EscapementError) as error:
        reason = " ".join(str(error).split())
        raise InputFileError(
            f"motion {path} must be whole, and is damaged: {reason}; write it anew"
        ) from None


def _check_content(path: str | PathLike[str], hdf5: Any) -> None:
    """Refuse a newer layout, and a mechanism of somebody's own, which a file cannot build."""
    version = int(hdf5.attrs["schema_version"])
    if version > SCHEMA_VERSION:
        raise InputFileError(
            f"motion {path} must have schema_version {SCHEMA_VERSION} or less, got {version}; "
            "install a newer geneva-escapement to read it"
        )
    machine = configuration_of(hdf5)["mechanism"]
    if machine["kind"] not in KINDS and "description" in machine:
        raise InputFileError(
            f"motion {path} must have a mechanism that a file can describe, got one of class "
            f"{machine['kind']}; take its numbers with h5py or xarray"
        )


def _read(hdf5: Any) -> Motion:
    escapement = parse_plan(configuration_of(hdf5)).escapement(0)
    groups = {
        group: {key: hdf5[f"{group}_{key}"][()] for key in columns}
        for group, columns in GROUPS.items()
    }
    samples = {name: hdf5[name][()] for name in ("t", "theta", "theta_dot")}
    end = float(hdf5.attrs["end_time"])
    # a damaged file may be read without an error of HDF5
    for columns in (samples, *groups.values()):
        _check_columns(columns, end)
    groups["extremum"]["maximum"] = groups["extremum"]["maximum"].astype(bool)
    t, pieces = samples["t"], groups.pop("piece")
    if (
        not t.size
        or not pieces["start"].size
        or not (np.diff(t) > 0.0).all()
        or t[0] != 0.0
        or t[-1] != end
    ):
        raise ValueError(f"t must ascend from 0 to the end_time, {end:g} s, and have a piece")
    extrema = Extrema(**groups["extremum"])
    found: dict[str, Any] = {"reversals": Events(**groups["reversal"]), "extrema": extrema}
    return Motion(
        escapement=escapement,
        engine=str(hdf5.attrs["engine"]),
        rtol=float(hdf5.attrs["rtol"]),
        trajectory=SampledTrajectory(escapement, **pieces, **found, **samples),
        end_time=end,
        handoff_times=groups["handoff"]["times"],
        handoff_velocities=groups["handoff"]["velocities"],
        status=Status[str(hdf5.attrs["status"]).upper()],
        message=str(hdf5.attrs["message"]),
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
