"""Sizes of a [mechanism] table that stand for numbers of the mechanism, as drawings give them."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from escapement.base import units, validate
from escapement.base.quantity import Quantity, declared
from escapement.mechanisms.kind import Kind
from escapement.mechanisms.other_sizes import numbers_of_sizes


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
