"""Design charts of gear-driven wheels, and their motion beside the ordinary wheel's."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.mechanisms import GearDriven, Geneva
from escapement.mechanisms.gear_equation import CURVES
from escapement.plots import style
from escapement.plots.style import label
from escapement.synthesis import follower_motion, motion_ratio_chart

CHART_STATIONS = (3, 4, 5, 6, 8, 10, 12, 16, 20, 24)
_POINTS = 241


def plot_design_chart(
    curve: str = CURVES[0],
    stations: Sequence[int] = CHART_STATIONS,
    most_lobes: float = 10.0,
    ax: Axes | None = None,
) -> Axes:
    """Ratio of times V0 over the number of lobes, a line for each number of stations n.

    Points mark whole numbers of lobes. Source: Dijksman (1974), eq. 14.
    """
    ax = ax or style.new_axes(style.ONE_COLUMN, 3.2)
    outside = curve in CURVES[1::2]
    for place, n in enumerate(stations):
        end = most_lobes if outside else min(n / 2.0 - 2.0, most_lobes)
        if end < 0.0:
            continue
        look = style.LOOKS[place % len(style.LOOKS)]
        lobes = np.linspace(0.0, end, _POINTS)
        line: dict[str, Any] = {"color": look.color, "linestyle": look.linestyle, "lw": 1.1}
        ratio = motion_ratio_chart(n, lobes, curve)
        ax.plot(lobes, ratio, gid=f"n-{n}", **line)
        whole = np.arange(int(end + 1e-9) + 1)
        ax.plot(whole, motion_ratio_chart(n, whole, curve), "o", color=look.color, ms=2.5)
        _name_line(ax, n, lobes, ratio, outside)
    room = 0.12 if outside else 0.04
    ax.set(xlim=(-0.04 * most_lobes, (1.0 + room) * most_lobes))
    ax.set(ylim=(0.0, 0.4) if outside else (0.4, 1.06))
    ax.set(xlabel=label("unreal lobes m"), ylabel=label("ratio of times V₀"))
    ax.set_title(f"{curve}, n stations", fontsize=style.LABEL_SIZE)
    return ax


def plot_design_charts() -> Figure:
    """The charts of the hypocycloid and of the epicycloid side by side."""
    figure = style.new_figure(style.TWO_COLUMN, 4.3)
    for ax, curve in zip(figure.subplots(1, 2), CURVES[:2], strict=True):
        plot_design_chart(curve, ax=style.dress(ax))
    return figure


def plot_motions(stations: int = 12, inside: int = 3, outside: int = 0) -> Figure:
    """Follower angle, velocity, acceleration and jerk over a cycle, beside ordinary wheels.

    All in the time of the cycle, so that shares of motion and dwell show; the motion
    begins at 0. Where it starts and stops the jerk has impulses that are not drawn.

    Parameters
    ----------
    stations : int
        Stations of every wheel.
    inside, outside : int
        Lobes of the hypocycloid and of the epicycloid.
    """
    wheels: dict[str, Geneva | GearDriven] = {
        "external": Geneva(stations, pins=1),
        "internal": Geneva(stations, internal=True),
        f"hypocycloid, m = {inside}": GearDriven(stations, inside, "hypocycloid"),
        f"epicycloid, m = {outside}": GearDriven(stations, outside, "epicycloid"),
    }
    figure = style.new_figure(style.TWO_COLUMN, 4.9)
    axes = [style.dress(ax) for ax in figure.subplots(2, 2).flat]
    for look, (name, wheel) in zip(style.LOOKS, wheels.items(), strict=False):
        edge, tiny = wheel.motion_ratio, 1e-9
        inner = np.linspace(0.0, edge, 401)
        time = np.concatenate([[-0.05, -tiny], inner, [edge + tiny, 1.0 - tiny]])
        found = follower_motion(wheel, time)
        line: dict[str, Any] = {"color": look.color, "linestyle": look.linestyle, "lw": 1.2}
        columns = (found.angle, found.velocity, found.acceleration, found.jerk)
        for ax, values in zip(axes, columns, strict=True):
            ax.plot(time, values, label=name, **line)
    names = ("Angle\nin steps", "Velocity\nin steps/cycle",
             "Acceleration\nin steps/cycle²", "Jerk\nin steps/cycle³")  # fmt: skip
    for ax, name in zip(axes, names, strict=True):
        ax.set(ylabel=name, xlim=(-0.05, 1.0))
    for ax in axes[2:]:
        ax.set_xlabel(label("time in cycles"))
    handles, texts = axes[0].get_legend_handles_labels()
    figure.legend(
        handles, texts, loc="outside upper center", ncols=4, frameon=False,
        fontsize=style.SMALL_SIZE, handlelength=2.6,
    )  # fmt: skip
    return figure


def _name_line(ax: Axes, n: int, lobes: np.ndarray, ratio: np.ndarray, outside: bool) -> None:
    """The number of stations where lines are apart: right of them, or above V0 = 1."""
    where: dict[str, Any] = {"xytext": (0, 4), "ha": "center", "va": "bottom"}
    if outside:
        where = {"xytext": (5, 0), "ha": "left", "va": "center"}
    ax.annotate(
        f"{n}", (lobes[-1], ratio[-1]), textcoords="offset points",
        fontsize=style.SMALL_SIZE, **where,
    )  # fmt: skip
