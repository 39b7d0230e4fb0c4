"""A planetary drive, and tables made of it."""

import numpy as np

import escapement as esc

DRIVE = esc.EllipticalPlanetary(sun_radius=0.016, planet_radius=0.009)
ANGLES = np.linspace(*DRIVE.breaks, 401)
INERTIA = esc.Inertia(1e-5, 2e-5)


def exact(rows, sense=-1.0):
    theta = np.linspace(*DRIVE.breaks, rows + 1)
    return esc.Tabulated(theta, sense * DRIVE.follower_angle(theta))


def measured(rows, noise, seed=1, cells=3.0):
    """Rows at random angles over some cells, in the order of their making."""
    random = np.random.default_rng(seed)
    theta = random.uniform(-cells, cells, rows) * DRIVE.cell_angle
    phi = -DRIVE.follower_angle(theta) + noise * random.standard_normal(rows)
    return esc.Tabulated(
        theta, phi, measured=True, cell_angle=DRIVE.cell_angle, follower_step=DRIVE.follower_step
    )
