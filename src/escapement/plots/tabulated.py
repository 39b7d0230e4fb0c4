"""The drawing of any mechanism; one without bodies is drawn as its transmission."""

from functools import singledispatch
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from escapement import validate
from escapement.mechanisms import Tabulated
from escapement.mechanisms.slotted import transmission
from escapement.model import FloatArray, is_mechanism
from escapement.plots import style

_SAMPLES = 721
_MOST_MARKS = 4000


@singledispatch
def plot_mechanism(mechanism: Any, theta: float = 0.0, ax: Axes | None = None) -> Axes:
    """Mechanism to scale, in any position; one without bodies as its transmission.

    The function for each class of mechanism is registered with `plot_mechanism.register`,
    and its docstring names what it draws.

    Parameters
    ----------
    mechanism : Mechanism
        What to draw.
    theta : float
        Driver angle [rad], of any size; it plays no part for a transmission.
    ax : Axes, optional
        Where to draw. Default: a new figure.

    Raises
    ------
    InvalidValue
        For what is no mechanism, or an angle that is not finite.
    """
    if not is_mechanism(mechanism):
        raise validate.fail("mechanism", "a mechanism", mechanism, "give for example Geneva(4)")
    if isinstance(mechanism, Tabulated):
        return plot_table(mechanism, ax)
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.2)
    angles = np.linspace(mechanism.breaks[0], mechanism.breaks[-1], _SAMPLES)
    _draw_transmission(ax, angles, transmission(mechanism.path, angles).g)
    return ax


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
    if mechanism.noise > 0.0:
        ax.fill_between(
            degrees, g - 2.0 * doubt, g + 2.0 * doubt, color=style.SKY, alpha=0.5, lw=0,
            label="± 2 standard deviations",
        )  # fmt: skip
    _draw_transmission(ax, theta, g)
    first = mechanism.breaks[0]
    rows = np.array(mechanism.theta)[:_MOST_MARKS]
    places = np.degrees(first + np.mod(rows - first, mechanism.cell_angle))
    low = float(min((g - 2.0 * doubt).min(), 0.0)) - 0.06 * float(np.ptp(g))
    ax.plot(places, np.full(places.size, low), "|", color=style.GREY, ms=5, mew=0.5, label="rows")
    style.legend_above(ax, 3)
    return ax


def _draw_transmission(ax: Axes, theta: FloatArray, g: FloatArray) -> None:
    degrees = np.degrees(theta)
    ax.axhline(0.0, color=style.BLACK, lw=0.6)
    ax.plot(degrees, g, color=style.BLUE, lw=1.4, label="transmission")
    ax.set(xlabel="Driver angle (°)", ylabel="Transmission g", xlim=(degrees[0], degrees[-1]))
