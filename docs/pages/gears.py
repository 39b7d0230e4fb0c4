"""Figures of gear-driven wheels."""

from matplotlib.figure import Figure

import escapement as esc
from escapement.plots.gear_driven import plot_curves, plot_gear_driven_examples, plot_row
from escapement.sources.dijksman.dijksman_figures import plot_design_charts, plot_motions
from pages import drawn


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
    shown = {}
    for n, m, curve, unused in (
        (12, 3, "epicycloid", 1),
        (12, 0, "epicycloid", 2),
        (12, "1/2", "hypocycloid", 1),
        (14, 1, "hypocycloid", 2),
    ):
        wheel = esc.GearDriven(n, m, curve, unused_lobes=unused)
        lobes = f"{unused} unused lobe{'s' * (unused > 1)}"
        shown[f"{n} stations, m = {m}\n{lobes}, {wheel.slots} slots"] = wheel
    return plot_row(shown, 0.2)


@drawn
def gear_escapements() -> Figure:
    """The gear-driven wheels with a pin always engaged."""
    shown = {}
    for n, curve, pins in (
        (12, "epicycloid", 6),
        (12, "pericycloid", 6),
        (24, "hypocycloid", 2),
        (24, "contracted-hypocycloid", 2),
    ):
        title = f"{curve.replace('-', ' ')}\n{n} stations, {pins} pins"
        shown[title] = esc.GearDriven(n, 5, curve, pins=pins)
    return plot_row(shown, 0.12)
