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
from typing import Any

import h5py
import numpy as np

from escapement import __version__
from escapement.dynamics import LOSSES
from escapement.errors import EscapementError, InputFileError
from escapement.files import check_target, pending_hdf5
from escapement.mechanisms import KINDS
from escapement.model import FloatArray
from escapement.motion import Motion
from escapement.motion_file.sampled import SampledTrajectory
from escapement.status import Status
from escapement.study.parse import parse_plan, plan_from
from escapement.study.reader import configuration_of, opened
from escapement.trajectory import Events, Extrema
from escapement.units import factor, unit_name

CONTENT = "motion"
"""Root attribute `content`, by which a motion is told from a study."""
SCHEMA_VERSION = 1
"""Version of the file layout: raised when an older reader would misread a newer file."""
_BLOCK = 65536  # samples computed and written at a time, and the length of a chunk
_FILTERS: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}
_ATTRIBUTES = {"engine": str, "rtol": float, "end_time": float, "message": str}
"""Attributes of a motion that are root attributes of the file too, and their types."""
Progress = Callable[[int, int, int], None]
"""Called with the samples written, their number and 0."""

# of each dataset its key in `escapement.units`, its name for people and its type
Columns = dict[str, tuple[str, str, str]]
SAMPLES: Columns = {
    "t": ("time", "time from the first pin entry", "<f8"),
    "theta": ("angle", "driver angle from the first dead centre", "<f8"),
    "theta_dot": ("speed", "driver velocity", "<f8"),
    "theta_ddot": ("acceleration", "driver acceleration", "<f8"),
    "phi": ("angle", "follower angle", "<f8"),
    "phi_dot": ("speed", "follower velocity", "<f8"),
    "phi_ddot": ("acceleration", "follower acceleration", "<f8"),
    "contact_moment": ("torque", "moment of the pin on the follower", "<f8"),
    "contact_force": ("force", "force between pin and slot, with a crank radius", "<f8"),
    "driver_bearing_reaction": ("force", "force that the driver's bearing carries", "<f8"),
    "follower_bearing_reaction": ("force", "force that the follower's bearing carries", "<f8"),
}
"""Columns over `t`, computed block by block."""
_HANDOFFS: Columns = {
    "handoff_times": ("time", "end of each engagement", "<f8"),
    "handoff_velocities": ("speed", "driver velocity at each handoff", "<f8"),
}
_EVENTS: Columns = {
    "time": ("time", "time of each", "<f8"),
    "engagement": ("ratio", "engagement, from 0", "<i8"),
    "theta": SAMPLES["theta"],
    "theta_dot": SAMPLES["theta_dot"],
}
_EXTREMA: Columns = {
    **_EVENTS,
    "maximum": ("ratio", "kind of extremum of the driver velocity", "u1"),
}
_PIECES: Columns = {
    "start": ("time", "start of each piece", "<f8"),
    "engagement": ("ratio", "engagement, from 0", "<i8"),
    "sign": ("ratio", "side of the slot that carries the force, 0 while locked", "<f8"),
    **{
        f"{name}_loss": ("energy", f"work lost in {name.replace('_', ' ')} over each piece", "<f8")
        for name in LOSSES
    },
}
_LOST = {f"{name}_loss": row for row, name in enumerate(LOSSES)}
GROUPS = (
    ("", "", _HANDOFFS),
    ("reversals", "reversal_", _EVENTS),
    ("extrema", "extremum_", _EXTREMA),
    ("trajectory", "piece_", _PIECES),
)
"""Everything else: an attribute of the motion or itself, prefix and columns of its datasets."""


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
    check_target(path, force)
    # HDF5 may crash where memory ends while it has a file
    times = np.concatenate([motion.t, motion.trajectory.start])
    times = np.unique(times[(times >= 0.0) & (times <= motion.end_time)])
    with pending_hdf5(path, force) as (hdf5, _):
        _write_root(hdf5, motion)
        _write_samples(hdf5, motion, times, units, progress)
        for owner, prefix, columns in GROUPS:
            source: Any = getattr(motion, owner) if owner else motion
            size = getattr(source, next(iter(columns))).size
            for key, dataset in _create(hdf5, prefix, columns, size, units).items():
                lost = key in _LOST
                dataset[...] = source.losses[_LOST[key]] if lost else getattr(source, key)


def _write_root(hdf5: Any, motion: Motion) -> None:
    hdf5.attrs.update(
        content=CONTENT,
        title=f"motion of an escapement, {motion.handoff_times.size} engagements",
        schema_version=SCHEMA_VERSION,
        package_version=__version__,
        **{name: getattr(motion, name) for name in _ATTRIBUTES},
        status=motion.status.label,
        created=datetime.now(UTC).isoformat(timespec="seconds"),
    )
    scene = motion.escapement
    run: dict[str, Any] = {"initial_speed": float(motion.at(0.0).theta_dot), "rtol": motion.rtol}
    # so written, the file says all that it takes to simulate the motion again
    axis = "torque" if scene.torque == scene.torque_unit else "load_torque"
    study = plan_from(scene, {axis: [getattr(scene, axis)]}, engine=motion.engine, **run)
    text = json.dumps(study.configuration, allow_nan=False)
    configuration = hdf5.create_dataset("configuration", data=text, dtype=h5py.string_dtype())
    configuration.attrs.update(units="1", long_name="the escapement as a study of one case, JSON")


def _write_samples(
    hdf5: Any, motion: Motion, times: FloatArray, units: str, progress: Progress | None
) -> None:
    """Columns over `t` in blocks, so that memory does not grow with the motion."""
    first = motion.at(0.0)
    columns = {name: SAMPLES[name] for name in SAMPLES if getattr(first, name) is not None}
    made = _create(hdf5, "", columns, times.size, units)
    for start in range(0, times.size, _BLOCK):
        rows = slice(start, start + _BLOCK)
        state = motion.at(times[rows])
        for name, dataset in made.items():
            dataset[rows] = getattr(state, name) / factor(columns[name][0], units)
        if progress is not None:
            progress(min(rows.stop, times.size), times.size, 0)


def _create(hdf5: Any, prefix: str, columns: Columns, size: int, units: str) -> dict[str, Any]:
    """Datasets of one length, the first of them the dimension scale of all."""
    # an empty one has no chunks that could be filtered
    options = _FILTERS | {"chunks": (min(size, _BLOCK),)} if size else {}
    made = {}
    for key, (quantity, long_name, dtype) in columns.items():
        made[key] = hdf5.create_dataset(prefix + key, (size,), dtype, **options)
        made[key].attrs.update(units=unit_name(quantity, units), long_name=long_name)
        if key == "maximum":
            flags = np.array([0, 1], "u1")
            made[key].attrs.update(flag_values=flags, flag_meanings="minimum maximum")
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
    the samples at reversals and handoffs.

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
    escapement = parse_plan(configuration_of(hdf5)).escapement(0)
    attributes = {name: kind(hdf5.attrs[name]) for name, kind in _ATTRIBUTES.items()}
    samples = {name: hdf5[name][()] for name in ("t", "theta", "theta_dot")}
    groups = [
        # files of the first versions hold the loss in friction alone
        {key: hdf5[prefix + key][()] for key in columns if key not in _LOST or prefix + key in hdf5}
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
    pieces["losses"] = np.array([pieces.pop(key, none) for key in _LOST])
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
