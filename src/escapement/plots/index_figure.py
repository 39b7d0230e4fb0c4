"""Indexing drives at constant speed in four panels: motion, torque, force, ringing."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.base import validate
from escapement.base.text import words
from escapement.base.units import SYSTEMS, factor, printed, unit_name
from escapement.constant_speed import IndexingDrive, IndexState
from escapement.dynamics.motion import Motion
from escapement.plots import style
from escapement.plots.motor_panels import draw_motor
from escapement.plots.style import finished, number_text, scaled

_SAMPLES = 800
_ANGLE = ("driver angle", "°")
Shown = tuple[IndexingDrive, IndexState, style.Look]
"""A drive, its states over the index, and how they are drawn."""


def plot_index(
    result: IndexingDrive,
    *,
    against: IndexingDrive | None = None,
    motor: Motion | None = None,
    units: str = SYSTEMS[0],
) -> Figure:
    """What an indexing drive does in a cycle, alone or beside another one.

    Parameters
    ----------
    result : IndexingDrive
        What `escapement.index` returns.
    against : IndexingDrive, optional
        Another one to draw beside it, as `escapement.cam_drive` makes it.
    motor : Motion, optional
        A motion of what its `driven_by` makes, to draw speed and torque of the motor.
    units : str
        A system of units, as of the command line.

    Returns
    -------
    Figure
        Over the driver angle from the middle of the index [degrees]: position, speed and
        acceleration of the follower, each as a share of its greatest value, or of two drives the
        accelerations; the torque of the drive with its mean and root mean square over the cycle;
        the force on the pin, or the moment on the follower without a crank radius, with reversals
        and impacts. Of a load that repeats in a turn of the follower the index with the greatest
        torque is drawn. Over the time [s]: the deflection of a load on an elastic shaft, with the
        dwell shaded; and what `plot_motor` draws of a motor.
    """
    drives = [result] if against is None else [result, against]
    if not all(isinstance(one, IndexingDrive) for one in drives):
        raise validate.fail("result", "an IndexingDrive", result, "give what index returns")
    validate.choice("units", units, SYSTEMS)
    rings = result.load_frequency > 0.0
    rows = 1 + rings + (motor is not None)
    figure = style.new_figure(style.TWO_COLUMN, 2.7 * rows)
    grid = figure.add_gridspec(rows, 3)
    axes = [style.dress(figure.add_subplot(grid[0, column])) for column in range(3)]
    shown: list[Shown] = []
    for one, look in zip(drives, style.LOOKS, strict=False):
        entry, exit_ = one.mechanism.breaks[0], one.mechanism.breaks[-1]
        begin = one.hardest * one.mechanism.cell_angle
        shown.append((one, one.at(begin + np.linspace(entry, exit_, _SAMPLES)), look))
    if against is None:
        _draw_motion(axes[0], *shown[0][:2], units)
    else:
        _draw_accelerations(axes[0], shown)
    _draw_torque(axes[1], shown, units)
    _draw_force(axes[2], shown, units)
    reach = math.degrees(0.5 * (result.mechanism.breaks[-1] - result.mechanism.breaks[0]))
    for ax in axes:
        ax.axhline(0.0, **style.ZERO)
        ax.set_xlim(-reach, reach)
    if rings:
        _draw_ringing(style.dress(figure.add_subplot(grid[1, :])), shown, units)
    if motor is not None:
        halves = grid[-1, :].subgridspec(1, 2)
        above, below = (style.dress(figure.add_subplot(halves[0, k])) for k in range(2))
        draw_motor(above, below, motor, None)
    return figure


def _name(drive: IndexingDrive) -> str:
    law = getattr(drive.mechanism, "law", None)
    return words(drive.mechanism.kind) if law is None else f"cam, {words(law)}"


def _degrees(drive: IndexingDrive, theta: Any) -> Any:
    """Driver angles from the middle of the index that is drawn, in degrees."""
    wheel = drive.mechanism
    middle = drive.hardest * wheel.cell_angle + 0.5 * (wheel.breaks[0] + wheel.breaks[-1])
    return np.degrees(theta - middle)


def _draw_motion(ax: Axes, drive: IndexingDrive, state: IndexState, units: str) -> None:
    """Position, speed and acceleration of the follower, each over its greatest value."""
    turned = state.phi - state.phi[0]
    fastest = float(np.abs(state.phi_dot).max()) / factor("speed", units)
    curves = (
        (turned, f"position, {number_text(math.degrees(abs(turned[-1])))}°"),
        (state.phi_dot, f"speed, {number_text(fastest)} {printed('speed', units)}"),
        (state.phi_ddot, f"acceleration, {number_text(np.abs(state.phi_ddot).max())} rad/s²"),
    )
    for (values, name), look in zip(curves, style.LOOKS, strict=False):
        greatest = float(np.abs(values).max()) or 1.0
        angle = _degrees(drive, state.theta)
        ax.plot(angle, values / greatest, color=look.color, ls=look.linestyle, label=name)
    finished(ax, _ANGLE, ("share of the greatest value", ""), 1)


def _draw_accelerations(ax: Axes, shown: Sequence[Shown]) -> None:
    """Acceleration of the follower of each drive."""
    for drive, state, look in shown:
        angle = _degrees(drive, state.theta)
        ax.plot(angle, state.phi_ddot, color=look.color, ls=look.linestyle, label=_name(drive))
    finished(ax, _ANGLE, ("acceleration", "rad/s²"), 1)


def _draw_torque(ax: Axes, shown: Sequence[Shown], units: str) -> None:
    """Torque of the drive, and its mean and root mean square over the cycle."""
    size = factor("torque", units)
    every = np.concatenate([state.torque for _, state, _ in shown])
    prefix, unit = scaled(unit_name("torque", units), every / size)
    for drive, state, look in shown:
        angle, values = _degrees(drive, state.theta), state.torque / size * prefix
        ax.plot(angle, values, color=look.color, ls=look.linestyle)
        lines = (("rms of cycle", drive.torque_rms, (1, 1.5)),)
        lines += (("mean of cycle", drive.torque_mean_cycle, (4, 2)),) * (len(shown) == 1)
        color = style.BLACK if len(shown) == 1 else look.color
        for name, value, dashes in reversed(lines):
            value = value / size * prefix
            text = f"{name}, {number_text(float(value))} {unit}"
            ax.axhline(value, color=color, lw=1.0, ls=(0, dashes), label=text)
    finished(ax, _ANGLE, ("drive torque", unit), 1)


def _draw_force(ax: Axes, shown: Sequence[Shown], units: str) -> None:
    """Force on the pin or moment on the follower of each drive; walls, reversals and impacts."""
    forces = all(bool(np.isfinite(state.contact_force).all()) for _, state, _ in shown)
    kind, name = ("force", "force on the pin") if forces else ("torque", "moment on the follower")
    sizes = [np.abs(s.contact_force if forces else s.contact_moment) for _, s, _ in shown]
    prefix, unit = scaled(unit_name(kind, units), np.concatenate(sizes) / factor(kind, units))
    for (drive, state, look), size in zip(shown, sizes, strict=True):
        angle, values = _degrees(drive, state.theta), size / factor(kind, units) * prefix
        known = _name(drive) if len(shown) > 1 else "_"
        ax.plot(angle, values, color=look.color, ls=look.linestyle, label=known)
    drive, state, _ = shown[0]
    values = sizes[0] / factor(kind, units) * prefix
    _mark_walls(ax, drive, _degrees(drive, state.theta), values, state.contact_moment < 0.0)
    some = any(not str(x.get_label()).startswith("_") for x in (*ax.lines, *ax.collections))
    finished(ax, _ANGLE, (name, unit), 1, legend=some)


def _mark_walls(ax: Axes, drive: IndexingDrive, angle: Any, values: Any, rear: Any) -> None:
    """Shade where the rear wall carries the force, and mark reversals and impacts."""
    if rear.any():
        across: dict[str, Any] = {"transform": ax.get_xaxis_transform(), "zorder": 0}
        across |= {"where": rear, "label": "follower pushes the pin", **style.SHADE}
        ax.fill_between(angle, 0.0, 1.0, **across)
    at = _degrees(drive, drive.reversals)
    at = at[(at >= angle[0]) & (at <= angle[-1])]
    if at.size:
        ax.plot(at, np.zeros_like(at), "o", ms=5, zorder=5, **style.REVERSAL)
    impacts = _degrees(drive, np.array([drive.entry_impact_angle, drive.reversal_impact_angle]))
    # of several indexes only those in the one that is drawn
    impacts = impacts[(impacts >= angle[0]) & (impacts <= angle[-1])]
    if impacts.size:
        heights = np.interp(impacts, angle, values)
        ax.plot(impacts, heights, "x", color=style.VERMILLION, ms=7, mew=1.6, label="impact")


def _draw_ringing(ax: Axes, shown: Sequence[Shown], units: str) -> None:
    """Deflection of the load over a cycle, the tolerance, and the dwell shaded."""
    first = shown[0][0]
    in_degrees = printed("angle", units) != "rad"
    size, unit = (180.0 / math.pi, "°") if in_degrees else (1e3, "mrad")
    dwell: dict[str, Any] = {"label": "dwell", **style.SHADE}
    if first.dwell_time > 0.0:
        ax.axvspan(first.index_time, first.cycle_time, **dwell)
    ax.axhline(0.0, **style.ZERO)
    for drive, _, look in shown:
        entry = drive.mechanism.breaks[0]
        theta = np.linspace(entry, entry + drive.mechanism.cell_angle, 5 * _SAMPLES)
        time, deflection = (theta - entry) / drive.speed, size * drive.at(theta).deflection
        name = "angle of the load minus that of the wheel" if len(shown) == 1 else _name(drive)
        ax.plot(time, deflection, color=look.color, ls=look.linestyle, lw=1.2, label=name)
    bound = size * first.load_tolerance
    for side in (-bound, bound):
        name = f"tolerance, ±{number_text(bound)} {unit}" if side > 0.0 else "_"
        ax.axhline(side, label=name, lw=1.0, **(style.BROKEN | {"color": style.GREEN}))
    ax.set_xlim(0.0, first.cycle_time)
    finished(ax, ("time", "s"), ("deflection", unit), 4)
