"""The reader of text files with columns of numbers, as loggers and spreadsheets write them."""

import csv
import math
import os
import re
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.base.clock import EXAMPLES, Clock, past_midnight
from escapement.base.errors import InputFileError, MissingInput
from escapement.base.files import AnyPath
from escapement.base.headings import is_row_of_units
from escapement.base.lines import BrokenLine, Lines

_MISSING = {  # an empty field, and what spreadsheets and loggers write for one
    "", "na", "n/a", "n.a.", "#na", "#n/a", "#value!", "#ref!", "#div/0!", "#num!", "null", "none",
    "-", "--", "---", "?",
}  # fmt: skip
_NUMBER = re.compile(r"[-+]?[\d.,]+(e[-+]?\d+)?|nan", re.IGNORECASE)
_DATE = re.compile(r" *\d+-\d+-")
_SEPARATORS = {"\t": "a tab", ";": "';'", ",": "','", " ": "blanks"}
_DECIMAL = re.compile(r" *[-+]?\d*,\d+\s*")


class Layout(NamedTuple):
    """Which columns of a file are read; the last one may hold times of day or dates.

    indices : of the columns, None for a missing one.
    units, scales : their units, as they are told, and the sizes of these.
    """

    indices: tuple[int | None, ...]
    units: tuple[str | None, ...]
    scales: tuple[float, ...]


class TextTable(NamedTuple):
    """Columns of a file.

    columns : those of the layout, NaN where a field is empty or marked as missing, each of
        shape (n,); None for a missing column.
    line : line of each row in the file, int, shape (n,).
    layout : the layout; the unit of the last column is "clock" for times of day and dates.
    comments : lines that begin with #.
    """

    columns: tuple[NDArray[np.float64] | None, ...]
    line: NDArray[np.int64]
    layout: Layout
    comments: list[str]


class Content(NamedTuple):
    """What a file is expected to hold.

    what : what the file is, for messages.
    rows : what its rows hold.
    columns : which columns to give, for messages.
    single : whether one column is enough.
    """

    what: str
    rows: str
    columns: str
    single: bool = False


FindLayout = Callable[[list[str], list[str], bool], Layout]
"""Finds the layout from the fields of the first line, the same with units from a second line, and
whether the first line is a heading. It raises BrokenLine if it finds none."""


def read_table(
    path: AnyPath, content: Content, find_layout: FindLayout, skip: int = 0
) -> TextTable:
    """Read columns of numbers from a text file.

    Parameters
    ----------
    path : path
        Text in UTF-8, UTF-16 or code page 1252, with fields separated by tab, semicolon, comma or
        blanks; lines that begin with # are comments. Where commas do not separate fields, they may
        be decimal points. The first line holds names if none of its fields is a number, and the
        line below it may hold units.
    content : Content
        What is expected.
    find_layout : callable
        Chooses the columns.
    skip : int
        How many lines to ignore at the beginning of the file.

    Raises
    ------
    MissingInput
        If there is no such file.
    InputFileError
        If the file has no such content; the message names the line.
    """
    lines = Lines(path, skip)
    try:
        # reading as plain numbers takes half the time; a pipe cannot be read a second time
        if os.path.isfile(path):
            with suppress(BrokenLine):
                return _read(lines, content, find_layout, plain=True)
        return _read(lines, content, find_layout, plain=False)
    except BrokenLine as error:
        (rule, remedy), text = error.args, lines.text.strip()
        shown = text if len(text) <= 60 else text[:57] + "..."
        where = f"{path}, line {lines.number}"
        raise InputFileError(f"{where} must {rule}, got {shown!r}; {remedy}") from None
    except (FileNotFoundError, NotADirectoryError):
        raise MissingInput(f"{content.what} {path} does not exist; check its name") from None
    except OSError as error:
        raise InputFileError(
            f"{content.what} {path} must be a readable text file, got: {error.strerror}; save it "
            "as CSV in UTF-8"
        ) from None
    except StopIteration:
        raise InputFileError(
            f"{content.what} {path} must hold rows of {content.rows}, got none; give "
            f"{content.columns}"
        ) from None


def _read(lines: Lines, content: Content, find_layout: FindLayout, plain: bool) -> TextTable:
    """The columns; `plain` allows only numbers. An error concerns the line that was read last."""
    rows = iter(lines)
    separator, fields = _first_fields(next(rows), content.single)
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
        if content.single and len(_split(lines.text, separator)) == 1:
            fields, names = [" ".join(fields)], [" ".join(names)]
    try:
        layout = find_layout(fields, names, header)
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
    except ValueError:
        raise _bad_row(lines.text, separator, len(fields), layout.indices) from None
    line = np.delete(np.arange(lines.number + 1), lines.passed_over)
    columns = [
        None if index is None else table[str(index)] * scale
        for index, scale in zip(layout.indices, layout.scales, strict=True)
    ]
    if clock.used:
        columns[-1] = past_midnight(table[str(layout.indices[-1])])
        layout = layout._replace(units=(*layout.units[:-1], "clock"))
    return TextTable(tuple(columns), line, layout, lines.comments)


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


def _first_fields(text: str, single: bool) -> tuple[str, list[str]]:
    """The separator of a file whose first row is `text`, and the fields of this row."""
    if single and _DECIMAL.fullmatch(text):
        return " ", [text.strip()]
    separator = next((mark for mark in _SEPARATORS if mark in text.strip()), " ")
    # a unit in brackets belongs to the word before it
    fields = _split(re.sub(r" +(?=[(\[])", "", text) if separator == " " else text, separator)
    if len(fields) < 2 and not single:
        remedy = "separate input and output by a comma, a semicolon or a tab"
        raise BrokenLine("have two columns", remedy)
    return separator, fields


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
