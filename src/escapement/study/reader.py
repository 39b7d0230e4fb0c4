"""Reading a study file back."""

import json
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from escapement.errors import CannotCreate, EscapementError, InputFileError, InvalidValue
from escapement.files import check_input
from escapement.status import Status
from escapement.study.identity import difference
from escapement.study.result import RESULTS, SCHEMA_VERSION, Study, count_failed

T = TypeVar("T")
DAMAGE = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError)
"""What h5py and NumPy raise over a file that is not as it should be."""


def read_study(path: str | PathLike[str]) -> Study:
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
    return _open_study(path, _read)


def read_configuration(path: str | PathLike[str]) -> dict[str, Any]:
    """The configuration of a study file, without its results; errors as `read_study`."""
    return _open_study(path, configuration_of)


def read_sample_case(path: str | PathLike[str], case: int) -> dict[str, Any]:
    """Sampled parameters of one case of a study file, in its units; errors as `read_study`.

    Raises
    ------
    InvalidValue
        When there is no such case.
    """

    def read(hdf5: Any) -> dict[str, Any]:
        cases = hdf5["status"].shape[-1]
        if not 0 <= case < cases:
            raise InvalidValue(
                f"case must be one of the {cases} cases of {path}, got {case}; "
                f"they are numbered from 0 to {cases - 1}"
            )
        return {name: hdf5[name][case].item() for name in _sampled(hdf5)}

    return _open_study(path, read)


def _open_study(path: str | PathLike[str], use: Callable[[Any], T]) -> T:
    """What `use` makes of the open file; whatever is wrong with it as one error."""
    import h5py

    file = Path(path)
    try:
        check_input(path, "study")
        with h5py.File(file, "r") as hdf5:
            _check_schema(path, hdf5)
            return use(hdf5)
    except PermissionError:
        raise InputFileError(f"study {path} must be readable; check its permissions") from None
    except EscapementError:
        raise
    except DAMAGE as error:
        if not h5py.is_hdf5(file):
            raise InputFileError(
                f"study {path} must be an HDF5 file, and is not or is cut short; "
                "name a file that escapement sweep wrote"
            ) from None
        raise _damaged(path, error) from None


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
            own = [name for name in frame.attributes if name != "created"]
            there = {
                "configuration": configuration_of(hdf5),
                "attributes": {name: _plain(hdf5.attrs[name]) for name in own},
            }
            attributes = {name: frame.attributes[name] for name in own}
            here = {"configuration": frame.configuration, "attributes": attributes}
            here = json.loads(json.dumps(here))
            if json.dumps(there) != json.dumps(here):
                raise CannotCreate(
                    f"output {path} must be of this study to be resumed, got the complete file of "
                    f"another: {difference(there, here)}; name another output, or give force=True "
                    "to replace it"
                )
            try:
                return _count_whole(hdf5, frame)
            except DAMAGE as error:
                raise _damaged(path, error, " with force=True") from None
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
    for name in RESULTS:
        if hdf5[name].shape != frame.shape:
            raise ValueError(f"{name} must have shape {frame.shape}, got {hdf5[name].shape}")
        for chunk in hdf5[name].iter_chunks():
            values = hdf5[name][chunk]
            _check_values(name, values, values.shape)
            failed += count_failed(values) if name == "status" else 0
    return failed


def _check_schema(path: str | PathLike[str], hdf5: Any) -> None:
    version = hdf5.attrs.get("schema_version")
    missing = [name for name in ("configuration", *RESULTS) if name not in hdf5]
    if missing or not isinstance(version, np.integer | int):
        raise InputFileError(
            f"study {path} must hold a study, and lacks {', '.join(missing) or 'schema_version'}; "
            "name a file that escapement sweep wrote"
        )
    if version > SCHEMA_VERSION:
        raise InputFileError(
            f"study {path} must have schema_version {SCHEMA_VERSION} or less, got {version}; "
            "install a newer geneva-escapement to read it"
        )


def _read(hdf5: Any) -> Study:
    axes = [dimension[0].name.lstrip("/") for dimension in hdf5["status"].dims]
    sampled = _sampled(hdf5)
    names = [*axes, *sampled, *RESULTS]
    study = Study(
        axes={name: hdf5[name][()] for name in axes},
        sampled={name: hdf5[name][()] for name in sampled},
        results={name: hdf5[name][()] for name in RESULTS},
        units={name: str(hdf5[name].attrs["units"]) for name in names},
        long_names={name: str(hdf5[name].attrs["long_name"]) for name in names},
        configuration=configuration_of(hdf5),
        attributes={name: _plain(value) for name, value in hdf5.attrs.items()},
    )
    for name, axis in {**study.axes, **study.sampled}.items():
        _check_values(name, axis, axis.shape[:1])
        if not axis.size or not np.isfinite(axis).all():
            raise ValueError(f"{name} must be finite numbers")
    for name, values in study.results.items():
        _check_values(name, values, study.shape)
    return study


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


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _damaged(path: str | PathLike[str], error: Exception, how: str = "") -> InputFileError:
    reason = " ".join(str(error).split())
    return InputFileError(
        f"study {path} must be whole, and is damaged: {reason}; write it anew{how}"
    )
