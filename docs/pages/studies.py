"""Figures of studies, and of Meyer's thesis beside them."""

import numpy as np
from matplotlib.figure import Figure

import escapement as esc
from escapement import plots
from escapement.plots import style
from escapement.sources import meyer
from escapement.sources.meyer.meyer_figures import plot_appendix_e
from escapement.sources.meyer.program import program_1973
from pages import LINES, RUNS, drawn, panels, timer


@drawn
def four_pins() -> Figure:
    """Meyer's figure 10 with the exact solution."""
    return plots.plot_study(esc.run_plan(esc.load_plan(RUNS / "meyer_four_pins.toml")))


@drawn
def torque_friction_map() -> Figure:
    """Lines and maps of a finer study."""
    return plots.plot_study(esc.run_plan(esc.load_plan(RUNS / "torque_friction_map.toml")))


@drawn
def four_pins_tolerances() -> Figure:
    """The effect of tolerances on the period and other results."""
    return plots.plot_study(esc.run_plan(esc.load_plan(RUNS / "four_pins_tolerances.toml")))


@drawn
def published_cell() -> Figure:
    """Transmission over driver angle, true and in the 90-degree cell."""
    figure, axes = panels(3, 2.5)
    for ax, slots in zip(axes, (3, 4, 6), strict=True):
        wheel = esc.Geneva(slots)
        cells = (wheel, meyer.PublishedCell(slots))
        for cell, name, look in zip(cells, ("true", "as published"), LINES[:2], strict=True):
            theta = np.linspace(cell.breaks[0], cell.breaks[-1], 200)
            starts = np.arange(3)[:, None] * cell.cell_angle
            turned = np.degrees(np.pad(theta - theta[0] + starts, ((0, 0), (0, 1)))).ravel()
            ratio = np.tile([*cell.transmission(theta).g, np.nan], 3)
            label = name if slots == 3 else "_"
            ax.plot(turned, ratio, ls=look[1], color=look[0], lw=1.3, label=label)
        ax.axhline(0.0, color="grey", lw=0.6)
        ax.set(xlabel="Driver angle (°)", xlim=(0, 180), xticks=range(0, 181, 60))
        ax.set_title(f"{wheel.pins} pins", fontsize=9)
    axes[0].set_ylabel("Transmission g")
    figure.legend(loc="outside upper center", ncols=2, frameon=False, fontsize=8)
    return figure


@drawn
def appendix_e_three_pins() -> Figure:
    """Meyer's figure 9 with his table in it."""
    return plot_appendix_e(meyer.appendix_e(), slots=6)


@drawn
def appendix_e_four_pins() -> Figure:
    """Meyer's figure 10 with his table in it."""
    return plot_appendix_e(meyer.appendix_e(), slots=4)


@drawn
def sampling() -> Figure:
    """Peaks of a motion and what rows half a millisecond apart show of them."""
    count = np.arange(1, 31)
    motion = esc.simulate(timer(4, 0.35, 0.20), count.size)
    times = np.arange(0.0, motion.end_time, 0.0005)
    listing = program_1973(4, 0.35, 0.20, *meyer.INERTIAS[4], duration=0.95)
    speeds = motion.at(times).theta_dot
    shown = {
        "true, at rows 0.5 ms apart": (speeds, np.searchsorted(motion.handoff_times, times)),
        meyer.COLUMNS["program_1973"][0]: (listing.theta_dot, listing.theta // 1.5708),
    }
    figure = style.new_figure(style.TWO_COLUMN, 3.0)
    left, right = style.new_panels(figure, 1, 2)
    dense = np.linspace(0.095, 0.161, 5000)
    left.plot(1e3 * dense, motion.at(dense).theta_dot, color=style.BLUE, lw=1.0)
    right.axhline(motion.extrema.theta_dot.max(), color=style.BLUE, lw=1.0, label="true")
    for (name, (speed, of)), look in zip(shown.items(), style.LOOKS[1:], strict=False):
        tops = [speed[of == k].max() for k in range(count.size)]
        right.plot(count, tops, lw=1.0, ms=4, mfc="white", label=name, **look._asdict())
    rows = (times >= dense[0]) & (times <= dense[-1])
    look = style.LOOKS[1]
    left.plot(1e3 * times[rows], speeds[rows], look.marker, color=look.color, ms=2.5)
    left.set(xlabel="Time (ms)", ylabel="Driver velocity (rad/s)", ylim=(0, 180))
    right.set(xlabel="Engagement", ylabel="Peak driver velocity (rad/s)", xlim=(0, 31))
    key = right.get_legend_handles_labels()[0]
    style.add_legend(figure, 3, handles=key, loc="outside upper center", handlelength=style.HANDLE)
    return figure
