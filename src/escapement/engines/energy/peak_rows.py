"""The greatest accelerations, moments and forces of many scenes of one mechanism.

`batch.solve_rows` finds the terminal speed of each. Here its engagement is marched once more with
all its events, and each piece between them is searched as `peaks` says.
"""

import numpy as np

from escapement.dynamics.codes import Event
from escapement.dynamics.law import LOSSES, scene_of, scene_with
from escapement.engines.energy import panels
from escapement.engines.energy.located_events import NO_EVENTS
from escapement.engines.energy.march import OK
from escapement.engines.energy.pairs import (
    Start,
    engage,
    make_exact,
    new_case,
    prepare,
)
from escapement.engines.energy.passage import Detail, request_of
from escapement.engines.energy.pieces import HALVINGS, ROOM, Asked, side_at_entry, states_in
from escapement.mechanisms.slotted import slide_edges
from escapement.model.torque_curve import MOST_KNOTS
from escapement.numerics.altered import altered
from escapement.numerics.held import held
from escapement.numerics.jit import inner_jit, jit

_LOST = len(LOSSES)


@jit(allocates=True)
def peak_rows(addresses, packed, cells, pattern, numbers, speeds, rtol, table):
    """Raise table[i] to `PEAKS` of the terminal engagement of scene i, in natural units.

    Parameters
    ----------
    addresses, packed, cells, numbers, rtol : as of `batch.solve_rows`.
    pattern : that of perfect parts, which is empty.
    speeds : driver speed at the terminal handoff of each scene; NaN where there is none.
    table : 0 for each peak that is wanted, and otherwise infinite, shape (scenes, peaks); NaN
        where there is no cycle.
    """
    shared, store, ends = scene_of(packed), panels.new_store(1), np.empty(HALVINGS)
    room = ROOM + 8 * shared.edges.size + MOST_KNOTS
    fixed, lost = new_case(addresses, shared, cells, pattern, room), np.empty(_LOST)
    for i in range(speeds.size):
        if not speeds[i] > 0.0:
            _miss(table[i])
            continue
        scene = scene_with(shared, shared.edges, numbers[i])
        if scene.pin > 0.0 and cells.size == 0:
            scene = scene_with(
                shared, slide_edges(shared.path, scene.pin, shared.edges), numbers[i]
            )
        inputs = altered(fixed, "scene", scene)
        _peaks_of(inputs, speeds[i] * speeds[i], rtol, store, ends, lost, table[i])


@inner_jit(allocates=True)
def _peaks_of(inputs, w, rtol, store, ends, lost, peaks):
    """Raise the peaks to those of the engagement that begins with w."""
    case, scene, nothing = held(inputs), inputs.scene, np.empty(0)
    prepare(case)
    found = engage(case, 0, Start(w, 0.0, NO_EVENTS), request_of(Detail.EVERYTHING, rtol), 0.0)
    if found.status != OK:
        _miss(peaks)
        return
    side, left = side_at_entry(found.side, case.events, found.used), scene.edges[0]
    for i in range(found.used + 1):
        end, kind, after = scene.edges[-1] + scene.dwell, Event.EXIT, w
        if i < found.used:
            kind = case.events[i].kind
            if not (kind == Event.REVERSAL or kind == Event.EXIT or kind == Event.BREAK):
                continue
            make_exact(case, i, 0.0)
            end, after = case.events[i].angle, case.events[i].w
        if end > left:
            asked = Asked(times=nothing, theta=nothing, squares=nothing, end=end)
            states_in(scene, store, ends, left, w, side, rtol, asked, lost, peaks)
        left, w = end, after
        if kind == Event.REVERSAL:
            side = -side
        elif kind == Event.EXIT:
            side = 0.0


@inner_jit
def _miss(peaks):
    """Set all peaks to NaN."""
    for j in range(peaks.size):
        peaks[j] = np.nan
