"""Figure of the effect of a drawing's tolerances."""

from matplotlib.figure import Figure

import escapement as esc
from escapement.plots import plot_budget
from pages import drawn

WHEEL = esc.Geneva(4, crank_radius=0.010, pin_radius=0.0005)
TIMER = esc.Escapement(WHEEL, esc.Inertia(3.39e-7, 5.65e-6), torque=0.0113, friction=0.20)
TOLERANCES = {
    "friction": {"low": 0.15, "high": 0.25},
    "torque": {"low": 0.8 * 0.0113, "high": 0.0113},
    "centre_distance_error": {"tolerance": 50e-6},
}


@drawn
def tolerance_budget() -> Figure:
    """Contributors to the scatter of the period, and the sample."""
    limits = {"period": (0.034, 0.040)}
    return plot_budget(esc.budget(TIMER, TOLERANCES, limits=limits, size=20_000, seed=1))
