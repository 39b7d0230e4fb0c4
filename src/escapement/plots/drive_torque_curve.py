"""Torque of a drive at constant speed over the driver angle, reversals marked."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from escapement.base import validate
from escapement.base.units import SYSTEMS, factor, unit_name
from escapement.constant_speed import DriveTorque
from escapement.plots import style
from escapement.plots.style import finished, number_text, scaled

_MOST = 4  # so many reversals have room in the legend
_ROUNDING = 1e-9  # a moment below this share of the greatest counts as zero


def plot_drive_torque(
    result: DriveTorque, ax: Axes | None = None, *, units: str = SYSTEMS[0], legend: bool = True
) -> Axes:
    """Drive torque over one engagement, with its maximum, mean and pin reversals.

    Parameters
    ----------
    result : DriveTorque
        What `escapement.drive_torque` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure across two columns.
    legend : bool
        Whether to draw one.
    units : str
        A system of units, as of the command line.

    Returns
    -------
    Axes
        Driver angle from dead centre [degrees] and torque [N m or in-lbf], in SI
        with the prefix that suits. Shaded: the follower pushes the pin. The broken line is the
        mean over the first half; thin: the moment of the pin on the follower.

    Source: Filemon (1960), figures 7 and 8.
    """
    if not isinstance(result, DriveTorque):
        raise validate.fail("result", "a DriveTorque", result, "give what drive_torque returns")
    validate.choice("units", units, SYSTEMS)
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.2)
    state = result.samples
    angle = np.degrees(state.theta)
    torque_unit = factor("torque", units)
    moments = np.array([state.torque, state.contact_moment]) / torque_unit
    prefix, unit = scaled(unit_name("torque", units), moments)
    torque, moment = moments * prefix
    ax.axhline(0.0, **style.ZERO)
    # the samples hold the reversals, where rounding decides the sign
    pushed = moment <= _ROUNDING * np.abs(moment).max()
    if np.any(pushed[1:] & pushed[:-1]):
        across: dict[str, Any] = {"transform": ax.get_xaxis_transform(), "zorder": 0}
        across |= {"where": pushed, "label": "follower pushes the pin", **style.SHADE}
        ax.fill_between(angle, 0.0, 1.0, **across)
    ax.plot(angle, torque, color=style.BLUE, lw=1.6, label="drive torque")
    ax.plot(angle, moment, lw=0.8, label="moment on the follower", **style.BROKEN)
    ends, mean = [angle[0], math.degrees(result.half)], result.torque_mean * prefix / torque_unit
    dashed: dict[str, Any] = {"color": style.BLACK, "lw": 1.0, "ls": (0, (4, 2))}
    ax.plot(ends, [mean, mean], label="mean of the first half", **dashed)
    ax.set_xlim(angle[0], angle[-1])
    x, y = math.degrees(result.torque_max_angle), result.torque_max * prefix / torque_unit
    text = f"greatest torque, {number_text(y)} {unit} at {_angles([x])}"
    ax.plot(x, y, "v", color=style.BLACK, ms=5, label=text, zorder=4, clip_on=False)
    reversals = np.degrees(result.reversals)
    if reversals.size:
        look = style.REVERSAL | {"label": f"pin reversal at {_angles(reversals[:_MOST])}"}
        ax.plot(reversals, np.zeros_like(reversals), "o", ms=5, zorder=5, **look)
    ax.margins(y=0.14)
    return finished(ax, ("driver angle from dead centre", "°"), ("torque", unit), 2, legend=legend)


def _angles(values: Iterable[float]) -> str:
    """Angles in degrees, with the sign as printed."""
    return ", ".join(f"{value:.2f}°" for value in values).replace("-", "−")
