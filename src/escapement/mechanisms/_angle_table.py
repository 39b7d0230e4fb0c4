"""Reading a table of driver and follower angles from a CSV file."""

import csv
import math
from collections.abc import Sequence
from os import PathLike

import numpy as np

from escapement.errors import InputFileError, MissingInput
from escapement.model import FloatArray


def read_angles(path: str | PathLike[str]) -> FloatArray:
    """Both columns of a table, shape (2, rows), in the file's unit.

    Parameters
    ----------
    path : path
        Two numbers in each line, separated by a comma; a line of headings may come
        first, and lines that start with # are passed over.

    Raises
    ------
    MissingInput, InputFileError
        When the file is not there, or is no such table.
    """
    try:
        with open(path, encoding="utf-8-sig", newline="") as stream:
            lines = [(k, row) for k, row in enumerate(csv.reader(stream), 1) if row]
    except FileNotFoundError:
        raise MissingInput(f"table {path} must exist, and does not; check the path") from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputFileError(
            f"table {path} must be a text file, and cannot be read: {error}; write it as CSV"
        ) from None
    rows = [(k, row) for k, row in lines if not row[0].lstrip().startswith("#")]
    if rows and not _numbers(rows[0][1]):
        rows = rows[1:]
    for k, row in rows:
        if not _numbers(row):
            raise InputFileError(
                f"table {path} must have two numbers in each line, got {','.join(row)[:40]!r} in "
                f"line {k}; give driver and follower angle in degrees"
            )
    return np.array([[float(cell) for cell in row[:2]] for _, row in rows]).reshape(-1, 2).T


def _numbers(row: Sequence[str]) -> bool:
    try:
        return len(row) == 2 and all(math.isfinite(float(cell)) for cell in row)
    except ValueError:
        return False
