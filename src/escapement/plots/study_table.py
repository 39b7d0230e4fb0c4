"""Data of a study for a figure: results over one or two parameters, as printed."""

import textwrap
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.base.units import spelt
from escapement.mechanisms.protocol import FloatArray
from escapement.plots.style import number_text, scaled
from escapement.study.result import Study
from escapement.study.subject import ESCAPEMENT

_SHORT = {
    "friction": "coefficient of friction",
    "blow_max": "energy of an impact",
    "velocity_max": "maximum driver velocity",
    "velocity_mean": "mean driver velocity",
    "rise_time_63": "rise time, 63 %",
    "rise_time_98": "rise time, 98 %",
    "velocity_min": "minimum driver velocity",
}
_REASONS = {
    Status.NO_TERMINAL: "no terminal velocity",
    Status.STALL: "stalled",
    Status.PAINLEVE: "beyond the Painlevé limit",
    Status.NOT_CONVERGED: "not converged",
    Status.INVALID: "invalid",
}
_WIDEST = 56  # characters of a note that fit above one column
_HARD = "\N{NO-BREAK SPACE}"
_LONGEST = 28  # a longer name is not used as an axis label
STEPPED = "rise_time", "settling_time"
"""Times of an extremum of the speed, which jump where another extremum takes its place."""
_DECADE = 8.0  # an axis that spans this factor in equal ratios is logarithmic


class Parameter(NamedTuple):
    """A parameter along an axis: its name and unit as printed, and its values."""

    name: str
    unit: str
    values: NDArray[Any]

    @property
    def whole(self) -> bool:
        """Whether it takes whole numbers only, with nothing between them."""
        return bool(np.issubdtype(self.values.dtype, np.integer))

    @property
    def logarithmic(self) -> bool:
        """Whether it takes numbers in equal ratios over a wide range."""
        values = np.sort(self.values)
        if values.size < 3 or values[0] <= 0.0 or values[-1] < _DECADE * values[0]:
            return False
        steps = np.diff(np.log(values))
        return bool(np.allclose(steps, steps[0], rtol=1e-6))


class StudyTable(NamedTuple):
    """Results over at most two parameters, ready to draw.

    results : names of the results along the first dimension of `values`.
    x, lines : parameters along the second and third, ascending; `lines` has one value where
        only one parameter varies.
    values : the results in one unit, not finite where there is none.
    name, unit : of the first result, as printed.
    note : the fixed axes with their values, and the cases that failed; "" if there are none.
    """

    results: Sequence[str]
    x: Parameter
    lines: Parameter
    values: FloatArray
    name: str
    unit: str
    note: str

    @property
    def first(self) -> str:
        """Name of the first result."""
        return self.results[0]

    @property
    def first_values(self) -> FloatArray:
        """Values of the first result, over both parameters."""
        return np.asarray(self.values[0])


