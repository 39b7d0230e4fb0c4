"""Text files with the times of beats, or with their intervals."""

from functools import partial

import numpy as np

from escapement.base import validate
from escapement.base.columns import wrong_unit
from escapement.base.errors import InputFileError
from escapement.base.files import AnyPath
from escapement.base.headings import TIMES, name_and_unit
from escapement.base.lines import BrokenLine
from escapement.base.text_table import Content, Layout, read_table
from escapement.mechanisms.protocol import FloatArray

_INTERVALS = ("interval", "intervals", "beat", "beats", "duration", "durations", "period")
_INSTANTS = ("time", "times", "t", "timestamp", "onset", "onsets")
_CONTENT = Content("file of beats", "times", "a column of times, or of intervals", single=True)


def read_times(path: AnyPath, time_unit: str | None = None) -> FloatArray:
    """Instants of beats [s], in turn.

    Parameters
    ----------
    path : path
        Text as `read_table` reads it, with a column of instants, or of intervals. It is the one
        named time or interval, else the only one. Numbers that increase throughout are instants,
        unless the heading says otherwise.
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
    table = read_table(path, _CONTENT, partial(_find_layout, time_unit=time_unit))
    intervals, instants = table.columns
    if instants is not None:
        found = instants[np.isfinite(instants)]
        back = np.flatnonzero(np.diff(found) <= 0.0)
        if not back.size:
            return np.asarray(found)
        if intervals is None:
            raise InputFileError(
                f"file of beats {path} must have times that increase, got "
                f"{found[back[0] + 1]:g} s after {found[back[0]]:g} s; sort them, or name the "
                "column interval"
            )
    steps = np.asarray(intervals)
    wrong = np.flatnonzero(~(steps > 0.0))
    if wrong.size:
        raise InputFileError(
            f"{path}, line {table.line[wrong[0]]} must have an interval greater than 0, got "
            f"{steps[wrong[0]]:g} s; give times of the beats instead"
        )
    return np.concatenate([[0.0], np.cumsum(steps)])


def _find_layout(
    fields: list[str], names: list[str], header: bool, time_unit: str | None
) -> Layout:
    """The column of intervals and that of instants, which are one if no heading tells which."""
    named = [name_and_unit(name) for name in names] if header else [("", None)]
    usual = [i for i, (name, _) in enumerate(named) if name in (*_INSTANTS, *_INTERVALS, "")]
    if not usual and len(fields) > 1:
        raise BrokenLine("have one column called time or interval", "rename the column of times")
    index = usual[0] if usual else 0
    name, stated = named[index]
    unit = time_unit or stated or "s"
    if unit not in TIMES:
        raise wrong_unit(unit, timed=True)
    indices = (None if name in _INSTANTS else index, None if name in _INTERVALS else index)
    return Layout(indices, (unit, unit), (TIMES[unit], TIMES[unit]))
