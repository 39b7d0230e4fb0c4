"""Figures of merit of many scenes of one mechanism."""

from dataclasses import replace

import numpy as np

from escapement.dynamics.needs import (
    CONSTANT,
    NUMBERS,
    kind_of,
    plain_scene,
    typed_scene,
)
from escapement.dynamics.painleve import beyond_painleve
from escapement.engines.energy.calls import MarchInputs, kernel_addresses
from escapement.engines.energy.case_figures import figures, workspace
from escapement.engines.energy.cells import NO_CELLS, cells_of
from escapement.engines.energy.cycle import FIGURES
from escapement.engines.energy.march import OK, PAINLEVE
from escapement.mechanisms.path import smooth_intervals, writeable
from escapement.mechanisms.protocol import FloatArray, Mechanism, dwell_angle
from escapement.mechanisms.slotted import slide_edges
from escapement.model.scene import Scene
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.known import as_given

_COUNT = len(NUMBERS)


@inner_jit(inlined=True)
def _scene_with(shared, edges, row):
    """The scene `shared` with other edges, and with the numbers in a row."""
    return Scene(
        shared.path, edges, shared.dwell, shared.torque, shared.driver_angle,
        row[0], row[1], row[2], row[3], as_given(row[4], shared.bearing),
        as_given(row[5], shared.driver_drag), as_given(row[6], shared.follower_drag),
        as_given(row[7], shared.driver_viscous), as_given(row[8], shared.follower_viscous),
        as_given(row[9], shared.pin), as_given(row[10], shared.driver_journal),
        as_given(row[11], shared.follower_journal), as_given(row[12], shared.gain),
        as_given(row[13], shared.flow), as_given(row[14], shared.barrel),
        as_given(row[15], shared.barrel_efficiency), as_given(row[16], shared.load_train),
        as_given(row[17], shared.load_train_efficiency),
    )  # fmt: skip


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
    shared = typed_scene(scene_tuple)
    store, events, handoffs, rows = workspace(shared.edges)
    for i in range(status.size):
        row = numbers[i]
        scene, known = _scene_with(shared, shared.edges, row), cells
        if scene.pin > 0.0:
            # a pin with a radius has its own breaks, between which nothing is tabulated
            edges = slide_edges(shared.path, scene.pin, shared.edges)
            scene, known = _scene_with(shared, edges, row), none
        # at the Painleve limit J_s reaches zero, and the march would divide by it
        if beyond_painleve(scene):
            status[i] = PAINLEVE
        else:
            case = MarchInputs(addresses, scene, known, store, events)
            w = row[_COUNT]
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
    kind = kind_of(path, CONSTANT, numbers[:_COUNT])
    zeros = dict.fromkeys(NUMBERS, 0.0)
    scene = Scene(path, edges, dwell_angle(mechanism), np.array(CONSTANT), 0.0, **zeros)
    fixed = kernel_addresses(kind), plain_scene(scene, kind), cells_of(path, edges), NO_CELLS
    solve_rows(*fixed, rows, rtol, int(extent), table, status)
    # for a stall the table holds its angle and engagement, which are not figures of merit
    table[status != OK] = np.nan
    return table, status