def tabulate(study: Study, results: Sequence[str], x: str | None = None) -> StudyTable:
    """Choose the axes of a figure, and fix every other one at its middle.

    Parameters
    ----------
    study : Study
        A sweep's result.
    results : sequence of str
        Which results; the first one decides their unit.
    x : str, optional
        First axis. Default: of the first two that were varied, torque, otherwise the one with
        most points.

    Raises
    ------
    InvalidValue
        For an unknown result, or a study that varies nothing.
    """
    chosen(study, results)
    if study.sampled:
        raise refusal("be a grid to be drawn as lines or a map", "a sample", "use plot_study")
    varied = [name for name, values in study.axes.items() if values.size > 1]
    if not varied:
        raise single_case()
    if x is None:
        pair = varied[:2]
        x = "torque" if "torque" in pair else max(pair, key=lambda name: study.axes[name].size)
    validate.choice("x", x, tuple(varied))
    lines = next((name for name in varied if name != x), None)
    # the axes of a study may descend or be in any order
    kept = {
        name: values.argsort() if name in (x, lines) else np.array([values.size // 2])
        for name, values in study.axes.items()
    }

    def arranged(name: str) -> FloatArray:
        # the quantiles of a sample stand in front of its axes
        found = study.results[name].reshape(-1, *study.shape)
        found = found[np.ix_(np.arange(len(found)), *kept.values())]
        found = np.moveaxis(found, 1 + [*kept].index(x), 1)
        return found.reshape(len(found), kept[x].size, -1)

    values, first = np.concatenate([arranged(name) for name in results]), results[0]
    factor, unit = scaled(study.units.get(first, ""), values)
    shown = {name: parameter(study, name, study.axes[name][index]) for name, index in kept.items()}
    at = (_fixed(shown[name], study.axes[name].size) for name in kept if name not in (x, lines))
    fixed = ", ".join(at)
    status = study.results.get("status", np.zeros(study.shape))
    notes = [fixed[:1].upper() + fixed[1:], _unanswered(status[np.ix_(*kept.values())])]
    note = "\n".join(textwrap.fill(line, _WIDEST) for line in notes if line).replace(_HARD, " ")
    return StudyTable(
        results=results,
        x=shown[x],
        lines=Parameter("", "", np.zeros(1)) if lines is None else shown[lines],
        values=factor * values,
        name=printed_name(study, first),
        unit=unit,
        note=note,
    )


def chosen(study: Study, names: Sequence[str] | None, usual: Sequence[str] = ()) -> list[str]:
    """Results to draw: those named; else the usual ones, but all of a study that chose its own.

    Raises
    ------
    InvalidValue
        When a name is none of the study's results.
    """
    has = tuple(name for name in study.results if name != "status")
    if names is None:
        return [*(usual if {*has} == {*ESCAPEMENT.usual} else has)]
    if isinstance(names, str):
        raise validate.fail("results", "a list of names", names, f"give [{names!r}]")
    return [validate.choice("result", name, has) for name in names]


def available(study: Study, names: Iterable[str]) -> list[StudyTable]:
    """A table of each of the named results that a figure can show.

    Raises
    ------
    InvalidValue
        When there is none.
    """
    tables = [tabulate(study, [name]) for name in names if name in study.results]
    check_number(names, [table.first_values for table in tables])
    return [table for table in tables if np.isfinite(table.first_values).any()]


def check_number(names: Iterable[str], values: ArrayLike) -> None:
    """Raise InvalidValue where no case that would be drawn has any of the named results."""
    if not np.isfinite(values).any():
        rule, remedy = f"hold a number for {' or '.join(names)}", "its status says why"
        raise refusal(f"{rule} to be plotted", "none in the cases shown", remedy)


def single_case() -> InvalidValue:
    """The error for a study that varies nothing."""
    rule, remedy = "vary at least one parameter to be plotted", "give it two values or more"
    return refusal(rule, "a single case", remedy)


def refusal(rule: str, got: str, remedy: str) -> InvalidValue:
    """The error for a study that a figure cannot show."""
    return InvalidValue(f"study must {rule}, got {got}; {remedy}")


def printed_name(study: Study, name: str) -> str:
    """Name of an axis or result, short enough for a label."""
    words = name.replace("_", " ")
    long = study.long_names.get(name) or words
    return _SHORT.get(name) or (long if len(long) <= _LONGEST else words)


def parameter(study: Study, name: str, values: NDArray[Any]) -> Parameter:
    """A parameter of a study at some of its values."""
    return Parameter(printed_name(study, name), spelt(study.units.get(name, "")), values)


def _unanswered(status: NDArray[Any]) -> str:
    """How many of the shown cases have no number, and why; "" if there are none."""
    counts = {why: int((status == code).sum()) for code, why in _REASONS.items()}
    lost = sum(counts.values())
    reasons = [f"{count} {why}".replace(" ", _HARD) for why, count in counts.items() if count]
    gaps = "leaves a gap" if lost == 1 else "leave gaps"
    return f"{lost} of {status.size} cases {gaps}: {', '.join(reasons)}" if lost else ""


def _fixed(along: Parameter, size: int) -> str:
    """A parameter that is not drawn, fixed at its only value or at the middle one."""
    text = f"{along.name} = {number_text(along.values[0])} {along.unit}".rstrip()
    return text if size == 1 else f"{text} (middle of {size})"
