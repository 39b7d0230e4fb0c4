"""Text files with the times of beats, or with their intervals."""

import math
import re

import numpy as np

from escapement.base import validate
from escapement.base.errors import InputFileError
from escapement.base.files import AnyPath, check_input
from escapement.base.headings import TIMES, UNITS, is_row_of_units, name_and_unit
from escapement.base.lines import BrokenLine, Lines
from escapement.mechanisms.protocol import FloatArray

INTERVALS = ("interval", "intervals", "beat", "beats", "duration", "durations", "period")
"""Headings of columns of intervals."""
_TIMES = ("time", "times", "t", "timestamp", "onset", "onsets")
_MISSING = {"", "-", "nan", "na", "n/a", "#n/a"}
_SEPARATORS = ("\t", ";", ",", " ")


def read_times(path: AnyPath, time_unit: str | None = None) -> FloatArray:
    """Instants of beats [s], in turn.

    Parameters
    ----------
    path : path
        Text with a column of instants, or of intervals, and with or without a heading. Its
        column is the one named time or interval, else the only one. Numbers that increase
        throughout are instants, unless the heading says otherwise. A decimal comma is understood
        where commas do not separate columns.
    time_unit : str, optional
        A key of `headings.TIMES`. Default: as in the heading, else seconds.

    Raises
    ------
    MissingInput, InputFileError
        When there is no such file, or it holds no times.
    InvalidValue
        For an unknown unit.
    """
    if time_unit is not None:
        validate.choice("time_unit", time_unit, tuple(TIMES))
    check_input(path, "file of beats")
    lines = Lines(path, 0)
    try:
        fields = [line.strip() for line in lines]
    except (OSError, UnicodeDecodeError) as error:
        raise InputFileError(
            f"file of beats {path} must be a readable text file, got: {error}; save it as text, or "
            "name a recording .wav"
        ) from None
    except BrokenLine as error:
        rule, remedy = error.args
        raise InputFileError(f"{path}, line {lines.number} must {rule}; {remedy}") from None
    if not fields:
        raise InputFileError(f"file of beats {path} must hold times, and is empty; check its name")
    mark = _separator(fields)
    rows = [[part.strip() for part in (row.split(mark) if mark else [row])] for row in fields]
    column, name, unit, rows = _column_of(rows, path)
    unit = time_unit or (unit if unit in TIMES else "s")
    values = TIMES[unit] * np.array([_number(row, column, path) for row in rows])
    filled = values[np.isfinite(values)]
    instants = name in _TIMES or (name not in INTERVALS and bool((np.diff(filled) > 0.0).all()))
    if instants:
        back = np.flatnonzero(np.diff(filled) <= 0.0)
        if back.size:
            raise InputFileError(
                f"file of beats {path} must have times that increase, got "
                f"{filled[back[0] + 1]:g} s after {filled[back[0]]:g} s; sort them, or name the "
                "column interval"
            )
        return np.asarray(filled)
    if filled.size < values.size or not (filled > 0.0).all():
        raise InputFileError(
            f"file of beats {path} must have an interval greater than 0 in each row, got "
            f"{values[~(values > 0.0)][0]:g} s; give times of the beats instead"
        )
    return np.concatenate([[0.0], np.cumsum(filled)])


def _separator(lines: list[str]) -> str:
    """The mark between columns, "" of one column, whose numbers may have a decimal comma."""
    last = lines[-1]
    found = next((mark for mark in _SEPARATORS if mark in last), "")
    # "199,98" is one number, unless the line of names has two names
    named = re.search("[a-z]", lines[0], re.IGNORECASE)
    two_names = named and "," in lines[0]
    decimal = last.count(",") == 1 and "." not in last and not two_names
    return "" if found == "," and decimal else found


def _column_of(
    rows: list[list[str]], path: AnyPath
) -> tuple[int, str, str | None, list[list[str]]]:
    """Index, name and unit of the column of times, and the rows of numbers."""
    head = rows[0]
    if any(re.fullmatch(r"[-+]?[\d.,]+(e[-+]?\d+)?", field, re.IGNORECASE) for field in head):
        return 0, "", None, rows
    below = rows[1:]
    if below and is_row_of_units(below[0]):
        head = [f"{name} {unit}" for name, unit in zip(head, below[0], strict=False)]
        below = below[1:]
    named = [name_and_unit(field) for field in head]
    unknown = next((unit for _, unit in named if unit and unit not in (*TIMES, *UNITS)), None)
    if unknown:
        raise InputFileError(
            f"file of beats {path} must have times in {', '.join(TIMES)}, got {unknown}; convert "
            "them, or give --time-unit (time_unit)"
        )
    usual = [i for i, (name, _) in enumerate(named) if name in (*_TIMES, *INTERVALS, "")]
    column = usual[0] if usual else 0
    if not usual and len(head) > 1:
        raise InputFileError(
            f"file of beats {path} must name its columns, one of them time or interval, got "
            f"{', '.join(head)}; rename the column of times"
        )
    return column, *named[column], below


def _number(row: list[str], column: int, path: AnyPath) -> float:
    text = row[column] if column < len(row) else ""
    if text.lower() in _MISSING:
        return math.nan
    try:
        return float(text.replace(",", "."))
    except ValueError:
        raise InputFileError(
            f"file of beats {path} must have a number in each row, got {text!r}; correct it, or "
            "name a recording .wav"
        ) from None
