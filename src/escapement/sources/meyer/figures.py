"""Meyer's figures 9-11 with his own table in them: printed points over computed lines."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from escapement.plots import style
from escapement.plots.style import label

Rows = Sequence[Mapping[str, Any]]
_MARK: dict[str, Any] = {"marker": "o", "ms": 4.5, "mfc": "white", "ls": ""}
_THIN = 0.6


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
        Markers: printed. Lines: the same runs recomputed as published. Thin
        lines: the real mechanism, where it differs.

    Notes
    -----
    Between the torques of the table the lines follow the square-root laws of
    the exact solution. Average velocity is the thesis' (max + min)/2.

    Source: Meyer (1973), figures 9-11 and Appendix E.
    """
    chosen = [row for row in rows if row["slots"] == slots]
    figure = style.new_figure(style.TWO_COLUMN, 3.3)
    rise, speed = style.new_panels(figure, 1, 2)
    _draw(rise, chosen, lambda it: 1e3 * it["rise_time"], -0.5)
    _draw(speed, chosen, lambda it: (it["velocity_max"] + it["velocity_min"]) / 2.0, 0.5)
    for ax, name, unit in ((rise, "rise time", "ms"), (speed, "average driver velocity", "rad/s")):
        ax.set(xlabel=label("driving torque", "in-lbf"), ylabel=label(name, unit), ylim=(0.0, None))
    looks = [
        {"label": "printed", **_MARK},
        {"label": "as published", "ls": style.LOOKS[1].linestyle, "lw": 1.2},
        {"label": "real mechanism", "lw": _THIN},
    ]
    # the cell of four slots is right
    looks = looks[:2] if slots == 4 else looks
    # colours stand for friction; markers, lines and thin lines for where a figure is from
    named, wide = rise.get_legend_handles_labels()[0], style.HANDLE
    style.add_legend(figure, 6, loc="outside upper center", handles=named, handlelength=wide)
    key = [Line2D([], [], color=style.GREY, **look) for look in looks]
    style.add_legend(speed, 1, loc="lower right", handles=key, handlelength=wide)
    return figure


def _draw(ax: Axes, rows: Rows, read: Any, power: float) -> None:
    frictions = sorted({row["friction"] for row in rows})
    for look, mu in zip(style.LOOKS, frictions, strict=False):
        series = [row for row in rows if row["friction"] == mu]
        torque = np.array([row["torque_inlbf"] for row in series])
        grid = np.linspace(0.9 * torque.min(), 1.04 * torque.max(), 101)
        # without a load speeds go as the root of torque, times as its inverse
        law = (grid / torque[0]) ** power
        published, true = (read(series[0][name]) * law for name in ("as_published", "true"))
        ax.plot(grid, published, color=look.color, ls=look.linestyle, lw=1.2, label=f"µ = {mu:.2f}")
        # one line would hide the other
        if series[0]["slots"] != 4:
            ax.plot(grid, true, color=look.color, lw=_THIN)
        printed = [read(row["printed"]) for row in series]
        mark = _MARK | {"marker": look.marker, "mec": look.color}
        ax.plot(torque, printed, mew=1.0, zorder=3, **mark)
