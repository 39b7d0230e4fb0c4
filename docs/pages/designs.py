"""Figure of the designs that meet a wish."""

from matplotlib.figure import Figure

import escapement as esc
from escapement.plots import plot_designs
from pages import RUNS, drawn


@drawn
def design_front() -> Figure:
    """Greatest contact force against scatter of timers that run for thirty seconds."""
    wish, _units = esc.load_wish(RUNS / "thirty_seconds.toml")
    return plot_designs(esc.design(wish))
