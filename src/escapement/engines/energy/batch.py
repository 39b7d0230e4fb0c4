"""Figures of merit of many scenes of one mechanism."""

from collections.abc import Collection
from dataclasses import replace
from typing import Any

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.law import scene_of, scene_with
from escapement.dynamics.load import has_load_curve
from escapement.dynamics.needs import CONSTANT, NO_CURVE, NUMBERS, Kind, kind_of
from escapement.engines.energy.calls import NO_PATTERN, kernel_addresses
from escapement.engines.energy.case_figures import figures, transient_memory
from escapement.engines.energy.cells import NO_CELLS, cells_of
from escapement.engines.energy.cycle import FIGURES
from escapement.engines.energy.march import OK
from escapement.engines.energy.pairs import new_case, prepare
from escapement.engines.energy.peak_rows import peak_rows
from escapement.engines.energy.peaks import PEAKS
from escapement.mechanisms.path import smooth_intervals, writeable
from escapement.mechanisms.pattern import PAIR, POSSIBLE, lay_pattern
from escapement.mechanisms.protocol import FloatArray, Mechanism, dwell_angle
from escapement.mechanisms.slotted import slide_edges
from escapement.model.scene import Scene, scene_tuple
from escapement.numerics.altered import altered
from escapement.numerics.jit import jit

Errors = tuple[FloatArray, FloatArray, FloatArray]
"""Errors of the parts of each scene: `longer`, `pins` and `slots` as `lay_pattern` takes them."""
_COUNT = len(NUMBERS)
_PIN = NUMBERS.index("pin")
_INVALID = int(Status.INVALID)
# So many pairs are laid out at once.
_AT_ONCE = 1 << 16


@jit(allocates=True)
def solve_rows(addresses, scene_tuple, cells, patterns, none, numbers, rtol, extent, table, status):
    """Fill table[i] and status[i] for every scene i, in natural units.

    Parameters
    ----------
    addresses, scene_tuple, cells : as `calls.prepared` gives them, for any scene of the
        mechanism, of which path, edges and dwell are used where the parts are perfect.
    patterns : array of `mechanisms.pattern.PAIR`, a row for each scene; empty rows for perfect
        parts.
    none : cells of no mechanism, with no columns.
    numbers : array of shape (scenes, k): the numbers of each scene, and its squared speed at
        the first entry.
    rtol : relative error asked for.
    extent : an `Extent`, how far the transient is followed.
    table, status : results, described in `solve`; of a stall the first two columns hold the
        driver angle [rad] and the engagement. A scene with another status than OK is left out.
    """
    shared, size = scene_of(scene_tuple), patterns.shape[1]
    room, handoffs, rows = transient_memory(shared.edges, size)
    fixed = new_case(addresses, shared, cells, patterns[0], room)
    for i in range(status.size):
        row = numbers[i]
        scene, known = scene_with(shared, shared.edges, row), cells
        if size == 0 and scene.pin > 0.0 and not has_load_curve(scene):
            # a pin with a radius has its own breaks, between which nothing is tabulated
            edges = slide_edges(shared.path, scene.pin, shared.edges)
            scene, known = scene_with(shared, edges, row), none
        case = altered(fixed, "scene", scene, "cells", known, "pattern", patterns[i])
        if status[i] == OK:
            status[i] = prepare(case)
        if status[i] == OK:
            w = row[_COUNT]
            status[i] = figures(case, handoffs, rows, w, rtol, extent, table[i])


@jit(allocates=True)
def lay_patterns(arms, turns, longer, pin, pins, slots, patterns, status):
    """Lay out the pattern of every scene, and mark those that are impossible as invalid."""
    for i in range(status.size):
        last = lay_pattern(arms, turns, longer[i], pin[i], pins[i], slots[i], patterns[i])
        status[i] = OK if last == POSSIBLE else _INVALID


