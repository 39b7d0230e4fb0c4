"""Lines of a CSV file, and which of its columns are the angles, in which unit."""

import csv
from collections.abc import Iterator
from itertools import repeat
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np

from escapement import validate
from escapement.errors import InputFileError, InvalidValue
from escapement.model import FloatArray
from escapement.text import NAMES, UNITS, name_and_unit

_BLOCK_BYTES = 1 << 22
_SEPARATORS = {"\t": "a tab", ";": "';'", ",": "','", " ": "blanks"}


class SourceFile(NamedTuple):
    """The file that is read, and the errors that name its lines."""

    path: Path

    def fault(self, line: int, rule: str, got: str, remedy: str) -> InputFileError:
        """The error that names a line; a long text is cut."""
        shown = got if len(got) <= 60 else got[:57] + "..."
        return InputFileError(f"{self.path}, line {line} must {rule}, got {shown!r}; {remedy}")


class LineBlock(NamedTuple):
    """Whole lines of a file, and the number of the first."""

    first: int
    lines: list[str]


def line_blocks(source: SourceFile, stream: BinaryIO) -> Iterator[LineBlock]:
    """A file as blocks of whole lines."""
    line, rest = 1, b""
    while True:
        new = stream.read(_BLOCK_BYTES)
        whole, end, rest = _cut(rest + new) if new else (rest, b"", b"")
        if line == 1:
            whole = whole.removeprefix(b"\xef\xbb\xbf")
        if whole or end:
            lines = _text(source, line, whole)
            yield LineBlock(line, lines)
            line += len(lines)
        if not new:
            return
        if len(rest) > _BLOCK_BYTES:
            remedy = "separate the samples by line ends"
            raise source.fault(line, "be a row of angles", f"{len(rest)} bytes and more", remedy)


def _cut(data: bytes) -> tuple[bytes, bytes, bytes]:
    """Split data into what is before the last line end, that end, and what follows."""
    if b"\n" in data:
        return data.rpartition(b"\n")
    # the last byte may be the first half of a line end
    whole, end, rest = data[:-1].rpartition(b"\r")
    return whole, end, rest + data[-1:]


def _text(source: SourceFile, first: int, data: bytes) -> list[str]:
    """Decode lines with any line ends; the error names the first line that is no text."""
    remedy = "save it as CSV in UTF-8"
    data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    try:
        text = data.decode("utf-8")
        fault = text.find("\0")
        place = len(text[:fault].encode()) if fault >= 0 else -1
    except UnicodeDecodeError as error:
        place = error.start
    if place >= 0:
        line = data.count(b"\n", 0, place)
        shown = data.split(b"\n")[line][:20].decode("ascii", "backslashreplace")
        raise source.fault(first + line, "be text in UTF-8", shown, remedy)
    return text.split("\n")


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
        # `loadtxt` reads only the columns it is to use, and so accepts rows that are too long
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
        # lines with a blank one or an infinite number are read one by one
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
    """Place of the input's or the output's column, by the name given or a usual one."""
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
