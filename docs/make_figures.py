"""Draw the figures of these pages: `python docs/make_figures.py [FOLDER]`.

One function a figure, named like its file; without FOLDER they go to docs/images.
"""

import io
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

import escapement as esc
from escapement import plots
from escapement.configuration import load_plan
from escapement.plots._style import legend_above
from escapement.plots.appendix_e import plot_appendix_e
from escapement.plots.filemon_reversals import plot_reversal_curves
from escapement.plots.nomograms import SHEETS, plot_nomogram
from escapement.plots.planetary import plot_planetary
from escapement.plots.prikhodko import plot_position_function, plot_velocity_plans
from escapement.plots.tabulated import plot_table
from escapement.published import meyer
from escapement.published.program_1973 import program_1973
from escapement.sweeping import run_plan
from escapement.units import INCH_POUND

HERE = Path(__file__).resolve().parent
RUNS = HERE.parent / "runs"
DPI = 200
COLOURS = 96  # a palette keeps the files small; the eye sees no difference
LINES = (
    ("#0072B2", "-"),
    ("#D55E00", "--"),
    ("#009E73", "-."),
    ("#CC79A7", ":"),
    ("#E69F00", (0, (5, 1, 1, 1))),
)

FIGURES: dict[str, Callable[[], Figure]] = {}


def drawn(make: Callable[[], Figure]) -> Callable[[], Figure]:
    """Enter a figure under the name of its function."""
    FIGURES[f"{make.__name__}.png"] = make
    return make


def main(folder: Path) -> None:
    """Draw every figure into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in FIGURES.items():
        image = io.BytesIO()
        make().savefig(image, dpi=DPI)
        Image.open(image).convert("RGB").quantize(COLOURS).save(folder / name, optimize=True)


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


@drawn
def mechanisms() -> Figure:
    """The three continuous drives."""
    return plots.plot_configurations(np.radians(-15.0))


@drawn
def dwell_and_internal() -> Figure:
    """A drive in its dwell, a fine one at dead centre, an internal one."""
    figure, axes = panels(3, 2.9)
    shown = (
        (esc.Geneva(4, pins=1), 180.0, "4 slots, 1 pin, in dwell"),
        (esc.Geneva(8), 10.0, "8 slots, 1 pin"),
        (esc.Geneva(4, internal=True), -50.0, "4 slots, internal"),
    )
    for ax, (mechanism, degrees, title) in zip(axes, shown, strict=True):
        plots.plot_mechanism(mechanism, np.radians(degrees), ax)
        limits = np.array([ax.get_xlim(), ax.get_ylim()])
        half = np.array([-0.5, 0.5]) * np.ptp(limits, axis=1).max()
        ax.set(xlim=limits[0].mean() + half, ylim=limits[1].mean() + half)  # titles in one row
        ax.set_title(title, fontsize=9)
    return figure


@drawn
def transmission() -> Figure:
    """Transmission function and sliding of the three continuous drives."""
    figure, axes = panels(2, 2.8)
    for slots, (color, style) in zip((3, 4, 6), LINES, strict=False):
        wheel = esc.Geneva(slots)
        theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 400)
        table = wheel.transmission(theta)
        for ax, values in zip(axes, (table.g, table.u), strict=True):
            ax.plot(np.degrees(theta), values, ls=style, color=color, label=f"{slots} slots")
    for ax, name in zip(axes, ("transmission g", "sliding u"), strict=True):
        ax.set(xlabel="driver angle from dead centre (°)", ylabel=name, xlim=(-60, 60))
    axes[0].legend(frameon=False)
    return figure


@drawn
def velocities() -> Figure:
    """Meyer's figure 8."""
    return plots.plot_velocities(esc.simulate(timer(4, 0.35, 0.10), 5)).figure


@drawn
def contact_moment() -> Figure:
    """Two terminal engagements."""
    design = timer(4, 0.35, 0.10)
    handoff = esc.terminal(design).handoff_velocity
    return plots.plot_contact_moment(esc.simulate(design, 2, initial_speed=handoff)).figure


