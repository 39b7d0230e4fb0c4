"""Meyer's figures 9-11, drawn with the numbers of his table as points over computed lines."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from escapement.plots import style
from escapement.plots.style import label
from escapement.sources.meyer import COLUMNS

Rows = Sequence[Mapping[str, Any]]
_LOOKS: dict[str, dict[str, Any]] = {
    "printed": {"marker": "o", "ls": "", "ms": 4.5, "mfc": "white"},
    "as_published": {"ls": "-", "lw": 1.2, "markevery": [0]},
    "true": {"ls": style.LOOKS[1].linestyle, "lw": 1.2, "markevery": [-1]},
}
"""Style of each kind of numbers, and the place of the marker on each line."""


def plot_appendix_e(rows: Rows, slots: int) -> Figure:
    """Rise time and average velocity against torque for one of the mechanisms.

    Parameters
    ----------
    rows : sequence of dict
        As `escapement.sources.meyer.appendix_e` returns them.
    slots : int
        3, 4 or 6.

    Returns
    -------
    Figure
        Open markers are printed numbers, full lines are computed as published, broken lines are
        true where that differs. The full marker at the end of a line shows its friction.

    Notes
    -----
    Between the torques of the table the lines follow the square-root laws of
    the exact solution. Average velocity is the thesis' (max + min)/2.

    Source: Meyer (1973), figures 9-11 and Appendix E.
    """
    chosen = [row for row in rows if row["slots"] == slots]
    figure = style.new_figure(style.TWO_COLUMN, 3.3)
    rise, speed = style.new_panels(figure, 1, 2)
    # the cell of four slots is the true one, so that one line would hide the other
    lines = ("as_published",) if slots == 4 else ("as_published", "true")
    _draw(rise, chosen, lines, lambda it: 1e3 * it["rise_time"], -0.5)
    _draw(speed, chosen, lines, lambda it: (it["velocity_max"] + it["velocity_min"]) / 2.0, 0.5)
    for ax, name, unit in ((rise, "rise time", "ms"), (speed, "average driver velocity", "rad/s")):
        ax.set(xlabel=label("driving torque", "in-lbf"), ylabel=label(name, unit), ylim=(0.0, None))
    key: list[Artist] = [
        Line2D([], [], color=style.BLACK, label=COLUMNS[name][0], **_LOOKS[name])
        for name in ("printed", *lines)
    ]
    if slots == 4:
        key[1].set_label("as published, and true")
    key += rise.get_legend_handles_labels()[0]
    style.add_legend(figure, len(key), loc="outside upper center", handles=key)
    return figure


def _draw(ax: Axes, rows: Rows, lines: Sequence[str], read: Any, power: float) -> None:
    frictions = sorted({row["friction"] for row in rows})
    for look, mu in zip(style.LOOKS, frictions, strict=False):
        series = [row for row in rows if row["friction"] == mu]
        torque = np.array([row["torque_inlbf"] for row in series])
        grid = np.linspace(0.9 * torque.min(), 1.04 * torque.max(), 101)
        # without a load speeds are proportional to the root of the torque, times to its inverse
        law = (grid / torque[0]) ** power
        look_of_marks: dict[str, Any] = {"color": look.color, "marker": look.marker, "ms": 4.5}
        ax.plot([], [], ls="", label=f"µ = {mu:.2f}", **look_of_marks)
        for name in lines:
            ax.plot(grid, read(series[0][name]) * law, **look_of_marks, **_LOOKS[name])
        printed = [read(row["printed"]) for row in series]
        ax.plot(torque, printed, mew=1.0, zorder=3, **_LOOKS["printed"] | look_of_marks)
