"""The reader of text files with columns of input angles, output angles and times."""

import csv
import math
import os
import re
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from itertools import chain
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.base import validate
from escapement.base.clock import EXAMPLES, Clock, past_midnight
from escapement.base.errors import InputFileError, InvalidValue, MissingInput
from escapement.base.headings import (
    COUNTS,
    NAMES,
    TIME_NAMES,
    TIMES,
    UNITS,
    is_row_of_units,
    name_and_unit,
)
from escapement.base.lines import BrokenLine, Lines

_ROLES = (*NAMES, "time")
_MISSING = {  # an empty field, and what spreadsheets and loggers write for one
    "", "na", "n/a", "n.a.", "#na", "#n/a", "#value!", "#ref!", "#div/0!", "#num!", "null", "none",
    "-", "--", "---", "?",
}  # fmt: skip
_NUMBER = re.compile(r"[-+]?[\d.,]+(e[-+]?\d+)?|nan", re.IGNORECASE)
_DATE = re.compile(r" *\d+-\d+-")
_SEPARATORS = {"\t": "a tab", ";": "';'", ",": "','", " ": "blanks"}


class Columns(NamedTuple):
    """Angles of input and output, and other contents of their file.

    angles : of input and output, NaN where a field is empty or marked as missing, each
        of shape (n,) [rad].
    time : of each row, shape (n,) [s]; None if it was not asked for.
    line : line of each row in the file, int, shape (n,).
    units : of both columns, from the caller or the headings; None where neither gives one,
        so that degrees were assumed.
    time_unit : likewise of the times; "clock" where they are times of day or dates.
    comments : lines that begin with #.
    """

    angles: tuple[NDArray[np.float64], NDArray[np.float64]]
    time: NDArray[np.float64] | None
    line: NDArray[np.int64]
    units: tuple[str | None, ...]
    time_unit: str | None
    comments: list[str]


class _Wanted(NamedTuple):
    """What a caller wants of a file; see `read_columns`.

    angles : size of each unit of the input, and of the output [rad].
    """

    names: tuple[str | None, ...]
    unit: str | None
    time_unit: str | None
    by_order: bool
    default: str
    angles: tuple[dict[str, float], dict[str, float]]


class _Layout(NamedTuple):
    """How a file is laid out.

    indices : of the columns of input, output and time, None for a missing column.
    units, scales : of the same.
    """

    indices: tuple[int | None, ...]
    units: tuple[str | None, ...]
    scales: tuple[float, ...]


def read_columns(
    path: str | PathLike[str],
    what: str,
    names: tuple[str | None, ...] = (None, None, None),
    unit: str | None = None,
    by_order: bool = False,
    default: str = "deg",
    resolution: int | tuple[int, int] | None = None,
    skip: int = 0,
    time_unit: str | None = None,
) -> Columns:
    """Read two columns of angles, and one of times where it is named, from a text file.

    Parameters
    ----------
    path : path
        Text in UTF-8, UTF-16 or code page 1252, with fields separated by tab, semicolon, comma or
        blanks; lines that begin with # are comments. Where commas do not separate fields, they may
        be decimal points. The first line holds names if none of its fields is a number, and the
        line below it may hold units.
    what : str
        What the file is, for messages.
    names : (str, str, str), optional
        Names of the columns of input, output and time, with or without their unit.
        Default: one of `NAMES`, in a file without a header the first and the second of two
        columns; no time. With a time, the output may be missing.
    unit : str, optional
        "deg", "rad", "turn" or "counts". Default: the last word of a column's name, else degrees.
    by_order : bool
        Whether the first of two columns with other names is the input.
    default : str
        Unit of a column for which neither `unit` nor its name gives one.
    resolution : int or (int, int), optional
        Counts in a turn, of both columns or of input and output.
    skip : int
        How many lines to ignore at the beginning of the file.
    time_unit : str, optional
        "s", "ms", "us", "ns", "min" or "h". Default: the last word of the column's name, else
        seconds. Times of day and dates have no unit.

    Raises
    ------
    MissingInput
        If there is no such file.
    InputFileError
        If the file has no such content; the message names the line.
    InvalidValue
        If there is no column with a given name, or the unit is unknown.
    """
    pair = resolution if isinstance(resolution, tuple) else (resolution, resolution)
    angles = [UNITS | ({} if n is None else {COUNTS: 2.0 * math.pi / n}) for n in pair]
    if unit is not None:
        validate.choice("angle_unit", unit, (*UNITS, COUNTS))
    if time_unit is not None:
        validate.choice("time_unit", time_unit, tuple(TIMES))
    if unit == COUNTS and resolution is None:
        raise InvalidValue(
            "angle_unit counts must come with a resolution, got none; give the number of counts in "
            "a turn"
        )
    lines = Lines(path, skip)
    layout = _Wanted(names, unit, time_unit, by_order, default, (angles[0], angles[1]))
    try:
        # reading as plain numbers takes half the time; a pipe cannot be read a second time
        if os.path.isfile(path):
            with suppress(BrokenLine):
                return _read(lines, layout, plain=True)
        return _read(lines, layout, plain=False)
    except BrokenLine as error:
        (rule, remedy), text = error.args, lines.text.strip()
        shown = text if len(text) <= 60 else text[:57] + "..."
        where = f"{path}, line {lines.number}"
        raise InputFileError(f"{where} must {rule}, got {shown!r}; {remedy}") from None
    except (FileNotFoundError, NotADirectoryError):
        raise MissingInput(f"{what} {path} does not exist; check its name") from None
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputFileError(
            f"{what} {path} must be a readable text file, got: {reason}; save it as CSV in UTF-8"
        ) from None
    except StopIteration:
        raise InputFileError(
            f"{what} {path} must hold rows of angles, got none; "
            "give a column of the input and one of the output"
        ) from None


