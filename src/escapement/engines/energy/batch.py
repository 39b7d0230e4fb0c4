"""Figures of merit of many scenes of one mechanism."""

import numpy as np

from escapement.dynamics import losses, scene_of
from escapement.engines.energy.calls import Case, kernel_addresses
from escapement.engines.energy.cycle import FIGURES
from escapement.engines.energy.figures import figures, workspace
from escapement.engines.energy.march import OK, PAINLEVE
from escapement.engines.energy.prepare import cells_of
from escapement.jit import jit
from escapement.model import FloatArray, Mechanism, dwell_angle
from escapement.painleve import beyond_painleve
from escapement.scene import Scene, smooth_intervals, writeable


@jit(allocates=True)
def solve_scenes(addresses, scene_tuple, cells, numbers, rtol, table, status):
    """Fill table[i] and status[i] for every scene i, in natural units.

    Parameters
    ----------
    addresses, scene_tuple, cells : as `prepare.prepared` gives them, for any scene of the
        mechanism, of which path, edges and dwell are used.
    numbers : rows rho, mu, load and w of the scenes, described in `solve`.
    rtol : relative error asked for.
    table, status : results, described in `solve`; of a stall the first two columns hold the
        driver angle [rad] and the engagement.
    """
    shared = scene_of(scene_tuple)
    store, events = workspace(shared.edges)
    for i in range(status.size):
        rho, mu, load, w = numbers[0, i], numbers[1, i], numbers[2, i], numbers[3, i]
        mu_plus, mu_minus = losses(shared.path, mu)
        scene = Scene(shared.path, shared.edges, shared.dwell, rho, mu_plus, mu_minus, load)
        # at the Painleve limit J_s reaches zero, and the march would divide by it
        if beyond_painleve(scene):
            status[i] = PAINLEVE
        else:
            case = Case(addresses, scene, cells, store, events)
            status[i] = figures(case, w, rtol, table[i])


def solve(
    mechanism: Mechanism,
    rho: FloatArray,
    mu: FloatArray,
    load: FloatArray,
    w: FloatArray,
    rtol: float,
) -> tuple[FloatArray, np.ndarray]:
    """Figures of merit of scenes given by their dimensionless numbers.

    Parameters
    ----------
    mechanism : Mechanism
        Shared by all scenes.
    rho, mu, load : ndarray, shape (n,)
        Inertia ratio, friction (of a mesh: 1/efficiency - 1), load over driving torque [-].
    w : ndarray, shape (n,)
        Squared driver speed at the first entry in units of torque / I_f [-].
    rtol : float
        Relative error asked for.

    Returns
    -------
    table : ndarray, shape (n, 7)
        Columns as in `cycle`; NaN where there is none.
    status : ndarray, shape (n,)
        Values of `Status`.
    """
    table = np.empty((rho.size, FIGURES))
    status = np.empty(rho.size, dtype=np.uint8)
    path = writeable(mechanism.path)
    edges = smooth_intervals(path, mechanism.breaks)
    scene_tuple = tuple(path), edges, dwell_angle(mechanism), 1.0, 0.0, 0.0, 0.0
    cells = cells_of(path, edges)
    numbers = np.array([rho, mu, load, w])
    solve_scenes(kernel_addresses(), scene_tuple, cells, numbers, rtol, table, status)
    # of a stall the table holds its angle and engagement, which are no figures of merit
    table[status != OK] = np.nan
    return table, status
