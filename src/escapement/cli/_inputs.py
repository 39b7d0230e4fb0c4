"""What went into a command, which its table and its JSON tell first.

A command gives the numbers of what it made, such as an escapement, with their defaults; whatever
else was typed is added from its arguments. Nobody then takes inches for metres unnoticed.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from escapement.base.records import in_units
from escapement.base.text import print_values, show, words
from escapement.base.units import SYSTEMS, printed
from escapement.cli._arguments import Arguments
from escapement.model.inputs import Input, in_words, inputs_of_curve, shortened

if TYPE_CHECKING:
    from escapement.study.plan import StudyPlan

_NO_INPUTS = {
    *("json", "log", "units", "output", "force", "plot", "report", "settings"),
    *("resume", "quiet", "segments", "r12", "format"),
}
"""Arguments that say where and how something is written."""
_ROUND = ("pin_radius", "roller_radius", "bearing_radius", "locking_radius")
"""Radii of round bodies, of which drawings have the diameter."""


def inputs_of_command(args: Arguments, known: Iterable[Input] = ()) -> list[Input]:
    """The numbers that are `known` of what was made, then whatever else was typed.

    Angles that are typed in degrees are told so, under a name with "_deg".
    """
    found = {}
    for name, value, kind in known:
        if kind == "degrees":
            found[f"{name}_deg"] = in_units(value, "angle", SYSTEMS[2]), kind
        else:
            found[name] = value, kind
    for name, value in vars(args).items():
        if name in _NO_INPUTS or value is None or value is False:
            continue
        entry = args.settings.get(name)
        if entry is not None and entry.unit == "degrees":
            found[f"{name}_deg"] = value, "degrees"
        elif name not in found:
            system = args.units or SYSTEMS[0]
            in_si = value if entry is None else replace(entry, system=system).to_si(value)
            plain = isinstance(value, bool | int | float | list | tuple)
            found[name] = in_si if plain else str(value), entry.unit if entry else "ratio"
    return [(name, *rest) for name, rest in found.items()]


def as_record(inputs: Iterable[Input], system: str) -> dict[str, Any]:
    """Inputs by JSON key; one that has another unit in another system is given in each."""
    record: dict[str, Any] = {"units": system}
    for name, value, kind in inputs:
        told = dict.fromkeys((*SYSTEMS[:2], system))
        alike = len({printed(kind, one) for one in told}) == 1
        each = {one: in_units(value, kind, one) for one in told}
        record[name] = value if alike or isinstance(value, str) else each
    return record


def print_inputs(inputs: Iterable[Input], system: str) -> None:
    """Inputs as a table, then an empty line."""
    rows = []
    for name, value, kind in inputs:
        unit = printed(kind, system)
        number = in_words(in_units(value, kind, system))
        # a number of another unit shows at once that it was typed in the wrong system
        other = SYSTEMS[0] if system == SYSTEMS[1] else SYSTEMS[1]
        shown = "" if isinstance(value, str) else unit
        if shown and printed(kind, other) != unit:
            shown += f" = {show(in_words(in_units(value, kind, other)))} {printed(kind, other)}"
        single = isinstance(number, int | float)
        if shown and single and system == SYSTEMS[2] and name.endswith(_ROUND):
            shown += f", diameter {show(2.0 * number)} {unit}"
        rows.append((words(name), number, shown))
    if rows:
        print_values(rows)
        print()


def of_plan(plan: "StudyPlan") -> Iterable[Input]:
    """The numbers of a study: those that are fixed, and the ends of those that vary."""
    from escapement.study.plan import unit_kind

    yield "kind", plan.build.kind, "ratio"
    entries = plan.settings | plan.parameters
    varied = {name for along in plan.varied.values() for name in along}
    for name, value in plan.fixed_si.items():
        entry = entries.get(name)
        idle = value is None or (entry is not None and entry.idle(value))
        if name == "torque" and plan.curve is not None:
            yield from inputs_of_curve(name, plan.curve)
        elif name not in varied and not idle:
            plain = isinstance(value, int | float | list | tuple)
            yield name, value if plain else str(value), unit_kind(name)
    for along in plan.varied.values():
        for name in along:
            values = plan.parameters[name].to_si(along[name])
            yield name, shortened(values.tolist()), unit_kind(name)
