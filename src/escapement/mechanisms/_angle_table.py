"""Reading a table of driver and follower angles from a CSV file."""

import csv
import math
from os import PathLike

import numpy as np

from escapement.errors import InputFileError, MissingInput
from escapement.model import FloatArray


def read_angles(path: str | PathLike[str]) -> FloatArray:
    """Both columns of a table, shape (2, rows), in the file's unit.

    Parameters
    ----------
    path : path
        Two numbers in each line, apart by a tab, semicolon, comma or blanks; beside a
        tab or semicolon a comma may be the decimal point. A line of headings may come
        first, and lines that start with # are passed over.

    Raises
    ------
    MissingInput, InputFileError
        When the file is not there, or is no such table.
    """
    try:
        with open(path, encoding="utf-8-sig") as stream:
            lines = [(k, text.strip()) for k, text in enumerate(stream, 1)]
            rows = [(k, text, _angles(text)) for k, text in lines if text and text[0] != "#"]
    except (FileNotFoundError, NotADirectoryError):
        raise MissingInput(f"table {path} must exist, and does not; check the path") from None
    except (OSError, ValueError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputFileError(
            f"table {path} must be a text file, and cannot be read: {reason}; write it as CSV"
        ) from None
    if rows and rows[0][2] is None:
        rows = rows[1:]
    for k, text, angles in rows:
        if angles is None:
            raise InputFileError(
                f"table {path} must have two numbers in each line, got {text[:40]!r} in line {k}; "
                "give driver and follower angle in degrees, apart by comma, semicolon, tab or blank"
            )
    return np.array([angles for *_, angles in rows], dtype=float).reshape(-1, 2).T


def _angles(text: str) -> list[float] | None:
    """Both numbers of a line; None where it holds anything else."""
    mark = next((mark for mark in "\t;," if mark in text), None)
    cells = text.split() if mark is None else next(csv.reader([text], delimiter=mark))
    if mark in ("\t", ";"):
        cells = [cell.replace(",", ".") for cell in cells]
    try:
        angles = [float(cell) for cell in cells]
    except ValueError:
        return None
    return angles if len(angles) == 2 and all(map(math.isfinite, angles)) else None
