"""Writing a motion: complete under its name, or not at all."""

import json
from collections.abc import Callable
from datetime import UTC, datetime
from os import PathLike
from typing import Any

import numpy as np

from escapement import __version__
from escapement.errors import EscapementError
from escapement.files import DeferredErrorFile, PendingFile, storage_error
from escapement.model import FloatArray
from escapement.motion import Motion
from escapement.motion_file.layout import CONTENT, SAMPLES, SCHEMA_VERSION, Column, event_groups
from escapement.study.sweep import plan_from
from escapement.units import factor, unit_name

_BLOCK = 65536  # samples computed and written at a time, and the length of a chunk
_TYPES = {"f": "<f8", "i": "<i8", "b": "u1"}


def write_motion(
    motion: Motion,
    path: str | PathLike[str],
    *,
    units: str = "SI",
    force: bool = False,
    progress: Callable[[int, int, int], None] | None = None,
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
            _write_samples(hdf5, motion, times, units, progress or _silent)
            for columns in event_groups(motion).values():
                _write_group(hdf5, columns)
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
    study = plan_from(
        scene,
        {"torque": [scene.torque]},
        initial_speed=float(motion.at(0.0).theta_dot),
        engine=motion.engine,
        rtol=motion.rtol,
    )
    text = json.dumps(study.configuration, allow_nan=False)
    configuration = hdf5.create_dataset("configuration", data=text, dtype=h5py.string_dtype())
    configuration.attrs.update(units="1", long_name="the escapement as a study of one case, JSON")


def _silent(done: int, total: int, failed: int) -> None:
    """Nobody watches."""


def _write_samples(
    hdf5: Any,
    motion: Motion,
    times: FloatArray,
    units: str,
    progress: Callable[[int, int, int], None],
) -> None:
    """Columns over `t` in blocks, so that memory does not grow with the motion."""
    forced = getattr(motion.escapement.mechanism, "crank_radius", None) is not None
    names = [name for name in SAMPLES if forced or name != "contact_force"]
    for name in names:
        _create(hdf5, name, SAMPLES[name], times.size, "<f8", units)
    for start in range(0, times.size, _BLOCK):
        state = motion.at(times[start : start + _BLOCK])
        for name in names:
            scale = factor(SAMPLES[name].quantity, units)
            hdf5[name][start : start + _BLOCK] = getattr(state, name) / scale
        progress(min(start + _BLOCK, times.size), times.size, 0)
    _attach(hdf5, names)


def _sample_times(motion: Motion) -> FloatArray:
    times = np.concatenate([motion.t, motion.trajectory.start])
    return np.unique(times[(times >= 0.0) & (times <= motion.end_time)])


def _write_group(hdf5: Any, columns: Any) -> None:
    for name, column in columns.items():
        values = np.asarray(column.values)
        _create(hdf5, name, column, values.size, _TYPES[values.dtype.kind], "SI")
        hdf5[name][...] = values
        if values.dtype.kind == "b":
            hdf5[name].attrs["flag_values"] = np.array([0, 1], "u1")
            hdf5[name].attrs["flag_meanings"] = "minimum maximum"
    _attach(hdf5, list(columns))


def _create(hdf5: Any, name: str, column: Column, size: int, kind: str, units: str) -> None:
    """A dataset; an empty one has no chunks to filter."""
    filters: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}
    options = filters | {"chunks": (min(size, _BLOCK),)} if size else {}
    dataset = hdf5.create_dataset(name, (size,), kind, **options)
    dataset.attrs["units"] = (
        "J" if column.quantity == "energy" else unit_name(column.quantity, units)
    )
    dataset.attrs["long_name"] = column.long_name


def _attach(hdf5: Any, names: list[str]) -> None:
    scale, *rest = (hdf5[name] for name in names)
    scale.make_scale(names[0])
    for dataset in rest:
        dataset.dims[0].attach_scale(scale)
