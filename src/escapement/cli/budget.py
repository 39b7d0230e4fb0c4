"""Command `budget`: how tolerances scatter the figures of merit, and which of them to tighten."""

from pathlib import Path
from typing import Any

from escapement.base.errors import InvalidValue
from escapement.base.quantity import Numbers
from escapement.base.records import Record
from escapement.base.units import factor, measured
from escapement.cli import SOME_FAILED, _arguments, _inputs, _output
from escapement.cli._arguments import Arguments, Parser

UNITS = "units of the figures printed (default: those of the study)"


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    text = "a study file with the tables [sample], of tolerances, and [limits], of figures"
    parser.add_argument("config", type=Path, metavar="CONFIG.toml", help=text)
    rule: dict[str, Any] = {"minimum": 0, "whole": True, "remedy": "give 0 for none"}
    text = (
        "cases N for Sobol' indices; (k + 2) N are solved for k numbers with a tolerance "
        "(default: 0)"
    )
    _arguments.add_number(parser, "indices", text, "N", **rule)
    text = "shares of good cases for which to find the permitted ranges, as .95,.99"
    rule = {"remedy": "give shares between 0 and 1"}
    entry = Numbers(name="yield", long_name=text, metavar="SHARE,...", **rule)
    _arguments.add_setting(parser, entry, dest="yields")
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "OUT.h5", "write the sample, as sweep does")
    _arguments.add_plot(output, "draw contributors, and the sample with its limits")
    _arguments.add_report(output)


def execute(args: Arguments) -> int:
    """Compute the budget and print it; write and draw it where that was asked for."""
    from escapement.study.parse import load_tables
    from escapement.study.plan import unit_kind
    from escapement.tolerance.scatter_record import (
        permitted_record,
        permitted_table,
        record_of,
        tables_of,
    )
    from escapement.tolerance.tolerance_budget import budget_of

    _output.speak_as(args, args.config, "study file")
    plan, tables = load_tables(args.config, "limits")
    system, date = plan.configuration["units"], plan.configuration.get("date", "")
    try:
        limits = {name: limits_in_si(name, ends, system) for name, ends in tables["limits"].items()}
        options: Any = {"indices": args.indices or 0, "path": args.output}
        options["yields"] = args.yields or ()
        found = budget_of(plan, limits, **options)
    except InvalidValue as error:
        raise InvalidValue(f"{args.config}: {error}") from None
    if plan.unused:
        _output.note(plan.unused)
    _output.save(
        args,
        plot=lambda plots: plots.plot_budget(found),
        report=lambda: _output.page_of(
            plan.built(plan.fixed_si), found, title=plan.title, date=date
        ),
    )
    ends = [
        (f"{name}_limits", [*(one.limits or ())], unit_kind(name))
        for name, one in found.figures.items() if name in limits
    ]  # fmt: skip
    known = [*_inputs.of_plan(plan), *ends, ("indices", args.indices or 0, "ratio")]
    record = {name: record_of(one, name, args.units) for name, one in found.figures.items()}
    record |= {"permitted": {
        f"{share:g}": permitted_record(one, args.units) for share, one in found.permitted.items()
    }} if found.permitted else {}  # fmt: skip
    sample = {"size": found.size, "seed": found.seed, "failed": list(found.failed)}

    def show() -> None:
        for name, one in found.figures.items():
            for table in tables_of(one, name, args.units):
                table.show()
                print()
        for share, ranges in found.permitted.items():
            permitted_table(share, ranges, args.units).show()
            print()
        Record(sample).show(args.units)

    _output.tell(args, record | sample | {"message": found.message}, known, show)
    return SOME_FAILED if found.failed.value else 0


def limits_in_si(name: str, ends: Any, system: str) -> Any:
    """Limits of a study file in SI; what is no pair of numbers stays as it is."""
    from escapement.study.plan import unit_kind

    kind = unit_kind(name)
    if isinstance(ends, dict) and isinstance(ends.get("tolerance"), int | float | str):
        size = measured(f"limits.{name}", ends["tolerance"], kind, system, "give a number")
        return {**ends, "tolerance": size * factor(kind, system)}
    if not isinstance(ends, list):
        return ends
    limits = [measured(f"limits.{name}", x, kind, system, "give a number") for x in ends]
    scale = factor(kind, system)
    return [scale * x if type(x) in (int, float) else x for x in limits]
