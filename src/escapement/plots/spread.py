"""How the results of a sample scatter: quantiles, and the figure of a sample over a grid.

Some cases of a sample have an answer but no time, because it is longer than an engine
follows: quantiles count such a time as longer than any.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from escapement.model import FloatArray
from escapement.plots import style
from escapement.plots.study_panels import draw_lines, is_whole, legend, lines_drawn
from escapement.plots.study_table import NoResult, StudyData, StudyTable, available, tabulate_study
from escapement.plots.style import scaled

QUANTILES = (0.05, 0.5, 0.95)
_RESULTS = ("rise_time", "velocity_mean")


def ran(study: StudyData) -> np.ndarray:
    """Which cases have an answer, shape of the results."""
    answered: np.ndarray = np.isfinite(np.asarray(study.results["velocity_mean"], dtype=float))
    return answered


def counted(study: StudyData, result: str) -> FloatArray:
    """A result as quantiles and ranks count it, of the shape of the results.

    NaN where a case has no answer. A case that has one lacks a rise or settling time
    only where that is beyond what an engine follows: infinity. Left out, the longest
    would be missing, and every quantile too short.
    """
    values = np.asarray(study.results[result], dtype=float)
    return np.where(ran(study), np.where(np.isfinite(values), values, np.inf), np.nan)


def quantile(values: FloatArray, share: float) -> FloatArray:
    """Quantile along the last axis, NaN where it falls on infinity or nothing counts.

    Values are joined by straight lines, as `numpy.quantile` does, which makes NaN of the
    last number before infinity too.

    values : shape (..., n), NaN where a case does not count.
    """
    ordered = np.sort(values, axis=-1)  # this puts NaN last
    last = np.count_nonzero(~np.isnan(values), axis=-1, keepdims=True) - 1
    place = share * np.maximum(last, 0)
    below, above = (
        np.take_along_axis(ordered, end(place).astype(int), axis=-1) for end in (np.floor, np.ceil)
    )
    with np.errstate(invalid="ignore"):  # two infinities have no difference
        between = below + (above - below) * (place - np.floor(place))
    return np.where(np.isfinite(above), between, np.nan)[..., 0]


def missing(study: StudyData, result: str) -> str:
    """How many of the cases with an answer lack a result: "no rise time in 3 of 20 cases"."""
    lost, name = int(np.isinf(counted(study, result)).sum()), result.replace("_", " ")
    return f"no {name} in {lost} of {int(ran(study).sum())} cases" if lost else ""


def plot_spread(study: StudyData) -> Figure:
    """How far a sample scatters at each point of a grid.

    Parameters
    ----------
    study : Study
        A sweep's result over a sample at each point of a grid.

    Returns
    -------
    Figure
        Rise time and mean velocity against a swept parameter: the median over the
        sample, in a band from its 5 % to its 95 % quantile; a line for each value of
        a second one. A rise time that a case lacks although it has an answer is longer
        than any: the median is not drawn where half of the cases lack it, nor is the
        band where one in twenty does.

    Raises
    ------
    InvalidValue
        When the study is no sample, or varies no axis beside it.
    """
    low, middle, high = (_at_quantile(study, share) for share in QUANTILES)
    names = available(middle, _RESULTS)
    figure = style.new_figure(style.ONE_COLUMN, 0.9 + 2.2 * len(names))
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False).ravel()
    for ax, name in zip(panels, names, strict=True):
        table = tabulate_study(middle, name)
        lines = draw_lines(style.dress(ax), middle, name, table)
        factor, _ = scaled(study.units.get(name, ""), table.values)
        ends = [_values(side, name, table) * factor for side in (low, high)]
        for line, column in zip(lines, lines_drawn(table.values.shape[1]), strict=True):
            below, above = (end[:, column] for end in ends)
            look: dict[str, Any] = {"color": line.get_color(), "alpha": 0.2, "lw": 0.0}
            if is_whole(study, table.x):
                ax.vlines(table.x_values, below, above, **(look | {"lw": 4.0}))
            else:
                ax.fill_between(table.x_values, below, above, **look)
        ax.label_outer()
    note = _note(study, names)
    legend(panels[0], study, table, lines, note)
    if table.lines is None:
        panels[0].set_title(note, fontsize=style.SMALL_SIZE)
    if table.note:
        figure.suptitle(table.note, fontsize=style.SMALL_SIZE)
    return figure


@dataclass(frozen=True)
class _QuantileGrid:
    """A sample's quantile over its grid, as a study of its own."""

    axes: dict[str, np.ndarray]
    results: dict[str, np.ndarray]
    units: Mapping[str, str]
    long_names: Mapping[str, str]
    sampled: dict[str, np.ndarray] = field(default_factory=dict)


def _present(study: StudyData) -> list[str]:
    return [name for name in _RESULTS if name in study.results]


def _values(side: _QuantileGrid, name: str, middle: StudyTable) -> FloatArray:
    """A quantile beside the median, NaN all over where it falls on no number anywhere."""
    try:
        return tabulate_study(side, name).values
    except NoResult:
        return np.full_like(middle.values, np.nan)


def _note(study: StudyData, drawn: list[str]) -> str:
    """Which cases the quantiles are of, and which of them have no number."""
    answered = ran(study)
    lines = [f"Median and 5 % to 95 % of {answered.shape[-1]} cases"]
    if lost := int((~answered).sum()):
        lines.append(f"but for {lost} of {answered.size} in all, without result")
    for name in _present(study):
        if lack := missing(study, name):
            lines.append(f"{lack}: {'counted as longest' if name in drawn else 'too many to draw'}")
    return "\n".join(lines)


def _at_quantile(study: StudyData, share: float) -> _QuantileGrid:
    """A quantile of the results drawn, over the cases that have an answer."""
    axes = {name: values for name, values in study.axes.items() if name != [*study.axes][-1]}
    results = {name: quantile(counted(study, name), share) for name in _present(study)}
    return _QuantileGrid(axes, results, study.units, study.long_names)
