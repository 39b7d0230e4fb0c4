"""Readings and errors as CSV, in degrees; complete under their name or not there."""

from collections.abc import Iterator, Sequence
from itertools import chain
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np

from escapement.files.atomic import write_file
from escapement.measurement._csv import SYNTHETIC
from escapement.measurement._position import blocks
from escapement.measurement.readings import Readings
from escapement.model import FloatArray

if TYPE_CHECKING:
    from escapement.measurement._result import Measurement

_LABEL = f"{SYNTHETIC} data: computed by escapement, not measured\n"
_DECIMALS = 6
"""Of a degree: ten times finer than an encoder of 26 bits."""


def write_readings(
    readings: Readings, path: str | PathLike[str], *, note: str = "", force: bool = False
) -> None:
    """Write readings as `read_readings` reads them.

    Parameters
    ----------
    readings : Readings
        What to write; synthetic ones say so in the first line.
    path : path
        Where.
    note : str
        A comment for the head of the file.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    CannotCreate, StorageError
        When it cannot be created, or writing fails half-way.
    """
    columns = {"input_deg": readings.input, "output_deg": readings.output}
    _write(path, _head(readings, note), columns, force)


def write_errors(result: "Measurement", path: str | PathLike[str], *, force: bool = False) -> None:
    """Write input, output, theory and error of each complete sample.

    Parameters
    ----------
    result : Measurement
        What `escapement.measure` returns.
    path, force :
        As for `write_readings`.
    """
    columns = {
        "input_deg": result.input,
        "output_deg": result.output,
        "theory_deg": result.fit.theory,
        "error_deg": result.errors,
    }
    _write(path, _head(result.readings, ""), columns, force)


def _head(readings: Readings, note: str) -> str:
    comments = "".join(f"# {line}\n" for line in note.splitlines())
    return (_LABEL if readings.synthetic else "") + comments


def _write(
    path: str | PathLike[str], head: str, columns: dict[str, FloatArray], force: bool
) -> None:
    text = chain([head + ",".join(columns) + "\n"], _rows(list(columns.values())))
    write_file(path, map(str.encode, text), force)


def _rows(columns: Sequence[FloatArray]) -> Iterator[str]:
    """Lines, a block of samples at a time; an empty field for what is missing."""
    row = ",".join([f"%.{_DECIMALS}f"] * len(columns)) + "\n"
    for part in blocks(columns[0].size):
        table = np.degrees([column[part] for column in columns]).T + 0.0
        yield (row * len(table) % tuple(table.ravel())).replace("nan", "")
