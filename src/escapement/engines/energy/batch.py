"""Figures of merit of many scenes of one mechanism."""

from collections.abc import Collection
from dataclasses import replace
from typing import Any

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.figure_table import PEAKS
from escapement.dynamics.law import scene_of, scene_with
from escapement.dynamics.needs import CONSTANT, NO_CURVE, NUMBERS, kind_of
from escapement.dynamics.painleve import (
    FrictionLimit,
    beyond_painleve,
    friction_limit_after,
    has_limit_of_its_own,
)
from escapement.engines.energy.calls import NO_PATTERN, kernel_addresses
from escapement.engines.energy.case_figures import figures, transient_memory
from escapement.engines.energy.cells import NO_CELLS, cells_of
from escapement.engines.energy.cycle import FIGURES
from escapement.engines.energy.march import OK, PAINLEVE
from escapement.engines.energy.pairs import new_case, prepare, scene_of_pair
from escapement.engines.energy.peak_rows import peak_rows
from escapement.mechanisms.path import smooth_intervals, writeable
from escapement.mechanisms.pattern import PAIR, POSSIBLE, lay_pattern
from escapement.mechanisms.protocol import FloatArray, Mechanism, dwell_angle
from escapement.mechanisms.slotted import slide_edges
from escapement.model.scene import Scene, packed
from escapement.numerics.altered import altered
from escapement.numerics.held import held
from escapement.numerics.jit import inner_jit, jit

Errors = tuple[FloatArray, FloatArray, FloatArray]
"""Errors of the parts of each scene: `longer`, `pins` and `slots` as `lay_pattern` takes them."""
_COUNT = len(NUMBERS)
_PIN = NUMBERS.index("pin")
_INVALID = int(Status.INVALID)
# So many pairs are laid out at once.
_AT_ONCE = 1 << 16


@jit(allocates=True)
def solve_rows(addresses, packed, cells, patterns, numbers, rtol, extent, table, status):
    """Fill table[i] and status[i] for every scene i, in natural units.

    Parameters
    ----------
    addresses, packed, cells : as `calls.prepared` gives them, for any scene of the
        mechanism, of which path, edges and dwell are used where the parts are perfect. Without
        cells each scene has edges for its own pin.
    patterns : array of `mechanisms.pattern.PAIR`, a row for each scene; empty rows for perfect
        parts.
    numbers : array of shape (scenes, k): the numbers of each scene, and its squared speed at
        the first entry.
    rtol : relative error asked for.
    extent : an `Extent`, how far the transient is followed.
    table, status : results, described in `solve`; of a stall the first two columns hold the
        driver angle [rad] and the engagement. A scene with another status than OK is left out; see
        `mark_jammed`.
    """
    shared, size = scene_of(packed), patterns.shape[1]
    room, handoffs, rows = transient_memory(shared.edges, size)
    fixed = new_case(addresses, shared, cells, patterns[0], room)
    asked = handoffs, rows, rtol, extent
    if size > 0 or cells.size > 0:
        _solve_alike(fixed, patterns, numbers, asked, table, status)
        return
    for i in range(status.size):
        one, pin = slice(i, i + 1), numbers[i, _PIN]
        edges = slide_edges(shared.path, pin, shared.edges) if pin > 0.0 else shared.edges
        case = altered(fixed, "scene", altered(shared, "edges", edges))
        _solve_alike(case, patterns[one], numbers[one], asked, table[one], status[one])


@inner_jit
def _solve_alike(fixed, patterns, numbers, asked, table, status):
    """Solve scenes with the edges of the case `fixed`; `asked` are inputs of `figures`."""
    for i in range(status.size):
        if status[i] == OK:
            row, scene = numbers[i], fixed.scene
            scene = scene_with(scene, scene.edges, row)
            case = held(altered(fixed, "scene", scene, "pattern", patterns[i]))
            prepare(case)
            handoffs, rows, rtol, extent = asked
            status[i] = figures(case, handoffs, rows, row[_COUNT], rtol, extent, table[i])


