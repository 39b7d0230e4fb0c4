"""Reading a study file back."""

import json
import os
from collections.abc import Iterable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np

from escapement.base.errors import CannotCreate, EscapementError
from escapement.base.files import AnyPath
from escapement.base.text import plain
from escapement.study.configuration import difference, whole_configuration
from escapement.study.result import Study, count_failed, result_names
from escapement.study.stored import (
    DAMAGE,
    SCHEMA_VERSION,
    StoredColumns,
    check_values,
    damaged,
    open_hdf5,
    opened,
    stamp_of,
)


def read_study(path: AnyPath) -> Study:
    """Read a study; each result is read when it is first used.

    Parameters
    ----------
    path : path
        File written by a sweep.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it is not an HDF5 file, is damaged, holds something else, or has a newer layout than
        this version can read. Damage within an array is found when the array is read; so is a
        file that was replaced or removed since.
    """
    target = os.path.realpath(path)
    with _open_study(path) as hdf5:
        stamp = stamp_of(target)
        beside = _coordinates(hdf5)
        sampled = [name for name in beside if hdf5[name].shape]
        fixed = [name for name in beside if not hdf5[name].shape]
        axes = {name: hdf5[name][()] for name in _dimensions(hdf5)}
        for name, values in axes.items():
            check_values(name, values, finite=True)
        configuration = configuration_of(hdf5)
        results = result_names(configuration)
        shape = tuple(values.size for values in axes.values())
        _check_columns(hdf5, sampled, shape[-1:])
        _check_columns(hdf5, results, shape)
        names = [*axes, *beside, *results]
        return Study(
            axes=axes,
            sampled=StoredColumns(target, sampled, True, stamp),
            results=StoredColumns(target, results, False, stamp),
            units={name: str(hdf5[name].attrs["units"]) for name in names},
            long_names={name: str(hdf5[name].attrs["long_name"]) for name in names},
            configuration=configuration,
            attributes=plain({k: v for k, v in hdf5.attrs.items() if k != "configuration"}),
            fixed={name: hdf5[name][()].item() for name in fixed},
        )


def _check_columns(hdf5: Any, names: Iterable[str], shape: tuple[int, ...]) -> None:
    """Raise ValueError unless these datasets hold numbers, in this shape."""
    for name in names:
        found = hdf5[name]
        if found.shape != shape or 0 in shape or found.dtype.kind not in "fiu":
            raise ValueError(
                f"{name} must be numbers of shape {shape}, got {found.dtype}, {found.shape}"
            )


def read_configuration(path: AnyPath) -> dict[str, Any]:
    """The configuration of a study file, without its results; errors as `read_study`."""
    with _open_study(path) as hdf5:
        return whole_configuration(configuration_of(hdf5), hdf5)


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
    try:
        with open_hdf5(path) as hdf5:
            check_same(path, configuration_of(hdf5), hdf5.attrs, frame)
            try:
                return _count_whole(hdf5, frame)
            except DAMAGE as error:
                raise damaged("study", path, error) from None
    except EscapementError:
        raise
    except DAMAGE:
        return None


def check_same(path: AnyPath, configuration: Any, attributes: Any, frame: Study) -> None:
    """Raise CannotCreate unless a complete file has the configuration and attributes of a study."""
    asked = {k: v for k, v in frame.attributes.items() if k != "created"}
    here = {"configuration": frame.configuration, "attributes": asked}
    found = plain({name: attributes.get(name) for name in asked})
    there = {"configuration": configuration, "attributes": found}
    if text := difference(there, json.loads(json.dumps(here))):
        raise CannotCreate(
            f"output {path} must be of this study to be resumed, got the complete file of "
            f"another: {text}; name another output, or give force=True to replace it"
        )


def _count_whole(hdf5: Any, frame: Study) -> int:
    """Failed cases, after every number of the frame's study was found and read."""
    for name, values in {**frame.axes, **frame.sampled}.items():
        if not np.array_equal(hdf5[name][()], values):
            raise ValueError(f"{name} has other values")
    failed = 0
    for name in frame.results:
        if hdf5[name].shape != frame.shape:
            raise ValueError(f"{name} must have shape {frame.shape}, got {hdf5[name].shape}")
        for chunk in hdf5[name].iter_chunks():
            values = hdf5[name][chunk]
            check_values(name, values)
            failed += count_failed(values) if name == "status" else 0
    return failed


def configuration_of(hdf5: Any) -> dict[str, Any]:
    """The configuration in an open file; ValueError if it has none."""
    name = "configuration"  # a dataset in the first version of the layout
    text = hdf5[name].asstr()[()] if name in hdf5 else hdf5.attrs[name]
    configuration = json.loads(text)
    if not isinstance(configuration, dict):
        raise ValueError(f"configuration must be a JSON object, got {configuration!r:.40}")
    return configuration


def _dimensions(hdf5: Any) -> list[str]:
    return [dimension[0].name.lstrip("/") for dimension in hdf5["status"].dims]


def _coordinates(hdf5: Any) -> list[str]:
    """Names of the parameters of a sample, and of those that are fixed."""
    return str(hdf5["status"].attrs.get("coordinates", "")).split()
