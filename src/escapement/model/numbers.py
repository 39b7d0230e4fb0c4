"""The numbers of an escapement that may vary: reading them, and changing one."""

from dataclasses import replace
from typing import Any

from escapement.base.quantity import quantities
from escapement.mechanisms.checks import LENGTHS
from escapement.model.escapement import Escapement, Inertia
from escapement.model.torque_curve import TorqueCurve
from escapement.model.train import PLACES, numbers_of_trains

_OF_CONTACT = ("clearance", "restitution", "stiffness", "damping", "slip_speed")
"""Numbers that affect a terminal cycle only with clearance or compliant contact."""


def numbers_of(escapement: Escapement) -> dict[str, float]:
    """The numbers of an escapement that may vary, by the names that studies use [SI]."""
    mechanism: Any = escapement.mechanism
    meshed, length = escapement.scene.path.table, getattr(mechanism, LENGTHS[0], None)
    owners = {**vars(escapement.inertia), **vars(escapement)}
    # the terminal cycle belongs to the full torque of a spring
    left_out = ("spring_rate", *(() if escapement.contact else _OF_CONTACT))
    found = {}
    for entry in (*quantities(Inertia).values(), *quantities(Escapement).values()):
        bare = entry.unit != "length" or length
        # damping that is not given follows from other numbers
        given = owners[entry.key] is not None
        if entry.fits(meshed) and bare and given and entry.name not in left_out:
            found[entry.name] = float(owners[entry.key])
    found = {"torque": full_torque(escapement), **found, **numbers_of_trains(escapement)}
    if length and not meshed:
        lengths = (name for name in LENGTHS if name not in left_out)
        found |= {name: float(getattr(mechanism, name, None) or 0.0) for name in lengths}
    return found | error_names(mechanism)


def full_torque(escapement: Escapement) -> float:
    """The greatest torque of the drive, at the barrel if there is one [N m]."""
    torque = escapement.torque
    return torque.greatest if isinstance(torque, TorqueCurve) else torque


def error_names(mechanism: Any) -> dict[str, float]:
    """The errors of the parts by the names that studies use [SI]; none for other mechanisms."""
    if getattr(mechanism, "perfect", True):
        return {}
    found = {"centre_distance_error": mechanism.centre_distance_error}
    for name, count in mechanism.error_counts.items():
        values = getattr(mechanism, name) or (0.0,) * count
        found |= {f"{name}_{i}": float(value) for i, value in enumerate(values)}
    if not mechanism.crank_radius:
        found = {name: value for name, value in found.items() if "angle" in name}
    return found


def with_number(escapement: Escapement, name: str, value: float) -> Escapement:
    """The escapement with another value of one number, by its name in studies [SI]."""
    if name in ("driver_inertia", "follower_inertia"):
        own = replace(escapement.inertia, **{name.removesuffix("_inertia"): value})
        return replace(escapement, inertia=own)
    for place in PLACES:
        key = name.removeprefix(f"{place}_")
        if key != name and (train := getattr(escapement, place)) is not None:
            changed: Any = {place: replace(train, **{key: value})}
            return replace(escapement, **changed)
    mechanism: Any = escapement.mechanism
    given: Any = value
    if name[-1].isdigit():
        name, place = name.rsplit("_", 1)
        values = list(getattr(mechanism, name))
        values[int(place)] = value
        given = tuple(values)
    if hasattr(mechanism, name):
        return replace(escapement, mechanism=replace(mechanism, **{name: given}))
    return replace(escapement, **{name: given})
