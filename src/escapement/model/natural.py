"""The numbers of a scene in natural units, from the declared numbers of an escapement.

The follower's inertia, the driving torque and the root of their ratio are the units of inertia,
torque and time; the crank radius is that of length.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

from escapement.base.lazy import np
from escapement.base.quantity import Quantity, quantities
from escapement.model.checks import is_given
from escapement.model.materials import first_given

_JOURNALS = ("driver_journal", "follower_journal")
_SLOT = ("mu_plus", "mu_minus", "pin", *_JOURNALS)
"""Numbers of a `Scene` that belong to the contact."""


@cache
def resisting() -> tuple[Quantity, ...]:
    """The declared numbers that are a field of a `Scene` in the natural unit of their kind."""
    from escapement.model.escapement import Escapement  # it imports this module

    return tuple(entry for entry in quantities(Escapement).values() if entry.scene)


def natural(values: Mapping[str, Any], meshed: bool) -> dict[str, Any]:
    """Numbers of a `Scene` by their names, from numbers or arrays in SI.

    Parameters
    ----------
    values : Mapping
        What `Escapement` and `Inertia` declare, by the names that studies use [SI].
    meshed : bool
        Whether the losses of the mechanism are given by an efficiency, not by friction in a slot.
    """
    follower, torque = values["follower_inertia"], values["torque"]
    units = {"torque": torque, "drag": follower, "viscous": (follower * torque) ** 0.5}
    found = {entry.scene: values[entry.name] / units[entry.unit] for entry in resisting()}
    found["rho"] = values["driver_inertia"] / follower
    none = 0.0 * found["load"]
    found |= {"gain": none + 1.0, "flow": none - 1.0}
    found["motor"] = none + _behind_losses(values) / units["viscous"]
    top = values.get("top_speed")
    found["pace"] = none + (0.0 if top is None else (torque / follower) ** 0.5 / top)
    for name, far in (("barrel", -2.0), ("load_train", 2.0)):
        # the far shaft of a barrel's train turns slower, that of the other one faster
        ratio, inertia = values.get(f"{name}_ratio"), values.get(f"{name}_inertia")
        share = none if ratio is None or inertia is None else inertia * ratio**far / follower
        given = values.get(f"{name}_efficiency")
        found |= {name: share, f"{name}_efficiency": none + (1.0 if given is None else given)}
    if meshed:
        losses = 1.0 / values["efficiency"] - 1.0, 1.0 - values["efficiency"]
        return found | dict(zip(_SLOT, (*losses, *(none,) * 3), strict=True))
    friction, pin = rolling(values)
    # without a length all radii are 0
    length = first_given(values["crank_radius"], 1.0)
    journals = [
        values[f"{body}_bearing_friction"] * values[f"{body}_bearing_radius"]
        for body in ("driver", "follower")
    ]
    if any(map(is_given, journals)):
        share = np.hypot(1.0, friction) / length
        journals = [journal * share for journal in journals]
    return found | dict(zip(_SLOT, (friction, friction, pin / length, *journals), strict=True))


def _behind_losses(values: Mapping[str, Any]) -> Any:
    """Slope of a motor's torque over its speed, referred to the driver, where its train loses
    power; 0 elsewhere, where it acts like drag of the driver.
    """
    slope, efficiency = values.get("motor_viscous"), values.get("barrel_efficiency")
    if slope is None or efficiency is None:
        return 0.0
    return np.where(np.asarray(efficiency) == 1.0, 0.0, slope)


def rolling(values: Mapping[str, Any]) -> tuple[Any, Any]:
    """Friction and radius of the body that touches the slot: the pin, or a roller on it.

    A roller turns on the pin, and the friction then acts between the two. A massless roller that
    rolls on the wall acts like a pin of its radius with less friction.
    """
    friction, pin, roller = values["friction"], values["pin_radius"], values["roller_radius"]
    if not is_given(roller):
        return friction, pin
    rolls = np.asarray(roller) > 0.0
    q = pin / np.where(rolls, roller, np.inf) * friction / np.hypot(1.0, friction)
    return np.where(rolls, q / np.sqrt(1.0 - q * q), friction), np.where(rolls, roller, pin)


def slid(values: Mapping[str, Any], friction: float) -> float:
    """Friction between a roller and its pin that has the effect of `friction` in the slot, see
    `rolling`; without a roller `friction` itself. It is infinite if no friction has such an
    effect.
    """
    roller = values.get("roller_radius")
    if not roller:
        return friction
    q = friction / math.hypot(1.0, friction) * roller / values["pin_radius"]
    return q / math.sqrt(1.0 - q * q) if q < 1.0 else math.inf
