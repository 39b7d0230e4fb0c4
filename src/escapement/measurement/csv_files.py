"""Readings and errors as CSV files: reading block by block, writing in degrees.

Every fault of a file that is read is told with its line. A file that is written is complete
under its name, or not there.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from escapement.errors import EscapementError, InputFileError, InvalidValue, MissingInput
from escapement.files import write_file
from escapement.measurement.csv_layout import (
    Layout,
    LineBlock,
    SourceFile,
    find_layout,
    line_blocks,
)
from escapement.measurement.fit import blocks
from escapement.measurement.readings import FARTHEST, WITHIN, Readings
from escapement.model import FloatArray

if TYPE_CHECKING:
    from escapement.measurement.comparison import Measurement

SYNTHETIC = "# synthetic"
"""How a comment begins that tells computed readings from measured ones."""
_NO_UNIT = "angles without a unit are taken for degrees"
_MISSING = {"", "nan", "na", "n/a", "null", "none"}
_LABEL = f"{SYNTHETIC} data: computed by escapement, not measured\n"
_DECIMALS = 6
"""Of a degree: ten times finer than an encoder of 26 bits."""


def read_readings(
    path: str | PathLike[str],
    *,
    input: str | None = None,
    output: str | None = None,
    angle_unit: str | None = None,
) -> Readings:
    """Read the angles of two encoders from a CSV file.

    Parameters
    ----------
    path : path
        Text in UTF-8, columns apart by comma, semicolon, tab or blanks; lines that
        begin with # are comments. Where commas do not part columns they may stand
        for decimal points. An empty field, NaN or NA is a missing reading.
    input, output : str, optional
        Names of the columns in the header, with or without their unit. Default:
        those called input or driver and output or follower, or without a header
        the first and the second of two columns.
    angle_unit : str, optional
        "deg" or "rad". Default: the unit in a column's name, as in input_rad or
        "input (rad)", else degrees.

    Returns
    -------
    Readings
        Marked as synthetic where a comment begins with "# synthetic".

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it cannot be read as such; the message has the line.
    InvalidValue
        When there is no column of the name given, or the unit is unknown.
    """
    file = Path(path)
    try:
        with open(file, "rb") as stream:
            table = _AnglesTable(SourceFile(file), input, output, angle_unit)
            for block in line_blocks(table.source, stream):
                table.take(block)
    except (FileNotFoundError, NotADirectoryError):
        raise MissingInput(f"measurement {file} does not exist; check its name") from None
    except (OSError, ValueError) as error:
        if isinstance(error, EscapementError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise InputFileError(
            f"measurement {file} must be a readable file, got: {reason}; name a CSV file"
        ) from None
    return table.readings()


@dataclass
class _AnglesTable:
    """Columns of angles that grow block after block."""

    source: SourceFile
    input: str | None
    output: str | None
    angle_unit: str | None
    layout: Layout | None = None
    synthetic: bool = False
    columns: list[FloatArray] = field(default_factory=list)
    lines: list[np.ndarray] = field(default_factory=list)

    def take(self, block: LineBlock) -> None:
        """Add the samples of a block, the fast way where it is a plain table."""
        if self.layout is None:
            block = self._after_header(block)
        if self.layout is None or not block.lines:
            return
        lines = block.lines if block.lines[-1] else block.lines[:-1]
        quick = self.layout.load(lines) if lines else None
        if quick is not None:
            self.columns.append(quick)
            self.lines.append(np.arange(block.first, block.first + len(quick)))
        else:
            self._take_line_by_line(self.layout, block)

    def readings(self) -> Readings:
        """All that was read, in rad."""
        path = self.source.path
        if self.layout is None:
            raise InputFileError(
                f"measurement {path} must hold rows of angles, got none; "
                "give a column of the input and one of the output"
            )
        table = np.concatenate(self.columns) if self.columns else np.empty((0, 2))
        self.columns.clear()
        line = np.concatenate(self.lines) if self.lines else np.empty(0, dtype=int)
        self._refuse_far(self.layout, table, line)
        first, second = (
            np.multiply(table[:, i], scale) for i, scale in enumerate(self.layout.scales)
        )
        assumed = self.layout.assumed
        del table
        try:
            return Readings(first, second, line, self.synthetic, _NO_UNIT if assumed else "")
        except InvalidValue as error:
            raise InputFileError(f"{path}: {error}") from None

    def _refuse_far(self, layout: Layout, table: FloatArray, line: np.ndarray) -> None:
        """Name the first row with an angle that a double holds too coarsely."""
        beyond = [np.abs(table[:, i]) > FARTHEST / scale for i, scale in enumerate(layout.scales)]
        rows = np.flatnonzero(beyond[0] | beyond[1])
        if rows.size:
            row = int(rows[0])
            column = 0 if beyond[0][row] else 1
            rule = f"have an angle {WITHIN}, in field {layout.places[column] + 1}"
            remedy = "correct it, or leave the field empty"
            raise self.source.fault(int(line[row]), rule, f"{table[row, column]:g}", remedy)

    def _after_header(self, block: LineBlock) -> LineBlock:
        """The rest of a block after its header, which gives the layout."""
        for i, text in enumerate(block.lines):
            if self._is_comment(text):
                continue
            try:
                found = find_layout(text, self.input, self.output, self.angle_unit)
            except InputFileError as error:
                where = f"{self.source.path}, line {block.first + i}"
                raise InputFileError(f"{where}: {error}") from None
            except InvalidValue as error:
                raise InvalidValue(f"{self.source.path}: {error}") from None
            self.layout = found
            start = i + 1 if found.header else i
            return LineBlock(block.first + start, block.lines[start:])
        return LineBlock(block.first + len(block.lines), [])

    def _is_comment(self, text: str) -> bool:
        if text.startswith(SYNTHETIC):
            self.synthetic = True
        return not text.strip() or text.startswith("#")

    def _take_line_by_line(self, layout: Layout, block: LineBlock) -> None:
        rows, lines = [], []
        for line, text in enumerate(block.lines, block.first):
            if self._is_comment(text):
                continue
            fields = layout.split(text)
            if len(fields) != layout.width:
                rule = f"have {layout.width} fields apart by {layout.named_separator}"
                raise self.source.fault(line, rule, text, "one row for each sample")
            rows.append([self._number(layout, line, i, fields[i]) for i in layout.places])
            lines.append(line)
        self.columns.append(np.array(rows).reshape(-1, 2))
        self.lines.append(np.array(lines, dtype=int))

    def _number(self, layout: Layout, line: int, place: int, text: str) -> float:
        text = text.strip()
        if text.lower() in _MISSING:
            return np.nan
        try:
            value = float(text.replace(",", ".") if layout.decimal_comma else text)
        except ValueError:
            value = np.inf
        if np.isinf(value) or "_" in text:
            rule = f"have a finite number in field {place + 1}"
            raise self.source.fault(line, rule, text, "correct it, or leave the field empty")
        return value


def write_readings(
    readings: Readings, path: str | PathLike[str], *, note: str = "", force: bool = False
) -> None:
    """Write readings as `read_readings` reads them.

    Parameters
    ----------
    readings : Readings
        What to write; synthetic ones say so in the first line.
    path : path
        Where.
    note : str
        A comment for the head of the file.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    CannotCreate, StorageError
        When it cannot be created, or writing fails half-way.
    """
    columns = {"input_deg": readings.input, "output_deg": readings.output}
    _write(path, _head(readings, note), columns, force)


def write_errors(result: "Measurement", path: str | PathLike[str], *, force: bool = False) -> None:
    """Write input, output, theory and error of each complete sample.

    Parameters
    ----------
    result : Measurement
        What `escapement.measure` returns.
    path, force :
        As for `write_readings`.
    """
    columns = {
        "input_deg": result.input,
        "output_deg": result.output,
        "theory_deg": result.fit.theory,
        "error_deg": result.errors,
    }
    _write(path, _head(result.readings, ""), columns, force)


def _head(readings: Readings, note: str) -> str:
    comments = "".join(f"# {line}\n" for line in note.splitlines())
    return (_LABEL if readings.synthetic else "") + comments


def _write(
    path: str | PathLike[str], head: str, columns: dict[str, FloatArray], force: bool
) -> None:
    text = chain([head + ",".join(columns) + "\n"], _rows(list(columns.values())))
    write_file(path, map(str.encode, text), force)


def _rows(columns: Sequence[FloatArray]) -> Iterator[str]:
    """Lines, a block of samples at a time; an empty field for what is missing."""
    row = ",".join([f"%.{_DECIMALS}f"] * len(columns)) + "\n"
    for part in blocks(columns[0].size):
        table = np.degrees([column[part] for column in columns]).T + 0.0
        yield (row * len(table) % tuple(table.ravel())).replace("nan", "")
