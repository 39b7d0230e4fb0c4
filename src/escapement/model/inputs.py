"""Every number and setting from which an escapement was made."""

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from escapement.base.quantity import Numbers, declared
from escapement.model.escapement import Escapement
from escapement.model.torque_curve import TorqueCurve
from escapement.model.train import numbers_of_trains, train_numbers

Input = tuple[str, Any, str]
"""A name, a value in SI and its kind of unit."""


def inputs_of(escapement: Escapement) -> Iterator[Input]:
    """Every number and choice of an escapement: its name, its value in SI and its unit.

    Optional numbers that are 0 are left out, except friction and load.
    """
    mechanism: Any = escapement.mechanism
    yield from inputs_of_mechanism(mechanism)
    for owner in (escapement.inertia, escapement):
        yield from inputs_of_settings(owner, mechanism.meshed)
    for name, value in numbers_of_trains(escapement.trains).items():
        yield name, value, train_numbers()[name].unit


def inputs_of_mechanism(mechanism: Any) -> Iterator[Input]:
    """As `inputs_of`, of a mechanism."""
    yield "kind", mechanism.kind, "ratio"
    yield from inputs_of_settings(mechanism, mechanism.meshed)


def inputs_of_settings(owner: Any, meshed: bool) -> Iterator[Input]:
    """As `inputs_of`, of anything that has declarations; `meshed` is as of its mechanism."""
    for name, entry in declared(type(owner)).items():
        value = getattr(owner, entry.key)
        if isinstance(entry, Numbers):
            # errors are listed if there are any; the angles of a table are too many
            value = [*value] if value and not entry.required else None
        told = value is not None and not entry.idle(value)
        if told and entry.fits(meshed):
            told = isinstance(value, Fraction | TorqueCurve)
            yield name, str(value) if told else value, "ratio" if told else entry.unit
