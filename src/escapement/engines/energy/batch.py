"""Figures of merit of many scenes of one mechanism, without a single trajectory."""

import numpy as np

from escapement.dynamics import beyond_painleve, losses
from escapement.engines.energy.figures import FIGURES, figures, workspace
from escapement.engines.energy.march import OK, PAINLEVE
from escapement.engines.energy.scene import numbers_of
from escapement.jit import jit
from escapement.model import FloatArray, Mechanism, dwell_angle


@jit(allocates=True)
def solve_scenes(calls, cells, path, breaks, dwell, rho, mu, load, w, rtol, table, status):
    """Fill table[i] and status[i] for every scene i; natural units."""
    store, events = workspace(breaks)
    for i in range(rho.size):
        loss = losses(path, mu[i])
        if beyond_painleve(path, rho[i], loss[1], breaks[0], breaks[-1]):
            status[i] = PAINLEVE
        else:
            status[i] = figures(
                calls, cells, path, breaks, dwell, rho[i], loss, load[i], w[i], rtol,
                store, events, table[i],
            )  # fmt: skip
        if status[i] != OK:
            for k in range(FIGURES):
                table[i, k] = np.nan


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
        Columns as in `_terminal`; NaN where there is none.
    status : ndarray, shape (n,)
        Values of `Status`.
    """
    table = np.empty((rho.size, FIGURES))
    status = np.empty(rho.size, dtype=np.uint8)
    breaks = np.array(mechanism.breaks)
    fixed = mechanism.path, breaks, dwell_angle(mechanism)
    solve_scenes(*numbers_of(fixed), rho, mu, load, w, rtol, table, status)
    return table, status
