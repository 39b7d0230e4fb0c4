"""The configuration of a study in its file: long axes by name, and how two of them differ."""

import json
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

_COPIED = 64  # a longer axis is not copied into the configuration, which then has its name
_TABLES = ("sweep", "sample")
_NOT_SET = object()


def short_configuration(
    configuration: Mapping[str, Any], columns: Mapping[str, Any]
) -> dict[str, Any]:
    """A configuration that names the datasets of long axes instead of copying their values.

    The checksum of the values stays, so that different studies differ in it.
    """

    def short(name: str, form: Any) -> Any:
        if not (isinstance(form, list) and len(form) > _COPIED and name in columns):
            return form
        values = np.asarray(columns[name])
        checksum = zlib.crc32(values.astype(values.dtype.newbyteorder("<")).tobytes())
        return {"dataset": name, "size": len(form), "checksum": f"{checksum:08x}"}

    return _with_forms(configuration, short)


def whole_configuration(configuration: Mapping[str, Any], columns: Any) -> dict[str, Any]:
    """The shortened configuration of an open file, with the values of all axes restored."""

    def whole(_: str, form: Any) -> Any:
        named = isinstance(form, dict) and "dataset" in form
        return columns[form["dataset"]][()].tolist() if named else form

    return _with_forms(configuration, whole)


def _with_forms(configuration: Mapping[str, Any], change: Any) -> dict[str, Any]:
    return {
        key: {name: change(name, form) for name, form in value.items()} if key in _TABLES else value
        for key, value in configuration.items()
    }


def difference(there: Mapping[str, Any], here: Mapping[str, Any]) -> str:
    """The first difference of two configurations or sets of attributes; "" if there is none."""
    parts = ("configuration", "attributes")
    return next(filter(None, (_first_difference(there[part], here[part]) for part in parts)), "")


def _first_difference(there: Any, here: Any, prefix: str = "") -> str:
    if not (isinstance(there, dict) and isinstance(here, dict)):
        return "" if there == here else f"{prefix} was {_short(there)} and is {_short(here)}"
    for key in there | here:
        where = f"{prefix}.{key}" if prefix else key
        if text := _first_difference(there.get(key, _NOT_SET), here.get(key, _NOT_SET), where):
            return text
    order = f"{prefix or 'the study'} had the order {', '.join(there)}"
    return "" if [*there] == [*here] else order


def _short(value: Any) -> str:
    text = "not set" if value is _NOT_SET else json.dumps(value)
    return text if len(text) <= 60 else text[:40] + " ... " + text[-15:]