@drawn
def phase_portrait() -> Figure:
    """From rest to the terminal cycle with little friction."""
    ax = plots.new_axes(5.4, 3.6)
    plots.plot_phase_portrait(esc.simulate(timer(4, 0.05, 0.10), 9), ax)
    return ax.figure


@drawn
def handoff_map() -> Figure:
    """Squared handoff speed against the one before, and the handoff speeds."""
    figure, (left, right) = panels(2, 3.1)
    entry = np.linspace(0.0, 350.0, 15)
    for mu, (color, style) in zip((0.0, 0.05, 0.1, 0.2, 0.35), LINES, strict=True):
        design = timer(4, mu, 0.10)
        leave = [esc.simulate(design, 1, initial_speed=v).handoff_velocities[0] for v in entry]
        name = f"µ = {mu:.2f}"
        left.plot(entry**2 / 1e3, np.square(leave) / 1e3, ls=style, color=color, label=name)
        speeds = [0.0, *esc.simulate(design, 8).handoff_velocities]
        right.plot(range(9), speeds, ls=style, marker="o", ms=4, mfc="white", color=color)
    left.plot([0, 122], [0, 122], color="grey", lw=0.8)
    left.set(xlim=(0, 122), ylim=(0, 230))
    left.set_xlabel("w at a handoff (1000 rad²/s²)")
    left.set_ylabel("w at the next (1000 rad²/s²)")
    right.set(xlabel="engagement", ylabel="handoff velocity (rad/s)", ylim=(0, 1000))
    figure.legend(loc="outside upper center", ncols=5, frameon=False, fontsize=8)
    return figure


@drawn
def four_pins() -> Figure:
    """Meyer's figure 10, true."""
    return plots.plot_study(run_plan(load_plan(RUNS / "meyer_four_pins.toml")))


@drawn
def torque_friction_map() -> Figure:
    """Lines and maps of a finer study."""
    return plots.plot_study(run_plan(load_plan(RUNS / "torque_friction_map.toml")))


@drawn
def four_pins_tolerances() -> Figure:
    """What tolerances do to a period."""
    return plots.plot_study(run_plan(load_plan(RUNS / "four_pins_tolerances.toml")))


