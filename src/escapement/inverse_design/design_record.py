"""What is told of the designs that satisfy a requirement for a timer."""

from typing import Any

from escapement.base.quantity import declared
from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.spoken import on_drawing
from escapement.inverse_design.requirement import BOUNDS
from escapement.inverse_design.timer_search import FOIL, Designs
from escapement.mechanisms import Geneva
from escapement.model.escapement import Escapement

_CHOSEN = ("slots", "pins", "internal", "crank_radius", "pin_radius", "torque", "friction",
           "spring_rate")  # fmt: skip
_SHORT = "slots", "internal", "crank_radius", "torque"
_DECIDES = ("scatter", "jam_margin", "pressure_max", "driver_thickness", "follower_thickness",
            "thinnest_wall")  # fmt: skip
"""Figures that decide between designs, which tables show even if nobody asked for them."""
RESULTS = {
    name: Result(entry.unit) for name, entry in {**declared(Geneva), **declared(Escapement)}.items()
} | {name: Result(entry.unit, entry.long_name) for name, entry in BOUNDS.items()}  # fmt: skip


def _lines(found: Designs) -> list[dict[str, Any]]:
    """The chosen numbers of every design, and its figures, in SI."""
    lines, names = [], (*_CHOSEN, *found.requirement.losses)
    for one in found.designs:
        given = one.timer.mechanism.settings | one.timer.settings
        chosen = {name: given[name] for name in names}
        lines.append(chosen | one.values | {"can_be_cut": one.can_be_cut})
    return lines


def record_of(found: Designs) -> Record:
    """Every number of every design."""
    lines = _lines(found)
    message = f"{len(lines)} designs, from {found.tried} points tried" if lines else found.message
    if foil := sum(not line["can_be_cut"] for line in lines):
        thin = f"a disc or a wall is thinner than {on_drawing(FOIL)}"
        message += f"; {foil} of them cannot be cut: {thin}"
    return Record({"designs": lines, "message": message}, RESULTS)


def short_record_of(found: Designs) -> Record:
    """The numbers by which a reader chooses: sizes, objectives, bounds and what decides."""
    asked = found.requirement
    figures = *asked.objectives, *asked.bounds, *_DECIDES, "can_be_cut"
    names = dict.fromkeys((*_SHORT, *asked.losses, *figures))
    lines = [{name: line[name] for name in names} for line in _lines(found)]
    return Record({"designs": lines}, RESULTS)
