"""The figure of a wish and the designs that meet it."""

from matplotlib.figure import Figure

import escapement as esc
from escapement.plots import plot_designs
from pages import RUNS, drawn


@drawn
def design_front() -> Figure:
    """Scatter and force of the timers of thirty seconds."""
    wish, _units = esc.load_wish(RUNS / "thirty_seconds.toml")
    return plot_designs(esc.design(wish))
