"""`escapement sweep`: a study from a configuration into a file."""

import argparse
import os
import signal
from pathlib import Path
from typing import TYPE_CHECKING

from escapement.cli import SOME_FAILED, _arguments, _cases, _output
from escapement.cli._arguments import Parser, UsageError, whole
from escapement.errors import InvalidValue
from escapement.text import print_columns, words

if TYPE_CHECKING:
    from escapement.study.plan import StudyPlan
    from escapement.study.run import Tally

SUMMARY = "A study on a grid or a sample of parameters, to an HDF5 file."


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    add = parser.add_argument
    add("config", type=Path, metavar="CONFIG.toml", help="what to compute")
    default = "default: the name of CONFIG with .h5, in the current folder"
    _arguments.add_output(parser, "OUT.h5", default)
    text = "continue an interrupted run where it stopped"
    add("--resume", action="store_true", help=text)
    add("--quiet", action="store_true", help="no progress on stderr")
    count = whole("--workers", 1, "give the number of threads")
    text = "threads, or processes of a local cluster (default: one for each processor)"
    add("--workers", type=count, metavar="N", help=text)
    text = "compute on a Dask cluster, as tcp://host:8786; 'local' starts one here"
    add("--scheduler", metavar="ADDRESS", help=text)
    text = "units of the axes printed (default: those of the study)"
    _arguments.add_common(parser, units=None, text=text)


def execute(args: argparse.Namespace) -> int:
    """Run the study, then show a dozen of its cases."""
    from escapement.study.parse import load_plan

    plan = load_plan(args.config)
    if args.workers is not None and args.scheduler not in (None, "local"):
        raise UsageError(
            f"--workers must not come with --scheduler {args.scheduler}, whose workers are "
            "already there; leave it out"
        )
    path = args.output or Path(f"{args.config.stem}.h5")
    _output.check_output(path, args.config, force=args.force or args.resume)
    try:
        plan.check_mechanism()
    except InvalidValue as error:
        raise InvalidValue(f"{args.config}: {error}") from None
    tally = _run(plan, path, args)
    cases, units = _cases.some_cases(plan, path, args.units)
    if args.json:
        sizes = dict(zip(plan.dimensions, plan.shape, strict=True))
        record = {"output": str(path), "axes": sizes, "cases": tally.cases, "failed": tally.failed}
        _output.print_json(record | {"resumed": tally.resumed, "some_cases": cases})
    else:
        below = ["" if units[name] == "1" else units[name] for name in cases[0]]
        print_columns([[*map(words, cases[0])], below], ([*case.values()] for case in cases))
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

    # a job scheduler ends a process by SIGTERM: it keeps what is finished, as after Ctrl-C
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        options = {"force": args.force, "resume": args.resume, "scheduler": args.scheduler}
        workers = args.workers or os.cpu_count() or 1
        return write_plan(plan, path, progress=not args.quiet, workers=workers, **options)
    except KeyboardInterrupt:
        partial = partial_path(path)
        if partial.exists():
            _output.note(f"what was finished is in {partial.name}; continue with --resume")
        raise
    finally:
        signal.signal(signal.SIGTERM, previous)