def _read(lines: Lines, wanted: _Wanted, plain: bool) -> Columns:
    """The columns; `plain` allows only numbers. An error concerns the line that was read last."""
    rows = iter(lines)
    separator, fields = _first_fields(next(rows))
    header = not any(map(_NUMBER.fullmatch, fields))
    names, head = fields, (lines.number, lines.text)
    if header:
        lines.passed_over.append(lines.number)
        next(rows)
        below = _split(lines.text, separator)
        if len(below) == len(fields) and is_row_of_units(below):
            names = [f"{name} {unit}" for name, unit in zip(fields, below, strict=True)]
            lines.passed_over.append(lines.number)
            next(rows)
    try:
        layout = _find_layout(fields, names, header, wanted)
    except BrokenLine:
        lines.number, lines.text = head
        raise
    indices = sorted(index for index in layout.indices if index is not None)
    number, clock = partial(_number, decimal_comma=separator != ","), Clock()
    readers: dict[int | str, Callable[[str], Any]] = dict.fromkeys(indices, number)
    if layout.indices[-1] is not None:
        readers[layout.indices[-1]] = partial(_time, number=number, clock=clock)
    # a type for each field makes `loadtxt` refuse rows with more or fewer of them
    kinds = [(str(i), float if i in indices else "U1") for i in range(len(fields))]
    try:
        table = np.loadtxt(
            chain([lines.text], rows), np.dtype(kinds), comments=None, encoding=None, ndmin=1,
            delimiter=None if separator == " " else separator, quotechar='"',
            converters=None if plain else readers,
        )  # fmt: skip
    except UnicodeDecodeError:
        raise
    except ValueError:
        raise _bad_row(lines.text, separator, len(fields), layout.indices) from None
    line = np.delete(np.arange(lines.number + 1), lines.passed_over)
    first, second, time = (
        np.full(line.size, np.nan) if index is None else table[str(index)] * scale
        for index, scale in zip(layout.indices, layout.scales, strict=True)
    )
    timed, time_unit = None if layout.indices[-1] is None else time, layout.units[-1]
    if clock.used:
        timed, time_unit = past_midnight(table[str(layout.indices[-1])]), "clock"
    units = tuple(
        unit
        for unit, index in zip(layout.units[:-1], layout.indices, strict=False)
        if index is not None
    )
    return Columns((first, second), timed, line, units, time_unit, lines.comments)


def _bad_row(text: str, separator: str, width: int, indices: tuple[int | None, ...]) -> BrokenLine:
    """The rule that a row breaks."""
    if len(_split(text, separator)) != width:
        remedy = "give one row for each sample"
        if separator == " " and re.search(r"\d-\d\d?-\d+ +\d+:\d", text):
            remedy = "write date and time as one word, or separate the columns by semicolons"
        return BrokenLine(f"have {width} fields separated by {_SEPARATORS[separator]}", remedy)
    known = sorted(index + 1 for index in indices if index is not None)
    remedy = "correct it, or leave the field empty"
    if indices[-1] is not None:
        remedy += f"; times are numbers, {EXAMPLES}"
    return BrokenLine(f"have numbers in fields {' and '.join(map(str, known))}", remedy)


def _first_fields(text: str) -> tuple[str, list[str]]:
    """The separator of a file whose first row is `text`, and the fields of this row."""
    separator = next((mark for mark in _SEPARATORS if mark in text.strip()), " ")
    # a unit in brackets belongs to the word before it
    fields = _split(re.sub(r" +(?=[(\[])", "", text) if separator == " " else text, separator)
    if len(fields) < 2:
        remedy = "separate input and output by a comma, a semicolon or a tab"
        raise BrokenLine("have two columns", remedy)
    return separator, fields


