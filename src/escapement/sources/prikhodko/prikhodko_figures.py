"""Prikhodko's figures 3 and 6: velocity diagrams, and the position function."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.mechanisms import EllipticalPlanetary
from escapement.mechanisms.protocol import FloatArray
from escapement.outlines.gears import EllipticalOutline
from escapement.plots import drawing, style
from escapement.plots.planetary import draw_planetary

Law = Callable[[FloatArray], FloatArray]
"""A function from driver angles to the ordinates of a curve."""
Offsets = Sequence[tuple[float, float]]
LETTERS = "abcde"
_LENGTH = 0.75  # drawn length of a vector of 1 mm per radian of the input [mm]


def positions(mechanism: EllipticalPlanetary) -> FloatArray:
    """Driver angles of positions a to e [rad]: stop, rising, fastest, falling, stop.

    At b and d the planet has turned by a quarter relative to its carrier; the paper does not give
    these positions.
    """
    return np.linspace(*mechanism.breaks, len(LETTERS))


def plot_position_function(mechanism: EllipticalPlanetary) -> Axes:
    """Output angle over input angle, stops and positions a to e marked (figure 6)."""
    offsets = [(8.0, 8.0)] * len(LETTERS)
    ax = _curve(mechanism, lambda at: np.degrees(-mechanism.follower_angle(at)), 3.6, offsets)
    cell, step = math.degrees(mechanism.cell_angle), math.degrees(mechanism.follower_step)
    for stop in (0.5 * cell, 1.5 * cell):
        ax.axvline(stop, color=style.GREY, lw=0.7, ls=":", zorder=1.9)
    ax.set_title(f"{cell:.10g}° between stops, output −{step:.10g}°", fontsize=style.TICK_SIZE)
    ax.set(ylabel="Output angle φ₃ (°)")
    return ax


def plot_velocity_analogue(mechanism: EllipticalPlanetary) -> Axes:
    """Output over input speed, equation 9, over the same angles as figure 6."""
    offsets = [(0.0, 9.0) if letter == "c" else (9.0, -7.0) for letter in LETTERS]
    ax = _curve(mechanism, lambda at: -mechanism.transmission(at).g, 2.8, offsets)
    ax.axhline(0.0, color=style.BLACK, lw=0.6, zorder=1.9)
    ax.set(ylabel="Velocity analogue φ₃′")
    return ax


def _curve(mechanism: EllipticalPlanetary, read: Law, height: float, offsets: Offsets) -> Axes:
    """A curve over two cells, with positions a to e marked."""
    ax = style.new_axes(style.TWO_COLUMN, height)
    angle = np.linspace(0.0, 2.0 * mechanism.cell_angle, 721)
    marks = positions(mechanism) + mechanism.cell_angle
    ax.plot(np.degrees(angle), read(angle), color=style.BLUE, lw=1.5)
    angles, heights = np.degrees(marks), read(marks)
    ax.plot(angles, heights, "o", color=style.BLACK, ms=4, mfc="white", zorder=4)
    for letter, x, y, offset in zip(LETTERS, angles, heights, offsets, strict=True):
        style.annotate(ax, letter, (x, y), offset)
    ax.set(xlabel="Input angle φ₁ (°)", xlim=(0.0, math.degrees(angle[-1])))
    return ax


def plot_velocity_plans(mechanism: EllipticalPlanetary) -> Figure:
    """Diagrams of linear velocities over the gears in positions a to e (figure 3).

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
    handles = panels[0].get_lines()[-3:]
    style.add_legend(figure, 3, handles=handles, loc="outside lower center", handlelength=3.0)
    return figure


def _draw_plan(ax: Axes, mechanism: EllipticalPlanetary, theta: float) -> None:
    draw_planetary(ax, mechanism, theta, 0.5 * math.pi)
    rolling, shaft, contact = EllipticalOutline(mechanism).line_of_centres(theta)
    # the planet turns about the point where it rolls on the sun
    spin = 1.0 + mechanism.ratio
    lowest, at_contact = min(contact, rolling), spin * (contact - rolling)
    a, b, c, d = 0j, 1j * rolling, 1j * shaft, 1j * contact
    # speeds over omega_1 are lengths, and are drawn to the left
    c_end, d_end = c - _LENGTH * shaft, d - _LENGTH * at_contact
    planet_end = 1j * lowest - _LENGTH * spin * (lowest - rolling)
    lines = {
        "carrier, A C′": (style.LOOKS[5], a, c_end),
        "planet, B C′": (style.LOOKS[0], planet_end, c_end),
        "output, A D′": (style.LOOKS[1], a, d_end),
    }
    for name, (look, *ends) in lines.items():
        x, y = np.real(ends), np.imag(ends)
        ax.plot(x, y, color=look.color, ls=look.linestyle, lw=1.4, zorder=6, label=name)
    marks = {"A": (a, (8, -1)), "C": (c, (8, 3)), "C′": (c_end, (0, 8))}
    drawing.arrow(ax, np.array([c, c_end]))
    # B and D are apart except at a stop, where they share a label
    if at_contact < -1e-9 * shaft:
        marks |= {"D′": (d_end, (-1, 9)), "B": (b, (-7, 1)), "D": (d, (-8, -4))}
        drawing.arrow(ax, np.array([d, d_end]))
    else:
        marks["B, D"] = (b, (14, -1))
    for letters, (point, offset) in marks.items():
        style.annotate(ax, letters, (point.real, point.imag), offset)
    reach = 1e3 * mechanism.sun_radius
    wide = max(reach, _LENGTH * shaft, _LENGTH * spin * (reach - 1e3 * mechanism.planet_radius))
    drawing.dress_scene(ax, (-1.12 * wide, 1.12 * wide, -1.05 * reach, shaft + 1.05 * reach))
