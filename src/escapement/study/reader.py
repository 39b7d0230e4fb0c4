"""Reading a study file back."""

import json
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from escapement.errors import CannotCreate, EscapementError, InputFileError, InvalidValue
from escapement.files import AnyPath, check_input
from escapement.status import Status
from escapement.study.result import SCHEMA_VERSION, Study, count_failed, difference, result_names
from escapement.text import plain

DAMAGE = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError)
"""What h5py and NumPy raise over a file that is not as it should be."""


def read_study(path: AnyPath) -> Study:
    """Read a study with all its results.

    Parameters
    ----------
    path : path
        File written by a sweep.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it is no HDF5 file, is damaged, holds something else, or was
        written in a layout newer than this version knows.
    """
    with _open_study(path) as hdf5:
        axes = [dimension[0].name.lstrip("/") for dimension in hdf5["status"].dims]
        sampled, configuration = _sampled(hdf5), configuration_of(hdf5)
        results = result_names(configuration)
        names = [*axes, *sampled, *results]
        study = Study(
            axes={name: hdf5[name][()] for name in axes},
            sampled={name: hdf5[name][()] for name in sampled},
            results={name: hdf5[name][()] for name in results},
            units={name: str(hdf5[name].attrs["units"]) for name in names},
            long_names={name: str(hdf5[name].attrs["long_name"]) for name in names},
            configuration=configuration,
            attributes=plain(hdf5.attrs),
        )
        for name, axis in {**study.axes, **study.sampled}.items():
            _check_values(name, axis, axis.shape[:1])
            if not axis.size or not np.isfinite(axis).all():
                raise ValueError(f"{name} must be finite numbers")
        for name, values in study.results.items():
            _check_values(name, values, study.shape)
        return study


def read_configuration(path: AnyPath) -> dict[str, Any]:
    """The configuration of a study file, without its results; errors as `read_study`."""
    with _open_study(path) as hdf5:
        return configuration_of(hdf5)


def read_sample_case(path: AnyPath, case: int) -> dict[str, Any]:
    """Sampled parameters of one case of a study file, in its units; errors as `read_study`.

    Raises
    ------
    InvalidValue
        When there is no such case.
    """
    with _open_study(path) as hdf5:
        cases = hdf5["status"].shape[-1]
        if not 0 <= case < cases:
            raise InvalidValue(
                f"case must be one of the {cases} cases of {path}, got {case}; "
                f"they are numbered from 0 to {cases - 1}"
            )
        return {name: hdf5[name][case].item() for name in _sampled(hdf5)}


@contextmanager
def opened(
    path: AnyPath, what: str, command: str, needed: Iterable[str], version: int
) -> Iterator[Any]:
    """The open file of a result; whatever is wrong with it, or within the block, as one error.

    what, command : what the file holds, and the command that writes such a file.
    needed : names of datasets that it must have.
    version : the newest layout that is understood.
    """
    import h5py

    check_input(path, what)
    remedy = f"name a file that escapement {command} wrote"
    try:
        with h5py.File(path, "r") as hdf5:
            layout = hdf5.attrs.get("schema_version")
            missing = [name for name in needed if name not in hdf5]
            if missing or not isinstance(layout, np.integer | int):
                lacks = ", ".join(missing) or "schema_version"
                raise InputFileError(
                    f"{what} {path} must hold a {what}, and lacks {lacks}; {remedy}"
                )
            if layout > version:
                raise InputFileError(
                    f"{what} {path} must have schema_version {version} or less, got {layout}; "
                    "install a newer geneva-escapement to read it"
                )
            yield hdf5
    except PermissionError:
        raise InputFileError(f"{what} {path} must be readable; check its permissions") from None
    except EscapementError:
        raise
    except DAMAGE as error:
        if h5py.is_hdf5(path):
            raise _damaged(what, path, error) from None
        raise InputFileError(
            f"{what} {path} must be an HDF5 file, and is not or is cut short; {remedy}"
        ) from None


def _open_study(path: AnyPath) -> AbstractContextManager[Any]:
    return opened(path, "study", "sweep", ("configuration", "status"), SCHEMA_VERSION)


def failed_cases(path: Path, frame: Study) -> int | None:
    """Failed cases of the file at `path`; None unless it is a study.

    Raises
    ------
    CannotCreate
        When it is another study than that of `frame`; the message has the difference.
    InputFileError
        When it is that study, and damaged.
    """
    import h5py

    try:
        with h5py.File(path, "r") as hdf5:
            attributes = {k: v for k, v in frame.attributes.items() if k != "created"}
            here = {"configuration": frame.configuration, "attributes": attributes}
            there = {
                "configuration": configuration_of(hdf5),
                "attributes": plain({name: hdf5.attrs[name] for name in attributes}),
            }
            if text := difference(there, json.loads(json.dumps(here))):
                raise CannotCreate(
                    f"output {path} must be of this study to be resumed, got the complete file of "
                    f"another: {text}; name another output, or give force=True to replace it"
                )
            try:
                return _count_whole(hdf5, frame)
            except DAMAGE as error:
                raise _damaged("study", path, error, " with force=True") from None
    except EscapementError:
        raise
    except DAMAGE:
        return None


def _count_whole(hdf5: Any, frame: Study) -> int:
    """Failed cases, once every number of the frame's study was found and read."""
    for name, values in {**frame.axes, **frame.sampled}.items():
        if not np.array_equal(hdf5[name][()], values):
            raise ValueError(f"{name} has other values")
    failed = 0
    for name in frame.results:
        if hdf5[name].shape != frame.shape:
            raise ValueError(f"{name} must have shape {frame.shape}, got {hdf5[name].shape}")
        for chunk in hdf5[name].iter_chunks():
            values = hdf5[name][chunk]
            _check_values(name, values, values.shape)
            failed += count_failed(values) if name == "status" else 0
    return failed


def _check_values(name: str, values: Any, shape: tuple[int, ...]) -> None:
    """Raise ValueError unless `values` may be numbers of a study, those of a status known."""
    if values.shape != shape or values.dtype.kind not in "fiu":
        raise ValueError(
            f"{name} must be numbers of shape {shape}, got {values.dtype} of {values.shape}"
        )
    # by its ends: as a set it would take ten times the memory of the file
    if name == "status" and values.size and not 0 <= values.min() <= values.max() <= max(Status):
        raise ValueError("status must hold known values")


def configuration_of(hdf5: Any) -> dict[str, Any]:
    """The configuration that an open file holds; ValueError where it is none."""
    configuration = json.loads(hdf5["configuration"].asstr()[()])
    if not isinstance(configuration, dict):
        raise ValueError(f"configuration must be a JSON object, got {configuration!r:.40}")
    return configuration


def _sampled(hdf5: Any) -> list[str]:
    """Names of the parameters of a sample."""
    return str(hdf5["status"].attrs.get("coordinates", "")).split()


def _damaged(what: str, path: AnyPath, error: Exception, how: str = "") -> InputFileError:
    reason = " ".join(str(error).split())
    return InputFileError(
        f"{what} {path} must be whole, and is damaged: {reason}; write it anew{how}"
    )
