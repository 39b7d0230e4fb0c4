"""Figures of merit of many scenes of one mechanism."""

from dataclasses import replace

import numpy as np

from escapement.dynamics.law import scene_of
from escapement.dynamics.painleve import beyond_painleve
from escapement.engines.energy.calls import MarchInputs, kernel_addresses
from escapement.engines.energy.cells import NO_CELLS, cells_of
from escapement.engines.energy.cycle import FIGURES
from escapement.engines.energy.figures import figures, workspace
from escapement.engines.energy.march import OK, PAINLEVE
from escapement.mechanisms.path import smooth_intervals, writeable
from escapement.mechanisms.protocol import FloatArray, Mechanism, dwell_angle
from escapement.mechanisms.slotted import slide_edges
from escapement.model.scene import Scene
from escapement.numerics.jit import jit, row_tuple

FIXED = Scene._fields.index("rho")
"""Fields of a scene that all scenes of a mechanism share; those behind them are numbers."""
_NUMBERS = len(Scene._fields) - FIXED


@jit(allocates=True)
def solve_rows(addresses, scene_tuple, cells, none, numbers, rtol, extent, table, status):
    """Fill table[i] and status[i] for every scene i, in natural units.

    Parameters
    ----------
    addresses, scene_tuple, cells : as `calls.prepared` gives them, for any scene of the
        mechanism, of which path, edges and dwell are used.
    none : cells of no mechanism, with no columns.
    numbers : array of shape (scenes, k): the numbers of each scene, and its squared speed at
        the first entry.
    rtol : relative error asked for.
    extent : an `Extent`, how far the transient is followed.
    table, status : results, described in `solve`; of a stall the first two columns hold the
        driver angle [rad] and the engagement.
    """
    shared = scene_of(scene_tuple)
    store, events, handoffs, rows = workspace(shared.edges)
    for i in range(status.size):
        own = row_tuple(numbers[i], _NUMBERS)
        drive = (shared.torque, shared.turned)
        scene, known = Scene(shared.path, shared.edges, shared.dwell, *drive, *own), cells
        if scene.pin > 0.0:
            # a pin with a radius has its own breaks, between which nothing is tabulated
            edges = slide_edges(shared.path, scene.pin, shared.edges)
            scene, known = Scene(shared.path, edges, shared.dwell, *drive, *own), none
        # at the Painleve limit J_s reaches zero, and the march would divide by it
        if beyond_painleve(scene):
            status[i] = PAINLEVE
        else:
            case = MarchInputs(addresses, scene, known, store, events)
            w = numbers[i, _NUMBERS]
            status[i] = figures(case, handoffs, rows, w, rtol, extent, table[i])


def solve(
    mechanism: Mechanism, numbers: FloatArray, rtol: float, extent: int
) -> tuple[FloatArray, np.ndarray]:
    """Figures of merit of scenes given by their dimensionless numbers.

    Parameters
    ----------
    mechanism : Mechanism
        Shared by all scenes.
    numbers : ndarray, shape (k, n)
        One column for each scene: the result of `natural.natural`, and the squared driver speed
        at the first entry in units of torque / I_f [-].
    rtol : float
        Relative error asked for.
    extent : int
        An `Extent`: times of the transient that need it to be followed further are NaN.

    Returns
    -------
    table : ndarray, shape (n, 9)
        Columns as in `cycle.COLUMNS`; NaN where there is none.
    status : ndarray, shape (n,)
        Values of `Status`.
    """
    if mechanism.pin_radius:
        # each scene has its own pin
        mechanism = replace(mechanism, pin_radius=0.0, roller_radius=0.0)  # type: ignore[type-var]
    rows = np.ascontiguousarray(numbers.T, dtype=float)
    table = np.empty((len(rows), FIGURES))
    status = np.empty(len(rows), dtype=np.uint8)
    path = writeable(mechanism.path)
    edges = smooth_intervals(path, mechanism.breaks)
    constant = np.array([0.0, 0.0, 1.0]), 0.0
    scene_tuple = tuple(path), edges, dwell_angle(mechanism), *constant, *(0.0,) * _NUMBERS
    cells = cells_of(path, edges)
    fixed = kernel_addresses(), scene_tuple, cells, NO_CELLS
    solve_rows(*fixed, rows, rtol, int(extent), table, status)
    # for a stall the table holds its angle and engagement, which are not figures of merit
    table[status != OK] = np.nan
    return table, status
