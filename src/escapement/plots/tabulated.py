"""What a table of a mechanism says: its rows, its transmission, and the doubt about it."""

import numpy as np
from matplotlib.axes import Axes

from escapement.mechanisms import Tabulated
from escapement.plots import style

_SAMPLES = 721
_MOST_MARKS = 4000


def plot_table(mechanism: Tabulated, ax: Axes | None = None) -> Axes:
    """Transmission over a cell, with twice its standard deviation, and the rows.

    Parameters
    ----------
    mechanism : Tabulated
        What to show.
    ax : Axes, optional
        Where to draw. Rows are ticks at the foot, at the driver angles they have
        within the cell. Default: a new figure.
    """
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.2)
    theta = np.linspace(*mechanism.breaks, _SAMPLES)
    g, doubt = mechanism.transmission(theta).g, mechanism.deviation(theta).g
    degrees = np.degrees(theta)
    ax.axhline(0.0, color=style.BLACK, lw=0.6)
    if mechanism.noise > 0.0:
        ax.fill_between(
            degrees, g - 2.0 * doubt, g + 2.0 * doubt, color=style.SKY, alpha=0.5, lw=0,
            label="± 2 standard deviations",
        )  # fmt: skip
    ax.plot(degrees, g, color=style.BLUE, lw=1.4, label="transmission")
    first = mechanism.breaks[0]
    rows = np.array(mechanism.theta)[:_MOST_MARKS]
    places = np.degrees(first + np.mod(rows - first, mechanism.cell_angle))
    low = float(min((g - 2.0 * doubt).min(), 0.0)) - 0.06 * float(np.ptp(g))
    ax.plot(places, np.full(places.size, low), "|", color=style.GREY, ms=5, mew=0.5, label="rows")
    ax.set(xlabel="Driver angle (°)", ylabel="Transmission g", xlim=(degrees[0], degrees[-1]))
    style.legend_above(ax, 3)
    return ax
