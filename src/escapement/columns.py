"""The reader of text files with a column of input angles and one of output angles."""

import csv
import math
import os
import re
from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain
from os import PathLike
from typing import NamedTuple, TextIO

import numpy as np
from numpy.typing import NDArray

from escapement import validate
from escapement.errors import InputFileError, InvalidValue, MissingInput

UNITS = {"deg": 2.0 * math.pi / 360.0, "rad": 1.0}
"""Units of angles, in rad."""
NAMES = {
    "input": ("input", "in", "driver", "theta", "phi1"),
    "output": ("output", "out", "follower", "phi", "phi3"),
}
"""Headings by which the columns of driver and follower are known."""
_SPELLINGS = {
    "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg",
    "rad": "rad", "radian": "rad", "radians": "rad",
}  # fmt: skip
# angles in these units are refused, for they would be taken for degrees
_FOREIGN = re.compile(r"(?:[mµμu]rad|grad|gon|turn|rev|revolution|arcmin|arcsec)s?")
_NUMBER = re.compile(r"[-+]?[\d.,]+(e[-+]?\d+)?|nan", re.IGNORECASE)
_SEPARATORS = {"\t": "a tab", ";": "';'", ",": "','", " ": "blanks"}
_MISSING = {"", "na", "n/a", "null", "none"}


class Columns(NamedTuple):
    """Angles of input and output, and what else their file tells.

    angles : of input and output, NaN where a field is empty or says so, each of
        shape (n,) [rad].
    line : line of each row in the file, int, shape (n,).
    units : of both columns, as named by the caller or the headings; None where
        nothing tells, and the angles were taken for degrees.
    comments : lines that begin with #.
    """

    angles: tuple[NDArray[np.float64], NDArray[np.float64]]
    line: NDArray[np.int64]
    units: tuple[str | None, ...]
    comments: list[str]


class _Layout(NamedTuple):
    """How the rows of a file are to be read; `places` are those of input and output."""

    separator: str
    header: bool
    width: int
    places: tuple[int, ...]
    units: tuple[str | None, ...]


class _BrokenLine(Exception):
    """The rule that a line breaks, and the remedy."""


def read_columns(
    path: str | PathLike[str],
    what: str,
    names: tuple[str | None, str | None] = (None, None),
    unit: str | None = None,
    by_order: bool = False,
) -> Columns:
    """Read two columns of angles from a text file.

    Parameters
    ----------
    path : path
        Text in UTF-8, fields apart by tab, semicolon, comma or blanks; lines that
        begin with # are comments. Where commas do not part fields they may stand for
        decimal points. The first line holds names if none of its fields is a number.
    what : str
        What the file is, for messages.
    names : (str, str), optional
        Names of the input's and the output's column, with or without their unit.
        Default: one of `NAMES`; without a header the first and the second of two.
    unit : str, optional
        "deg" or "rad". Default: the last word of a column's name, else degrees.
    by_order : bool
        Whether, of two columns with other names, the input's is taken to be the first.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it cannot be read as such; the message has the line.
    InvalidValue
        When there is no column of the name given, or the unit is unknown.
    """
    if unit is not None:
        validate.choice("angle_unit", unit, tuple(UNITS))
    find = partial(_find_layout, names=names, unit=unit, by_order=by_order)
    try:
        # a pipe can be read only once, so it gets the reader that takes whatever is allowed
        return _read(path, find, plain=os.path.isfile(path))
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


def _read(path: str | PathLike[str], find: Callable[[str], _Layout], plain: bool) -> Columns:
    """Both columns, first as `plain` numbers, which takes half the time, then field by field."""
    with open(path, encoding="utf-8-sig") as stream:
        table = _Table(stream)
        try:
            return table.read(find, plain)
        except _BrokenLine as error:
            if not plain:
                rule, remedy = error.args
                text = table.text.strip()
                shown = text if len(text) <= 60 else text[:57] + "..."
                where = f"{path}, line {table.number}"
                raise InputFileError(f"{where} must {rule}, got {shown!r}; {remedy}") from None
    return _read(path, find, plain=False)


