"""Figures of merit of many scenes of one mechanism, without a single trajectory."""

import numpy as np

from escapement.dynamics import losses, scene_of
from escapement.engines.energy.calls import Case, addresses
from escapement.engines.energy.cycle import FIGURES
from escapement.engines.energy.figures import figures, workspace
from escapement.engines.energy.march import OK, PAINLEVE
from escapement.engines.energy.prepare import cells_of
from escapement.jit import jit
from escapement.model import FloatArray, Mechanism, dwell_angle
from escapement.painleve import beyond_painleve
from escapement.scene import Scene, smooth_intervals, writeable


@jit(allocates=True)
def solve_scenes(calls, plain, cells, numbers, rtol, table, status):
    """Fill table[i] and status[i] for every scene i; natural units.

    Parameters
    ----------
    calls, plain, cells : as `prepare.prepared` gives them, of any scene of the mechanism.
    numbers : rows rho, mu, load and w of the scenes, as `solve` takes them.
    rtol, table, status : as `solve` takes and returns them; of a stall the first two columns
        hold its driver angle [rad] and engagement.
    """
    same = scene_of(plain)
    store, events = workspace(same.edges)
    for i in range(status.size):
        rho, mu, load, w = numbers[0, i], numbers[1, i], numbers[2, i], numbers[3, i]
        mu_plus, mu_minus = losses(same.path, mu)
        scene = Scene(same.path, same.edges, same.dwell, rho, mu_plus, mu_minus, load)
        if beyond_painleve(scene):
            status[i] = PAINLEVE
        else:
            case = Case(calls, scene, cells, store, events)
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
    plain = tuple(path), edges, dwell_angle(mechanism), 1.0, 0.0, 0.0, 0.0
    cells = cells_of(path, edges)
    numbers = np.array([rho, mu, load, w])
    solve_scenes(addresses(), plain, cells, numbers, rtol, table, status)
    table[status != OK] = np.nan
    return table, status
