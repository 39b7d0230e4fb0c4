"""Figure of the designs that meet a requirement."""

from matplotlib.figure import Figure

import escapement as esc
from escapement.plots import plot_designs
from pages import RUNS, drawn


@drawn
def design_front() -> Figure:
    """Greatest contact force against scatter of timers that run for thirty seconds."""
    requirement, _units = esc.load_requirement(RUNS / "thirty_seconds.toml")
    return plot_designs(esc.design(requirement))
