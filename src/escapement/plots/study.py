"""Figures of a study: figures of merit over one or two swept parameters."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from escapement.plots import style
from escapement.plots.sample import QUANTILES, counted, missing, plot_sample, quantile, ran
from escapement.plots.study_panels import draw_lines, draw_map, explain, head, legend_title
from escapement.plots.study_table import Parameter, StudyTable, available, refusal, tabulate
from escapement.study.result import Study
from escapement.study.varied import CASE

_ENOUGH = 5  # a contour map needs so many points on either axis
_FOREMOST = ("rise_time", "velocity_mean")
_MAPS = ("period", "velocity_mean", "rise_time")
_SINGLE = dict.fromkeys(("rise_time", "settling_time"), "time")
_SINGLE |= dict.fromkeys(("velocity_max", "velocity_mean", "velocity_min"), "driver velocity")


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
        Axis of the study along the abscissa. Default: torque where it was
        varied, else the axis with most points.
    ax : Axes, optional
        Where to draw. Default: a new figure in one column.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Computed points are marked where they are few, and not joined over a parameter
        that is a whole number. A note says how many have no answer, and why. Of many lines six are
        drawn. Axes beyond two stay at their middle value, told in the legend.

    Raises
    ------
    InvalidValue
        For an unknown or empty result, or a study with nothing varied.

    Source: the figures are Meyer (1973), figures 9-11.
    """
    table = tabulate(study, [result], x)
    ax = ax or style.new_axes(style.ONE_COLUMN, 3.1)
    explain(ax, table, draw_lines(ax, table), table.note, legend)
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
    return _stack(available(study, _FOREMOST))


def plot_map(study: Study, result: str, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Map of one result over two parameters; hatched: no result.

    Contours, but cells of one colour each for times that jump by an engagement, and
    over parameters that are whole numbers.

    Parameters
    ----------
    study : Study
        A sweep's result with two varied axes or more; beyond the first two,
        axes stay at their middle value.
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
    own = ax is None
    ax = ax or style.new_axes(style.ONE_COLUMN, 2.9)
    key = draw_map(ax, table, bar="right")
    if key and legend:
        style.legend_above(ax, 1, handles=key)
    if own:
        head(ax.figure, table)
    return ax


def plot_spread(study: Study) -> Figure:
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
    if not study.sampled:
        raise refusal("be a sample for this figure", "a grid", "use plot_study")
    names = [name for name in _FOREMOST if name in study.results]
    results = {name: quantile(counted(study, name), [*QUANTILES]) for name in names}
    axes = {name: values for name, values in study.axes.items() if name != CASE}
    tables = available(replace(study, axes=axes, results=results, sampled={}), names)
    drawn, answered = [table.results[0] for table in tables], ran(study)
    note = [f"Median and 5 % to 95 % of {answered.shape[-1]} cases"]
    if lost := int((~answered).sum()):
        note.append(f"but for {lost} of {answered.size} in all, without result")
    for name in names:
        if lack := missing(study, name):
            note.append(f"{lack}: {'counted as longest' if name in drawn else 'too many to draw'}")
    return _stack(tables, "\n".join(note))


def plot_study(study: Study) -> Figure:
    """The figure that suits a study.

    Parameters
    ----------
    study : Study
        A sweep's result.

    Returns
    -------
    Figure
        One varied axis: rise and settling time, and the terminal velocities.
        Two: rise time and mean velocity, a line for each value of the second;
        with five points or more on both, maps below. More: the first
        two, the others at their middle value, which the title tells; `study.at(slots=6)`
        is the slice at another. A sample is drawn by `plot_sample`, or with axes beside it
        by `plot_spread`.

    Raises
    ------
    InvalidValue
        When nothing was varied, or no case has a result.
    """
    if study.sampled:
        return (plot_spread if max(study.shape[:-1], default=1) > 1 else plot_sample)(study)
    tables = available(study, _FOREMOST)
    if not tables[0].lines.name:
        return _plot_single(study)
    # a contour map of fewer points would invent what lies between them
    if min(tables[0].values.shape[1:]) < _ENOUGH:
        return _stack(tables)
    return _plot_double(tables, available(study, _MAPS))


def _stack(tables: Sequence[StudyTable], note: str = "") -> Figure:
    """Panels of lines above one another, with a legend each or one for all."""
    figure = style.new_figure(style.ONE_COLUMN, 0.9 + 2.2 * len(tables))
    panels = style.new_panels(figure, len(tables))
    for ax, table in zip(panels, tables, strict=True):
        lines = draw_lines(ax, table)
        ax.label_outer()
        if ax is panels[0] or table.lines.values.dtype.kind == "U":
            explain(ax, table, lines, note)
    head(figure, table)
    return figure


def _plot_single(study: Study) -> Figure:
    """Times above velocities, against the only varied parameter."""
    found = [table.results[0] for table in available(study, _SINGLE)]
    tables = []
    for title, group in groupby(found, _SINGLE.__getitem__):
        table = tabulate(study, [*group])
        entries = [name.removeprefix("velocity_").replace("_", " ") for name in table.results]
        lines = Parameter("", "", np.array(entries))
        tables.append(table._replace(name=title, lines=lines, values=table.values.T))
    return _stack(tables)


def _plot_double(tables: Sequence[StudyTable], maps: Sequence[StudyTable]) -> Figure:
    """Lines above maps."""
    figure = style.new_figure(style.TWO_COLUMN, 6.5)
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.0, 1.1))  # type: ignore[misc]
    for ax, table in zip(style.new_panels(upper, 1, len(tables)), tables, strict=True):
        lines = draw_lines(ax, table)
    where: dict[str, Any] = {"handlelength": style.HANDLE, "loc": "outside upper center"}
    style.add_legend(upper, len(lines), legend_title(table), handles=lines, **where)
    where["loc"] = "outside lower center"
    keys = dict[Any, Patch]()
    for ax, table in zip(style.new_panels(lower, 1, len(maps)), maps, strict=True):
        keys |= {key.get_label(): key for key in draw_map(ax, table, bar="top")}
        ax.label_outer()
    if keys:
        style.add_legend(lower, 2, handles=[*keys.values()], **where)
    head(figure, table)
    return figure
