"""Functions that the figures of the pages share, and the list of figures by file name."""

from collections.abc import Callable
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

import escapement as esc
from escapement.base.units import INCH_POUND
from escapement.plots.style import LOOKS
from escapement.sources import meyer

RUNS = Path(__file__).resolve().parents[2] / "runs"
LINES = tuple(look[:2] for look in LOOKS)
"""Colour and line style of curves: those of the package's own figures."""

FIGURES: dict[str, Callable[[], Figure]] = {}


def drawn(make: Callable[[], Figure]) -> Callable[[], Figure]:
    """Add a figure to the list, under the name of its function."""
    FIGURES[f"{make.__name__}.png"] = make
    return make


def timer(slots: int, friction: float, torque: float) -> esc.Escapement:
    """A mechanism of Meyer's thesis; torque in in-lbf."""
    driver, follower = (inertia * INCH_POUND for inertia in meyer.INERTIAS[slots])
    return esc.Escapement(
        esc.Geneva(slots), esc.Inertia(driver, follower), torque * INCH_POUND, friction
    )


def panels(count: int, height: float) -> tuple[Figure, list[Axes]]:
    """Panels side by side, with ticks as in the package's own figures."""
    figure = Figure(figsize=(7.2, height), layout="constrained")
    axes = figure.subplots(1, count)
    for ax in axes:
        ax.tick_params(direction="in", top=True, right=True)
    return figure, list(axes)
