"""`escapement sweep`: a study from a configuration into a file."""

import argparse
import os
import signal
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.cli import SOME_FAILED, _arguments, _cases, _output
from escapement.cli._arguments import Parser, UsageError, whole
from escapement.errors import InvalidValue
from escapement.text import print_columns, words
from escapement.units import unit_name

if TYPE_CHECKING:
    from escapement.study.plan import StudyPlan
    from escapement.study.run import Tally

SUMMARY = "A study on a grid or a sample of parameters, to an HDF5 file."


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    parser.add_argument("config", type=Path, metavar="CONFIG.toml", help="what to compute")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="OUT.h5",
        help="default: the name of CONFIG with .h5, in the current folder",
    )
    parser.add_argument("--force", action="store_true", help="replace OUT.h5 where it exists")
    parser.add_argument(
        "--resume", action="store_true", help="continue an interrupted run where it stopped"
    )
    parser.add_argument("--quiet", action="store_true", help="no progress on stderr")
    parser.add_argument(
        "--workers",
        type=whole("--workers", 1, "give the number of threads"),
        metavar="N",
        help="threads, or processes of a local cluster (default: one for each processor)",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="compute on a Dask cluster, as tcp://host:8786; 'local' starts one here",
    )
    _arguments.add_common(
        parser, units=None, text="units of the axes printed (default: those of the study)"
    )


def execute(args: argparse.Namespace) -> int:
    """Run the study, then show a dozen of its cases."""
    from escapement.study.parse import load_plan

    plan = load_plan(args.config)
    if args.workers is not None and args.scheduler not in (None, "local"):
        raise UsageError(
            f"--workers must not come with --scheduler {args.scheduler}, whose workers are "
            "already there; leave it out"
        )
    path = Path(f"{args.config.stem}.h5") if args.output is None else args.output
    _output.check_output(path, args.config, force=args.force or args.resume)
    try:
        plan.check_mechanism()
    except InvalidValue as error:
        raise InvalidValue(f"{args.config}: {error}") from None
    tally = _run(plan, path, args)
    cases = _cases.some_cases(plan, path, args.units)
    if args.json:
        sizes = {name: values.size for name, values in plan.dimensions.items()}
        record = {"output": str(path), "axes": sizes, "cases": tally.cases, "failed": tally.failed}
        record["resumed"] = tally.resumed
        _output.print_json(record | {"some_cases": cases})
    else:
        _print_table(plan, cases, args.units or plan.unit_system)
        before = f", {tally.resumed} of them from before" if tally.resumed else ""
        _output.note(f"{tally.cases} case{'s' * (tally.cases != 1)} in {path}{before}")
    if tally.failed:
        _output.note(
            f"{tally.failed} of {tally.cases} cases failed: the file's status says why, "
            f"of one case in words escapement run --from {path} --select"
        )
    return SOME_FAILED if tally.failed else 0


def _run(plan: "StudyPlan", path: Path, args: argparse.Namespace) -> "Tally":
    """Run the study; a request to end is answered with how to go on."""
    from escapement.study.run import write_plan
    from escapement.study.writer import partial_path

    in_charge = threading.current_thread() is threading.main_thread()
    previous = signal.getsignal(signal.SIGTERM)
    if in_charge:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        return write_plan(
            plan,
            path,
            force=args.force,
            resume=args.resume,
            progress=not args.quiet,
            workers=args.workers or os.cpu_count() or 1,
            scheduler=args.scheduler,
        )
    except KeyboardInterrupt:
        partial = partial_path(path)
        if partial.exists():
            _output.note(f"what was finished is in {partial.name}; continue with --resume")
        raise
    finally:
        if in_charge:
            signal.signal(signal.SIGTERM, previous)


def _print_table(plan: "StudyPlan", cases: list[dict[str, Any]], units: str) -> None:
    named = {name: unit_name(parameter.unit, units) for name, parameter in plan.parameters.items()}
    named |= {
        name: "s" if name.endswith(("period", "time")) else "rad s-1" for name in _cases.RESULTS
    }
    names = [*cases[0]]
    header = [words(name) for name in names]
    below = ["" if named.get(name) in (None, "1") else named[name] for name in names]
    print_columns([header, below], ([case[name] for name in names] for case in cases))
