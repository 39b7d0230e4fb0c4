"""Work-precision diagrams and cost curves, with the machine's description at the foot."""

from collections.abc import Sequence
from itertools import groupby
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.benchmark.costs import Cost
from escapement.benchmark.measuring import machine_in_a_line
from escapement.benchmark.problems import Problem
from escapement.benchmark.work_precision import Point
from escapement.plots.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LIGHT_GREY,
    ORANGE,
    PURPLE,
    SKY,
    SMALL_SIZE,
    TWO_COLUMN,
    VERMILLION,
    dress,
    new_figure,
)

# The package itself does not measure heyoka and CyRK; `benchmarks/standings.py` does.
_COLORS = {
    "energy": BLACK,
    "ivp": GREY,
    "heyoka": VERMILLION,
    "CyRK": ORANGE,
    "DOP853": BLUE,
    "RK45": SKY,
    "LSODA": GREEN,
    "Radau": PURPLE,
    "BDF": "#8c6bb1",
    "RK23": LIGHT_GREY,
}
_FOOT = "solve_ivp: solid with a Numba right-hand side, dashed in plain Python\n{}"
_SECOND = ("Vern8", "Taylor, angle")
_MARKERS = {"energy": "o", "ivp": "s", "heyoka": "^", "CyRK": "D", "solve_ivp": "."}


def work_precision_figure(
    points: Sequence[Point], problems: Sequence[Problem], machine: dict[str, Any]
) -> Figure:
    """A panel for each problem: measured error to the right, run time upwards."""
    figure = new_figure(TWO_COLUMN, 0.58 * TWO_COLUMN)
    panels = figure.subplots(1, len(problems), sharey=True, squeeze=False)[0]
    for ax, problem in zip(panels, problems, strict=True):
        plot_work_precision([p for p in points if p.problem == problem.name], ax)
        ax.set_title(problem.title)
        ax.label_outer()
    handles, names = panels[0].get_legend_handles_labels()
    legend = figure.legend(
        handles,
        names,
        loc="outside lower center",
        ncols=4,
        fontsize=SMALL_SIZE,
        frameon=False,
        title=_FOOT.format(machine_in_a_line(machine)),
        title_fontsize=6.0,
    )
    legend.get_title().set_multialignment("center")
    return figure


def plot_work_precision(points: Sequence[Point], ax: Axes) -> Axes:
    """Run time against measured error, a line for each solver."""
    for name, group in groupby(points, key=lambda point: point.solver):
        line = sorted(group, key=lambda point: -point.rtol)
        first = line[0]
        own = first.family == "energy"
        ax.loglog(
            [point.error for point in line],
            [point.time for point in line],
            color=_COLORS[first.method if first.family == "solve_ivp" else first.family],
            linestyle="--" if first.language == "Python" or first.method in _SECOND else "-",
            marker=_MARKERS[first.family],
            markersize=5 if own else 3,
            linewidth=2 if own else 1,
            zorder=3 if own else 2,
            label="_" if first.language == "Python" else name.removesuffix(" Numba"),
        )
    ax.set_xlabel("Largest relative error")
    ax.set_ylabel("Warm run time (s)")
    ax.invert_xaxis()
    return dress(ax)


def scaling_figure(costs: Sequence[Cost], machine: dict[str, Any]) -> Figure:
    """Cost against engagements, cases and workers."""
    figure = new_figure(TWO_COLUMN, 0.36 * TWO_COLUMN)
    left, middle, right = figure.subplots(1, 3)
    for engine in ("energy", "ivp"):
        line = [c for c in costs if c.against == "engagements" and c.engine == engine]
        left.loglog(
            [cost.size for cost in line],
            [cost.time for cost in line],
            color=_COLORS[engine],
            marker=_MARKERS[engine],
            markersize=3,
            label=engine,
        )
    left.set(xlabel="Engagements", ylabel="Run time (s)")
    left.legend(fontsize=SMALL_SIZE, frameon=False)
    line = [cost for cost in costs if cost.against == "cases"]
    middle.loglog(
        [cost.size for cost in line],
        [cost.time / cost.items * 1e6 for cost in line],
        color=BLACK,
        marker="o",
        markersize=3,
    )
    middle.set(xlabel="Cases in a batch", ylabel="Time by case (µs)", ylim=(1.0, None))
    line = [cost for cost in costs if cost.against == "workers"]
    sizes = [cost.size for cost in line]
    right.plot(sizes, [c.items / c.time for c in line], color=BLACK, marker="o", markersize=3)
    right.plot(
        sizes,
        [size * line[0].items / line[0].time for size in sizes],
        color=GREY,
        linestyle=":",
        label="proportional",
    )
    right.set(xlabel="Workers", ylabel="Cases a second", ylim=(0, None), xticks=sizes)
    right.legend(fontsize=SMALL_SIZE, frameon=False)
    for ax in (left, middle, right):
        dress(ax)
    figure.supxlabel(machine_in_a_line(machine), fontsize=6.0)
    return figure
