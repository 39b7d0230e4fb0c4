"""Every number and setting from which an escapement was made."""

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from escapement.base.quantity import Numbers, declared
from escapement.base.text import show
from escapement.model.escapement import Escapement
from escapement.model.load_curve import LoadCurve, Unbalance
from escapement.model.torque_curve import TorqueCurve
from escapement.model.train import numbers_of_trains, train_numbers

Input = tuple[str, Any, str]
"""A name, a value in SI and its kind of unit."""
_LONGEST = 12
"""Values of a list that are told one by one."""


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
        if value is None or entry.idle(value) or not entry.applies_to(meshed):
            continue
        # a default that only matters together with another number
        if entry.needs and value == entry.default and not getattr(owner, entry.needs, True):
            continue
        if isinstance(value, TorqueCurve | LoadCurve):
            yield from inputs_of_curve(name, value)
        elif isinstance(value, Unbalance):
            yield f"{name}_moment", value.moment, "torque"
            yield f"{name}_angle", value.angle, "angle"
        else:
            exact = isinstance(value, Fraction)
            yield name, str(value) if exact else value, "ratio" if exact else entry.unit


def inputs_of_curve(name: str, curve: TorqueCurve | LoadCurve) -> Iterator[Input]:
    """As `inputs_of`, of a torque curve or a load curve."""
    if curve.angle:
        yield f"{name}_angles", shortened([*curve.angle]), "angle"
    torques = [*curve.torque]
    if isinstance(curve, TorqueCurve) and curve.speed:
        yield f"{name}_speeds", shortened([*curve.speed]), "speed"
        torques = curve.table.reshape(-1).tolist()
    yield name, shortened(torques), "torque"


def shortened(values: list[Any]) -> Any:
    """A list of at most a dozen values; of more the ends and their number."""
    if len(values) <= _LONGEST:
        return values
    return {"from": min(values), "to": max(values), "values": len(values)}


def in_words(value: Any) -> Any:
    """A shortened list in words; any other value as it is."""
    if isinstance(value, dict):
        return f"{show(value['from'])} to {show(value['to'])}, {value['values']} values"
    return value
