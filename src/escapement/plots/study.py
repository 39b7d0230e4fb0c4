"""Figures of a study: figures of merit over one or two swept parameters."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from escapement.plots import style
from escapement.plots.sample import QUANTILES, counted, missing, plot_sample, quantile, ran
from escapement.plots.study_panels import NARROW, columns_drawn, draw_lines, draw_map
from escapement.plots.study_table import Parameter, StudyTable, available, chosen, refusal, tabulate
from escapement.study.plan import CASE
from escapement.study.result import Study

_ENOUGH = 5  # fewest points of a contour map on either axis
_BESIDE = 3  # number of maps that fit beside one another
_FOREMOST = ("period", "velocity_mean", "rise_time")
_SINGLE = ("period", "rise_time", "settling_time", "velocity_max", "velocity_mean", "velocity_min")
_SHARED = {"s": "time", "rad s-1": "driver velocity", "rpm": "driver velocity"}
"""Labels of panels for results with the same unit."""


def plot_lines(
    study: Study, result: str, x: str | None = None, ax: Axes | None = None, *, legend: bool = True
) -> Axes:
    """One result against one parameter, a line for each value of another.

    Parameters
    ----------
    study : Study
        A sweep's result.
    result : str
        Which result, for example "rise_time".
    x : str, optional
        Axis of the study along the abscissa. Default: torque if it was varied, otherwise the axis
        with most points.
    ax : Axes, optional
        Where to draw. Default: a new figure in one column.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Computed points are marked if they are few, and not joined over a parameter that is a
        whole number. A note says how many cases failed, and why. At most six lines are drawn. Axes
        beyond two are fixed at their middle value, which the legend names.

    Raises
    ------
    InvalidValue
        For an unknown or empty result, or a study with nothing varied.

    Source: the figures are Meyer (1973), figures 9-11.
    """
    table = tabulate(study, [result], x)
    ax = ax or style.new_axes(style.ONE_COLUMN, 3.1)
    _explain(ax, table, draw_lines(ax, table), table.note, legend)
    return ax


def plot_rise_and_terminal(study: Study) -> Figure:
    """Rise time above mean terminal velocity, against one parameter.

    Parameters
    ----------
    study : Study
        A sweep's result, as for `plot_lines`.

    Source: the figure is Meyer (1973), figures 9-11; his average velocity is
    (max + min)/2, here it is the cell angle over the period.
    """
    return _stack(available(study, ("rise_time", "velocity_mean")))


def plot_map(study: Study, result: str, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Map of one result over two parameters; hatched: no result.

    It has contours. Rise and settling times, which jump, and results over whole numbers, are drawn
    as a cell of one colour for each case.

    Parameters
    ----------
    study : Study
        A sweep's result with two varied axes or more; axes beyond the first two are fixed at
        their middle value.
    result : str
        Which result.
    ax : Axes, optional
        Where to draw. Default: a new figure in one column.
    legend : bool
        Whether to draw one.

    Raises
    ------
    InvalidValue
        For an unknown or empty result, or fewer than two varied axes.
    """
    table = tabulate(study, [result])
    if not table.lines.name:
        raise refusal("vary two parameters for a map", f"one ({table.x.name})", "use plot_lines")
    alone = ax is None
    ax = ax or style.new_axes(style.ONE_COLUMN, 2.9)
    key = draw_map(ax, table, bar="right")
    if key and legend:
        style.legend_above(ax, 1, handles=key)
    if alone:
        _head(ax.figure, table)
    return ax


def plot_spread(study: Study, results: Sequence[str] | None = None) -> Figure:
    """Scatter of a sample at each point of a grid.

    Parameters
    ----------
    study : Study
        A sweep's result over a sample at each point of a grid.
    results : sequence of str, optional
        Which results, as for `plot_study`.

    Returns
    -------
    Figure
        Each result against a swept parameter: the median over the sample, in a band from
        its 5 % to its 95 % quantile; a line for each value of a second one. A rise time that is
        missing in a computed case counts as longer than any other: the median is not drawn where
        half of the cases lack it, nor the band where one in twenty does.

    Raises
    ------
    InvalidValue
        If the study is not a sample, or varies no axis in addition to it.
    """
    if not study.sampled:
        raise refusal("be a sample for this figure", "a grid", "use plot_study")
    names = chosen(study, results, _FOREMOST)
    quantiles = {name: quantile(counted(study, name), [*QUANTILES]) for name in names}
    axes = {name: values for name, values in study.axes.items() if name != CASE}
    tables = available(replace(study, axes=axes, results=quantiles, sampled={}), names)
    drawn, answered = [table.results[0] for table in tables], ran(study)
    note = [f"Median and 5 % to 95 % of {answered.shape[-1]} cases"]
    if lost := int((~answered).sum()):
        note.append(f"{lost} of {answered.size} cases in all have no result")
    for name in names:
        if lack := missing(study, name):
            note.append(f"{lack}: {'counted as longest' if name in drawn else 'too many to draw'}")
    return _stack(tables, "\n".join(note))


