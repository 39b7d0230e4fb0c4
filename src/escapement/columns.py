"""The reader of text files with columns of input angles, output angles and times."""

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
COUNTS = "counts"
"""Unit of angles that are counts of an encoder; its resolution converts them."""
_TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
NAMES = {
    "input": ("input", "in", "driver", "theta", "phi1"),
    "output": ("output", "out", "follower", "phi", "phi3"),
}
"""Headings that identify the columns of input and output."""
_ROLES = (*NAMES, "time")
_SPELLINGS = {
    **dict.fromkeys(("deg", "degree", "degrees", "°"), "deg"),
    **dict.fromkeys(("rad", "radian", "radians"), "rad"),
    **dict.fromkeys(("count", "counts", "ticks"), COUNTS),
    **{"s": "s", "ms": "ms", "us": "us", "µs": "us"},
}
# angles in these units are refused, for they would otherwise be taken as degrees
_FOREIGN = re.compile(r"(?:[mµμu]rad|grad|gon|turn|rev|revolution|arcmin|arcsec)s?")
_NUMBER = re.compile(r"[-+]?[\d.,]+(e[-+]?\d+)?|nan", re.IGNORECASE)
_SEPARATORS = {"\t": "a tab", ";": "';'", ",": "','", " ": "blanks"}
_MISSING = {"", "na", "n/a", "null", "none"}


class Columns(NamedTuple):
    """Angles of input and output, and other contents of their file.

    angles : of input and output, NaN where a field is empty or marked as missing, each
        of shape (n,) [rad].
    time : of each row, shape (n,) [s]; None if it was not asked for.
    line : line of each row in the file, int, shape (n,).
    units : of both columns, from the caller or the headings; None where neither gives one,
        so that degrees were assumed.
    comments : lines that begin with #.
    """

    angles: tuple[NDArray[np.float64], NDArray[np.float64]]
    time: NDArray[np.float64] | None
    line: NDArray[np.int64]
    units: tuple[str | None, ...]
    comments: list[str]


# separator, whether there is a header, number of fields in a row, places of input, output and time
# (None for a missing column), units of the angles, and the scales of all three
_Layout = tuple[str, bool, int, tuple[int | None, ...], tuple[str | None, ...], tuple[float, ...]]


class _BrokenLine(Exception):
    """The rule that a line breaks, and the remedy."""


def read_columns(
    path: str | PathLike[str],
    what: str,
    names: tuple[str | None, ...] = (None, None, None),
    unit: str | None = None,
    by_order: bool = False,
    default: str = "deg",
    resolution: int | None = None,
    skip: int = 0,
) -> Columns:
    """Read two columns of angles, and one of times where it is named, from a text file.

    Parameters
    ----------
    path : path
        Text in UTF-8, with fields separated by tab, semicolon, comma or blanks; lines that begin
        with # are comments. Where commas do not separate fields, they may be decimal points. The
        first line holds names if none of its fields is a number.
    what : str
        What the file is, for messages.
    names : (str, str, str), optional
        Names of the columns of input, output and time, with or without their unit.
        Default: one of `NAMES`, in a file without a header the first and the second of two
        columns; no time. With a time, the output may be missing.
    unit : str, optional
        "deg", "rad" or "counts". Default: the last word of a column's name, else degrees.
    by_order : bool
        Whether the first of two columns with other names is the input.
    default : str
        Unit of a column for which neither `unit` nor its name gives one.
    resolution : int, optional
        Counts in a turn.
    skip : int
        How many lines to ignore at the beginning of the file.

    Raises
    ------
    MissingInput
        If there is no such file.
    InputFileError
        If the file has no such content; the message names the line.
    InvalidValue
        If there is no column with a given name, or the unit is unknown.
    """
    units = UNITS if resolution is None else UNITS | {COUNTS: 2.0 * math.pi / resolution}
    if unit is not None:
        validate.choice("angle_unit", unit, (*UNITS, COUNTS))
    if unit == COUNTS and resolution is None:
        raise InvalidValue(
            "angle_unit counts must come with a resolution, got none; give the number of counts in "
            "a turn"
        )
    lines = _Lines(path, skip)
    layout = partial(
        _find_layout, names=names, unit=unit, by_order=by_order, default=default, angles=units
    )
    try:
        # reading as plain numbers takes half the time; a pipe cannot be read a second time
        if os.path.isfile(path):
            with suppress(_BrokenLine):
                return _read(lines, layout, plain=True)
        return _read(lines, layout, plain=False)
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

    def __init__(self, path: str | PathLike[str], skip: int) -> None:
        self.path, self.skip, self.number, self.text = path, skip, 0, ""

    def __iter__(self) -> Iterator[str]:
        """Lines that are neither skipped nor blank nor comments, from the first one on."""
        self.passed_over, self.comments = [0], list[str]()
        with open(self.path, encoding="utf-8-sig") as stream:
            for self.number, self.text in enumerate(stream, 1):
                if self.number <= self.skip or self.text.isspace() or self.text[0] == "#":
                    self.passed_over.append(self.number)
                    self.comments.append(self.text)
                # `loadtxt` would take the lines after an open quote for one field
                elif '"' in self.text and self.text.count('"') % 2:
                    raise _BrokenLine("close its quotes", "correct it")
                else:
                    yield self.text