def solve(
    mechanism: Mechanism,
    numbers: FloatArray,
    rtol: float,
    extent: int,
    errors: Errors | None = None,
) -> tuple[FloatArray, np.ndarray]:
    """Figures of merit of scenes given by their dimensionless numbers.

    Parameters
    ----------
    mechanism : Mechanism
        Shared by all scenes; without errors of its own.
    numbers : ndarray, shape (k, n)
        One column for each scene: the result of `natural.natural`, and the squared driver speed
        at the first entry in units of torque / I_f [-].
    rtol : float
        Relative error asked for.
    extent : int
        An `Extent`: times of the transient that need it to be followed further are NaN.
    errors : tuple of ndarray, shapes (n,), (n, m, 2) and (n, k, 2), optional
        Errors of the parts of a wheel.

    Returns
    -------
    table : ndarray, shape (n, 11)
        Columns as in `cycle.COLUMNS`; NaN where there is none.
    status : ndarray, shape (n,)
        Values of `Status`.
    """
    rows = np.ascontiguousarray(numbers.T, dtype=float)
    table, status = np.empty((len(rows), FIGURES)), np.zeros(len(rows), dtype=np.uint8)
    scene = _shared(mechanism)
    kind, size, at_once = kind_of(scene.path, CONSTANT, numbers[:_COUNT]), 0, max(len(rows), 1)
    wheel: Any = mechanism
    if errors is not None:
        size = int(np.lcm(errors[1].shape[1], errors[2].shape[1]))
        at_once = max(_AT_ONCE // size, 1)
        if errors[2][:, :, 1].any():  # an ideal slot has no offset
            kind = max(kind, Kind.STEADY)
    fixed = kernel_addresses(kind), scene_tuple(scene)
    cells = NO_CELLS if size else cells_of(scene.path, scene.edges)
    for first in range(0, len(rows), at_once):
        some = slice(first, first + at_once)
        patterns = np.empty((len(rows[some]), size), PAIR)
        if errors is not None:
            longer, pins, slots = (each[some] for each in errors)
            given = longer, rows[some, _PIN], pins, slots
            lay_patterns(*wheel.path_numbers.values(), *given, patterns, status[some])
        given = cells, patterns, NO_CELLS, rows[some]
        solve_rows(*fixed, *given, rtol, int(extent), table[some], status[some])
    # for a stall the table holds its angle and engagement, which are not figures of merit
    table[status != OK] = np.nan
    return table, status


def peaks(
    mechanism: Mechanism, numbers: FloatArray, speeds: FloatArray, rtol: float,
    wanted: Collection[str],
) -> dict[str, FloatArray]:  # fmt: skip
    """Greatest magnitudes over the terminal engagement of scenes with perfect parts.

    Parameters
    ----------
    mechanism, numbers, rtol : as of `solve`.
    speeds : ndarray, shape (n,)
        Driver speeds at the terminal handoff, NaN where there is none; natural units.
    wanted : collection of str
        Some of `peaks.PEAKS`.

    Returns
    -------
    dict of ndarray, shape (n,)
        Each of them in natural units.
    """
    scene, rows = _shared(mechanism), np.ascontiguousarray(numbers.T, dtype=float)
    table = np.tile([0.0 if name in wanted else np.inf for name in PEAKS], (len(rows), 1))
    kind = kind_of(scene.path, CONSTANT, numbers[:_COUNT])
    given = kernel_addresses(kind), scene_tuple(scene), cells_of(scene.path, scene.edges)
    peak_rows(*given, NO_PATTERN, NO_CELLS, rows, speeds, rtol, table)
    return {name: column for name, column in zip(PEAKS, table.T, strict=True) if name in wanted}


def _shared(mechanism: Mechanism) -> Scene:
    """The scene of a mechanism with thin pins, of which the numbers are those of no case."""
    if mechanism.pin_radius:
        # each scene has its own pin
        mechanism = replace(mechanism, pin_radius=0.0, roller_radius=0.0)  # type: ignore[type-var]
    path = writeable(mechanism.path)
    edges, dwell = smooth_intervals(path, mechanism.breaks), dwell_angle(mechanism)
    none = dict.fromkeys(NUMBERS, 0.0)
    return Scene(path, edges, dwell, np.array(CONSTANT), 0.0, np.array(NO_CURVE), **none)
