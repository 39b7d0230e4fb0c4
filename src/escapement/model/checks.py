"""Checks whether numbers of a model fit together, and whether they fit its mechanism."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Declared, Quantity, Setting, declared, per_class, quantities
from escapement.model.load_curve import steps_of


def check_contact(contact: str, mechanism: Any, values: Mapping[str, Any]) -> None:
    """Refuse clearance and stiffness for mechanisms whose contact cannot be computed.

    contact : "", "rigid", "compliant" or that of outlines, as `Escapement.contact` says.
    """
    if not contact or contact.endswith("outlines"):
        return
    name = "stiffness" if contact == "compliant" else "clearance"
    value = values[name] if contact == "compliant" else mechanism.clearance
    if not mechanism.takes_clearance:
        rule = "0 for a mechanism that is not a Geneva wheel"
        raise validate.fail(name, rule, value, "choose geneva, or leave it out")
    if not mechanism.perfect:
        raise validate.fail(name, "0 with errors of the parts", value, "leave out one or the other")


_SWINGING = ("follower_spring", "follower_gravity", "follower_rest_angle")
"""Numbers of the follower of two bodies that touch with their outlines."""
_NO_OUTLINES = {
    "pin_length": (
        "stresses are told of pins in straight slots",
        "compute them from contact_force_max and the radii where the bodies touch",
    ),
    "load_curve": (
        "their follower swings, and its load is a constant torque, a spring or a weight",
        "give load_torque, follower_spring or follower_gravity",
    ),
}
"""What bodies with outlines cannot have, why, and what to do."""


def check_outlines(owner: Any) -> None:
    """Refuse what only mechanisms with outlines have, or what these cannot have."""
    if owner.mechanism.pitch is None:
        for name in _SWINGING:
            if value := getattr(owner, name):
                rule = "0 for a mechanism without outlines of both bodies"
                raise validate.fail(name, rule, value, "choose runaway, or leave it out")
        return
    if owner.friction and owner.friction >= owner.mechanism.wedge_friction:
        most = owner.mechanism.wedge_friction
        rule = f"less than {most:.4g}, from which on tooth and pallet wedge each other"
        raise validate.fail("friction", rule, owner.friction, "give steeper faces or less friction")
    if owner.follower_rest_angle and not (owner.follower_spring or owner.follower_gravity):
        remedy = "give follower_spring or follower_gravity"
        rule = "0 for a follower without a spring and without a weight"
        raise validate.fail("follower_rest_angle", rule, owner.follower_rest_angle, remedy)
    for name, (reason, remedy) in _NO_OUTLINES.items():
        if value := getattr(owner, name):
            rule = f"left out with outlines of both bodies: {reason}"
            raise validate.fail(name, rule, value, remedy)
    for role, train in owner.trains.items():
        if (passed := train.efficiency) < 1.0:
            rule = "1 with outlines, whose engine does not follow which way power flows"
            remedy = f"give {passed:g} of the torque" if role == "barrel" else ""
            remedy = remedy or f"give 1/{passed:g} of the load torque"
            raise validate.fail(f"{role}_efficiency", rule, passed, remedy)


def check_load(owner: Any) -> None:
    """Refuse a load over the follower angle that does not repeat in a step or a turn of it."""
    if owner.load_curve is not None:
        steps_of(owner.load_curve, abs(float(owner.mechanism.follower_step)))


def check_pin(values: Mapping[str, Any], mechanism: Any) -> None:
    """Refuse the length of a pin of which the stresses cannot be told."""
    if not (length := values["pin_length"]):
        return
    if not mechanism.crank_radius:
        rule, remedy = "0 for a mechanism without a length", "give the crank radius"
        raise validate.fail("pin_length", rule, length, remedy)
    sizes = values["pressure_pin_radius"], mechanism.pin_radius, values.get("pressure_limit")
    if not any(sizes):
        rule = "given with the radius of the pin"
        raise validate.fail("pin_length", rule, length, "give pin_radius or pressure_pin_radius")


def check_speeds(owner: Any) -> None:
    """Refuse a torque over the speed where no engine computes it."""
    if owner.drive_curve is not None and owner.drive_curve.speed and owner.contact:
        rule = "without speeds with clearance or stiffness"
        remedy = "leave those out: engines energy and ivp have a torque over the speed"
        raise validate.fail("torque", rule, owner.torque, remedy)


def check_trains(owner: Any, running_down: bool) -> None:
    """Refuse trains that lose power where no engine computes them.

    running_down : whether the torque of the drive may come to an end.
    """
    for role, train in owner.trains.items():
        if train.efficiency == 1.0:
            continue
        name, value = f"{role}_efficiency", train.efficiency
        if not owner.mechanism.perfect:
            raise validate.fail(name, "1 with errors of the parts", value, "leave out one of them")
        over_speed = owner.drive_curve is not None and owner.drive_curve.speed
        if running_down and (over_speed or any(value for _, value in _viscous(owner))):
            rule = "1 with viscous drag and a spring that runs down"
            if over_speed:
                rule = "1 with a torque over angle and speed"
            raise validate.fail(name, rule, value, "leave out one of them")


def _viscous(owner: Declared) -> list[tuple[str, Any]]:
    """Names and values of drag proportional to the speed."""
    kinds = quantities(type(owner)).values()
    return [(x.name, getattr(owner, x.key)) for x in kinds if x.unit == "viscous"]


@per_class
def _numbers_of_contact(owner: type) -> list[Quantity]:
    """Numbers that only mechanisms with slots have, or only those without."""
    return [entry for entry in quantities(owner).values() if entry.slotted is not None]


def check_losses(owner: Declared, meshed: bool) -> None:
    """Refuse a loss that the mechanism cannot have: slots have friction, gears an efficiency."""
    for entry in _numbers_of_contact(type(owner)):
        value = getattr(owner, entry.key)
        if value != entry.default and not entry.applies_to(meshed):
            mechanism = "mechanism without a slot" if meshed else "slotted mechanism"
            rule = f"{entry.default:g} for a {mechanism}"
            raise validate.fail(entry.name, rule, value, f"give its {entry.instead}")


@per_class
def _dependent(owner: type) -> list[Setting]:
    """Settings that have no effect without another one."""
    return [entry for entry in declared(owner).values() if entry.needs]


def idle_settings(owner: type, values: Mapping[str, Any]) -> str:
    """Which settings have no effect, since another one is missing; "" if there are none.

    owner : the class that declares them.
    values : numbers, or arrays of those that vary, by name.
    """
    notes = []
    for entry in _dependent(owner):
        value = values.get(entry.name)
        plain = not hasattr(value, "any")
        if value is None or (plain and (value == entry.default or _alike(value, entry.default))):
            continue
        # compliant walls have impacts without clearance, too
        enough = (entry.needs, "stiffness") if entry.needs == "clearance" else (entry.needs,)
        if not any(is_given(values.get(name)) for name in enough):
            notes.append(f"{entry.name} has no effect without {entry.needs}")
    return "; ".join(notes)


def refuse_idle(owner: Declared) -> None:
    """Refuse a setting that has no effect, since another one is missing."""
    for entry in _dependent(type(owner)):
        value = getattr(owner, entry.key)
        given = value != entry.default and not _alike(value, entry.default)
        if given and not is_given(getattr(owner, entry.needs)):
            raise InvalidValue(
                f"{entry.name} must come with {entry.needs}, got none; it has no effect alone"
            )


def _alike(value: Any, default: Any) -> bool:
    """Whether a number is a default that was converted from other units, with its rounding."""
    both = isinstance(value, float) and isinstance(default, float)
    return both and math.isclose(value, default, rel_tol=1e-12)


def is_given(value: Any) -> bool:
    """Whether a number, or one of an array, is not 0."""
    return bool(value.any() if hasattr(value, "any") else value)
