"""Figures and drawings to scale: data in, matplotlib axes out.

Functions named after one panel draw into the axes they are given, or into a new
figure of their own; nothing is shown on a screen. `save` writes a figure.
"""

from collections.abc import Callable
from typing import Any

from matplotlib.axes import Axes

from escapement.plots.animation import animate
from escapement.plots.drive_torque import plot_drive_torque
from escapement.plots.gear_driven import plot_gear_driven
from escapement.plots.geneva import plot_configurations, plot_mechanism
from escapement.plots.measurement import (
    plot_error_histogram,
    plot_errors,
    plot_frequencies,
    plot_measurement,
    plot_periodogram,
    plot_positions,
)
from escapement.plots.motion import plot_contact_moment, plot_phase_portrait, plot_velocities
from escapement.plots.planetary import plot_planetary
from escapement.plots.sample import plot_sample, plot_spread
from escapement.plots.saving import save
from escapement.plots.study import plot_lines, plot_map, plot_rise_and_terminal, plot_study
from escapement.plots.style import new_axes
from escapement.plots.tabulated import plot_table

DRAWINGS: dict[str, Callable[[Any, float], Axes]] = {
    "geneva": plot_mechanism,
    "gear-driven": plot_gear_driven,
    "elliptical-planetary": plot_planetary,
    "tabulated": lambda mechanism, _: plot_table(mechanism),
}
"""What draws each kind of mechanism at a driver angle [rad], which plays no part for a table."""

__all__ = [
    "DRAWINGS",
    "animate",
    "new_axes",
    "plot_configurations",
    "plot_contact_moment",
    "plot_drive_torque",
    "plot_error_histogram",
    "plot_errors",
    "plot_frequencies",
    "plot_gear_driven",
    "plot_lines",
    "plot_map",
    "plot_measurement",
    "plot_mechanism",
    "plot_periodogram",
    "plot_phase_portrait",
    "plot_planetary",
    "plot_positions",
    "plot_rise_and_terminal",
    "plot_sample",
    "plot_spread",
    "plot_study",
    "plot_table",
    "plot_velocities",
    "save",
]
