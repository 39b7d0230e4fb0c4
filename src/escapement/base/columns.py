"""The reader of text files with columns of input angles, output angles and times."""

import math
from functools import partial
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.headings import COUNTS, NAMES, TIME_NAMES, TIMES, UNITS, name_and_unit
from escapement.base.lines import BrokenLine
from escapement.base.text_table import Content, Layout, read_table


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
        Text as `read_table` reads it.
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
    known = [UNITS | ({} if n is None else {COUNTS: 2.0 * math.pi / n}) for n in pair]
    if unit is not None:
        validate.choice("angle_unit", unit, (*UNITS, COUNTS))
    if time_unit is not None:
        validate.choice("time_unit", time_unit, tuple(TIMES))
    if unit == COUNTS and resolution is None:
        raise InvalidValue(
            "angle_unit counts must come with a resolution, got none; give the number of counts in "
            "a turn"
        )
    content = Content(what, "angles", "a column of the input and one of the output")
    units = zip((*known, TIMES), (unit, unit, time_unit), (default, default, "s"), strict=True)
    find = partial(_find_layout, wanted=names, by_order=by_order, known=[*units])
    table = read_table(path, content, find, skip)
    *both, time = table.columns
    empty = np.full(table.line.size, np.nan)
    first, second = (empty if one is None else one for one in both)
    *told, time_unit = table.layout.units
    kept = tuple(one for one, column in zip(told, both, strict=True) if column is not None)
    return Columns((first, second), time, table.line, kept, time_unit, table.comments)


class _NoSpeed(Exception):
    """A file has no column of speeds."""


def read_speeds(path: str | PathLike[str], what: str) -> tuple[Any, Any, Any] | None:
    """Angles [rad], None without a column of them, speeds [rad/s] and torques of a file.

    None where no column is called speed. Errors are those of `read_columns`.
    """
    content = Content(what, "speeds", "a column of speeds and one of torques")
    try:
        return read_table(path, content, _speed_layout).columns  # type: ignore[return-value]
    except _NoSpeed:
        return None


def _speed_layout(fields: list[str], names: list[str], header: bool) -> Layout:
    """Layout of a file with a column called speed."""
    speeds = [i for i, name in enumerate(names) if name.lower().startswith("speed")]
    if not (header and speeds):
        raise _NoSpeed
    if len(fields) > 3 or speeds != [len(fields) - 2]:
        rule = "name the columns angle, speed and torque, or speed and torque"
        raise BrokenLine(rule, "put them in this order")
    unit = name_and_unit(names[0])[1] if len(fields) > 2 else None
    if (unit or "rad") not in UNITS:
        raise wrong_unit(unit, False)
    rpm = names[speeds[0]].lower().rstrip(")] ").endswith("rpm")
    scales = UNITS[unit or "rad"], 2.0 * math.pi / 60.0 if rpm else 1.0, 1.0
    indices = (None, 0, 1) if len(fields) < 3 else (0, 1, 2)
    return Layout(indices, (unit, "rpm" if rpm else "rad/s", None), scales)


def _find_layout(
    fields: list[str], names: list[str], header: bool, wanted: tuple[str | None, ...],
    by_order: bool, known: list[tuple[dict[str, float], str | None, str]],
) -> Layout:  # fmt: skip
    """Layout of a file with these fields in its first row; `names` have their units too.

    known : sizes of the units of input, output and time, that which the caller gives, and that of
        a column without any.
    """
    if not header and (len(fields) > 2 or any(wanted)):
        remedy = "begin the file with a line of names, among them input and output"
        raise BrokenLine(f"name its {len(fields)} columns", remedy)
    indices = _named_indices(fields, wanted, by_order) if header else (0, 1, None)
    units: list[str | None] = []
    scales = []
    for index, (sizes, given, usual) in zip(indices, known, strict=True):
        word, stated = name_and_unit(names[index]) if header and index is not None else ("", None)
        timed = sizes is TIMES
        if not (timed or word) and stated in TIMES:
            stated = None  # a heading may just be "second"
        chosen = given or stated
        if (chosen or usual) not in sizes:
            raise wrong_unit(chosen, timed)
        scales.append(sizes[chosen or usual])
        units.append(chosen)
    return Layout(indices, tuple(units), tuple(scales))


def wrong_unit(unit: str | None, timed: bool) -> BrokenLine:
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
