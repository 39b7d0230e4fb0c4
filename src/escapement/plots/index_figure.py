"""An indexing drive at constant speed in four panels: motion, torque, force, ringing."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.base import validate
from escapement.base.units import SYSTEMS, factor, unit_name
from escapement.constant_speed import IndexingDrive, IndexState
from escapement.plots import style
from escapement.plots.style import finished, number_text, scaled

_SAMPLES = 800


def plot_index(result: IndexingDrive, *, units: str = SYSTEMS[0]) -> Figure:
    """What an indexing drive does in a cycle.

    Parameters
    ----------
    result : IndexingDrive
        What `escapement.index` returns.
    units : str
        "SI" or "in-lbf-s".

    Returns
    -------
    Figure
        Over the driver angle from dead centre [degrees]: position, speed and acceleration of the
        follower, each as a share of its greatest value; the torque of the drive with its mean and
        root mean square over the cycle; the force on the pin, or the moment on the follower
        without a crank radius, with reversals and impacts. Over the time [s]: the deflection of a
        load on an elastic shaft, with the dwell shaded.
    """
    if not isinstance(result, IndexingDrive):
        raise validate.fail("result", "an IndexingDrive", result, "give what index returns")
    validate.choice("units", units, SYSTEMS)
    rings = result.load_frequency > 0.0
    figure = style.new_figure(style.TWO_COLUMN, 5.4 if rings else 2.7)
    grid = figure.add_gridspec(2 if rings else 1, 3)
    axes = [style.dress(figure.add_subplot(grid[0, column])) for column in range(3)]
    entry, exit_ = result.mechanism.breaks[0], result.mechanism.breaks[-1]
    state = result.at(np.linspace(entry, exit_, _SAMPLES))
    _draw_motion(axes[0], state)
    _draw_torque(axes[1], result, state, units)
    _draw_force(axes[2], result, state, units)
    for ax in axes:
        ax.axhline(0.0, **style.ZERO)
        ax.set_xlim(*np.degrees([entry, exit_]))
    if rings:
        _draw_ringing(style.dress(figure.add_subplot(grid[1, :])), result)
    return figure


_ANGLE = ("driver angle", "°")


def _draw_motion(ax: Axes, state: IndexState) -> None:
    """Position, speed and acceleration of the follower, each over its greatest value."""
    angle = np.degrees(state.theta)
    turned = state.phi - state.phi[0]
    curves = (
        (turned, f"position, {number_text(math.degrees(abs(turned[-1])))}°"),
        (state.phi_dot, f"speed, {number_text(np.abs(state.phi_dot).max())} rad/s"),
        (state.phi_ddot, f"acceleration, {number_text(np.abs(state.phi_ddot).max())} rad/s²"),
    )
    for (values, name), look in zip(curves, style.LOOKS, strict=False):
        greatest = float(np.abs(values).max()) or 1.0
        ax.plot(angle, values / greatest, color=look.color, ls=look.linestyle, label=name)
    finished(ax, _ANGLE, ("share of the greatest value", ""), 1)


def _draw_torque(ax: Axes, result: IndexingDrive, state: IndexState, units: str) -> None:
    """Torque of the drive, its mean and its root mean square over the cycle."""
    numbers = np.array([result.torque_mean_cycle, result.torque_rms])
    size = factor("torque", units)
    prefix, unit = scaled(unit_name("torque", units), state.torque / size)
    ax.plot(np.degrees(state.theta), state.torque / size * prefix, color=style.BLUE)
    for value, name, dashes in zip(
        numbers / size * prefix, ("mean of cycle", "rms of cycle"), ((4, 2), (1, 1.5)), strict=True
    ):
        text = f"{name}, {number_text(float(value))} {unit}"
        ax.axhline(value, color=style.BLACK, lw=1.0, ls=(0, dashes), label=text)
    finished(ax, _ANGLE, ("drive torque", unit), 1)


def _draw_force(ax: Axes, result: IndexingDrive, state: IndexState, units: str) -> None:
    """Force on the pin or moment on the follower; walls, reversals and impacts."""
    forces = bool(np.isfinite(state.contact_force).all())
    kind = "force" if forces else "torque"
    values = state.contact_force if forces else np.abs(state.contact_moment)
    prefix, unit = scaled(unit_name(kind, units), values / factor(kind, units))
    angle, values = np.degrees(state.theta), values / factor(kind, units) * prefix
    ax.plot(angle, values, color=style.BLUE)
    rear = state.contact_moment < 0.0
    if rear.any():
        across: dict[str, Any] = {"transform": ax.get_xaxis_transform(), "zorder": 0}
        ax.fill_between(
            angle, 0.0, 1.0, where=rear, label="follower pushes the pin", **across, **style.SHADE
        )
    reversals = np.degrees(result.reversals)
    if reversals.size:
        ax.plot(reversals, np.zeros_like(reversals), "o", ms=5, zorder=5, **style.REVERSAL)
    impacts = np.degrees([result.entry_impact_angle, result.reversal_impact_angle])
    impacts = impacts[np.isfinite(impacts)]
    if impacts.size:
        heights = np.interp(impacts, angle, values)
        ax.plot(impacts, heights, "x", color=style.VERMILLION, ms=7, mew=1.6, label="impact")
    name = "force on the pin" if forces else "moment on the follower"
    finished(ax, _ANGLE, (name, unit), 1)


def _draw_ringing(ax: Axes, result: IndexingDrive) -> None:
    """Deflection of the load over a cycle, the tolerance, and the dwell shaded."""
    entry = result.mechanism.breaks[0]
    end = entry + result.mechanism.cell_angle
    theta = np.linspace(entry, end, 5 * _SAMPLES)
    time = (theta - entry) / result.speed
    deflection = 1e3 * result.at(theta).deflection
    dwell: dict[str, Any] = {"label": "dwell", **style.SHADE}
    if result.dwell_time > 0.0:
        ax.axvspan(result.index_time, result.cycle_time, **dwell)
    ax.axhline(0.0, **style.ZERO)
    ax.plot(
        time, deflection, color=style.BLUE, lw=1.2, label="angle of the load less that of the wheel"
    )
    bound = 1e3 * result.load_tolerance
    for side in (-bound, bound):
        name = f"tolerance, ±{number_text(bound)} mrad" if side > 0.0 else "_"
        ax.axhline(side, label=name, lw=1.0, **style.BROKEN)
    ax.set_xlim(0.0, result.cycle_time)
    finished(ax, ("time", "s"), ("deflection", "mrad"), 3)
