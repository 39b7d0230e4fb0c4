"""Command `budget`: how tolerances scatter the figures of merit, and which of them to tighten."""

from pathlib import Path
from typing import Any

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.text import print_columns, words
from escapement.base.units import factor, measured, printed
from escapement.cli import SOME_FAILED, _arguments, _inputs, _output
from escapement.cli._arguments import Arguments, Parser

UNITS = "units of the figures printed (default: those of the study)"


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    add = parser.add_argument
    text = "a study file with the tables [sample], of tolerances, and [limits], of figures"
    add("config", type=Path, metavar="CONFIG.toml", help=text)
    rule: dict[str, Any] = {"minimum": 0, "whole": True, "remedy": "give 0 for none"}
    text = (
        "cases N for Sobol' indices; (k + 2) N are solved for k numbers with a tolerance "
        "(default: 0)"
    )
    _arguments.add_number(parser, "indices", text, "N", **rule)
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "OUT.h5", "write the sample, as sweep does")
    _arguments.add_plot(output, "draw contributors, and the sample with its limits")
    _arguments.add_report(output)


def execute(args: Arguments) -> int:
    """Compute the budget and print it; write and draw it where that was asked for."""
    from escapement.study.parse import load_tables
    from escapement.study.plan import unit_kind
    from escapement.tolerance.tolerance_budget import budget_of

    _output.check_wanted(args, file="OUT.h5")
    _output.speak_as(args, args.config, "study file")
    plan, tables = load_tables(args.config, "limits")
    system = plan.configuration["units"]
    try:
        limits = {name: _limits(name, ends, system) for name, ends in tables["limits"].items()}
        options: Any = {"indices": args.indices or 0, "path": args.output}
        found = budget_of(plan, limits, **options)
    except InvalidValue as error:
        raise InvalidValue(f"{args.config}: {error}") from None
    if plan.unused:
        _output.note(plan.unused)
    picture = _output.drawn(args.plot, lambda plots: plots.plot_budget(found))
    report = _output.reported(args, plan.built(plan.fixed_si), found)
    picture()
    report()
    record = {name: _record(scatter, name, args.units) for name, scatter in found.figures.items()}
    ends = [(f"{name}_limits", x, unit_kind(name)) for name, x in limits.items()]
    known = [*_inputs.of_plan(plan), *ends, ("indices", args.indices or 0, "ratio")]
    extra = {"size": found.size, "seed": found.seed, "failed": list(found.failed)}
    shown_record = {**record, **extra, "message": found.message}
    _output.tell(args, shown_record, lambda: _print(found, args.units), "", known)
    return SOME_FAILED if found.failed.value else 0


def _limits(name: str, ends: Any, system: str) -> Any:
    """Limits of a study file in SI; what is no pair of numbers stays as it is."""
    from escapement.study.plan import unit_kind

    if not isinstance(ends, list):
        return ends
    kind = unit_kind(name)
    limits = [measured(f"limits.{name}", x, kind, system, "give a number") for x in ends]
    scale = factor(kind, system)
    return [scale * x if type(x) in (int, float) else x for x in limits]


def _record(scatter: Any, name: str, system: str) -> dict[str, Any]:
    """The scatter of a figure by JSON key, in a system of units.

    An estimate is a list of three numbers: its value and the ends of its interval.
    """
    from escapement.study.plan import unit_kind

    scale = 1.0 / factor(unit_kind(name), system)
    slopes = {
        number: slope * scale * factor(unit_kind(number), system)
        for number, slope in scatter.slopes.items()
    }
    record: dict[str, Any] = {
        "nominal": scatter.nominal * scale,
        "worst_case": [scatter.worst.low * scale, scatter.worst.high * scale],
        "worst_case_searched": scatter.worst.searched,
        "standard_deviation_first_order": scatter.sigma * scale,
        "slopes": slopes,
        "contributions": scatter.contributions,
        "balanced_factors": scatter.balanced,
        "mean": [x * scale for x in scatter.mean],
        "standard_deviation": [x * scale for x in scatter.deviation],
        "quantiles": {
            f"{level:g}": [x * scale for x in value] for level, value in scatter.quantiles.items()
        },
    }
    if scatter.inside is not None and scatter.capability is not None:
        record |= {"yield": list(scatter.inside), "capability": list(scatter.capability)}
    if scatter.first:
        record["first_indices"] = {key: list(value) for key, value in scatter.first.items()}
        record["total_indices"] = {key: list(value) for key, value in scatter.total.items()}
    return record


def _print(found: "esc.Budget", system: str) -> None:
    """The budget as tables."""
    from escapement.study.plan import unit_kind

    for name, scatter in found.figures.items():
        record, unit = _record(scatter, name, system), printed(unit_kind(name), system)
        print(f"{words(name)} [{unit}]" if unit else words(name))
        rows: list[tuple[Any, ...]] = [
            ("nominal", record["nominal"], "", ""),
            ("worst case", "", *record["worst_case"]),
            ("mean, 95 % interval", *record["mean"]),
            ("standard deviation", *record["standard_deviation"]),
            ("to first order", record["standard_deviation_first_order"], "", ""),
        ]
        if scatter.inside is not None and scatter.capability is not None:
            rows += [("share within limits", *scatter.inside), ("C_pk", *scatter.capability)]
        print_columns([["", "value", "from", "to"]], rows)
        print()
        parts = scatter.contributions.items()
        if parts:
            header = ["tolerance", "share of variance", "factor for equal shares"]
            table: list[tuple[Any, ...]] = [
                (key, share, scatter.balanced.get(key, "")) for key, share in parts
            ]
            print_columns([header], table)
            print()
        if scatter.first:
            header = ["Sobol' index", "first", "from", "to", "total", "from", "to"]
            table = [(key, *scatter.first[key], *scatter.total[key]) for key in scatter.first]
            print_columns([header], table)
            print()
    _output.note(f"{found.size} cases, seed {found.seed}; {found.message}")
