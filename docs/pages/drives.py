"""Figures of drives at constant speed, of the planetary drive, and of measurements."""

import numpy as np
from matplotlib.figure import Figure

import escapement as esc
from escapement import plots
from escapement.base.units import INCH_POUND
from escapement.plots import plot_table
from escapement.plots.planetary import plot_planetary
from escapement.plots.style import legend_above
from escapement.sources import meyer
from escapement.sources.filemon.filemon_figures import plot_reversal_curves
from escapement.sources.filemon.nomograms import NOMOGRAMS, plot_nomogram
from escapement.sources.prikhodko.prikhodko_figures import (
    plot_position_function,
    plot_velocity_plans,
)
from pages import LINES, RUNS, drawn


@drawn
def indexing_drive() -> Figure:
    """A table of six stations with a load on an elastic shaft."""
    table = esc.Geneva(6, pins=1, crank_radius=0.05, clearance=1e-4)
    drive = esc.index(
        table, 2.0 * np.pi, 2.0, follower_inertia=0.4, friction=0.08,
        load_frequency=15.0, load_damping=0.02, load_tolerance=1e-4,
    )  # fmt: skip
    return plots.plot_index(drive)


@drawn
def motor() -> Figure:
    """The same table with a motor and its gearbox, from rest to the steady state."""
    drive = esc.Escapement(
        esc.Geneva(6, pins=1, crank_radius=0.05),
        esc.Inertia(driver=0.02, follower=0.4),
        torque=esc.Motor(stall_torque=2.0, no_load_speed=3000.0 * np.pi / 30.0),
        friction=0.08,
        load_torque=2.0,
        barrel=esc.Train(ratio=1 / 40, efficiency=0.8, inertia=2e-5),
    )
    return plots.plot_motor(esc.simulate(drive, engagements=4), esc.terminal(drive))


@drawn
def indexing_cam() -> Figure:
    """The same table beside a cam."""
    table = esc.Geneva(6, pins=1, crank_radius=0.05)
    drive = esc.index(
        table, 2.0 * np.pi, 2.0, follower_inertia=0.4, load_frequency=15.0, load_damping=0.02
    )
    return plots.plot_index(drive, against=esc.cam_drive(drive, "modified-sine"))


@drawn
def reversal_curves() -> Figure:
    """Filemon's figure 10."""
    return plot_reversal_curves().figure


@drawn
def nomogram() -> Figure:
    """A nomogram from which torques are read by hand."""
    figure = plot_nomogram(NOMOGRAMS["16b"])
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
    """The planetary drive from rest; its gears lose a tenth of the power."""
    driver, follower = (inertia * INCH_POUND for inertia in meyer.INERTIAS[4])
    design = esc.Escapement(
        PLANETARY, esc.Inertia(driver, follower), 0.1 * INCH_POUND, efficiency=0.9
    )
    # it ends in a trough, because a peak would be cut in half
    return plots.plot_velocities(esc.simulate(design, duration=0.204)).figure


@drawn
def measured_table() -> Figure:
    """Transmission from 148 noisy angles of Prikhodko's drive, which are computed."""
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


@drawn
def measurement() -> Figure:
    """Synthetic readings of the planetary drive."""
    drive = esc.EllipticalPlanetary(sun_radius=0.016, planet_radius=0.009)
    encoder = esc.Encoder(resolution=4096, linearity=0.003)
    readings = RUNS / "encoder_synthetic.csv"
    return plots.plot_measurement(esc.measure(readings, drive, encoder=encoder))
