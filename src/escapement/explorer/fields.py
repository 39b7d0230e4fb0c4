"""The numbers of a design that the page computes: one table for Python and for the page.

Range, default, unit and words of each number are those of its declaration. `design_of` checks a
design with this table, and `rules.js`, `design.js` and `fields.js` read it from the page's data.
"""

from typing import Any

from escapement.base import validate
from escapement.base.quantity import Quantity, Setting, Truth, declared
from escapement.base.units import SYSTEMS, factor, printed
from escapement.dynamics.figure_table import FIGURES
from escapement.mechanisms import Geneva
from escapement.model.escapement import Escapement, Inertia, Run

GROUPS = {
    "Friction, drive and inertia": (
        *("friction", "torque", "driver_inertia", "follower_inertia", "load_torque"),
    ),
    "Mechanism": ("slots", "pins", "internal", "crank_radius", "pin_radius"),
    "Bearings": (
        *("driver_bearing_friction", "driver_bearing_radius"),
        *("follower_bearing_friction", "follower_bearing_radius", "driver_bearing_torque"),
    ),
    "Air, spring and start": (
        *("driver_drag", "follower_drag", "spring_rate", "initial_speed", "engagements"),
    ),
}
"""Fields of the page, by the titles of their groups; the page opens the first two."""
COMPUTED = tuple(name for names in GROUPS.values() for name in names)
"""Numbers of a design that the page computes with, by the names of studies."""
_MOST = {"slots": 40, "engagements": 1000}  # figures that the page computes while one drags
_MOST_OF = {"ratio": 1e3, "length": 1e3, "inertia": 1e6, "drag": 1e6}
_ANY = 1e9  # greatest value of a number of another kind
_SIZE = "crank_radius"  # the length to which the other ones are compared
_START = {"slots": 4, "driver_inertia": 3.39e-7, "follower_inertia": 5.65e-6, "torque": 0.0113}
_START |= {_SIZE: 0.02}  # the motion of thin pins does not depend on it, only their force
"""Values of the numbers without a default where a design or an address leaves them out."""
_FIGURES = {
    "period": "Period",
    "velocity_mean": "Mean velocity",
    "velocity_max": "Greatest velocity",
    "velocity_min": "Least velocity",
    "rise_time": "Rise time",
    "contact_force_max": "Greatest contact force",
    "contact_moment_max": "Greatest contact moment",
    "critical_friction": "Painlevé limit of friction",
}
_ELSEWHERE = "play its motion: escapement run ... --plot motion.html"


def settings() -> dict[str, Setting]:
    """Declarations of all numbers of a Geneva wheel and its motion, by name."""
    return declared(Geneva) | declared(Inertia) | declared(Escapement) | declared(Run)


def table() -> dict[str, Any]:
    """What Python and the page share, as types that JSON has.

    Returns
    -------
    dict
        `fields` has the properties of each number that the page computes with, `groups` their
        order, `beyond` the words of numbers that it refuses, `figures` label and kind of unit of
        each figure of merit, and `systems` name and size of the unit of every kind, by system.
    """
    entries = settings()
    refused = {name: it.long_name for name, it in entries.items() if name not in COMPUTED}
    return {
        "fields": {name: _field(entries[name]) for name in COMPUTED},
        "groups": GROUPS,
        "beyond": refused | dict.fromkeys(("barrel", "load_train"), "a train of gears"),
    } | report_table()


def report_table() -> dict[str, Any]:
    """`figures` and `systems` of `table`, which a page that plays a motion needs too."""
    figures = {name: {"label": text, "unit": FIGURES[name].kind} for name, text in _FIGURES.items()}
    kinds = {entry.unit for entry in settings().values()} | {it["unit"] for it in figures.values()}

    def of_system(system: str) -> dict[str, Any]:
        return {
            kind: {"name": printed(kind, system), "factor": factor(kind, system)}
            for kind in sorted(kinds)
        }

    return {"figures": figures, "systems": {system: of_system(system) for system in SYSTEMS}}


def _field(entry: Setting) -> dict[str, Any]:
    """Properties of a number for its field, its rule and its line in a study."""
    rule: dict[str, Any] = {"truth": isinstance(entry, Truth)}
    if isinstance(entry, Quantity):
        rule = {"least": entry.minimum, "most": most_of(entry)}
        rule |= {"above": entry.exclusive, "whole": entry.whole}
    return rule | {
        "label": entry.long_name[0].upper() + entry.long_name[1:],
        "unit": entry.unit,
        "default": _START.get(entry.name, entry.default),
        "section": entry.section,
        "key": entry.key,
        "optional": entry.default is None and not entry.required and entry.name not in _START,
        "needs": _SIZE if entry.unit == "length" and entry.name != _SIZE else "",
    }


def most_of(entry: Setting) -> float:
    """Greatest value with which the page computes, in SI."""
    return _MOST.get(entry.name, _MOST_OF.get(entry.unit, _ANY))


def design_of(
    escapement: Escapement, initial_speed: float = 0.0, engagements: int = 20
) -> dict[str, Any]:
    """The design that the page begins with: numbers in SI by the names of `COMPUTED`.

    Raises
    ------
    InvalidValue
        If the page cannot compute the escapement.
    """
    wheel = escapement.mechanism
    if not isinstance(wheel, Geneva):
        raise validate.fail("mechanism", "a Geneva wheel for the explorer", wheel.kind, _ELSEWHERE)
    if escapement.without_trains is not escapement:
        raise validate.fail(
            "barrel and load_train", "left out for the explorer", "a train", _ELSEWHERE
        )
    owners: tuple[Any, ...] = wheel, escapement.inertia, escapement
    given = {name: value for owner in owners for name, value in owner.settings.items()}
    entries = settings()
    for name, value in (("initial_speed", initial_speed), ("engagements", engagements)):
        given[name] = entries[name].check(name, value)
    for name, value in given.items():
        entry = entries[name]
        if name in COMPUTED:
            _check_most(entry, value)
        elif value != entry.default:
            rule = f"{entry.default or 'left out'} for the explorer"
            raise validate.fail(name, rule, value, _ELSEWHERE)
    return {name: given[name] for name in COMPUTED}


def _check_most(entry: Setting, value: Any) -> None:
    """Raise InvalidValue unless a number is one that the page computes with."""
    if entry.name == "torque":
        validate.number(entry.name, value, "the explorer takes no torque curve")
    if isinstance(value, int | float) and not value <= most_of(entry):
        rule = f"at most {most_of(entry):g} for the explorer"
        raise validate.fail(entry.name, rule, value, _ELSEWHERE)