@jit(allocates=True)
def mark_jammed(packed, patterns, numbers, status):
    """Mark the scenes at or above the Painleve limit, at which a march would divide by zero.

    The arguments are those of `solve_rows`.
    """
    _mark_jammed(scene_of(packed), patterns, numbers, status)


@inner_jit
def _mark_jammed(shared, patterns, numbers, status):
    limit = FrictionLimit(np.nan, np.nan, np.nan, np.nan, np.inf)
    for i in range(status.size):
        scene, jammed = scene_with(shared, shared.edges, numbers[i]), 0
        if status[i] != OK:
            continue
        if patterns.shape[1] == 0 and has_limit_of_its_own(scene):
            # mostly neighbours differ in friction and torque, and have one limit
            limit = friction_limit_after(limit, scene)
            jammed += scene.mu_minus >= limit.friction
        else:
            for index in range(max(patterns.shape[1], 1)):
                jammed += beyond_painleve(scene_of_pair(scene, patterns[i], index, 0.0))
        if jammed > 0:
            status[i] = PAINLEVE


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
    scene, own_pins = _shared(mechanism, rows if errors is None else rows[:0])
    kind, size, at_once = kind_of(CONSTANT, numbers[:_COUNT]), 0, max(len(rows), 1)
    wheel: Any = mechanism
    if errors is not None:
        size = int(np.lcm(errors[1].shape[1], errors[2].shape[1]))
        at_once = max(_AT_ONCE // size, 1)
    fixed = kernel_addresses(kind), packed(scene)
    cells = NO_CELLS if size or own_pins else cells_of(scene.path, scene.edges)
    for first in range(0, len(rows), at_once):
        some = slice(first, first + at_once)
        patterns = np.empty((len(rows[some]), size), PAIR)
        if errors is not None:
            longer, pins, slots = (each[some] for each in errors)
            given = longer, rows[some, _PIN], pins, slots
            lay_patterns(*wheel.path_numbers.values(), *given, patterns, status[some])
        mark_jammed(fixed[1], patterns, rows[some], status[some])
        inputs = cells, patterns, rows[some], rtol, int(extent)
        solve_rows(*fixed, *inputs, table[some], status[some])
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
        Some of `PEAKS`.

    Returns
    -------
    dict of ndarray, shape (n,)
        Each of them in natural units.
    """
    rows, speeds = np.ascontiguousarray(numbers.T, dtype=float), np.ascontiguousarray(speeds)
    scene, own_pins = _shared(mechanism, rows)
    table = np.tile([0.0 if name in wanted else np.inf for name in PEAKS], (len(rows), 1))
    kind = kind_of(CONSTANT, numbers[:_COUNT])
    cells = NO_CELLS if own_pins else cells_of(scene.path, scene.edges)
    peak_rows(kernel_addresses(kind), packed(scene), cells, NO_PATTERN, rows, speeds, rtol, table)
    return {name: column for name, column in zip(PEAKS, table.T, strict=True) if name in wanted}


def _shared(mechanism: Mechanism, rows: FloatArray) -> tuple[Scene, bool]:
    """The scene that cases share, whose numbers are those of no case, and whether pins differ.

    It has the edges of the pin that all cases have; of a thin pin where they differ.
    """
    if mechanism.pin_radius:
        # each scene has its own pin
        mechanism = replace(mechanism, pin_radius=0.0, roller_radius=0.0)  # type: ignore[type-var]
    path = writeable(mechanism.path)
    edges, dwell = smooth_intervals(path, mechanism.breaks), dwell_angle(mechanism)
    own_pins = bool((rows[:, _PIN] != rows[:1, _PIN]).any())
    if len(rows) and not own_pins and rows[0, _PIN] > 0.0:
        edges = slide_edges(path, rows[0, _PIN], edges)
    none = dict.fromkeys(NUMBERS, 0.0)
    torque, flat = np.array(CONSTANT), np.array(NO_CURVE)
    scene = Scene(path, edges, dwell, torque, 0.0, flat, flat, **none)
    return scene, own_pins
