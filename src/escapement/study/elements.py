"""The numbers of a list, such as the angle error of each slot, as parameters of a study.

A study that varies one of them has a parameter for each number of the list, "slot_angle_errors_0"
and so on. What a sample says of the list as a whole it says of each, and each is drawn alone.
"""

import math
from collections.abc import Mapping
from typing import Any

from escapement import validate
from escapement.quantity import Numbers, Quantity, Setting

Content = Mapping[str, Any]


def part_lists(
    content: Content, settings: Mapping[str, Setting], counts: Mapping[str, int]
) -> tuple[Content, dict[str, Setting]]:
    """The content of a study, and its settings, with the lists that vary taken apart.

    Parameters
    ----------
    content : Mapping
        Of a study file.
    settings : Mapping
        What a study may say, lists included.
    counts : Mapping
        How many numbers each list has, by its name.
    """
    found = dict(settings)
    # what is no table is refused later, by name
    tables = {
        name: dict(table)
        for name in ("mechanism", "sweep", "sample")
        if isinstance(table := content.get(name), Mapping)
    }
    for name, entry in settings.items():
        if not isinstance(entry, Numbers) or name not in counts:
            continue
        names = [f"{name}_{i}" for i in range(counts[name])]
        sample = tables.get("sample", {})
        if name in sample:
            form = sample.pop(name)
            if not isinstance(form, Mapping):
                remedy = f"write for example {{ tolerance = 1e-3 }}, or values of {names[0]}"
                raise validate.fail(f"sample.{name}", "a table of how each spreads", form, remedy)
            sample |= dict.fromkeys(names, form)
        if not any(one in tables.get(where, ()) for where in ("sweep", "sample") for one in names):
            continue
        del found[name]
        nominal = [0.0] * len(names)
        if name in tables.get("mechanism", {}):
            nominal = [*entry.read(entry.label, tables["mechanism"].pop(name))] or nominal
        if len(nominal) != len(names):
            raise validate.fail(entry.label, f"{len(names)} numbers long", nominal, entry.remedy)
        for i, (one, value) in enumerate(zip(names, nominal, strict=True)):
            found[one] = Quantity(
                long_name=f"{entry.long_name}, number {i}", unit=entry.unit, minimum=-math.inf,
                remedy="give the error, 0 for none", name=one, key=one, section=entry.section,
                default=value, system=entry.system,
            )  # fmt: skip
    return {**content, **tables}, found


def joined(name: str, values: Mapping[str, Any]) -> tuple[float, ...] | None:
    """A list put together from its numbers among `values`; None where it is not apart."""
    if f"{name}_0" not in values:
        return None
    count = sum(key.startswith(f"{name}_") for key in values)
    return tuple(values[f"{name}_{i}"] for i in range(count))
