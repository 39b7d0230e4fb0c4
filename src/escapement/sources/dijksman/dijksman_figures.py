"""Design charts of gear-driven wheels, and their motion beside the ordinary wheel's."""

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from escapement.mechanisms import GearDriven, Geneva
from escapement.mechanisms.gear_equation import CURVES
from escapement.plots import style
from escapement.plots.style import label
from escapement.synthesis import follower_motion, motion_ratio_chart

CHART_STATIONS = (3, 4, 5, 6, 8, 10, 12, 16, 20, 24)
_MOST_LOBES = 10.0


def plot_design_charts() -> Figure:
    """Ratio of times V0 over the number of lobes, a line for each number of stations n.

    Hypocycloids on the left, epicycloids on the right; points mark whole numbers of lobes.
    Source: Dijksman (1974), eq. 14.
    """
    figure = style.new_figure(style.TWO_COLUMN, 4.3)
    for ax, curve in zip(style.new_panels(figure, 1, 2), CURVES[:2], strict=True):
        outside = curve == "epicycloid"
        # numbers of stations are written where lines are apart: right of them, or above V0 = 1
        offset, side = ((5.0, 0.0), "left") if outside else ((0.0, 8.0), "center")
        for n, look in zip(CHART_STATIONS, cycle(style.LOOKS), strict=False):
            # the line of a hypocycloid ends at the wheel that never rests
            end = _MOST_LOBES if outside else min(n / 2.0 - 2.0, _MOST_LOBES)
            if end < 0.0:
                continue
            lobes, whole = np.linspace(0.0, end, 241), np.arange(int(end) + 1)
            ratio = motion_ratio_chart(n, lobes, curve)
            ax.plot(lobes, ratio, color=look.color, ls=look.linestyle, lw=1.1, gid=f"n-{n}")
            ax.plot(whole, motion_ratio_chart(n, whole, curve), "o", color=look.color, ms=2.5)
            style.annotate(ax, f"{n}", (float(lobes[-1]), float(ratio[-1])), offset, side)
        right, heights = (11.2, (0.0, 0.4)) if outside else (10.4, (0.4, 1.06))
        ax.set(xlim=(-0.4, right), ylim=heights)
        ax.set(xlabel=label("lobes m"), ylabel=label("ratio of times V₀"))
        ax.set_title(f"{curve}, n stations", fontsize=style.LABEL_SIZE)
    return figure


def plot_motions() -> Figure:
    """Follower angle, velocity, acceleration and jerk over a cycle, beside ordinary wheels.

    All in the time of the cycle, so that shares of motion and dwell show; the motion
    begins at 0. Where it starts and stops the jerk has impulses that are not drawn.
    """
    wheels: dict[str, Geneva | GearDriven] = {
        "external": Geneva(12, pins=1),
        "internal": Geneva(12, internal=True),
        "hypocycloid, m = 3": GearDriven(12, 3, "hypocycloid"),
        "epicycloid, m = 0": GearDriven(12, 0, "epicycloid"),
    }
    units = {"angle": "steps", "velocity": "steps/cycle"}
    units |= {"acceleration": "steps/cycle²", "jerk": "steps/cycle³"}
    figure = style.new_figure(style.TWO_COLUMN, 4.9)
    panels = style.new_panels(figure, 2, 2)
    for look, (name, wheel) in zip(style.LOOKS, wheels.items(), strict=False):
        # points close to both ends of the motion show its jumps upright
        edge, tiny = wheel.motion_ratio, 1e-9
        time = np.r_[-0.05, -tiny, np.linspace(0.0, edge, 401), edge + tiny, 1.0 - tiny]
        found = follower_motion(wheel, time)
        for ax, quantity in zip(panels, units, strict=True):
            values = getattr(found, quantity)
            ax.plot(time, values, color=look.color, ls=look.linestyle, lw=1.2, label=name)
    for ax, (quantity, unit) in zip(panels, units.items(), strict=True):
        ax.set(ylabel=f"{quantity.capitalize()}\nin {unit}", xlim=(-0.05, 1.0))
    for ax in panels[2:]:
        ax.set_xlabel(label("time in cycles"))
    handles = panels[0].get_lines()
    style.add_legend(figure, 4, handles=handles, loc="outside upper center", handlelength=2.6)
    return figure
