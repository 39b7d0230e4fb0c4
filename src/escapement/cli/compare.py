"""Several designs side by side: period, sensitivities, losses, accelerations and forces."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from escapement.base.errors import InvalidValue
from escapement.base.quantity import like
from escapement.base.records import Record
from escapement.base.results import Result
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser
from escapement.cli.budget import limits_in_si
from escapement.model.escapement import Escapement

UNITS = "units of the figures printed (default: those of the first file)"
_STIFFNESS = {"stiffness": next(iter(like(Escapement, "stiffness", needs="").values()))}


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    text = "study files of one design each; with [sample] and [limits] the yield is told too"
    parser.add_argument("config", nargs="+", metavar="CONFIG.toml", help=text)
    text = "give all designs torque and period of the first, by similarity"
    parser.add_argument("--equal-period", action="store_true", help=text)
    _arguments.add_group(parser, "blows", _STIFFNESS)
    _arguments.add_plot(parser.add_argument_group("output"), "draw the designs side by side")


def execute(args: Arguments) -> int:
    """Compare the designs and print them, a column for each."""
    import escapement as esc
    from escapement.tolerance.side_by_side import COMPARED

    _output.speak_as(args, args.config[0], "study file")
    designs, yields = zip(*(_design(Path(path)) for path in args.config), strict=True)
    stiffness = _arguments.typed_by_name(args, _STIFFNESS).get("stiffness")
    found: Sequence[Any] = esc.compare(
        *designs, equal_period=args.equal_period, stiffness=stiffness
    )
    names = [Path(path).stem for path in args.config]
    names = [f"{name} {k + 1}" * (names.count(name) > 1) or name for k, name in enumerate(names)]
    results = COMPARED | {
        f"yield_{figure}": Result("ratio", f"share of the sample within the limits of {figure}")
        for every in yields for figure in every
    }  # fmt: skip
    notes = list[str]()
    found = [
        replace(one, values={**one.values, **{f"yield_{n}": x for n, x in inside.items()}})
        for one, inside in zip(found, yields, strict=True)
    ]
    records = [Record(one.values, results) for one in found]
    for name, one in zip(names, found, strict=True):
        reasons: dict[str, list[str]] = {}
        for key, reason in one.reasons.items():
            reasons.setdefault(reason, []).append(key)
        notes += [f"{name}: no {', '.join(keys)}: {text}" for text, keys in reasons.items()]
    _output.save(args, plot=lambda plots: plots.plot_comparison(found, names))
    cases = [{"design": name, **one.values} for name, one in zip(names, records, strict=True)]
    message = {"message": "; ".join(notes)} if notes else {}
    told = Record({"designs": cases, **message}, results)
    _output.tell(args, told, table=lambda: _output.side_by_side(args, records, names))
    return 0


def _design(path: Path) -> tuple[Escapement, dict[str, float]]:
    """The one design of a study file, and the yield of each figure that has limits there."""
    from escapement.study.parse import load_tables, parse_plan
    from escapement.tolerance.spread import spreads_of
    from escapement.tolerance.tolerance_budget import budget_of

    plan, tables = load_tables(path, "limits", lone=True)
    try:
        if "sample" not in plan.configuration:
            if plan.cases > 1:
                raise InvalidValue(
                    f"a design to compare must be one case, got {plan.cases}; leave [sweep] out"
                )
            return plan.escapement(0), {}
        system = plan.configuration["units"]
        limits = {n: limits_in_si(n, ends, system) for n, ends in tables["limits"].items()}
        values: dict[str, Any] = {n: one.nominal for n, one in spreads_of(plan, {}).items()}
        nominal = plan.built(plan.fixed_si | values)
        if not limits:
            return nominal, {}
        # the yield needs these alone
        plan = parse_plan({**plan.configuration, "results": [*limits]})
        scatters = budget_of(plan, limits).figures
    except InvalidValue as error:
        raise InvalidValue(f"{path}: {error}") from None
    return nominal, {n: one.inside.value for n, one in scatters.items() if one.inside}