def _find_layout(fields: list[str], names: list[str], header: bool, wanted: _Wanted) -> _Layout:
    """Layout of a file with these fields in its first row; `names` have their units too."""
    if not header and (len(fields) > 2 or any(wanted.names)):
        remedy = "begin the file with a line of names, among them input and output"
        raise BrokenLine(f"name its {len(fields)} columns", remedy)
    indices = _named_indices(fields, wanted.names, wanted.by_order) if header else (0, 1, None)
    units: list[str | None] = []
    scales = []
    for role, index, known in zip(_ROLES, indices, (*wanted.angles, TIMES), strict=True):
        word, stated = name_and_unit(names[index]) if header and index is not None else ("", None)
        timed = role == "time"
        if not (timed or word) and stated in TIMES:
            stated = None  # a heading may just be "second"
        chosen = (wanted.time_unit if timed else wanted.unit) or stated
        usual = "s" if timed else wanted.default
        if (chosen or usual) not in known:
            raise _wrong_unit(chosen, timed)
        scales.append(known[chosen or usual])
        units.append(chosen)
    return _Layout(indices, tuple(units), tuple(scales))


def _wrong_unit(unit: str | None, timed: bool) -> BrokenLine:
    """The rule that the unit in a heading breaks."""
    if timed:
        remedy = "convert them, or give --time-unit, in Python time_unit"
        return BrokenLine(f"have times in {', '.join(TIMES)}", remedy)
    if unit == COUNTS:
        remedy = "give --resolution N, in Python resolution=N"
        return BrokenLine("come with the number of counts in a turn", remedy)
    remedy = "convert them, or give the unit that they are in"
    return BrokenLine("have angles in turns, degrees or radians", remedy)


def _named_indices(
    fields: list[str], names: tuple[str | None, ...], by_order: bool
) -> tuple[int | None, ...]:
    """Indices of the columns of input, output and time, by the names given or usual ones."""
    indices: list[int | None] = []
    *angles, time = names
    for (role, usual), name in zip(NAMES.items(), angles, strict=True):
        found = _index_of(fields, role, name, usual)
        # if one of two columns is known, the other one has the other role
        may_lack = (by_order and len(fields) == 2) or (role == "output" and time is not None)
        if found is None and not may_lack:
            raise _unnamed(role, usual)
        indices.append(found)
    first, second = indices
    if by_order:
        first = (0 if second is None else 1 - second) if first is None else first
        second = 1 - first if second is None else second
    if first == second:
        raise InvalidValue(
            f"input and output must be different columns, got {fields[first or 0]!r} for both; "
            "name another column for one of them"
        )
    return first, second, None if time is None else _time_index(fields, time)


def _time_index(fields: list[str], name: str) -> int | None:
    """Index of the column of times; one called time may have another usual name."""
    usual = [field for field in fields if name_and_unit(field)[0] in TIME_NAMES]
    other = name == TIME_NAMES[0] and len(usual) == 1
    return _index_of(fields, "time", usual[0] if other else name, ())


def _index_of(fields: list[str], role: str, name: str | None, usual: tuple[str, ...]) -> int | None:
    """Index of the column called `name`, or else of the only one with a usual name, or None."""
    wanted = usual if name is None else (name_and_unit(name)[0],)
    found = [i for i, field in enumerate(fields) if field == name]
    found = found or [i for i, text in enumerate(fields) if name_and_unit(text)[0] in wanted]
    if len(found) != 1 and name is not None:
        rule, remedy = f"one of {', '.join(fields)}", validate.nearest(name, tuple(fields))
        raise validate.fail(f"{role} column (--{role}-column)", rule, name, remedy)
    if len(found) > 1:
        raise _unnamed(role, usual)
    return found[0] if found else None


def _unnamed(role: str, usual: tuple[str, ...]) -> BrokenLine:
    """The rule that headings break if they do not identify the column of a role."""
    rule = f"have one column called {' or '.join(usual)}"
    return BrokenLine(rule, f"name the {role}'s column with --{role}-column NAME")


def _split(text: str, separator: str) -> list[str]:
    """Fields of a line."""
    fields = text.split() if separator == " " else next(csv.reader([text], delimiter=separator))
    return [field.strip() for field in fields]


def _number(field: str, decimal_comma: bool) -> float:
    """A field as a number, NaN for a missing reading."""
    if field.strip().lower() in _MISSING:
        return math.nan
    if "_" in field:  # Python takes 1_5 for 15
        raise ValueError
    return float(field.replace(",", ".") if decimal_comma else field)


def _time(field: str, number: Callable[[str], float], clock: Clock) -> float:
    """A time as a number, or in s as a time of day or a date."""
    if ":" in field or _DATE.match(field):
        return clock(field)
    return number(field)
