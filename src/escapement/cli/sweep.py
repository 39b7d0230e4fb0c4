"""A study on a grid or a sample of parameters, to an HDF5 file."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.records import Table
from escapement.base.text import words
from escapement.cli import SOME_FAILED, _arguments, _inputs, _log, _output
from escapement.cli._arguments import Arguments, Parser, UsageError

if TYPE_CHECKING:
    from escapement.study.plan import StudyPlan
    from escapement.study.running import Tally

UNITS = "units of the axes printed (default: those of the study)"


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    add = parser.add_argument
    add("config", type=Path, metavar="CONFIG.toml", help="what to compute")
    default = ".h5, .hdf5 or .nc (HDF5), .csv or .parquet (a table); default: CONFIG.h5, here"
    add("-o", "--output", type=Path, metavar="OUT.h5", help=default)
    _arguments.add_force(parser, "OUT.h5")
    text = "continue an interrupted run where it stopped"
    add("--resume", action="store_true", help=text)
    add("--quiet", action="store_true", help="no progress on stderr")
    text = "threads, or processes of a local cluster (default: one for each processor)"
    rule: dict[str, Any] = {"minimum": 1, "whole": True, "remedy": "give the number of threads"}
    _arguments.add_number(parser, "workers", text, "N", **rule)
    text = "compute on a Dask cluster, as tcp://host:8786; 'local' starts one here"
    add("--scheduler", metavar="ADDRESS", help=text)


def execute(args: Arguments) -> int:
    """Run the study, then show a dozen of its cases."""
    from escapement.study.table_files import check_format

    _output.speak_as(args, args.config, "study file")
    plan = esc.load_plan(args.config)
    if args.workers is not None and args.scheduler not in (None, "local"):
        raise UsageError(
            f"--workers must not come with --scheduler {args.scheduler}, whose workers are "
            "already there; leave it out"
        )
    path = args.output or Path(f"{args.config.stem}.h5")
    check_format(path)
    others = [other for other in (args.config, args.log) if other is not None]
    _output.check_output(path, *others, force=args.force or args.resume)
    try:
        plan.check_mechanism()
    except InvalidValue as error:
        raise InvalidValue(f"{args.config}: {error}") from None
    from escapement.study.scenes import cost_note

    for text in filter(None, (plan.idle, plan.unused, "" if args.quiet else cost_note(plan))):
        _output.note(text)
    tally = _run(plan, path, args)
    from escapement.study.selection import some_cases

    cases, units = some_cases(plan, path, args.units)

    def table() -> None:
        Table("", [*map(words, cases[0])], units, [[*case.values()] for case in cases]).show()
        before = f", {tally.resumed} of them from an earlier run" if tally.resumed else ""
        shown = f", {len(cases)} of them above" if len(cases) < tally.cases else ""
        _output.note(f"{tally.cases} case{'s' * (tally.cases != 1)} in {path}{shown}{before}")

    sizes = dict(zip(plan.dimensions, plan.shape, strict=True))
    record = {"output": str(path), "axes": sizes} | tally._asdict() | {"some_cases": cases}
    _output.tell(args, record, _inputs.of_plan(plan), table)
    if tally.failed:
        _output.note(
            f"{tally.failed} of {tally.cases} cases failed: the status in the file says why; "
            f"escapement run --from {path} --select explains one case"
        )
    return SOME_FAILED if tally.failed else 0


def _run(plan: "StudyPlan", path: Path, args: Arguments) -> "Tally":
    """Run the study; if it is interrupted, tell how to continue."""
    from escapement.base.notice import notice
    from escapement.base.progress import Progress
    from escapement.study.running import write_plan
    from escapement.study.writer import partial_path

    notice.silent |= args.quiet
    workers = args.workers or os.cpu_count() or 1
    try:
        options = {"force": args.force, "resume": args.resume, "scheduler": args.scheduler}
        with Progress(quiet=args.quiet, log=_log.progress) as shown:
            tally = write_plan(plan, path, progress=shown, workers=workers, **options)
    except KeyboardInterrupt:
        if (partial := partial_path(path)).exists():
            _output.note(f"finished cases are kept in {partial.name}; continue with --resume")
            _log.record("saved", file=str(partial))
        raise
    _log.record("saved", file=str(path))
    return tally
