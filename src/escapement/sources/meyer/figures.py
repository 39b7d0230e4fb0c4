"""Meyer's figures 9-11 with his own table in them: printed points over computed lines."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from escapement import validate
from escapement.model import FloatArray
from escapement.plots import style
from escapement.plots.style import label

Rows = Sequence[Mapping[str, Any]]
_COMPUTED = ("as_published", "true")
_POINTS = 101
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
    known = tuple(sorted({row["slots"] for row in rows}))
    if slots not in known:
        raise validate.fail("slots", f"one of {known}", slots, "those are Meyer's mechanisms")
    chosen = [row for row in rows if row["slots"] == slots]
    figure = style.new_figure(style.TWO_COLUMN, 3.3)
    rise, speed = (style.dress(ax) for ax in figure.subplots(1, 2))
    _draw(rise, chosen, _rise_time_ms, -0.5)
    _draw(speed, chosen, _average, 0.5)
    rise.set_ylabel(label("rise time", "ms"))
    speed.set_ylabel(label("average driver velocity", "rad/s"))
    for ax in (rise, speed):
        ax.set_xlabel(label("driving torque", "in·lbf"))
        ax.set_ylim(bottom=0.0)
    key: dict[str, Any] = {"fontsize": style.SMALL_SIZE, "handlelength": style.HANDLE}
    key["frameon"] = False
    figure.legend(handles=_frictions(chosen), loc="outside upper center", ncols=6, **key)
    speed.legend(handles=_styles(chosen), loc="lower right", **key)
    return figure


def _draw(ax: Axes, rows: Rows, read: Any, power: float) -> None:
    for look, (_, series) in zip(style.LOOKS, _by_friction(rows), strict=False):
        torque = np.array([row["torque_inlbf"] for row in series])
        grid = np.linspace(0.9 * torque.min(), 1.04 * torque.max(), _POINTS)
        lines = {name: _law(read(series[0][name]), torque[0], grid, power) for name in _COMPUTED}
        drawn: dict[str, Any] = {"color": look.color, "zorder": 2}
        ax.plot(grid, lines["as_published"], linestyle=look.linestyle, lw=1.2, **drawn)
        if not np.allclose(lines["as_published"], lines["true"], rtol=1e-6):
            ax.plot(grid, lines["true"], linestyle="-", lw=_THIN, **drawn)
        printed = [read(row["printed"]) for row in series]
        ax.plot(
            torque, printed, look.marker, ms=4.5, mfc="white", mec=look.color, mew=1.0, zorder=3
        )


def _law(value: float, torque: float, grid: FloatArray, power: float) -> FloatArray:
    """Without a load speeds go as the root of torque, times as its inverse."""
    return value * (grid / torque) ** power


def _rise_time_ms(figures: Mapping[str, float]) -> float:
    return 1e3 * figures["rise_time"]


def _average(figures: Mapping[str, float]) -> float:
    return (figures["velocity_max"] + figures["velocity_min"]) / 2.0


def _by_friction(rows: Rows) -> list[tuple[float, Rows]]:
    frictions = sorted({row["friction"] for row in rows})
    return [(mu, [row for row in rows if row["friction"] == mu]) for mu in frictions]


def _frictions(rows: Rows) -> list[Line2D]:
    return [
        Line2D([], [], color=look.color, linestyle=look.linestyle, lw=1.2, label=f"µ = {mu:.2f}")
        for look, (mu, _) in zip(style.LOOKS, _by_friction(rows), strict=False)
    ]


def _styles(rows: Rows) -> list[Line2D]:
    """What markers, lines and thin lines mean."""
    grey = style.GREY
    entries = [
        Line2D([], [], marker="o", ms=4.5, mfc="white", mec=grey, ls="", label="printed"),
        Line2D([], [], color=grey, ls=style.LOOKS[1].linestyle, lw=1.2, label="as published"),
    ]
    if any(row["as_published"] != row["true"] for row in rows):
        entries.append(Line2D([], [], color=grey, lw=_THIN, label="real mechanism"))
    return entries
