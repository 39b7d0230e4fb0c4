"""Similarity: an escapement that does the same in another time under another torque.

Torques grow with the torque of the drive, and moments of inertia with torque times time squared.
Lengths stay, so that forces grow with the torque.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

from escapement.base.quantity import quantities
from escapement.model.escapement import Escapement, Inertia
from escapement.model.train import ROLES

_POWERS = {
    **{"torque": (1, 0), "rate": (1, 0), "stiffness": (1, 0), "inertia": (1, 2)},
    **{"viscous": (1, 1), "damping": (1, 1), "drag": (1, 2), "slip": (0, -1), "speed": (0, -1)},
}
"""Powers of torque and time by the kind of unit; other numbers stay."""


def similar(escapement: Escapement, torque: float, time: float) -> Escapement:
    """The escapement with its torques and its times multiplied by two factors."""

    def factor(unit: str) -> float:
        of_torque, of_time = _POWERS.get(unit, (0, 0))
        return float(torque**of_torque * time**of_time)

    changes: dict[str, Any] = {"torque": cast(Any, escapement.torque) * torque}
    for name, entry in quantities(Escapement).items():
        if name != "torque" and (value := getattr(escapement, entry.key)) is not None:
            changes[name] = factor(entry.unit) * value
    if escapement.load_curve is not None:
        changes["load_curve"] = escapement.load_curve * torque
    for role in ROLES:
        if (train := getattr(escapement, role)) is not None:
            changes[role] = replace(train, inertia=factor("inertia") * train.inertia)
    bodies = (
        factor("inertia") * x for x in (escapement.inertia.driver, escapement.inertia.follower)
    )
    return replace(escapement, inertia=Inertia(*bodies), **changes)
