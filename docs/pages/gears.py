"""Figures of gear-driven wheels."""

from matplotlib.figure import Figure

import escapement as esc
from escapement.plots.gear_driven import (
    plot_curves,
    plot_gear_driven,
    plot_gear_driven_examples,
)
from escapement.sources.dijksman.figures import plot_design_charts, plot_motions
from pages import drawn, panels


@drawn
def gear_driven() -> Figure:
    """Dijksman's figures 6 to 9."""
    return plot_gear_driven_examples()


@drawn
def gear_curves() -> Figure:
    """The four cycloids."""
    return plot_curves()


@drawn
def gear_charts() -> Figure:
    """Ratio of times over lobes."""
    return plot_design_charts()


@drawn
def gear_motions() -> Figure:
    """Motions of twelve stations, beside ordinary wheels."""
    return plot_motions()


@drawn
def gear_unused() -> Figure:
    """Wheels with fewer slots than lobes that pass."""
    wheels = (
        (12, 3, "epicycloid", 1),
        (12, 0, "epicycloid", 2),
        (12, "1/2", "hypocycloid", 1),
        (14, 1, "hypocycloid", 2),
    )
    figure, axes = panels(4, 2.2)
    for ax, (n, m, curve, unused) in zip(axes, wheels, strict=True):
        wheel = esc.GearDriven(n, m, curve, unused_lobes=unused)
        plot_gear_driven(wheel, 0.2, ax)
        ax.set_title(f"n = {n}, m = {m}\n{unused} unused, {wheel.slots} slots", fontsize=8)
    return figure


@drawn
def gear_escapements() -> Figure:
    """The gear-driven wheels with a pin always engaged."""
    wheels = (
        (12, "epicycloid", 6),
        (12, "pericycloid", 6),
        (24, "hypocycloid", 2),
        (24, "contracted-hypocycloid", 2),
    )
    figure, axes = panels(4, 2.2)
    for ax, (n, curve, pins) in zip(axes, wheels, strict=True):
        plot_gear_driven(esc.GearDriven(n, 5, curve, pins=pins), 0.12, ax)
        ax.set_title(f"{curve}\n{n} stations, {pins} pins", fontsize=8)
    return figure