def plot_study(study: Study, results: Sequence[str] | None = None) -> Figure:
    """The figure that suits a study.

    Parameters
    ----------
    study : Study
        A sweep's result.
    results : sequence of str, optional
        Names of results. Default: period, mean velocity and rise time, over one axis also
        settling time and the other velocities; all results if the study names its own.

    Returns
    -------
    Figure
        With one varied axis there is a panel of times, one of velocities, and one for each other
        result. With two there is a panel for each result, with a line for each value of the
        second axis; with five points or more on both axes there are maps below. With more axes
        the first two are drawn, and the others are fixed at their middle value, which the title
        names; `study.at(slots=6)` is the slice at another value. A sample is drawn by
        `plot_sample`, or, if it has axes too, by `plot_spread`.

    Raises
    ------
    InvalidValue
        When nothing was varied, or no case has a result.
    """
    if study.sampled:
        draw = plot_spread if max(study.shape[:-1], default=1) > 1 else plot_sample
        return draw(study, results)
    alone = sum(size > 1 for size in study.shape) == 1
    panels = available(study, chosen(study, results, _SINGLE if alone else _FOREMOST))
    if alone:
        return _stack(_joined(study, panels))
    # a contour map of fewer points would be misleading between them
    return (_stack if min(panels[0].values.shape[1:]) < _ENOUGH else _with_maps)(panels)


def _joined(study: Study, panels: Sequence[StudyTable]) -> list[StudyTable]:
    """Panels over the only varied parameter, those of similar results as one."""
    groups: dict[str, list[str]] = {}
    shared = _SHARED
    if "study" in study.configuration:  # a drive, of which both bodies have speeds
        shared = shared | dict.fromkeys([*shared][1:], "speed")
    for (name,), *_ in panels:
        groups.setdefault(shared.get(study.units.get(name, ""), name), []).append(name)
    found = []
    for title, names in groups.items():
        table = tabulate(study, names)
        if len(names) > 1:
            entries = [name.removeprefix("velocity_").replace("_", " ") for name in names]
            lines = Parameter("", "", np.array(entries))
            table = table._replace(name=title, lines=lines, values=table.values.T)
        found.append(table)
    return found


def _stack(panels: Sequence[StudyTable], note: str = "") -> Figure:
    """Panels of lines above one another, each with a legend or with one for all."""
    figure = style.new_figure(style.ONE_COLUMN, 0.9 + 2.2 * len(panels))
    for ax, table in zip(style.new_panels(figure, len(panels)), panels, strict=True):
        lines = draw_lines(ax, table)
        ax.label_outer()
        if table is panels[0] or table.lines.values.dtype.kind == "U":
            _explain(ax, table, lines, note)
    _head(figure, table)
    return figure


def _with_maps(panels: Sequence[StudyTable]) -> Figure:
    """Panels of lines, each above its map, in rows of three."""
    rows = [panels[i : i + _BESIDE] for i in range(0, len(panels), _BESIDE)]
    figure = style.new_figure(style.TWO_COLUMN, 6.5 * len(rows))
    parts: Any = figure.subfigures(2 * len(rows), 1, height_ratios=[1.0, 1.1] * len(rows))
    where: dict[str, Any] = {"handlelength": style.HANDLE}
    for row, upper, lower in zip(rows, parts[::2], parts[1::2], strict=True):
        keys = dict[Any, Artist]()
        axes, maps = (style.new_panels(part, 1, len(row)) for part in (upper, lower))
        for ax, below, table in zip(axes, maps, row, strict=True):
            lines = draw_lines(ax, table, NARROW if len(row) == _BESIDE else style.LINE)
            keys |= {key.get_label(): key for key in draw_map(below, table, bar="top")}
            below.label_outer()
        title, above = _legend_title(table), "outside upper center"
        style.add_legend(upper, len(lines), title, handles=lines, loc=above, **where)
        if keys:
            at = "outside lower center"
            style.add_legend(lower, 2, handles=[*keys.values()], loc=at, **where)
    _head(figure, table)
    return figure


def _explain(
    ax: Axes, table: StudyTable, lines: list[Line2D], note: str = "", legend: bool = True
) -> None:
    """A legend of the lines, above a panel in one column; for a single line only the note."""
    if legend and table.lines.values.size > 1:
        title = "\n".join(text for text in (note, _legend_title(table)) if text)
        columns = 2 if len(lines) == 4 else 3
        style.legend_above(ax, columns, title, handles=lines, handlelength=style.HANDLE)
    else:
        ax.set_title(note, fontsize=style.SMALL_SIZE)


def _legend_title(table: StudyTable) -> str:
    """Title of the lines, and how many of them are drawn: "Driving torque (in-lbf)"."""
    text = style.label(table.lines.name, table.lines.unit)
    count, shown = table.lines.values.size, len(columns_drawn(table))
    return text if shown == count else f"{text}, {shown} of {count} values"


def _head(figure: Any, table: StudyTable) -> None:
    """A title above the figure with the fixed axes and their values."""
    if table.note:
        figure.suptitle(table.note, fontsize=style.SMALL_SIZE)
