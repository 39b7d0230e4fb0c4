"""The numbers of an escapement that may vary: reading them, and changing one."""

from dataclasses import replace
from typing import Any

from escapement.base.quantity import quantities
from escapement.model.escapement import Escapement, Inertia
from escapement.model.torque_curve import TorqueCurve
from escapement.model.train import numbers_of_trains

_OF_CONTACT = ("clearance", "restitution", "stiffness", "damping", "slip_speed")
"""Numbers that affect a terminal cycle only with clearance or compliant contact."""

_OF_PIN = ("pin_length", "pin_gap", "pressure_pin_radius")
"""Numbers that affect only stresses of the pin."""


def numbers_of(escapement: Escapement) -> dict[str, float]:
    """The numbers of an escapement that may vary, by the names that studies use [SI]."""
    mechanism: Any = escapement.mechanism
    meshed, length = mechanism.meshed, mechanism.crank_radius
    settings = {**escapement.inertia.settings, **escapement.settings}
    settings["torque"] = full_torque(escapement)
    # the terminal cycle belongs to the full torque of a spring
    left_out = ("spring_rate", *(() if escapement.contact else _OF_CONTACT))
    left_out += () if escapement.pin_length else _OF_PIN
    found = {}
    for entry in (*quantities(Inertia).values(), *quantities(Escapement).values()):
        bare = entry.unit != "length" or length
        # damping that is not given follows from other numbers
        given = settings[entry.name] is not None
        if entry.applies_to(meshed) and bare and given and entry.name not in left_out:
            found[entry.name] = float(settings[entry.name])
    found = {"torque": settings["torque"], **found, **numbers_of_trains(escapement.trains)}
    if mechanism.pitch is not None:
        numbers = quantities(type(mechanism)).items()
        varies = {name: x.default for name, x in numbers if not (x.whole or x.half)}
        for name, value in mechanism.settings.items():
            if name in varies and value != varies[name]:
                found[name] = float(value)
    elif length and not meshed:
        lengths = mechanism.lengths.items()
        own = mechanism.settings.keys() - left_out
        found |= {name: float(value) for name, value in lengths if name in own}
    found |= mechanism.errors
    return found


def full_torque(escapement: Escapement) -> float:
    """The greatest torque of the drive, at the barrel if there is one [N m]."""
    torque: Any = escapement.torque
    return float(torque.greatest if isinstance(torque, TorqueCurve) else torque)


def with_number(escapement: Escapement, name: str, value: float) -> Escapement:
    """The escapement with another value of one number, by its name in studies [SI]."""
    if name in ("driver_inertia", "follower_inertia"):
        inertia = replace(escapement.inertia, **{name.removesuffix("_inertia"): value})
        return replace(escapement, inertia=inertia)
    for role, train in escapement.trains.items():
        key = name.removeprefix(f"{role}_")
        if key != name:
            changed: Any = {role: replace(train, **{key: value})}
            return replace(escapement, **changed)
    mechanism: Any = escapement.mechanism
    given: Any = value
    if name == "torque" and isinstance(escapement.torque, TorqueCurve):
        given = escapement.torque * (value / escapement.torque.greatest)
    if name[-1].isdigit():
        name, role = name.rsplit("_", 1)
        # the lists of perfect parts may be empty
        values = [*(mechanism.settings[name] or (0.0,) * mechanism.error_counts[name])]
        values[int(role)] = value
        given = tuple(values)
    if name in mechanism.settings:
        return replace(escapement, mechanism=replace(mechanism, **{name: given}))
    return replace(escapement, **{name: given})
