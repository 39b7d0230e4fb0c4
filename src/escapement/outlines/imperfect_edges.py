"""A Geneva wheel with the errors of its parts, as large as they are or exaggerated."""

import cmath
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.mechanisms import Geneva
from escapement.mechanisms.wheel_checks import IMPERFECT
from escapement.outlines.bodies import Land
from escapement.outlines.curves import Curve, FloatArray, chain


def scaled_errors(mechanism: Geneva, factor: float) -> Geneva:
    """The wheel with all errors times a factor; InvalidValue if such a wheel could not turn."""
    factor = validate.number("exaggerate", factor, remedy := "give a factor, 1 for true scale")
    if factor < 0.0:
        raise validate.fail("exaggerate", "at least 0", factor, remedy)
    if factor == 1.0 and not mechanism.misfit:
        return mechanism
    given = {name: mechanism.settings[name] for name in IMPERFECT}
    larger: dict[str, Any] = {
        name: tuple(factor * x for x in value) if isinstance(value, tuple) else factor * value
        for name, value in given.items()
    }
    found = replace(mechanism, **larger)
    if found.misfit and factor != 1.0:
        raise validate.fail("exaggerate", "small enough for pins to meet slots", factor, remedy)
    if found.misfit:
        raise InvalidValue(found.misfit)
    return found


def each(errors: Sequence[float], count: int | None) -> FloatArray:
    """Errors of pins or slots, zeros if none are given."""
    return np.array(errors or (0.0,) * (count or 1), dtype=float)


def imperfect_edge(
    rim: float,
    slot_end: float,
    half_slot: float,
    land: Land,
    angles: FloatArray,
    offsets: FloatArray,
) -> Curve:
    """Edge of the follower with each slot in its own place.

    Parameters
    ----------
    rim, slot_end, half_slot, land :
        As for `slotted_edge`, of the perfect wheel.
    angles, offsets : ndarray, shape (slots,)
        Direction of each slot [rad], clockwise from slot 0 on, and how far its line runs ahead of
        the axis.
    """  # fmt: skip
    corner, away = math.asin(half_slot / rim), math.copysign(math.pi, slot_end - rim)
    pitch = 2.0 * math.pi / angles.size - 2.0 * corner
    sides = offsets[::-1, None] + half_slot * np.array([-1.0, -1.0, 1.0, 1.0])
    along = np.sqrt(rim**2 - sides**2)
    along[:, 1:3] = slot_end
    slots = (along + 1j * sides) * np.exp(1j * angles[::-1])[:, None]
    corners, turns = list[complex](), list[float]()
    for slot, following in zip(slots.tolist(), np.roll(slots, -1, 0).tolist(), strict=True):
        # the land between two slots is drawn out to reach from one to the other
        whole = cmath.phase(following[0] / slot[-1]) % (2.0 * math.pi)
        start = slot[-1] / abs(slot[-1])
        shares = [(cmath.phase(z) - corner) / pitch for z in land[0]]
        rims = [whole]
        if shares:
            rims = [shares[0] * whole, land[1][1], (1.0 - shares[1]) * whole]
        corners += slot
        for z, share in zip(land[0], shares, strict=True):
            corners.append(abs(z) * start * cmath.exp(1j * share * whole))
        turns += [0.0, away, 0.0, *rims]
    edge = chain(corners, turns)
    return edge.reversed() if away > 0.0 else edge
