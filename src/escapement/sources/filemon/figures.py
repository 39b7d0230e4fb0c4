"""Filemon's figures 3 to 8: transmission functions and what becomes of the torque.

External wheels; angles in degrees from dead centre. Families of curves have their
number of slots written on them, as in the paper.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import StrMethodFormatter

from escapement.constant_speed import drive_torque, geneva, reversal_study
from escapement.mechanisms import Geneva
from escapement.mechanisms.slotted import Transmission
from escapement.model import FloatArray
from escapement.plots import style
from escapement.plots.style import label

SLOTS = tuple(range(3, 11))
"""Numbers of slots of the families of curves."""
ANGLE = label("driver angle β", "°")
RATIO, RATE, LOAD_RATIO = r"$i_\omega$", r"$i_\varepsilon$", r"$F$"
_POINTS = 500


def plot_transmission(slots: int = 4, ax: Axes | None = None) -> Axes:
    """Transmission function over an engagement (figure 3)."""
    ax = ax or style.new_axes()
    angle, table = engagement(slots)
    ax.plot(angle, table.g, color=style.BLUE, lw=1.4)
    top = float(geneva.ratio_max(slots))
    ax.plot(0.0, top, "v", color=style.BLACK, ms=5)
    style.annotate(
        ax, rf"$i_{{\omega\,\mathrm{{max}}}}$ = {top:.3f}", (0.0, top), (7.0, 0.0), "left"
    )
    ax.set(xlabel=ANGLE, ylabel=RATIO, xlim=(angle[0], angle[-1]), ylim=(0.0, 1.15 * top))
    ax.set_title(f"n = {slots}", fontsize=style.TICK_SIZE)
    return ax


def plot_transmission_family(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """Transmission functions up to dead centre, logarithmic (figure 4)."""
    ax = ax or style.new_axes(style.TWO_COLUMN, 4.6)
    _draw_family(ax, slots, lambda table: table.g, -2.0)
    ax.set(xlabel=ANGLE, ylabel=RATIO, ylim=(0.01, 10.0))
    return ax


def plot_acceleration(slots: int = 4, ax: Axes | None = None) -> Axes:
    """Acceleration function over an engagement, with start and maximum (figure 5)."""
    ax = ax or style.new_axes()
    angle, table = engagement(slots)
    ax.axhline(0.0, color=style.BLACK, lw=0.6)
    ax.plot(angle, table.dg, color=style.BLUE, lw=1.4)
    start, top = (float(f(slots)) for f in (geneva.acceleration_start, geneva.acceleration_max))
    place = -np.degrees(float(geneva.acceleration_max_angle(slots)))
    ax.plot([angle[0], place], [start, top], "o", color=style.BLACK, ms=4, clip_on=False, zorder=4)
    ax.plot([place, place], [0.0, top], color=style.GREY, lw=0.7, ls=":")
    style.annotate(
        ax, rf"$i_{{\varepsilon s}}$ = {start:.3f}", (angle[0], start), (6.0, -22.0), "left"
    )
    name = rf"$i_{{\varepsilon\,\mathrm{{max}}}}$ = {top:.3f}"
    style.annotate(ax, f"{name}\nat −{-place:.2f}°", (place, top), (14.0, -4.0), "left")
    ax.set(xlabel=ANGLE, ylabel=RATE, xlim=(angle[0], angle[-1]))
    ax.set_ylim(-1.2 * top, 1.2 * top)
    ax.set_title(f"n = {slots}", fontsize=style.TICK_SIZE)
    return ax


def plot_acceleration_family(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """Acceleration functions up to dead centre, logarithmic (figure 6)."""
    ax = ax or style.new_axes(style.TWO_COLUMN, 4.6)
    _draw_family(ax, slots, lambda table: table.dg, None)
    tops = [-np.degrees(float(geneva.acceleration_max_angle(n))) for n in slots]
    ax.plot(
        tops, [float(geneva.acceleration_max(n)) for n in slots], "o", ms=3.5, mfc="white",
        mec=style.BLACK, mew=0.8, label="maximum",
    )  # fmt: skip
    ax.set(xlabel=ANGLE, ylabel=RATE, ylim=(0.05, 50.0))
    ax.legend(loc="upper left", fontsize=style.SMALL_SIZE, frameon=False)
    return ax


def plot_torque_terms(slots: int = 4, ratio: float = 1.0, ax: Axes | None = None) -> Axes:
    """Torque as the sum of the load's and the inertia's share (figure 7)."""
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.8)
    angle, table = engagement(slots)
    product = ratio * table.g * table.dg
    name = r"$i_\omega i_\varepsilon$" if ratio == 1.0 else r"$F\, i_\omega i_\varepsilon$"
    lines = (
        (table.g, RATIO, style.LOOKS[1]),
        (table.dg, RATE, style.LOOKS[2]),
        (product, name, style.LOOKS[3]),
        (table.g + product, r"$M_2 \eta / M_e$", style.LOOKS[0]),
    )
    ax.axhline(0.0, color=style.BLACK, lw=0.6)
    for values, text, look in lines:
        width = 1.8 if look is style.LOOKS[0] else 1.1
        ax.plot(angle, values, color=look.color, ls=look.linestyle, lw=width, label=text)
    reversals = np.degrees(reversal_study(slots, ratio).reversals)
    found = reversals[~np.isnan(reversals)]
    ax.plot(found, np.zeros_like(found), label="pin reversal", **MARK)
    ax.set(xlabel=ANGLE, ylabel="Function", xlim=(angle[0], angle[-1]))
    style.legend_above(ax, 5, f"n = {slots}, F = {ratio:g}")
    return ax


def plot_zones(slots: int = 8, ratios: Sequence[float] = (1.0, 1.9, 4.0)) -> Figure:
    """Torque in zones 1, 2 and 3, the inertia ratio growing (figure 8)."""
    figure = style.new_figure(style.TWO_COLUMN, 2.7)
    panels = figure.subplots(1, len(ratios))
    for ax, ratio, letter in zip(panels, ratios, "abc", strict=False):
        result = drive_torque(Geneva(slots, pins=1), 1.0, 1.0, ratio)
        state = result.samples
        style.dress(ax).axhline(0.0, color=style.BLACK, lw=0.6)
        angle = np.degrees(state.theta)
        ax.plot(angle, state.torque, color=style.BLUE, lw=1.4)
        ax.fill_between(
            angle, state.torque, 0.0, where=state.torque < 0.0, color=style.SKY, alpha=0.5, lw=0
        )
        found = np.degrees(result.reversals)
        ax.plot(found, np.zeros_like(found), **MARK)
        ax.set_title(f"{letter}  zone {result.zone}, F = {ratio:g}", fontsize=style.TICK_SIZE)
        ax.set(xlabel="β (°)", xlim=(angle[0], angle[-1]))
    panels[0].set_ylabel(r"$M_2 \eta / M_e$")
    figure.suptitle(f"n = {slots}", fontsize=style.TICK_SIZE)
    return figure


MARK: dict[str, Any] = {
    "ls": "", "marker": "o", "ms": 5, "mfc": "white", "mec": style.BLACK, "mew": 0.9, "zorder": 5
}  # fmt: skip
"""How a pin reversal is marked."""


def engagement(slots: int, share: float = 1.0) -> tuple[FloatArray, Transmission]:
    """Angles [degrees] from pin entry to `share` of the exit, and the transmission there."""
    wheel = Geneva(slots, pins=1)
    theta = np.linspace(wheel.breaks[0], share * wheel.breaks[-1], _POINTS)
    return np.degrees(theta), wheel.transmission(theta)


def _draw_family(
    ax: Axes,
    slots: Sequence[int],
    read: Callable[[Transmission], FloatArray],
    shift: float | None,
) -> None:
    """A logarithmic curve a number of slots, pin entry dotted.

    shift : where a curve's number stands, in degrees from dead centre; None for
        pin entry.
    """
    style.grid(ax)
    ax.set_yscale("log")
    ax.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    for n in slots:
        angle, table = engagement(n, 0.0)
        values = read(table)
        # both functions vanish at one end of the half, where the logarithm does not exist
        inside = values > 1e-9
        ax.plot(angle[inside], values[inside], color=style.BLUE, lw=1.1)
        ax.axvline(angle[0], color=style.GREY, lw=0.5, ls=":")
        i = 0 if shift is None else int(np.searchsorted(angle, shift))
        style.annotate(ax, str(n), (angle[i], values[i]))
    ax.set_xlim(-75.0, 0.0)
    start = " ".join(f"{np.degrees(geneva.engagement_half(n)):.4g}°" for n in slots)
    ax.set_title(
        f"n on the curves; β₀ for n = {slots[0]} to {slots[-1]}: {start}",
        fontsize=style.SMALL_SIZE,
    )
