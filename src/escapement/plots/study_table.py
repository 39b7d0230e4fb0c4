"""What of a study goes into a figure: one result over one or two axes."""

import contextlib
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.errors import InvalidValue
from escapement.model import FloatArray
from escapement.plots.style import LINE, label, parameter_text, print_unit, scaled
from escapement.status import Status
from escapement.study.result import Study

_SHORT = {
    "friction": "coefficient of friction",
    "velocity_max": "maximum driver velocity",
    "velocity_mean": "mean driver velocity",
    "velocity_min": "minimum driver velocity",
}
_REASONS = {
    Status.NO_TERMINAL: "no terminal velocity",
    Status.STALL: "stalled",
    Status.PAINLEVE: "beyond the Painlevé limit",
    Status.NOT_CONVERGED: "not converged",
    Status.INVALID: "invalid",
}
_WIDEST = 56  # so many characters of a note fit over one column
_HARD = "\N{NO-BREAK SPACE}"
_LONGEST = 28  # a longer name makes no axis label


@dataclass(frozen=True)
class StudyTable:
    """One result over at most two axes, ready to draw.

    x, lines : names of the axes along the first and second dimension of
        `values`; without a second axis `lines` is None, and that dimension 1.
    x_values, line_values : values along them, ascending.
    values : the result, NaN where there is none.
    note : which axes were fixed, and where, and which cases have no answer; "" for none.
    """

    x: str
    lines: str | None
    x_values: FloatArray
    line_values: FloatArray
    values: FloatArray
    note: str


def tabulate_study(study: Study, result: str, x: str | None = None) -> StudyTable:
    """Choose the axes of a figure, and fix every other one at its middle.

    Parameters
    ----------
    study : Study
        A sweep's result.
    result : str
        Which result.
    x : str, optional
        First axis. Default: of the first two that were varied, torque, else
        the one with most points.

    Raises
    ------
    InvalidValue
        For an unknown or empty result, or a study that varies nothing.
    """
    known = tuple(name for name in study.results if name != "status")
    validate.choice("result", result, known)
    if study.sampled:
        raise InvalidValue(
            "study must be a grid to be drawn as lines or a map, got a sample; use plot_study"
        )
    varied = [name for name, values in study.axes.items() if np.size(values) > 1]
    if not varied:
        raise single_case()
    if x is None:
        pair = varied[:2]
        x = "torque" if "torque" in pair else max(pair, key=lambda name: len(study.axes[name]))
    validate.choice("x", x, tuple(varied))
    lines = next((name for name in varied if name != x), None)
    middle = {
        name: np.size(values) // 2 for name, values in study.axes.items() if name not in (x, lines)
    }
    index = tuple(middle.get(name, slice(None)) for name in study.axes)
    values = np.asarray(study.results[result], dtype=float)[index]
    values = np.where(np.isfinite(values), values, np.nan)
    if np.isnan(values).all():
        raise _empty([result])
    names = list(study.axes)
    if lines is None:
        values = values[:, None]
    elif names.index(lines) < names.index(x):
        values = values.T
    x_values = np.asarray(study.axes[x], dtype=float)
    line_values = np.zeros(1) if lines is None else np.asarray(study.axes[lines], dtype=float)
    # the axes of a study may descend or be in any order
    rows, columns = np.argsort(x_values), np.argsort(line_values)
    fixed = [_fixed(study, name, i) for name, i in middle.items()]
    where = ", ".join(fixed)
    notes = [where[:1].upper() + where[1:], _unanswered(study, index)]
    return StudyTable(
        x,
        lines,
        x_values[rows],
        line_values[columns],
        values[np.ix_(rows, columns)],
        "\n".join(textwrap.fill(line, _WIDEST) for line in notes if line).replace(_HARD, " "),
    )


def available(study: Study, names: Sequence[str]) -> list[str]:
    """Those of the named results that a figure can show.

    Raises
    ------
    InvalidValue
        When there is none.
    """
    found = drawable(study, names)
    if not found:
        raise _empty(names)
    return found


def drawable(study: Study, names: Sequence[str]) -> list[str]:
    """As `available`, but an empty list where there is none."""
    found = []
    for name in filter(study.results.__contains__, names):
        with contextlib.suppress(NoResult):
            tabulate_study(study, name)
            found.append(name)
    return found


class NoResult(InvalidValue):
    """Every case that would be drawn lacks the result."""


def printed_name(study: Study, name: str) -> str:
    """Name of an axis or result, short enough for a label."""
    words = name.replace("_", " ")
    long = study.long_names.get(name) or words
    return _SHORT.get(name) or (long if len(long) <= _LONGEST else words)


def parameter_label(study: Study, name: str, line: int = LINE) -> str:
    """Label of an axis that a parameter runs along, in lines of so many characters."""
    return label(printed_name(study, name), print_unit(study.units.get(name, "")), line)


def result_scale(study: Study, name: str, values: ArrayLike, line: int = LINE) -> tuple[float, str]:
    """Factor that brings a result to readable numbers, and the label that tells their unit."""
    factor, unit = scaled(study.units.get(name, ""), values)
    return factor, label(printed_name(study, name), unit, line)


def _unanswered(study: Study, index: tuple[Any, ...]) -> str:
    """How many of the cases shown have no number, and why; "" for none."""
    status = np.asarray(study.results.get("status", 0))
    shown = status[index] if status.ndim else status
    counts = {why: int((shown == code).sum()) for code, why in _REASONS.items()}
    lost = sum(counts.values())
    if not lost:
        return ""
    reasons = [f"{count} {why}".replace(" ", _HARD) for why, count in counts.items() if count]
    gaps = "leaves a gap" if lost == 1 else "leave gaps"
    return f"{lost} of {shown.size} cases {gaps}: {', '.join(reasons)}"


def _fixed(study: Study, name: str, index: int) -> str:
    values = study.axes[name]
    text = parameter_text(printed_name(study, name), values[index], study.units.get(name, ""))
    return text if np.size(values) == 1 else f"{text} (middle of {np.size(values)})"


def single_case() -> InvalidValue:
    """The error for a study that varies nothing."""
    return InvalidValue(
        "study must vary at least one parameter to be plotted, got a single case; "
        "give a parameter two values or more"
    )


def _empty(names: Sequence[str]) -> NoResult:
    return NoResult(
        f"study must hold a number for {' or '.join(names)} to be plotted, got none in the cases "
        "shown; its status says what went wrong in each"
    )
