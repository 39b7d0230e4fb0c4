"""The two long kernels of the engine, `march` and `refine`, which others call by address.

If they were called by name they would be compiled again in every caller. Their callers take
scenes of any kind, and the address decides for which of them the kernel was compiled.
"""

from functools import cache
from typing import Any

import numpy as np
from numba import typeof, types

from escapement.dynamics.needs import FIXED, KINDS, Kind, kind_of
from escapement.engines.energy import located_events as _events
from escapement.engines.energy import march as _march
from escapement.engines.energy.cells import CELL, NO_CELLS, cells_of
from escapement.engines.energy.located_events import EVENT
from escapement.engines.energy.panels import PANEL, WORKSPACE, Store
from escapement.engines.energy.passage import Detail, Request
from escapement.mechanisms.path import Path
from escapement.mechanisms.pattern import PAIR
from escapement.model.escapement import Escapement, once_per_escapement
from escapement.model.load_cells import in_a_round
from escapement.model.scene import Scene, packed
from escapement.numerics.by_address import by_address
from escapement.numerics.interpreted import when_compiled

NO_PATTERN = np.empty(0, PAIR)
"""The pattern where all engagements are alike, with the scene of the escapement."""

# The types of the arguments are read off empty samples. A call by address needs them before
# there is a caller, and they must be those of every caller.
_numbers = np.empty(0)
_path, _zeros = Path(False, _numbers), (0.0,) * (len(Scene._fields) - 7)
_sample = Scene(_path, _numbers, 0.0, _numbers, 0.0, _numbers, _numbers, *_zeros)
_scene = typeof(_sample)
_store = typeof(Store(np.empty(0, PANEL), np.empty(0, WORKSPACE)))
_cells, _event = typeof(np.empty((0, 0), CELL)), typeof(np.empty(0, EVENT))
_request = typeof(Request(Detail.MAP, 0.0, 0.0))
_f, _i = types.float64, types.int64

_inputs = (_scene, _cells, _store, _i, _request, _f, _f, _event, _i)
march, _march_address = by_address(_march.march, 0, KINDS, _inputs)
refine, _refine_address = by_address(_events.refine, 1, KINDS, (_scene, _store, _event, _i))


@cache
def kernel_addresses(kind: Kind = Kind.SPEED) -> np.ndarray:
    """Addresses of `march` and `refine` in this process, the first argument of their calls.

    They are 0 as long as kernels are not compiled.
    """
    addresses = np.zeros(2, dtype=np.int64)

    def fill() -> None:
        addresses[:] = _march_address(kind), _refine_address(kind)

    when_compiled(fill)
    return addresses


@once_per_escapement
def scene_and_pattern(escapement: Escapement) -> tuple[Scene, np.ndarray]:
    """The scene that all engagements share, and their pattern, see `pairs.scene_of_pair`.

    With a load that changes, the scene holds the loads of all engagements, and the edges of the one
    that has most of them.
    """
    scene, scenes, wheel = escapement.scene, escapement.scenes, escapement.mechanism
    if len(scenes) == 1:
        return scene, NO_PATTERN
    if wheel.perfect:
        pattern = np.zeros(len(scenes), PAIR)
        pattern["dwell"] = scene.dwell
        if not scene.path.table:
            pattern["pin_numbers"] = scene.path.numbers
    else:
        pattern = np.resize(wheel.pattern, len(scenes))  # type: ignore[attr-defined]
    if escapement.load_curve is None:
        return scene, pattern
    most = max((one.edges for one in scenes), key=len)
    loads = in_a_round([(one.edges, one.load_curve) for one in scenes])
    return scene._replace(edges=most, load_curve=loads), pattern


@once_per_escapement
def prepared(escapement: Escapement) -> tuple[Any, ...]:
    """Addresses of the long kernels, packed scene, cells of the mechanism, and pattern.

    They are kept on the escapement, so that its next call does not tabulate the cells again.
    """
    scene, pattern = scene_and_pattern(escapement)
    kind = max(kind_of(one.torque, one[FIXED:]) for one in escapement.scenes)
    kind = max(kind, Kind.WHOLE) if scene.load_curve.size > 1 else kind
    cells = NO_CELLS if pattern.size else cells_of(scene.path, scene.edges)
    return kernel_addresses(kind), packed(scene), cells, pattern