def _read(lines: _Lines, find: Callable[[str], _Layout], plain: bool) -> Columns:
    """The columns; `plain` allows only numbers. An error concerns the line that was read last."""
    rows = iter(lines)
    separator, header, width, where, units, scales = find(next(rows))
    places = sorted(place for place in where if place is not None)
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
            rule = f"have {width} fields separated by {_SEPARATORS[separator]}"
            raise _BrokenLine(rule, "give one row for each sample") from None
        rule = f"have numbers in fields {' and '.join(str(i + 1) for i in places)}"
        raise _BrokenLine(rule, "correct it, or leave the field empty") from None
    line = np.delete(np.arange(lines.number + 1), lines.passed_over)
    first, second, time = (
        np.full(line.size, np.nan) if place is None else table[str(place)] * scale
        for place, scale in zip(where, scales, strict=True)
    )
    timed = None if where[-1] is None else time
    return Columns((first, second), timed, line, units, lines.comments)


def _find_layout(
    text: str,
    names: tuple[str | None, ...],
    unit: str | None,
    by_order: bool,
    default: str,
    angles: dict[str, float],
) -> _Layout:
    """Layout of a file whose first row is `text`; see `read_columns`."""
    separator = next((mark for mark in _SEPARATORS if mark in text.strip()), " ")
    # a unit in brackets belongs to the word before it
    fields = _split(re.sub(r" +(?=[(\[])", "", text) if separator == " " else text, separator)
    if len(fields) < 2:
        remedy = "separate input and output by a comma, a semicolon or a tab"
        raise _BrokenLine("have two columns", remedy)
    header = not any(map(_NUMBER.fullmatch, fields))
    if not header and (len(fields) > 2 or any(names)):
        remedy = "begin the file with a line of names, among them input and output"
        raise _BrokenLine(f"name its {len(fields)} columns", remedy)
    places = _named_places(fields, names, by_order) if header else (0, 1, None)
    units: list[str | None] = []
    scales = []
    for role, place in zip(_ROLES, places, strict=True):
        own = _name_and_unit(fields[place])[1] if header and place is not None else None
        timed = role == "time"
        chosen, usual, known = (own, "s", _TIMES) if timed else (unit or own, default, angles)
        if (chosen or usual) not in known:
            raise _wrong_unit(chosen, timed)
        scales.append(known[chosen or usual])
        if place is not None and not timed:
            units.append(chosen)
    return separator, header, len(fields), places, tuple(units), tuple(scales)


def _wrong_unit(unit: str | None, timed: bool) -> _BrokenLine:
    """The rule that the unit in a heading breaks."""
    if timed:
        return _BrokenLine("have times in s, ms or us", "convert them")
    if unit == COUNTS:
        remedy = "give --resolution N, in Python resolution=N"
        return _BrokenLine("come with the number of counts in a turn", remedy)
    remedy = "convert them, or give the unit that they are in"
    return _BrokenLine("have angles in degrees or radians", remedy)


def _named_places(
    fields: list[str], names: tuple[str | None, ...], by_order: bool
) -> tuple[int | None, ...]:
    """Places of input, output and time, by the names given or usual ones."""
    places: list[int | None] = []
    *angles, time = names
    for (role, usual), name in zip(NAMES.items(), angles, strict=True):
        found = _place(fields, role, name, usual)
        # if one of two columns is known, the other one has the other role
        may_lack = (by_order and len(fields) == 2) or (role == "output" and time is not None)
        if found is None and not may_lack:
            raise _unnamed(role, usual)
        places.append(found)
    first, second = places
    if by_order:
        first = (0 if second is None else 1 - second) if first is None else first
        second = 1 - first if second is None else second
    if first == second:
        raise InvalidValue(
            f"input and output must be different columns, got {fields[first or 0]!r} for both; "
            "name another column for one of them"
        )
    return first, second, None if time is None else _place(fields, "time", time, (time,))


def _place(fields: list[str], role: str, name: str | None, usual: tuple[str, ...]) -> int | None:
    """Place of the column called `name`, or else of the only one with a usual name, or None."""
    wanted = usual if name is None else (_name_and_unit(name)[0],)
    found = [i for i, field in enumerate(fields) if field == name]
    found = found or [i for i, text in enumerate(fields) if _name_and_unit(text)[0] in wanted]
    if len(found) != 1 and name is not None:
        rule, remedy = f"one of {', '.join(fields)}", validate.nearest(name, tuple(fields))
        raise validate.fail(f"{role} column (--{role}-column)", rule, name, remedy)
    if len(found) > 1:
        raise _unnamed(role, usual)
    return found[0] if found else None


def _unnamed(role: str, usual: tuple[str, ...]) -> _BrokenLine:
    """The rule that headings break if they do not identify the column of a role."""
    rule = f"have one column called {' or '.join(usual)}"
    return _BrokenLine(rule, f"name the {role}'s column with --{role}-column NAME")


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
