"""Figures of a study: figures of merit over one or two swept parameters."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from escapement.errors import InvalidValue
from escapement.plots import style
from escapement.plots.sample import plot_sample, plot_spread
from escapement.plots.study_panels import (
    draw_line,
    draw_lines,
    draw_map,
    dress_axis,
    head,
    is_whole,
    legend,
    legend_title,
)
from escapement.plots.study_table import StudyTable, available, drawable, tabulate_study
from escapement.plots.style import label, scaled
from escapement.study.result import Study

_ENOUGH = 5  # a contour map needs so many points on either axis
_TIMES = ("rise_time", "settling_time")
_VELOCITIES = ("velocity_max", "velocity_mean", "velocity_min")
_MAPS = ("period", "velocity_mean", "rise_time")


def plot_lines(study: Study, result: str, x: str | None = None, ax: Axes | None = None) -> Axes:
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
    table = tabulate_study(study, result, x)
    ax = ax or style.new_axes(style.ONE_COLUMN, 3.1)
    lines = draw_lines(ax, study, result, table)
    legend(ax, study, table, lines, table.note)
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
    names = available(study, ("rise_time", "velocity_mean"))
    figure = style.new_figure(style.ONE_COLUMN, 0.7 + 2.2 * len(names))
    panels = style.new_panels(figure, len(names))
    lines, table = _fill(panels, study, names)
    for ax in panels:
        ax.label_outer()
    legend(panels[0], study, table, lines)
    head(figure, table)
    return figure


def plot_map(study: Study, result: str, ax: Axes | None = None) -> Axes:
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

    Raises
    ------
    InvalidValue
        For an unknown or empty result, or fewer than two varied axes.
    """
    table = tabulate_study(study, result)
    if table.lines is None:
        raise InvalidValue(
            f"study must vary two parameters for a map, got one ({table.x}); use plot_lines"
        )
    own = ax is None
    ax = ax or style.new_axes(style.ONE_COLUMN, 2.9)
    key = draw_map(ax, study, result, table, bar="right")
    if key:
        style.legend_above(ax, 1, handles=key)
    if own:
        head(ax.figure, table)
    return ax


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
        beside = [*study.axes.values()][:-1]
        return (plot_spread if max(map(len, beside), default=1) > 1 else plot_sample)(study)
    names = available(study, ("rise_time", "velocity_mean"))
    table = tabulate_study(study, names[0])
    if table.lines is None:
        return _plot_single(study, table)
    # a contour map of fewer points would invent what lies between them
    if min(table.values.shape) < _ENOUGH:
        return plot_rise_and_terminal(study)
    return _plot_double(study, names, table)


def _plot_double(study: Study, names: Sequence[str], table: StudyTable) -> Figure:
    """Lines above maps."""
    figure = style.new_figure(style.TWO_COLUMN, 6.3)
    rows = figure.add_gridspec(2, 1, height_ratios=(1.0, 1.05))
    upper, lower = figure.add_subfigure(rows[0]), figure.add_subfigure(rows[1])
    lines, _ = _fill(style.new_panels(upper, 1, len(names)), study, names)
    style.add_legend(
        upper, len(lines), legend_title(study, table), handles=lines,
        loc="outside upper center", handlelength=style.HANDLE,
    )  # fmt: skip
    maps = available(study, _MAPS)
    holes = []
    for ax, name in zip(style.new_panels(lower, 1, len(maps)), maps, strict=True):
        holes += draw_map(ax, study, name, tabulate_study(study, name), bar="top")
        ax.label_outer()
    if holes:
        style.add_legend(
            lower, 1, handles=holes[:1], loc="outside lower center", handlelength=style.HANDLE
        )
    head(figure, table)
    return figure


def _plot_single(study: Study, table: StudyTable) -> Figure:
    """Times above velocities, against the only varied parameter."""
    wanted = {"time": _TIMES, "driver velocity": _VELOCITIES}
    groups = {name: found for name in wanted if (found := drawable(study, wanted[name]))}
    figure = style.new_figure(style.ONE_COLUMN, 0.4 + 2.2 * len(groups))
    panels, joined = style.new_panels(figure, len(groups)), not is_whole(study, table.x)
    for ax, (name, members) in zip(panels, groups.items(), strict=True):
        values = {member: tabulate_study(study, member).values[:, 0] for member in members}
        factor, unit = scaled(study.units.get(members[0], ""), list(values.values()))
        for look, (member, y) in zip(style.LOOKS, values.items(), strict=False):
            entry = member.removeprefix("velocity_").replace("_", " ")
            draw_line(ax, table.x_values, y * factor, look, entry, joined)
        dress_axis(ax, "x", study, table.x)
        ax.set_ylabel(label(name, unit))
        ax.label_outer()
        style.legend_above(ax, 3, handlelength=style.HANDLE)
    head(figure, table)
    return figure


def _fill(
    panels: list[Axes], study: Study, names: Sequence[str]
) -> tuple[list[Line2D], StudyTable]:
    """Lines of one result in each panel; returns those of the last."""
    for ax, name in zip(panels, names, strict=True):
        table = tabulate_study(study, name)
        lines = draw_lines(ax, study, name, table)
    return lines, table
