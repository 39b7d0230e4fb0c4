"""Columns of a CSV file: what parts them, which are the angles, in which unit."""

import csv
from itertools import repeat
from typing import NamedTuple

import numpy as np

from escapement import validate
from escapement.errors import InputFileError, InvalidValue
from escapement.model import FloatArray
from escapement.text import NAMES, UNITS, name_and_unit

_SEPARATORS = {"\t": "a tab", ";": "';'", ",": "','", " ": "blanks"}


class Layout(NamedTuple):
    """How the lines of a file are to be read.

    separator : what parts the fields; a blank for any number of them.
    decimal_comma : whether commas are decimal points.
    width : fields in a line.
    places : of input and output among them.
    scales : unit of input and output in rad.
    header : whether the first line holds names.
    assumed : whether degrees were assumed, for want of a unit.
    """

    separator: str
    decimal_comma: bool
    width: int
    places: tuple[int, int]
    scales: tuple[float, float]
    header: bool
    assumed: bool

    @property
    def named_separator(self) -> str:
        """The separator in words."""
        return _SEPARATORS[self.separator]

    def split(self, text: str) -> list[str]:
        """Fields of a line."""
        return _split(text, self.separator)

    def load(self, lines: list[str]) -> FloatArray | None:
        """Input and output of lines that are all plain numbers, else None."""
        blank = self.separator == " "
        # of rows too long or short `loadtxt` takes the columns it is to use
        if not blank and set(map(str.count, lines, repeat(self.separator))) != {self.width - 1}:
            return None
        if self.decimal_comma:
            lines = [line.replace(",", ".") for line in lines]
        try:
            table = np.loadtxt(
                lines, delimiter=None if blank else self.separator, comments=None, ndmin=2,
                usecols=None if blank else self.places,
            )  # fmt: skip
        except ValueError:
            return None
        if blank:
            if table.shape[1] != self.width:
                return None
            table = table[:, self.places]
        # a blank line or an infinite number: to be looked at line by line
        return table if len(table) == len(lines) and not np.isinf(table).any() else None


def find_layout(text: str, input: str | None, output: str | None, angle_unit: str | None) -> Layout:
    """Layout of a file from its first line, see `read_readings`."""
    if angle_unit is not None:
        validate.choice("angle_unit", angle_unit, tuple(UNITS))
    separator = _separator(text)
    fields = _split(text, separator)
    decimal_comma = separator != ","
    if len(fields) < 2:
        raise InputFileError(
            f"must have two columns, got {_short(text)}; "
            "separate input and output by a comma, a semicolon or a tab"
        )
    header = not any(_is_number(field, decimal_comma) for field in fields)
    if header:
        places = tuple(
            _find(fields, role, name) for role, name in (("input", input), ("output", output))
        )
    elif input is not None or output is not None:
        raise InvalidValue(
            f"input and output must not be named for a file without a header, got "
            f"{input or output!r}; leave them out"
        )
    elif len(fields) != 2:
        raise InputFileError(
            f"must name its {len(fields)} columns, got {_short(text)}; "
            "put a line with input and output among the names first"
        )
    else:
        places = 0, 1
    if places[0] == places[1]:
        raise InvalidValue(
            f"input and output must be different columns, got {fields[places[0]]!r} for both"
        )
    units = [angle_unit or (name_and_unit(fields[i])[1] if header else None) for i in places]
    for place, unit in zip(places, units, strict=True):
        if unit not in (*UNITS, None):
            raise InputFileError(
                f"must have angles in degrees or radians, got {_short(fields[place].strip())}; "
                "convert them, or give the unit that they are in"
            )
    scales = tuple(UNITS[unit or "deg"] for unit in units)
    assumed = None in units
    return Layout(separator, decimal_comma, len(fields), places, scales, header, assumed)  # type: ignore[arg-type]


def _separator(text: str) -> str:
    return next((mark for mark in _SEPARATORS if mark in text.strip()), " ")


def _split(text: str, separator: str) -> list[str]:
    if separator == " ":
        return text.split()
    if '"' in text:
        return next(csv.reader([text], delimiter=separator))
    return text.split(separator)


def _is_number(field: str, decimal_comma: bool) -> bool:
    try:
        float(field.replace(",", ".") if decimal_comma else field)
    except ValueError:
        return False
    return True


def _find(fields: list[str], role: str, name: str | None) -> int:
    """Place of the column of a role, by the name given or a usual one."""
    bare = [name_and_unit(field)[0] for field in fields]
    wanted = NAMES[role] if name is None else (name_and_unit(name)[0],)
    whole = [field.strip() for field in fields]
    found = [i for i, field in enumerate(bare) if field and field in wanted]
    if name is not None and name.strip() in whole:
        found = [i for i, field in enumerate(whole) if field == name.strip()]
    if len(found) == 1:
        return found[0]
    listed = ", ".join(whole)
    if name is None:
        reason = "several" if found else "none"
        raise InputFileError(
            f"must have one column called {' or '.join(wanted)}, got {reason} among "
            f"{_short(listed)}; name the {role}'s column"
        )
    raise validate.fail(
        f"{role} column", f"one of {_short(listed)}", name, validate.nearest(name, tuple(whole))
    )


def _short(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:57] + "...")
