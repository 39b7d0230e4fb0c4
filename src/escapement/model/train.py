"""Gear trains on either side of the mechanism: before its driver and behind its follower.

A train with ratio i turns its far shaft slower by i where it is a barrel's, which drives the
driver, and faster by i where it is behind the follower. One that loses nothing is the same as an
escapement with other numbers, those that its driver and its follower see: see `referred`. What one
loses that does lose some depends on the direction of its power: see `dynamics.train_losses`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

from escapement.base import validate
from escapement.base.quantity import Declared, Quantity, quantities, quantity

ROLES = ("barrel", "load_train")
"""Where a train may be: before the driver, and behind the follower."""


@dataclass(frozen=True, repr=False)
class Train(Declared):
    """A gear train without backlash, from a barrel to the driver or from the follower to a load.

    Parameters
    ----------
    ratio : float
        Turns of the faster end over turns of the slower one [-], > 0: driver turns per barrel
        turn, or turns of the last shaft per follower turn.
    efficiency : float
        Share of the power that the train passes on, either way [-], in [0.001, 1].
    inertia : float
        Moment of inertia of the far shaft, barrel or last shaft [kg m^2], >= 0.

    Source: the balance of power of a train, an extension of Meyer (1973), chapter I.
    """

    ratio: float = field(metadata=quantity(
        "turns of the faster end of the {} over turns of its slower end", exclusive=True,
        metavar="I", remedy="give for example 5"
    ))  # fmt: skip
    efficiency: float = field(default=1.0, metadata=quantity(
        "share of the power that the {} passes on", metavar="E", minimum=1e-3, maximum=1.0,
        remedy="give a share of 1, 1 for no loss"
    ))  # fmt: skip
    inertia: float = field(default=0.0, metadata=quantity(
        "moment of inertia of the far shaft of the {}", "inertia",
        remedy="give the moment of inertia, 0 for none"
    ))  # fmt: skip

    def __post_init__(self) -> None:
        self.check_fields()


@cache
def train_numbers() -> dict[str, Quantity]:
    """The numbers of both trains by the names that studies use, such as `barrel_ratio`.

    None has a default: what is not given is left to `Train`.
    """
    found = {}
    for role in ROLES:
        for key, entry in quantities(Train).items():
            name, words = f"{role}_{key}", entry.long_name.format(role.replace("_", " "))
            without = "" if key == "ratio" else f", {entry.default:g} where none is given"
            named: dict[str, Any]
            named = {"name": name, "key": key, "section": role, "long_name": words}
            found[name] = replace(entry, **named, default=None, required=False, note=without)
    return found


def trains_of(values: Mapping[str, Any]) -> dict[str, Train]:
    """The trains that numbers by the names of `train_numbers` describe, by their roles.

    Raises
    ------
    InvalidValue
        When a train is given without its ratio.
    """
    check_ratios(name for name, value in values.items() if value is not None)
    found = {}
    for role in ROLES:
        given: dict[str, Any] = {key: values.get(f"{role}_{key}") for key in quantities(Train)}
        if given["ratio"] is not None:
            found[role] = Train(**{k: value for k, value in given.items() if value is not None})
    return found


def check_ratios(names: Iterable[str]) -> None:
    """Refuse a train, of which some numbers are given, without its ratio."""
    given = {*names}
    if given.isdisjoint(train_numbers()):
        return
    for role in ROLES:
        name, others = f"{role}_ratio", {f"{role}_{key}" for key in quantities(Train)}
        if name not in given and (lone := sorted(others & given)):
            raise validate.fail(name, f"given with {lone[0]}", None, "give the ratio of its turns")


def numbers_of_trains(trains: Mapping[str, Train]) -> dict[str, float]:
    """The numbers of trains, which stand by their roles, by the names of `train_numbers`."""
    return {
        f"{role}_{name}": value
        for role, train in trains.items()
        for name, value in train.settings.items()
    }


def referred(values: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers that driver and follower see: of a barrel, of what is behind the follower.

    With i turns of the driver for each of the barrel, torque and inertia of the barrel act on the
    driver as torque/i, inertia/i^2, and the torque that a spring loses as rate/i^2. With i turns of
    the last shaft for each of the follower, its load and inertia act as i load and i^2 inertia.

    A motor's torque falls with its speed like that of a constant torque with viscous drag, which
    `driver_viscous` then contains, and `motor_viscous` has alone.

    Parameters
    ----------
    values : Mapping
        Numbers or arrays by the names that studies use [SI]; a train that is not there has no
        ratio, or None.
    """
    found = dict(values)
    if (ratio := values.get("barrel_ratio")) is not None:
        found["torque"] = values["torque"] / ratio
        found["spring_rate"] = values["spring_rate"] / ratio**2
        if (inertia := values.get("barrel_inertia")) is not None:
            found["driver_inertia"] = values["driver_inertia"] + inertia / ratio**2
    if (top := values.get("top_speed")) is not None and ratio is not None:
        found["top_speed"] = top * ratio
    if (speed := values.get("no_load_speed")) is not None:
        found["no_load_speed"] = speed if ratio is None else speed * ratio
        found["motor_viscous"] = found["torque"] / found["no_load_speed"]
        found["driver_viscous"] = values["driver_viscous"] + found["motor_viscous"]
    if (ratio := values.get("load_train_ratio")) is not None:
        found["load_torque"] = ratio * values["load_torque"]
        if (inertia := values.get("load_train_inertia")) is not None:
            found["follower_inertia"] = values["follower_inertia"] + inertia * ratio**2
    return found
