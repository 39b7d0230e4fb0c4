"""Torque of a drive at constant speed over the driver angle, reversals marked."""

import math
import re
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from escapement.base import validate
from escapement.base.units import SYSTEMS, factor, unit_name
from escapement.constant_speed import DriveTorque
from escapement.plots import style
from escapement.plots.style import finished, number_text, scaled

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
    ax.plot(x, y, "v", color=style.BLACK, ms=5, label="greatest torque", zorder=4, clip_on=False)
    # the moment is greater before the greatest torque than after it
    _write(ax, f"{number_text(y)} {unit} at {x:.2f}°", (x, y), 10.0, "right")
    reversals = np.degrees(result.reversals)
    if reversals.size:
        ax.plot(reversals, np.zeros_like(reversals), "o", ms=5, zorder=5, **style.REVERSAL)
    # a number goes above the axis or below it, or is left out
    room = {11.0: -math.inf, -11.0: -math.inf}
    for reversal in reversals.tolist():
        text, falls = f"{reversal:.2f}°", np.interp(reversal + 1.0, angle, moment) < 0.0
        wide = 2.0 * _half_width(ax, text)
        for above, end in room.items():
            # both curves pass the other side of the mark
            side = "left" if falls == (above > 0.0) else "right"
            start = reversal if side == "left" else reversal - wide
            if end < start:
                _write(ax, text, (reversal, 0.0), above, side)
                room[above] = start + wide
                break
    ax.margins(y=0.14)
    return finished(ax, ("driver angle from dead centre", "°"), ("torque", unit), 3, legend=legend)


def _half_width(ax: Axes, text: str) -> float:
    """About half the width of a text along the abscissa."""
    start, end = ax.get_xlim()
    points = 72.0 * ax.bbox.width / ax.figure.dpi
    return 0.3 * style.SMALL_SIZE * len(text) * (end - start) / points


def _write(ax: Axes, text: str, point: tuple[float, float], above: float, side: str) -> None:
    """A number some points above its mark, and within the ends of the abscissa.

    It begins at the mark if `side` is "left", and ends there if it is "right".
    """
    (start, end), half = ax.get_xlim(), _half_width(ax, text)
    if point[0] - start < 2.0 * half:
        side = "left"
    elif end - point[0] < 2.0 * half:
        side = "right"
    style.annotate(ax, re.sub(r"-(?=\d)", "−", text), point, (0.0, above), side)
