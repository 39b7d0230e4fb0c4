"""What is told of the scatter of a figure: its record, and its tables."""

from collections.abc import Mapping, Sequence
from typing import Any

from escapement.base.records import Record, Table, in_units
from escapement.base.results import Result
from escapement.base.text import words
from escapement.base.units import factor, printed
from escapement.study.plan import unit_kind
from escapement.tolerance.intervals import per_cent
from escapement.tolerance.permitted import Permitted
from escapement.tolerance.scatter import Scatter
from escapement.tolerance.spread import grouped

_OF_FIGURE = (
    "nominal", "worst_case", "standard_deviation_first_order", "mean", "standard_deviation",
    "quantiles",
)  # fmt: skip
"""What has the unit of the figure."""


def record_of(scatter: Scatter, name: str, system: str) -> dict[str, Any]:
    """The scatter of a figure by JSON key, in a system of units.

    An estimate is a list of three numbers: its value and the ends of its interval.
    """
    kind = unit_kind(name)
    unit = factor(kind, system)
    values: dict[str, Any] = {
        "nominal": scatter.nominal,
        "worst_case": [scatter.worst.low, scatter.worst.high],
        "worst_case_searched": scatter.worst.searched,
        "standard_deviation_first_order": scatter.sigma,
        "slopes": {
            number: slope * factor(unit_kind(number), system) / unit
            for number, slope in scatter.slopes.items()
        },
        "contributions": scatter.contributions,
        "balanced_factors": scatter.balanced,
        "mean": [*scatter.mean],
        "standard_deviation": [*scatter.deviation],
        "quantiles": {f"{level:g}": [*value] for level, value in scatter.quantiles.items()},
    }
    if scatter.inside is not None and scatter.capability is not None:
        values |= {"yield": [*scatter.inside], "capability": [*scatter.capability]}
    if scatter.first:
        values |= {"first_indices": scatter.first, "total_indices": scatter.total}
    return Record(values, dict.fromkeys(_OF_FIGURE, Result(kind))).in_units(system)


def tables_of(scatter: Scatter, name: str, system: str) -> list[Table]:
    """The scatter of a figure, its contributors and their Sobol' indices."""
    record, unit = record_of(scatter, name, system), printed(unit_kind(name), system)
    rows: list[tuple[Any, ...]] = [
        ("nominal", record["nominal"], "", ""),
        ("worst case", "", *record["worst_case"]),
        ("mean, 95 % interval", *record["mean"]),
        ("standard deviation", *record["standard_deviation"]),
        ("to first order", record["standard_deviation_first_order"], "", ""),
        ("one case of twenty lies below", *record["quantiles"]["0.05"]),
        ("one case of twenty lies above", *record["quantiles"]["0.95"]),
    ]
    if "yield" in record:
        rows += [("share within limits", *record["yield"])]
        rows += [("C_pk", *record["capability"])]
    title = f"{words(name)} [{unit}]" if unit else words(name)
    tables = [_table(title, ("", "value", "from", "to"), rows)]
    if parts := scatter.contributions:
        header = ("tolerance", "share of variance", "factor for equal shares")
        equal = grouped(parts)
        shares = [
            (f"{key}, each of {len(names)}" if len(names) > 1 else key, parts[names[0]],
             scatter.balanced.get(names[0], ""))
            for key, names in equal.items()
        ]  # fmt: skip
        tables.append(_table("", header, shares))
    if scatter.first:
        index = ("Sobol' index", "first", "from", "to", "total", "from", "to")
        indices = [(key, *scatter.first[key], *scatter.total[key]) for key in scatter.first]
        tables.append(_table("", index, indices))
    return tables


def permitted_record(permitted: Mapping[str, Permitted], system: str) -> dict[str, Any]:
    """The ranges for a wanted yield by JSON key, in a system of units."""

    def told(one: Permitted) -> dict[str, Any]:
        ranges = {key: in_units(x, unit_kind(key), system) for key, x in one.ranges.items()}
        return {
            "factor": one.factor, "bounded": one.bounded, "yield": [*one.inside], "ranges": ranges
        }  # fmt: skip

    return {key: told(one) for key, one in permitted.items()}


def permitted_table(share: float, permitted: Mapping[str, Permitted], system: str) -> Table:
    """The ranges for a wanted yield: those of all numbers together, and of each alone."""
    record = permitted_record(permitted, system)
    rows = []
    for key, ends in record["all"]["ranges"].items():
        unit = printed(unit_kind(key), system)
        alone = record[key] if key in record else record["all"]
        beyond = "" if alone["bounded"] else "no limit found"
        rows.append((key, unit, *ends, *alone["ranges"][key], alone["factor"], beyond))
    found = permitted["all"]
    title = (
        f"ranges for a yield of {100.0 * share:g} %: all times {found.factor:.4g} (then "
        f"{per_cent(found.inside)} % of random cases are good), or each alone"
    )
    header = ("number", "unit", "all, from", "to", "alone, from", "to", "factor", "")
    return _table(title, header, rows)


def _table(title: str, names: Sequence[str], rows: list[tuple[Any, ...]]) -> Table:
    return Table(title, names, [""] * len(names), rows)
