"""A motor over a motion: its speed and its torque, from rest to the steady state."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.base import validate
from escapement.dynamics.figures_of_merit import Figures
from escapement.dynamics.motion import Motion
from escapement.plots import style
from escapement.plots.motion_plots import times_of
from escapement.plots.style import finished, number_text, readable, scaled


def plot_motor(motion: Motion, figures: Figures | None = None) -> Figure:
    """Speed and torque of the motor that drives an escapement, against time.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns for an escapement with a motor.
    figures : Figures, optional
        What `escapement.terminal` returns for it: its effective torque is drawn too.

    Returns
    -------
    Figure
        Time [s]; above the speed of the motor [rad/s] with its no-load speed, below its torque
        [N m] with that at rest. Dotted lines are handoffs. Below zero, shaded, the mechanism
        drives the motor.

    Raises
    ------
    InvalidValue
        If no motor drives, or for a motion without length.
    """
    if motion.escapement.no_load_speed is None:
        rule, remedy = "of an escapement with a motor", "give torque=Motor(...)"
        raise validate.fail("motion", rule, "one without", remedy)
    times_of(motion)  # refuses a motion without length
    figure = style.new_figure(style.TWO_COLUMN, 4.4)
    above, below = (style.dress(ax) for ax in figure.subplots(2, 1, sharex=True))
    draw_motor(above, below, motion, figures)
    above.set_xlabel("")
    return figure


def draw_motor(above: Axes, below: Axes, motion: Motion, figures: Figures | None) -> None:
    """Draw speed and torque of the motor of a motion, see `plot_motor`."""
    escapement: Any = motion.escapement
    no_load, stall, times = escapement.no_load_speed, escapement.torque, times_of(motion)
    factor, unit = scaled("s", times)
    share = motion.at(times).theta_dot / escapement.referred["no_load_speed"]
    for ax in (above, below):
        ax.axhline(0.0, **style.ZERO)
        look: dict[str, Any] = {"color": style.LIGHT_GREY, "lw": 0.7, "ls": ":", "zorder": 0}
        ax.vlines(
            motion.handoff_times * factor, 0.0, 1.0, transform=ax.get_xaxis_transform(), **look
        )
        ax.set_xlim(0.0, motion.end_time * factor)
    above.plot(times * factor, share * no_load, color=style.BLUE, label="motor")
    text = f"no-load speed, {number_text(no_load)} rad/s"
    above.axhline(no_load, lw=1.0, label=text, **style.BROKEN)
    finished(above, ("time", unit), ("speed of the motor", "rad/s"), 2)
    prefix, torque_unit = readable("torque", np.array([stall]))
    x, torque = times * factor, prefix * stall * (1.0 - share)
    below.plot(x, torque, color=style.BLUE, label="motor")
    if (torque < 0.0).any():
        below.fill_between(x, torque, 0.0, where=torque < 0.0, label="driven", **style.SHADE)
    text = f"at rest, {number_text(prefix * stall)} {torque_unit}"
    below.axhline(prefix * stall, lw=1.0, label=text, **style.BROKEN)
    if figures is not None:
        effective = prefix * figures.motor_torque_rms
        text = f"effective in the steady state, {number_text(effective)} {torque_unit}"
        below.axhline(effective, color=style.BLACK, lw=1.0, ls=(0, (1, 1.5)), label=text)
    finished(below, ("time", unit), ("torque of the motor", torque_unit), 3)
