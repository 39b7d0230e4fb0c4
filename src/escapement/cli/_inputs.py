"""What went into a command, which its table and its JSON tell first.

A command gives the numbers of what it made, such as an escapement, with their defaults; whatever
else was typed is added from its arguments. Nobody then takes inches for metres unnoticed.
"""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from escapement.base.text import print_values, show, words
from escapement.base.units import SYSTEMS, factor, printed
from escapement.cli._arguments import Arguments
from escapement.model.inputs import Input

if TYPE_CHECKING:
    from escapement.study.plan import StudyPlan

_NO_INPUTS = {
    *("json", "log", "units", "output", "force", "plot", "report", "settings"),
    *("resume", "quiet", "serve", "segments", "r12", "format"),
}
"""Arguments that say where and how something is written."""
_LONGEST = 12
"""Values of a list that are told one by one."""


def inputs_of_command(args: Arguments, known: Iterable[Input] = ()) -> list[Input]:
    """The numbers that are `known` of what was made, then whatever else was typed.

    Angles that were typed in degrees are told so, under a name with "_deg".
    """
    found = {name: (value, kind) for name, value, kind in known}
    for name, value in vars(args).items():
        if name in _NO_INPUTS or value is None or value is False:
            continue
        entry = args.settings.get(name)
        if entry is not None and entry.unit == "degrees":
            found.pop(name, None)
            found[f"{name}_deg"] = value, "degrees"
        elif name not in found:
            told = value if isinstance(value, bool | int | float | list | tuple) else str(value)
            kind = "ratio" if entry is None else entry.unit
            scale = factor(kind, args.units or SYSTEMS[0])
            found[name] = _scaled(told, 1.0 / scale), kind
    return [(name, *rest) for name, rest in found.items()]


def as_record(inputs: Iterable[Input], system: str) -> dict[str, Any]:
    """Inputs by JSON key; one that has another unit in another system is told in each."""
    told: dict[str, Any] = {"units": system}
    for name, value, kind in inputs:
        alike = len({printed(kind, one) for one in SYSTEMS}) == 1
        each = {one: _scaled(value, factor(kind, one)) for one in SYSTEMS}
        told[name] = value if alike or isinstance(value, str) else each
    return told


def print_inputs(inputs: Iterable[Input], system: str) -> None:
    """Inputs as a table, then an empty line."""
    others = [one for one in SYSTEMS if one != system]
    rows = []
    for name, value, kind in inputs:
        shown = "" if isinstance(value, str) else printed(kind, system)
        for other in others:
            # a number of another unit shows at once that it was typed in the wrong system
            if shown != printed(kind, other) and not isinstance(value, str):
                shown += (
                    f" = {show(_said(_scaled(value, factor(kind, other))))} {printed(kind, other)}"
                )
        unit = 1.0 if kind == "degrees" else factor(kind, system)
        rows.append((words(name), _said(_scaled(value, unit)), shown))
    if rows:
        print_values(rows)
        print()


def of_plan(plan: "StudyPlan") -> Iterable[Input]:
    """The numbers of a study: those that are fixed, and the ends of those that vary."""
    from escapement.study.plan import settings_of, unit_kind

    yield "kind", plan.build.kind, "ratio"
    entries = settings_of(plan.build, plan.meshed) | plan.parameters
    varied = {name for along in plan.varied.values() for name in along}
    for name, value in plan.fixed_si.items():
        entry = entries.get(name)
        idle = value is None or (entry is not None and entry.idle(value))
        if name not in varied and not idle:
            yield name, value if isinstance(value, int | float) else str(value), unit_kind(name)
    for along in plan.varied.values():
        for name in along:
            values = plan.parameters[name].to_si(along[name])
            yield name, _shortened(values.tolist()), unit_kind(name)


def of_wish(wish: Any) -> Iterable[Input]:
    """The numbers of a wish for a timer, and its bounds, of which None is no bound."""
    from escapement.inverse_design.wish import BOUNDS, NUMBERS, RANGES

    for name, entry in (NUMBERS | RANGES).items():
        if (value := getattr(wish, name)) is not None:
            yield name, value, entry.unit
    yield "internal", "any" if wish.internal is None else wish.internal, "ratio"
    yield "objectives", ", ".join(wish.objectives), "ratio"
    for name, ends in wish.bounds.items():
        yield f"{name}_bounds", [x if math.isfinite(x) else None for x in ends], BOUNDS[name].unit


def _shortened(values: list[Any]) -> Any:
    """A list of at most a dozen values; of more the ends and their number."""
    if len(values) <= _LONGEST:
        return values
    return {"from": min(values), "to": max(values), "values": len(values)}


def _said(value: Any) -> Any:
    """A shortened list in words."""
    if isinstance(value, dict):
        return f"{show(value['from'])} to {show(value['to'])}, {value['values']} values"
    return value


def _scaled(value: Any, unit: float) -> Any:
    """A value in SI, or each of several, in a unit; what is no number stays as it is."""
    if isinstance(value, dict):
        return {key: x if key == "values" else _scaled(x, unit) for key, x in value.items()}
    if isinstance(value, list | tuple):
        return [_scaled(one, unit) for one in value]
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return value / unit if number and unit != 1.0 else value
