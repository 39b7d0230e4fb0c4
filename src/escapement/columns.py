"""The reader of text files with a column of input angles and one of output angles."""

import csv
import math
import os
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from itertools import chain
from os import PathLike
from typing import NamedTuple

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
    **dict.fromkeys(("deg", "degree", "degrees", "°"), "deg"),
    **dict.fromkeys(("rad", "radian", "radians"), "rad"),
}
# angles in these units are refused, for they would be taken for degrees
_FOREIGN = re.compile(r"(?:[mµμu]rad|grad|gon|turn|rev|revolution|arcmin|arcsec)s?")
_NUMBER = re.compile(r"[-+]?[\d.,]+(e[-+]?\d+)?|nan", re.IGNORECASE)
_SEPARATORS = {"\t": "a tab", ";": "';'", ",": "','", " ": "blanks"}
_MISSING = {"", "na", "n/a", "null", "none"}


class Columns(NamedTuple):
    """Angles of input and output, and other contents of their file.

    angles : of input and output, NaN where a field is empty or says so, each of
        shape (n,) [rad].
    line : line of each row in the file, int, shape (n,).
    units : of both columns, as named by the caller or the headings; None where
        nothing names them, and degrees were assumed.
    comments : lines that begin with #.
    """

    angles: tuple[NDArray[np.float64], NDArray[np.float64]]
    line: NDArray[np.int64]
    units: tuple[str | None, ...]
    comments: list[str]


# of rows: separator, whether there is a header, number of fields, and of input and output
# the places and the units
_Layout = tuple[str, bool, int, tuple[int, ...], tuple[str | None, ...]]


class _BrokenLine(Exception):
    """The rule that a line breaks, and the remedy."""


def read_columns(
    path: str | PathLike[str],
    what: str,
    names: tuple[str | None, str | None] = (None, None),
    unit: str | None = None,
    by_order: bool = False,
    default: str = "deg",
) -> Columns:
    """Read two columns of angles from a text file.

    Parameters
    ----------
    path : path
        Text in UTF-8, with fields separated by tab, semicolon, comma or blanks; lines that begin
        with # are comments. Where commas do not separate fields, they may be decimal points. The
        first line holds names if none of its fields is a number.
    what : str
        What the file is, for messages.
    names : (str, str), optional
        Names of the input's and the output's column, with or without their unit.
        Default: one of `NAMES`; without a header the first and the second of two.
    unit : str, optional
        "deg" or "rad". Default: the last word of a column's name, else degrees.
    by_order : bool
        Whether the first of two columns with other names is the input.
    default : str
        Unit of a column of which nothing tells another.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it has no such content; the message names the line.
    InvalidValue
        When there is no column of the name given, or the unit is unknown.
    """
    if unit is not None:
        validate.choice("angle_unit", unit, tuple(UNITS))
    lines = _Lines(path)
    layout = partial(_find_layout, names=names, unit=unit, by_order=by_order)
    try:
        # plain numbers take half the time, but a pipe can be read only once
        if os.path.isfile(path):
            with suppress(_BrokenLine):
                return _read(lines, layout, default, plain=True)
        return _read(lines, layout, default, plain=False)
    except _BrokenLine as error:
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


class _Lines:
    """Lines of a file, the line that was read last, and the lines without a row."""

    def __init__(self, path: str | PathLike[str]) -> None:
        self.path, self.number, self.text = path, 0, ""

    def __iter__(self) -> Iterator[str]:
        """Lines that are neither blank nor comments, from the first one on."""
        self.passed_over, self.comments = [0], list[str]()
        with open(self.path, encoding="utf-8-sig") as stream:
            for self.number, self.text in enumerate(stream, 1):
                if self.text.isspace() or self.text[0] == "#":
                    self.passed_over.append(self.number)
                    self.comments.append(self.text)
                # `loadtxt` would take the lines after an open quote for one field
                elif '"' in self.text and self.text.count('"') % 2:
                    raise _BrokenLine("close its quotes", "correct it")
                else:
                    yield self.text


def _read(lines: _Lines, find: Callable[[str], _Layout], default: str, plain: bool) -> Columns:
    """Both columns, of `plain` numbers or of all that is allowed; an error is of the last line."""
    rows = iter(lines)
    separator, header, width, places, units = find(next(rows))
    if header:
        lines.passed_over.append(lines.number)
        next(rows)
    number = partial(_number, decimal_comma=separator != ",")
    # a type for each field makes `loadtxt` refuse rows with more or fewer of them
    kinds = [(str(i), float if i in places else "U1") for i in range(width)]
    try:
        table = np.loadtxt(
            chain([lines.text], rows), np.dtype(kinds), comments=None, encoding=None, ndmin=1,
            delimiter=None if separator == " " else separator, quotechar='"',
            converters=None if plain else dict.fromkeys(places, number),
        )  # fmt: skip
    except UnicodeDecodeError:
        raise
    except ValueError:
        if len(_split(lines.text, separator)) != width:
            rule = f"have {width} fields apart by {_SEPARATORS[separator]}"
            raise _BrokenLine(rule, "one row for each sample") from None
        rule = f"have numbers in fields {' and '.join(str(i + 1) for i in sorted(places))}"
        raise _BrokenLine(rule, "correct it, or leave the field empty") from None
    line = np.delete(np.arange(lines.number + 1), lines.passed_over)
    first, second = (
        table[str(place)] * UNITS[unit or default]
        for place, unit in zip(places, units, strict=True)
    )
    return Columns((first, second), line, units, lines.comments)


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
        return separator, header, 2, (0, 1), (unit, unit)
    else:
        remedy = "put a line with input and output among the names first"
        raise _BrokenLine(f"name its {len(fields)} columns", remedy)
    units = tuple(unit or _name_and_unit(fields[place])[1] for place in places)
    if not set(units) <= {*UNITS, None}:
        remedy = "convert them, or give the unit that they are in"
        raise _BrokenLine("have angles in degrees or radians", remedy)
    return separator, header, len(fields), places, units


def _named_places(
    fields: list[str], names: tuple[str | None, str | None], by_order: bool
) -> tuple[int, ...]:
    """Places of input and output, by the names given or usual ones."""
    places: list[int | None] = []
    for (role, usual), name in zip(NAMES.items(), names, strict=True):
        wanted = usual if name is None else (_name_and_unit(name)[0],)
        found = [i for i, field in enumerate(fields) if field == name]
        found = found or [i for i, text in enumerate(fields) if _name_and_unit(text)[0] in wanted]
        if len(found) != 1 and name is not None:
            rule, remedy = f"one of {', '.join(fields)}", validate.nearest(name, tuple(fields))
            raise validate.fail(f"{role} column", rule, name, remedy)
        if len(found) > 1 or not (found or (by_order and len(fields) == 2)):
            rule = f"have one column called {' or '.join(usual)}"
            raise _BrokenLine(rule, f"name the {role}'s column")
        places.append(found[0] if found else None)
    first, second = places
    # of two columns, the one that is known tells the other
    first = (0 if second is None else 1 - second) if first is None else first
    second = 1 - first if second is None else second
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
