"""Design charts of gear-driven wheels, and their motion beside the ordinary wheel's."""

from collections.abc import Sequence

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
    # numbers of stations stand where lines are apart: right of them, or above V0 = 1
    offset, side = ((5.0, 0.0), "left") if outside else ((0.0, 8.0), "center")
    for place, n in enumerate(stations):
        # the line of a hypocycloid ends at the wheel that never rests
        end = most_lobes if outside else min(n / 2.0 - 2.0, most_lobes)
        if end < 0.0:
            continue
        look = style.LOOKS[place % len(style.LOOKS)]
        lobes, whole = np.linspace(0.0, end, _POINTS), np.arange(int(end + 1e-9) + 1)
        ratio = motion_ratio_chart(n, lobes, curve)
        ax.plot(lobes, ratio, color=look.color, ls=look.linestyle, lw=1.1, gid=f"n-{n}")
        ax.plot(whole, motion_ratio_chart(n, whole, curve), "o", color=look.color, ms=2.5)
        style.annotate(ax, f"{n}", (float(lobes[-1]), float(ratio[-1])), offset, side)
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
    units = {"angle": "steps", "velocity": "steps/cycle"}
    units |= {"acceleration": "steps/cycle²", "jerk": "steps/cycle³"}
    figure = style.new_figure(style.TWO_COLUMN, 4.9)
    panels = dict(zip(units, map(style.dress, figure.subplots(2, 2).flat), strict=True))
    for look, (name, wheel) in zip(style.LOOKS, wheels.items(), strict=False):
        # points close to both ends of the motion show its jumps upright
        edge, tiny = wheel.motion_ratio, 1e-9
        inner = np.linspace(0.0, edge, 401)
        time = np.concatenate([[-0.05, -tiny], inner, [edge + tiny, 1.0 - tiny]])
        found = follower_motion(wheel, time)
        for quantity, ax in panels.items():
            values = getattr(found, quantity)
            ax.plot(time, values, color=look.color, ls=look.linestyle, lw=1.2, label=name)
    for quantity, ax in panels.items():
        ax.set(ylabel=f"{quantity.capitalize()}\nin {units[quantity]}", xlim=(-0.05, 1.0))
    for quantity in ("acceleration", "jerk"):
        panels[quantity].set_xlabel(label("time in cycles"))
    handles, _ = panels["angle"].get_legend_handles_labels()
    style.add_legend(figure, 4, handles=handles, loc="outside upper center", handlelength=2.6)
    return figure
