"""Figure of a timer that runs down."""

from matplotlib.figure import Figure

from escapement.engines.run_down import Rundown
from escapement.plots import style
from escapement.plots.style import finished, readable, scaled


def plot_rundown(run: Rundown) -> Figure:
    """Mean speed and lateness against driver turns.

    Parameters
    ----------
    run : Rundown
        What `escapement.rundown` returns.

    Returns
    -------
    Figure
        Above, the mean driver speed over each engagement [rad/s] and that of the nominal
        period; below, by how much the timer is late [s, or ms where that is short].
    """
    figure = style.new_figure(style.ONE_COLUMN, 4.2)
    above, below = style.new_panels(figure, 2)
    nominal = run.escapement.mechanism.cell_angle / run.nominal_period
    size, speed = readable("speed", run.mean_speeds)
    above.plot(run.turns, run.mean_speeds * size, color=style.BLUE, label="mean over an engagement")
    above.axhline(nominal * size, label="at the torque of the start", **style.BROKEN)
    factor, unit = scaled("s", run.lateness)
    below.axhline(0.0, **style.ZERO)
    below.plot(run.turns, run.lateness * factor, color=style.BLUE)
    for ax in (above, below):
        ax.axvline(run.end_turns, color=style.GREY, lw=0.8, ls=":", label="end of the run")
    finished(above, ("", ""), ("mean speed", speed), 1)
    finished(below, ("driver turns", ""), ("lateness", unit), 1, legend=False)
    return figure
