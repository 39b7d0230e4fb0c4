"""Prikhodko's figures 3 and 6: plans of velocities, and the position function."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.mechanisms import EllipticalPlanetary
from escapement.model import FloatArray
from escapement.outlines.elliptical import EllipticalOutline
from escapement.plots import style
from escapement.plots.planetary import draw_planetary

LETTERS = "abcde"
_CELLS = 2
_POINTS = 721
_LENGTH = 0.75  # a vector of 1 mm per radian of the input is drawn so long [mm]
_PLAN = {
    "carrier, A C′": style.LOOKS[5],
    "planet, B C′": style.LOOKS[0],
    "output, A D′": style.LOOKS[1],
}
_ARROW: dict[str, Any] = {"arrowstyle": "-|>", "lw": 0.9, "color": style.BLACK}
_ARROW |= {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 7}


def positions(mechanism: EllipticalPlanetary) -> FloatArray:
    """Driver angles of positions a to e [rad]: stop, rising, fastest, falling, stop.

    b and d are where the planet has turned a quarter on its carrier; the paper does
    not say where its own are.
    """
    return np.linspace(*mechanism.breaks, len(LETTERS))


def plot_position_function(mechanism: EllipticalPlanetary, ax: Axes | None = None) -> Axes:
    """Output angle over input angle, stops and positions a to e marked (figure 6)."""
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.6)
    cell = math.degrees(mechanism.cell_angle)
    for k in range(_CELLS):
        ax.axvline((k + 0.5) * cell, color=style.GREY, lw=0.7, ls=":")
    offsets = [(8.0, 8.0)] * len(LETTERS)
    _over_input(ax, mechanism, lambda at: np.degrees(-mechanism.follower_angle(at)), offsets)
    step = round(math.degrees(mechanism.follower_step), 9)
    ax.set_title(f"{cell:g}° between stops, output −{step:g}°", fontsize=style.TICK_SIZE)
    ax.set(ylabel="Output angle φ₃ (°)")
    return ax


def plot_velocity_analogue(mechanism: EllipticalPlanetary, ax: Axes | None = None) -> Axes:
    """Output over input speed, equation 9, over the same angles as figure 6."""
    ax = ax or style.new_axes(style.TWO_COLUMN, 2.8)
    ax.axhline(0.0, color=style.BLACK, lw=0.6)
    offsets = [(0.0, 9.0) if letter == "c" else (9.0, -7.0) for letter in LETTERS]
    _over_input(ax, mechanism, lambda at: -mechanism.transmission(at).g, offsets)
    ax.set(ylabel="Velocity analogue φ₃′")
    return ax


def _over_input(
    ax: Axes,
    mechanism: EllipticalPlanetary,
    read: Callable[[FloatArray], FloatArray],
    offsets: Sequence[tuple[float, float]],
) -> None:
    """A curve over two cells, with positions a to e marked."""
    end = _CELLS * mechanism.cell_angle
    angle, marks = np.linspace(0.0, end, _POINTS), positions(mechanism) + mechanism.cell_angle
    ax.plot(np.degrees(angle), read(angle), color=style.BLUE, lw=1.5)
    places, heights = np.degrees(marks), read(marks)
    ax.plot(places, heights, "o", color=style.BLACK, ms=4, mfc="white", zorder=4)
    for letter, x, y, offset in zip(LETTERS, places, heights, offsets, strict=True):
        style.annotate(ax, letter, (x, y), offset)
    ax.set(xlabel="Input angle φ₁ (°)", xlim=(0.0, math.degrees(end)))


def plot_velocity_plans(mechanism: EllipticalPlanetary) -> Figure:
    """Plans of linear velocities over the gears in positions a to e (figure 3).

    Seen from the carrier, which stands upright. A horizontal vector is the speed of
    a point of the line of centres: of the carrier on A C', of the planet on B C',
    of the output on A D'.
    """
    figure = style.new_figure(style.TWO_COLUMN, 2.75)
    panels = figure.subplots(1, len(LETTERS))
    for ax, letter, theta in zip(panels, LETTERS, map(float, positions(mechanism)), strict=True):
        _draw_plan(ax, mechanism, theta)
        speed = float(mechanism.transmission(theta).g)
        moves = speed > 1e-9 * mechanism.ratio_max
        text = f"ω₃ = −{speed:.3g} ω₁" if moves else "ω₃ = 0"
        ax.set_title(f"{letter}   {text}", fontsize=style.TICK_SIZE)
    handles = panels[0].get_lines()[-len(_PLAN) :]
    style.add_legend(figure, 3, handles=handles, loc="outside lower center", handlelength=3.0)
    return figure


def _draw_plan(ax: Axes, mechanism: EllipticalPlanetary, theta: float) -> None:
    draw_planetary(ax, mechanism, theta, 0.5 * math.pi)
    rolling, shaft, contact = EllipticalOutline(mechanism).line_of_centres(theta)
    # speeds over omega_1 are lengths, and are drawn to the left
    spin = 1.0 + mechanism.ratio
    # the planet turns about the point where it rolls on the sun
    at_contact = spin * (contact - rolling)
    lowest = min(contact, rolling)
    lines = (
        ([0.0, shaft], [0.0, shaft]),
        ([spin * (lowest - rolling), shaft], [lowest, shaft]),
        ([0.0, at_contact], [0.0, contact]),
    )
    for (speeds, heights), (name, look) in zip(lines, _PLAN.items(), strict=True):
        line: dict[str, Any] = {"color": look.color, "ls": look.linestyle, "lw": 1.4}
        ax.plot(-_LENGTH * np.array(speeds), heights, zorder=6, label=name, **line)
    marks = [("A", 0.0, 0.0, (8, -1)), ("C", 0.0, shaft, (8, 3)), ("C′", shaft, shaft, (0, 8))]
    # B and D are apart but at a stop, where they share a label
    if at_contact < -1e-9 * shaft:
        marks += [("D′", at_contact, contact, (-1, 9)), ("B", 0.0, rolling, (-7, 1))]
        marks += [("D", 0.0, contact, (-8, -4))]
    else:
        marks += [("B, D", 0.0, rolling, (14, -1))]
    for letters, speed, height, offset in marks:
        style.annotate(ax, letters, (-_LENGTH * speed, height), offset)
    for height, speed in ((shaft, shaft), (contact, at_contact)):
        if abs(speed) > 1e-9 * shaft:
            ax.annotate("", (-_LENGTH * speed, height), (0.0, height), zorder=7, arrowprops=_ARROW)
    reach = 1e3 * mechanism.sun_radius
    wide = max(reach, _LENGTH * shaft, _LENGTH * spin * (reach - 1e3 * mechanism.planet_radius))
    ax.set(xlim=(-1.12 * wide, 1.12 * wide), ylim=(-1.05 * reach, shaft + 1.05 * reach))
    ax.set_aspect("equal")
    ax.set_axis_off()
