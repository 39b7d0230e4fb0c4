"""Reading a table of driver and follower angles from a CSV file."""

import csv
import math
import re
from os import PathLike

import numpy as np

from escapement.errors import InputFileError, MissingInput
from escapement.model import FloatArray
from escapement.text import FOREIGN, NAMES, UNITS, name_and_unit


def read_angles(path: str | PathLike[str]) -> FloatArray:
    """Driver and follower angles of a table, shape (2, rows) [rad].

    Parameters
    ----------
    path : path
        Two numbers in each line, apart by a tab, semicolon, comma or blanks; beside a
        tab or semicolon a comma may be the decimal point. A line of headings may come
        first, none of them a number, and lines that start with # are passed over.
        Angles are in degrees, the driver's first, where no heading says otherwise.

    Raises
    ------
    MissingInput, InputFileError
        When the file is not there, or is no such table.
    """
    try:
        with open(path, encoding="utf-8-sig") as stream:
            lines = [(k, text.strip()) for k, text in enumerate(stream, 1)]
            rows = [(k, text, _numbers(text)) for k, text in lines if text and text[0] != "#"]
    except (FileNotFoundError, NotADirectoryError):
        raise MissingInput(f"table {path} must exist, and does not; check the path") from None
    except (OSError, ValueError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputFileError(
            f"table {path} must be a text file, and cannot be read: {reason}; write it as CSV"
        ) from None
    places, units = (0, 1), ("deg", "deg")
    if rows and not any(number is not None for number in rows[0][2]):
        k, text, _ = rows.pop(0)
        try:
            places, units = _headings(text)
        except ValueError as error:
            raise InputFileError(
                f"table {path} must have {error}, got {text[:40]!r} in line {k}; "
                "write for example theta_deg,phi_deg"
            ) from None
    for k, text, numbers in rows:
        if len(numbers) != 2 or not all(n is not None and math.isfinite(n) for n in numbers):
            raise InputFileError(
                f"table {path} must have two numbers in each line, got {text[:40]!r} in line {k}; "
                "give driver and follower angle in degrees, apart by comma, semicolon, tab or blank"
            )
    table = np.array([numbers for *_, numbers in rows], dtype=float).reshape(-1, 2)
    return np.array([table[:, i] * UNITS[unit] for i, unit in zip(places, units, strict=True)])


def _headings(text: str) -> tuple[tuple[int, int], tuple[str, str]]:
    """Places of driver and follower, and their units, as far as a line of headings tells."""
    if any(FOREIGN.fullmatch(word) for word in re.findall(r"[^\W\d_]+", text)):
        raise ValueError("its angles in degrees or radians")
    # a unit in brackets belongs to the word before it
    fields = _fields(re.sub(r"\s+(?=[(\[])", "", text))
    if len(fields) != 2:
        if any(name_and_unit(field)[1] == "rad" for field in fields):
            raise ValueError("a heading for each of its two columns where it names radians")
        return (0, 1), ("deg", "deg")
    (first, one), (second, other) = (name_and_unit(field) for field in fields)
    if {one, other} == {"rad", None}:
        raise ValueError("the units of both columns in its headings, or of neither")
    if first in NAMES["output"] or second in NAMES["input"]:
        if first in NAMES["input"] or second in NAMES["output"]:
            raise ValueError("a heading for driver and one for follower")
        return (1, 0), (other or "deg", one or "deg")
    return (0, 1), (one or "deg", other or "deg")


def _numbers(text: str) -> list[float | None]:
    """Fields of a line as numbers; None for what is none."""
    return [_number(field) for field in _fields(text)]


def _fields(text: str) -> list[str]:
    mark = next((mark for mark in "\t;," if mark in text), None)
    fields = text.split() if mark is None else next(csv.reader([text], delimiter=mark))
    return [field.replace(",", ".") for field in fields] if mark in ("\t", ";") else fields


def _number(field: str) -> float | None:
    try:
        return float(field)
    except ValueError:
        return None
