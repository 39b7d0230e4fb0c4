"""Torque of a drive at constant speed over the driver angle, reversals marked."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from escapement import validate
from escapement.constant_speed import DriveTorque
from escapement.plots import style
from escapement.plots.style import label, number_text, scaled
from escapement.units import SYSTEMS, factor, unit_name

_ROUNDING = 1e-9  # of the greatest moment: less is none


def plot_drive_torque(
    result: DriveTorque, ax: Axes | None = None, *, units: str = SYSTEMS[0]
) -> Axes:
    """Drive torque over one engagement, with its maximum, mean and pin reversals.

    Parameters
    ----------
    result : DriveTorque
        What `escapement.drive_torque` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure across two columns.
    units : str
        "SI" or "in-lbf-s".

    Returns
    -------
    Axes
        Driver angle from dead centre [degrees] and torque [N m or in-lbf], in SI
        with the prefix that suits. Shaded: the follower pushes the pin. The broken line is the
        mean over the first half; thin: the moment of the pin on the follower.

    Source: Filemon (1960), figures 7 and 8.
    """
    if not isinstance(result, DriveTorque):
        raise validate.fail(
            "result", "a DriveTorque", result, "give what escapement.drive_torque returns"
        )
    validate.choice("units", units, SYSTEMS)
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.2)
    state = result.samples
    angle = np.degrees(state.theta)
    own = factor("torque", units)
    moments = np.array([state.torque, state.contact_moment]) / own
    prefix, unit = scaled(unit_name("torque", units), moments)
    scale = prefix / own
    ax.axhline(0.0, color=style.BLACK, lw=0.6)
    # the samples hold the reversals, where rounding decides the sign
    pushed = state.contact_moment <= _ROUNDING * np.abs(state.contact_moment).max()
    if np.any(pushed[1:] & pushed[:-1]):
        ax.fill_between(
            angle, 0.0, 1.0, where=pushed, transform=ax.get_xaxis_transform(), color=style.SKY,
            alpha=0.22, lw=0, label="follower pushes the pin", zorder=0,
        )  # fmt: skip
    ax.plot(angle, state.torque * scale, color=style.BLUE, lw=1.6, label="drive torque")
    ax.plot(
        angle, state.contact_moment * scale, color=style.VERMILLION, lw=0.8,
        ls=style.LOOKS[1].linestyle, label="moment on the follower",
    )  # fmt: skip
    ax.plot(
        [angle[0], math.degrees(result.half)], [result.torque_mean * scale] * 2,
        color=style.BLACK, lw=1.0, ls=(0, (4, 2)), label="mean of the first half",
    )  # fmt: skip
    ax.set_xlim(angle[0], angle[-1])
    x, y = math.degrees(result.torque_max_angle), result.torque_max * scale
    ax.plot(x, y, "v", color=style.BLACK, ms=5, label="greatest torque", zorder=4, clip_on=False)
    _write(ax, f"{number_text(y)} {unit} at {x:.2f}°", (x, y), 10.0)
    _mark_reversals(ax, result)
    ax.set(xlabel=label("driver angle from dead centre", "°"), ylabel=label("torque", unit))
    ax.margins(y=0.14)
    style.legend_above(ax, 3)
    return ax


def _mark_reversals(ax: Axes, result: DriveTorque) -> None:
    marks: dict[str, Any] = {"mfc": "white", "mec": style.BLACK, "mew": 0.9, "zorder": 5}
    found = np.degrees(result.reversals)
    if found.size:
        ax.plot(found, np.zeros_like(found), "o", ms=5, label="pin reversal", **marks)
    ends = {11.0: -math.inf, -11.0: -math.inf}
    for place in found.tolist():
        text = f"{place:.2f}°"
        half = _half_width(ax, text)
        free = [side for side, end in ends.items() if place - half > end]
        if free:  # the number goes above the axis or below it, or is left out
            _write(ax, text, (place, 0.0), free[0])
            ends[free[0]] = place + half


def _write(ax: Axes, text: str, place: tuple[float, float], above: float) -> None:
    """A number some points above its mark; not over the ends of the abscissa."""
    start, end = ax.get_xlim()
    half = _half_width(ax, text)
    side = "left" if place[0] - start < half else "right" if end - place[0] < half else "center"
    style.annotate(ax, text.replace("-", "−"), place, (0.0, above), side)


def _half_width(ax: Axes, text: str) -> float:
    """About half the width of a number, along the abscissa."""
    start, end = ax.get_xlim()
    points = 72.0 * ax.bbox.width / ax.figure.dpi
    return 0.3 * style.SMALL_SIZE * len(text) * (end - start) / points