@drawn
def published_cell() -> Figure:
    """Transmission over driver angle, real and as the 1973 program has it."""
    figure, axes = panels(3, 2.5)
    for ax, slots in zip(axes, (3, 4, 6), strict=True):
        wheel = esc.Geneva(slots)
        cells = (wheel, meyer.PublishedCell(slots))
        for cell, name, look in zip(
            cells, ("real mechanism", "1973 program"), LINES[:2], strict=True
        ):
            theta = np.linspace(cell.breaks[0], cell.breaks[-1], 200)
            starts = np.arange(3)[:, None] * cell.cell_angle
            turned = np.degrees(np.pad(theta - theta[0] + starts, ((0, 0), (0, 1)))).ravel()
            ratio = np.tile([*wheel.transmission(theta).g, np.nan], 3)
            label = name if slots == 3 else "_"
            ax.plot(turned, ratio, ls=look[1], color=look[0], lw=1.3, label=label)
        ax.axhline(0.0, color="grey", lw=0.6)
        ax.set(xlabel="driver angle (°)", xlim=(0, 180), xticks=range(0, 181, 60))
        ax.set_title(f"{wheel.pins} pins", fontsize=9)
    axes[0].set_ylabel("transmission g")
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
    engagements = 30
    design = timer(4, 0.35, 0.20)
    motion = esc.simulate(design, engagements)
    times = np.arange(0.0, motion.end_time, 0.0005)
    listing = program_1973(4, 0.35, 0.20, *meyer.INERTIAS[4], duration=0.95)
    shown = {
        "exact, every 0.5 ms": (
            motion.at(times).theta_dot,
            np.searchsorted(motion.handoff_times, times),
        ),
        "1973 program": (listing.theta_dot, listing.theta // 1.5708),
    }
    figure, (left, right) = panels(2, 3.0)
    dense = np.linspace(0.095, 0.161, 5000)
    rows = times[(times >= dense[0]) & (times <= dense[-1])]
    left.plot(1e3 * dense, motion.at(dense).theta_dot, color=LINES[0][0], lw=1.0)
    left.plot(1e3 * rows, motion.at(rows).theta_dot, ".", color="black", ms=3.5)
    left.set(xlabel="time (ms)", ylabel="driver velocity (rad/s)", ylim=(0, 180))
    peak = motion.extrema.theta_dot.max()
    right.axhline(peak, color=LINES[0][0], label="exact")
    for (name, (speed, of)), look, mark in zip(shown.items(), LINES[1:], "os", strict=False):
        tops = [speed[of == k].max() for k in range(engagements)]
        count = np.arange(1, engagements + 1)
        right.plot(
            count, tops, ls=look[1], color=look[0], marker=mark, ms=3.5, mfc="white", label=name
        )
    right.set(xlabel="engagement", ylabel="peak driver velocity (rad/s)", xlim=(0, 31))
    right.set_ylim(153.0, 169.0)
    right.legend(
        frameon=False, ncols=3, fontsize=7, loc="upper center", columnspacing=0.8, handlelength=1.8
    )
    return figure


@drawn
def drive_torque() -> Figure:
    """A drive at constant speed whose pin changes sides twice."""
    drive = esc.drive_torque(esc.Geneva(8), speed=10.0, load_torque=1.0, follower_inertia=0.019)
    return plots.plot_drive_torque(drive).figure


@drawn
def reversal_curves() -> Figure:
    """Filemon's figure 10."""
    return plot_reversal_curves().figure


@drawn
def nomogram() -> Figure:
    """A sheet to be read by hand."""
    figure = plot_nomogram(SHEETS["16b"])
    figure.set_size_inches(9.6, 6.6)
    return figure


PLANETARY = esc.EllipticalPlanetary(sun_radius=0.016, planet_radius=0.009)


@drawn
def planetary_drive() -> Figure:
    """Prikhodko's drive to scale."""
    return plot_planetary(PLANETARY, np.radians(30.0)).figure


@drawn
def position_function() -> Figure:
    """Prikhodko's figure 6."""
    return plot_position_function(PLANETARY).figure


@drawn
def velocity_plans() -> Figure:
    """Prikhodko's figure 3."""
    return plot_velocity_plans(PLANETARY)


@drawn
def planetary_start() -> Figure:
    """The planetary drive from rest, its mesh losing a tenth."""
    driver, follower = (inertia * INCH_POUND for inertia in meyer.INERTIAS[4])
    design = esc.Escapement(
        PLANETARY, esc.Inertia(driver, follower), 0.1 * INCH_POUND, efficiency=0.9
    )
    return plots.plot_velocities(esc.simulate(design, 12)).figure


@drawn
def measured_table() -> Figure:
    """Transmission from 148 noisy angles of Prikhodko's drive, made up."""
    random = np.random.default_rng(2020)
    theta = random.uniform(0.0, 2.0, 148) * PLANETARY.cell_angle
    phi = -PLANETARY.follower_angle(theta) + np.radians(1.298) * random.standard_normal(theta.size)
    table = esc.Tabulated(
        theta, phi, measured=True, cell_angle=PLANETARY.cell_angle,
        follower_step=PLANETARY.follower_step,
    )  # fmt: skip
    ax = plot_table(table)
    angles = np.linspace(*table.breaks, 400)
    truth = PLANETARY.transmission(angles).g
    ax.plot(np.degrees(angles), truth, color=LINES[1][0], ls=LINES[1][1], label="true")
    legend_above(ax, 4)
    return ax.figure


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "images")
