"""The [mechanism] table: sizes that stand for its numbers, and lists of which numbers vary.

A study that varies a number of a list, such as the angle error of a slot, has a parameter for each
number of it, "slot_angle_errors_0" and so on. A distribution of the whole list in a sample applies
to each number, and each is drawn independently. "slot_angle_errors_factor" multiplies all of them.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from escapement.base import units, validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Numbers, Quantity, Setting, declared
from escapement.mechanisms.kind import Kind
from escapement.mechanisms.other_sizes import numbers_of_sizes
from escapement.mechanisms.wheel_checks import IMPERFECT
from escapement.study.plan import Settings

Content = Mapping[str, Any]


def with_numbers_of_sizes(
    content: Mapping[str, Any], kind: type[Kind], system: str
) -> Mapping[str, Any]:
    """The content of a study file with other sizes replaced, see `mechanisms.other_sizes`.

    Raises
    ------
    InvalidValue
        If two sizes say the same, or the conversion of one needs a number that varies.
    """
    table, sizes = content.get("mechanism"), kind.other_sizes()
    if not isinstance(table, Mapping) or sizes.keys().isdisjoint(table):
        return content
    tables = [content.get(key) for key in ("sweep", "sample")]
    varied = {name for rows in tables if isinstance(rows, Mapping) for name in rows}
    entries = declared(kind) | {name: size.entry for name, size in sizes.items()}
    given = {}
    for name in table:
        if isinstance(entry := entries.get(name), Quantity):
            entry = replace(entry, system=system)
            given[name] = entry.to_si(entry.read(entry.label, table[name]))
        if name in sizes and (vary := sorted(varied.intersection(sizes[name].reads))):
            rule = f"left out where {vary[0]} varies"
            raise validate.fail(name, rule, table[name], f"give {sizes[name].of}")
    numbers = numbers_of_sizes(sizes, given)
    stated = {sizes[name].of for name in sizes.keys() & table.keys()}
    kept = {name: value for name, value in table.items() if name not in sizes}
    scale = units.factor("length", system)
    return {**content, "mechanism": kept | {name: numbers[name] / scale for name in stated}}


def part_lists(
    content: Content, settings: Settings, counts: Mapping[str, int]
) -> tuple[Content, Settings]:
    """The content of a study, and its settings, with lists that vary split into their numbers.

    Parameters
    ----------
    content : Mapping
        Content of a study file.
    settings : Settings
        Settings of a study, including lists.
    counts : Mapping
        How many numbers each list has, by its name.
    """
    found = settings
    # a value that is not a table is refused later, by name
    tables = {
        name: dict(table)
        for name in ("mechanism", "sweep", "sample")
        if isinstance(table := content.get(name), Mapping)
    }
    machine, swept, sample = (tables.get(name, {}) for name in ("mechanism", "sweep", "sample"))
    for name, entry in settings.items():
        if not isinstance(entry, Numbers):
            continue
        factor = f"{name}_factor"
        scaled = factor in swept or factor in sample
        if name not in counts:
            if scaled and name in IMPERFECT:
                raise InvalidValue(
                    f"{factor} must come with a fixed number of parts under [mechanism], got none; "
                    "give it, or leave the factor out"
                )
            continue
        names = [f"{name}_{i}" for i in range(counts[name])]
        _spread(sample, name, names)
        varied = any(one in swept or one in sample for one in names)
        if not (scaled or varied):
            continue
        found, given = Settings(found), machine.get(name)
        nominal = () if given is None else entry.read(entry.label, given)
        nominal = nominal or (0.0,) * len(names)
        if len(nominal) != len(names):
            raise validate.fail(entry.label, f"{len(names)} numbers long", nominal, entry.remedy)
        if scaled:
            remedy = "give the factor, 1 for the list as it is"
            found[factor] = _number(entry, factor, f"factor on the {entry.long_name}", 1.0, remedy)
        if varied:
            del found[name]
            machine.pop(name, None)
            for i, (one, value) in enumerate(zip(names, nominal, strict=True)):
                words, remedy = f"{entry.long_name}, number {i}", "give the error, 0 for none"
                number = _number(entry, one, words, value, remedy)
                found[one] = replace(number, unit=entry.unit, system=entry.system)
    return {**content, **tables}, found


def _spread(sample: dict[str, Any], name: str, names: list[str]) -> None:
    """Give each number of a list the distribution of the list, if a sample has one."""
    if name in sample:
        form = sample.pop(name)
        if not isinstance(form, Mapping):
            remedy = f"write for example {{ tolerance = 1e-3 }}, or values of {names[0]}"
            rule = "a table that says how each varies"
            raise validate.fail(f"sample.{name}", rule, form, remedy)
        sample |= dict.fromkeys(names, form)


def _number(entry: Setting, name: str, words: str, value: float, remedy: str) -> Quantity:
    return Quantity(
        long_name=words, minimum=-math.inf, default=value, remedy=remedy, name=name, key=name,
        section=entry.section,
    )  # fmt: skip
