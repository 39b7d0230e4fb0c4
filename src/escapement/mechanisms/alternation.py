"""Whether two pallets let one tooth of an escape wheel after the other go by.

It is decided in the plane of wheel angle and verge angle. Each pallet blocks a range of wheel
angles at each verge angle. The teeth go by one at a time if what is free leads once around the
wheel, and if at no verge angle the wheel is free all around.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.mechanisms.protocol import FloatArray

_NAMES = ("entry", "exit")
_ROWS, _COLUMNS = 101, 512
_COARSE, _FINE = 12, 96  # points of each line and arc of a pallet
_CLOSE = 2e-6  # error of a drop, because chords stand for arcs [rad]
_HALVINGS = 36


class Alternation(NamedTuple):
    """Verge angles at which the pallets release a tooth, and the drops that follow [rad].

    A drop is the wheel angle from there until a tooth meets the other pallet.
    """

    entry_release: float
    exit_release: float
    entry_drop: float
    exit_drop: float


def alternation(
    blocked: Callable[[FloatArray, int], FloatArray],
    innermost: Callable[[int, float], complex],
    pitch: float,
    most: float,
) -> Alternation:
    """What the pallets let by; InvalidValue if they do not let by one tooth after the other.

    blocked, innermost : as of `EscapeWheel`.
    most : verge angles to either side that are searched [rad].
    """
    angles = np.linspace(-most, most, _ROWS)
    between = blocked(angles, _COARSE)
    free = _free(between, pitch)
    _check_free(angles, free)
    releases, drops = [], []
    for pallet, sense in ((0, 1.0), (1, -1.0)):
        inside = ~np.isnan(between[:: int(sense), pallet, 0])
        steps = sense * angles
        last = int(np.flatnonzero(inside)[-1])
        if last == _ROWS - 1:
            raise InvalidValue(
                f"the {_NAMES[pallet]} pallet must leave the wheel within "
                f"{math.degrees(most):.6g} deg of verge angle; give less deep pallets"
            )
        low, high = np.sort(steps)[last : last + 2].tolist()
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            out = abs(innermost(pallet, sense * middle)) >= 1.0
            low, high = (low, middle) if out else (middle, high)
        at = blocked(np.array([sense * low]), _FINE)[0]
        if np.isinf(at[1 - pallet, 0]):
            raise InvalidValue(
                f"the {_NAMES[1 - pallet]} pallet must not reach the roots of the teeth when the "
                f"{_NAMES[pallet]} pallet releases one; give deeper teeth or smaller pallets"
            )
        released = cmath.phase(innermost(pallet, sense * low))
        ahead = (released - at[1 - pallet, 0]) % pitch
        wide = at[1 - pallet, 1] - at[1 - pallet, 0]
        releases.append(sense * low)
        drops.append(-ahead if ahead < wide else pitch - ahead)
    for name, drop in zip(_NAMES, drops, strict=True):
        if not drop >= -_CLOSE:
            raise InvalidValue(
                f"the drop from the {name} pallet must be at least 0, got "
                f"{math.degrees(drop):.4g} deg; give slimmer teeth or pallets"
            )
    _check_way(free)
    return Alternation(*map(float, (*releases, *drops)))


def _free(between: FloatArray, pitch: float) -> Any:
    """Whether the wheel angles of a pitch, the columns, are free at the verge angles, the rows."""
    columns = (np.arange(_COLUMNS) + 0.5) / _COLUMNS * pitch
    low, high = between[:, :, :1], between[:, :, 1:]
    with np.errstate(invalid="ignore"):
        wide = high - low
        taken = np.mod(columns - np.where(np.isfinite(low), low, 0.0), pitch) < wide
    return ~taken.any(axis=1)


def _check_free(angles: FloatArray, free: Any) -> None:
    open_ = np.flatnonzero(free.all(axis=1))
    if open_.size:
        raise InvalidValue(
            "the pallets must stand in the way of the teeth at every verge angle, but both are "
            f"clear of them at {math.degrees(angles[open_[0]]):.4g} deg, and the wheel runs free; "
            "bring the pallets closer to the wheel"
        )


def _check_way(free: Any) -> None:
    from scipy import ndimage

    # a way around leads from a point to the same point one pitch on
    labels, _ = ndimage.label(np.tile(free, 3))
    once = labels[:, _COLUMNS // 2], labels[:, _COLUMNS // 2 + _COLUMNS]
    if not np.any((once[0] == once[1]) & (once[0] > 0)):
        raise InvalidValue(
            "a tooth must be able to go by both pallets, but there is no way between them; give "
            "more room: another span, or pallets farther from the wheel"
        )
