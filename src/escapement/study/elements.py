"""The numbers of a list, such as the angle error of each slot, as parameters of a study.

A study that varies one of them has a parameter for each number of the list, "slot_angle_errors_0"
and so on. A distribution of the whole list in a sample applies to each number, and each is drawn
independently. "slot_angle_errors_factor" multiplies all numbers of the list.
"""

import math
from collections.abc import Mapping
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Numbers, Quantity, Setting
from escapement.mechanisms.wheel_checks import IMPERFECT

Content = Mapping[str, Any]


def part_lists(
    content: Content, settings: Mapping[str, Setting], counts: Mapping[str, int]
) -> tuple[Content, dict[str, Setting]]:
    """The content of a study, and its settings, with lists that vary split into their numbers.

    Parameters
    ----------
    content : Mapping
        Content of a study file.
    settings : Mapping
        Settings of a study, including lists.
    counts : Mapping
        How many numbers each list has, by its name.
    """
    found = dict(settings)
    # a value that is not a table is refused later, by name
    tables = {
        name: dict(table)
        for name in ("mechanism", "sweep", "sample")
        if isinstance(table := content.get(name), Mapping)
    }
    for name, entry in settings.items():
        if not isinstance(entry, Numbers):
            continue
        sample, factor = tables.get("sample", {}), f"{name}_factor"
        scaled = factor in tables.get("sweep", ()) or factor in sample
        if name not in counts:
            if scaled and name in IMPERFECT:
                raise InvalidValue(
                    f"{factor} must come with a fixed number of parts under [mechanism], got none; "
                    "give it, or leave the factor out"
                )
            continue
        names = [f"{name}_{i}" for i in range(counts[name])]
        given = tables.get("mechanism", {}).get(name)
        nominal = [0.0] * len(names) if given is None else [*entry.read(entry.label, given)]
        if scaled:
            _check_length(entry, nominal, len(names))
            found[factor] = Quantity(
                long_name=f"factor on the {entry.long_name}", minimum=-math.inf, default=1.0,
                remedy="give the factor, 1 for the list as it is", name=factor, key=factor,
                section=entry.section,
            )  # fmt: skip
        if name in sample:
            form = sample.pop(name)
            if not isinstance(form, Mapping):
                remedy = f"write for example {{ tolerance = 1e-3 }}, or values of {names[0]}"
                rule = "a table that says how each varies"
                raise validate.fail(f"sample.{name}", rule, form, remedy)
            sample |= dict.fromkeys(names, form)
        if not any(one in tables.get(where, ()) for where in ("sweep", "sample") for one in names):
            continue
        del found[name]
        tables.get("mechanism", {}).pop(name, None)
        nominal = nominal or [0.0] * len(names)
        _check_length(entry, nominal, len(names))
        for i, (one, value) in enumerate(zip(names, nominal, strict=True)):
            found[one] = Quantity(
                long_name=f"{entry.long_name}, number {i}", unit=entry.unit, minimum=-math.inf,
                remedy="give the error, 0 for none", name=one, key=one, section=entry.section,
                default=value, system=entry.system,
            )  # fmt: skip
    return {**content, **tables}, found


def _check_length(entry: Numbers, nominal: list[float], count: int) -> None:
    if len(nominal) not in (0, count):
        raise validate.fail(entry.label, f"{count} numbers long", nominal, entry.remedy)


def joined(name: str, values: Mapping[str, Any]) -> Any:
    """A setting of a case; a list is made from its numbers, times its factor."""
    found = values.get(name)
    if f"{name}_0" in values:
        count = sum(key.startswith(f"{name}_") and key[-1].isdigit() for key in values)
        found = tuple(values[f"{name}_{i}"] for i in range(count))
    factor = values.get(f"{name}_factor", 1.0)
    return tuple(factor * number for number in found) if found and factor != 1.0 else found