class _Table:
    """A stream of lines, the one that was read last, and which of them held no row."""

    def __init__(self, stream: TextIO) -> None:
        self.stream, self.number, self.text = stream, 0, ""
        self.passed_over, self.comments = [0], list[str]()

    def rows(self) -> Iterator[str]:
        """Lines that are neither blank nor comments."""
        lines = enumerate(self.stream, 1)
        for self.number, self.text in lines:
            if self.text.isspace() or self.text[0] == "#":
                self.passed_over.append(self.number)
                self.comments.append(self.text)
            # `loadtxt` would take the lines after an open quote for one field
            elif '"' in self.text and self.text.count('"') % 2:
                raise _BrokenLine("close its quotes", "correct it")
            else:
                yield self.text

    def read(self, find: Callable[[str], _Layout], plain: bool) -> Columns:
        """Both columns; an error is about the line that was read last."""
        rows = self.rows()
        layout = find(next(rows))
        if layout.header:
            self.passed_over.append(self.number)
            next(rows)
        number = partial(_number, decimal_comma=layout.separator != ",")
        # a type for each field makes `loadtxt` refuse rows with more or fewer of them
        kinds = [(str(i), float if i in layout.places else "U1") for i in range(layout.width)]
        try:
            table = np.loadtxt(
                chain([self.text], rows), np.dtype(kinds), comments=None, encoding=None, ndmin=1,
                delimiter=None if layout.separator == " " else layout.separator, quotechar='"',
                converters=None if plain else dict.fromkeys(layout.places, number),
            )  # fmt: skip
        except ValueError as error:
            if isinstance(error, UnicodeDecodeError):
                raise
            raise _BrokenLine(*_rule_of_rows(layout, self.text)) from None
        line = np.delete(np.arange(self.number + 1), self.passed_over)
        first, second = (
            table[str(place)] * UNITS[unit or "deg"]
            for place, unit in zip(layout.places, layout.units, strict=True)
        )
        return Columns((first, second), line, layout.units, self.comments)


def _rule_of_rows(layout: _Layout, text: str) -> tuple[str, str]:
    """The rule that a row breaks, and the remedy."""
    if len(_split(text, layout.separator)) != layout.width:
        apart = _SEPARATORS[layout.separator]
        return f"have {layout.width} fields apart by {apart}", "one row for each sample"
    places = " and ".join(str(place + 1) for place in sorted(layout.places))
    return f"have numbers in fields {places}", "correct it, or leave the field empty"


def _find_layout(
    text: str, names: tuple[str | None, str | None], unit: str | None, by_order: bool
) -> _Layout:
    """Layout of a file whose first row is `text`; see `read_columns`."""
    separator = next((mark for mark in _SEPARATORS if mark in text.strip()), " ")
    # a unit in brackets belongs to the word before it
    fields = _split(re.sub(r" +(?=[(\[])", "", text) if separator == " " else text, separator)
    if len(fields) < 2:
        remedy = "separate input and output by a comma, a semicolon or a tab"
        raise _BrokenLine("have two columns", remedy)
    header = not any(map(_NUMBER.fullmatch, fields))
    if header:
        places = _named_places(fields, names, by_order)
    elif len(fields) == 2 and names == (None, None):
        return _Layout(separator, header, 2, (0, 1), (unit, unit))
    else:
        remedy = "put a line with input and output among the names first"
        raise _BrokenLine(f"name its {len(fields)} columns", remedy)
    units = tuple(unit or _name_and_unit(fields[place])[1] for place in places)
    if not set(units) <= {*UNITS, None}:
        remedy = "convert them, or give the unit that they are in"
        raise _BrokenLine("have angles in degrees or radians", remedy)
    return _Layout(separator, header, len(fields), places, units)


def _named_places(
    fields: list[str], names: tuple[str | None, str | None], by_order: bool
) -> tuple[int, ...]:
    """Places of input and output, by the names given or usual ones."""
    places: list[int | None] = []
    by_order = by_order and len(fields) == 2
    for (role, usual), name in zip(NAMES.items(), names, strict=True):
        wanted = usual if name is None else (_name_and_unit(name)[0],)
        found = [i for i, field in enumerate(fields) if field == name]
        found = found or [i for i, text in enumerate(fields) if _name_and_unit(text)[0] in wanted]
        if len(found) != 1 and name is not None:
            rule, remedy = f"one of {', '.join(fields)}", validate.nearest(name, tuple(fields))
            raise validate.fail(f"{role} column", rule, name, remedy)
        if len(found) > 1 or not (found or by_order):
            rule = f"have one column called {' or '.join(usual)}"
            raise _BrokenLine(rule, f"name the {role}'s column")
        places.append(found[0] if found else None)
    first, second = places
    # of two columns, the one that is known tells the other
    if first is None:
        first = 0 if second is None else 1 - second
    if second is None:
        second = 1 - first
    if first == second:
        raise InvalidValue(
            f"input and output must be different columns, got {fields[first]!r} for both"
        )
    return first, second


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


def _name_and_unit(field: str) -> tuple[str, str | None]:
    """Name of a column in small letters, and its unit, which may be a foreign one."""
    *words, last = re.findall(r"[^\W_]+|°", field.lower()) or [""]
    unit = _SPELLINGS.get(last) or (last if _FOREIGN.fullmatch(last) else None)
    return "".join(words if unit else [*words, last]), unit
