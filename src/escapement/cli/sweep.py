"""A study on a grid or a sample of parameters, to an HDF5 file."""

import itertools
import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import escapement as esc
from escapement.base.errors import InputFileError, InvalidValue
from escapement.base.quantity import Quantity
from escapement.base.status import Status
from escapement.base.text import print_columns, words
from escapement.base.units import SYSTEMS, ratio_of, spelt, unit_name
from escapement.cli import SOME_FAILED, _arguments, _inputs, _log, _output
from escapement.cli._arguments import Arguments, Parser, UsageError

if TYPE_CHECKING:
    from escapement.study.plan import StudyPlan
    from escapement.study.running import Tally

UNITS = "units of the axes printed (default: those of the study)"

_ROWS = 12
_RESULTS = 5  # greatest number of results in a printed table


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    add = parser.add_argument
    add("config", type=Path, metavar="CONFIG.toml", help="what to compute")
    default = ".h5, .hdf5 or .nc (HDF5), .csv or .parquet (a table); default: CONFIG.h5, here"
    _arguments.add_output(parser, "OUT.h5", default)
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
    for text in filter(None, (plan.idle, plan.unused)):
        _output.note(text)
    tally = _run(plan, path, args)
    cases, units = some_cases(plan, path, args.units)

    def table() -> None:
        below = [spelt(units[name]) for name in cases[0]]
        print_columns([[*map(words, cases[0])], below], ([*case.values()] for case in cases))
        before = f", {tally.resumed} of them from an earlier run" if tally.resumed else ""
        shown = f", {len(cases)} of them above" if len(cases) < tally.cases else ""
        _output.note(f"{tally.cases} case{'s' * (tally.cases != 1)} in {path}{shown}{before}")

    sizes = dict(zip(plan.dimensions, plan.shape, strict=True))
    record = {"output": str(path), "axes": sizes} | tally._asdict() | {"some_cases": cases}
    _output.tell(args, record, table, known=_inputs.of_plan(plan))
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


def some_cases(
    plan: "StudyPlan", path: Path, units: str
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """At most a dozen cases of a study file, spread evenly over every dimension.

    Only these cases are read, and the first five of their results, so that a large file takes no
    longer. Numbers are in `units`, a system; the unit of every column is returned as well.
    """
    import numpy as np

    from escapement.study.plan import unit_kind
    from escapement.study.stored import open_hdf5
    from escapement.study.table_files import is_table, read_rows

    along = [{name: values} | plan.varied[name] for name, values in plan.dimensions.items()]
    shown = [name for name in plan.results if name != "status"][:_RESULTS]
    names = [*(name for columns in along for name in columns), *shown, "status"]
    scaled = {name: in_system(unit_kind(name), plan.unit(name), units) for name in names}
    cases, indices = [], spread(plan.shape, _ROWS)
    if is_table(path):
        numbers = [int(np.ravel_multi_index(index, plan.shape)) for index in indices]
        results: dict[str, Any] = dict(read_rows(path, numbers))
    else:
        with open_hdf5(path) as hdf5:
            wanted = (*shown, "status")
            results = {name: [hdf5[name][index] for index in indices] for name in wanted}
    for row, index in enumerate(indices):
        case = {
            name: values[i].item() * scaled[name][0]
            for columns, i in zip(along, index, strict=True)
            for name, values in columns.items()
        }
        case |= {name: float(results[name][row]) * scaled[name][0] for name in shown}
        cases.append(case | {"status": Status(int(results["status"][row])).label})
    return cases, {name: unit for name, (_, unit) in scaled.items()}


def in_system(kind: str, unit: str, system: str) -> tuple[float, str]:
    """Factor that brings numbers of a kind from their unit into a system, and the unit there."""
    wanted = unit_name(kind, system)
    scale = 1.0 if unit == wanted else ratio_of(unit, wanted)
    return 1 if scale == 1.0 else scale, wanted  # a whole number stays whole


def spread(shape: tuple[int, ...], most: int) -> list[tuple[int, ...]]:
    """At most `most` grid points: the ends of every axis, the middle, and points between them."""
    counts = list(shape)
    marked = [tuple(index) for index in zip(*((0, n // 2, n - 1) for n in shape), strict=True)]

    def added() -> list[tuple[int, ...]]:
        few = any(n < min(size, 3) for size, n in zip(shape, counts, strict=True))
        return marked if few else []

    while math.prod(counts) + len(added()) > most:
        largest = max(counts)
        # an odd number of points between two ends has the middle among them
        counts[counts.index(largest)] -= 2 if largest > 3 and largest % 2 else 1
    picks = [
        [round(i * (size - 1) / (count - 1)) for i in range(count)] if count > 1 else [size // 2]
        for size, count in zip(shape, counts, strict=True)
    ]
    return sorted({*itertools.product(*picks), *added()})


def load_case(path: Path, selection: str | None) -> "tuple[StudyPlan, int]":
    """The plan of a study, and the number of the case that was selected.

    Parameters
    ----------
    path : Path
        File that `escapement sweep` wrote, or its configuration, CONFIG.toml.
    selection : str, optional
        "friction=0.35,torque=0.1", in the units of the file, with "case=17" of a sample.
        An axis of one value needs no selection.

    Raises
    ------
    UsageError, InvalidValue
        When the selection cannot be understood, or does not name exactly one case.
    MissingInput, InputFileError
        When the file is not a study.
    """
    import numpy as np

    from escapement.study.parse import parse_plan
    from escapement.study.reader import read_configuration
    from escapement.study.result import index_on

    written = path.suffix.lower() != ".toml"
    configuration = read_configuration(path) if written else esc.load_plan(path).configuration
    wanted = parse_selection(selection or "", configuration.get("units", SYSTEMS[0]))
    if written and "sample" in configuration and "case" in wanted:
        if not (case := wanted.pop("case")).is_integer():
            raise InvalidValue(f"case must be a whole number, got {case:g}; cases count from 0")
        # another version of SciPy may draw other numbers: use the stored ones
        row = esc.read_study(path).at(case=case).sampled
        drawn = {name: values.tolist() for name, values in row.items()}
        configuration["sample"] = {"method": "list"} | drawn
    try:
        plan = parse_plan(configuration) if written else esc.load_plan(path)
    except InvalidValue as error:
        raise InputFileError(
            f"study {path} must hold a configuration this version understands, got: {error}"
        ) from None
    unknown = [name for name in wanted if name not in plan.dimensions]
    if unknown:
        raise UsageError(
            f"--select must name axes of {path}, got {unknown[0]!r}; "
            f"it has {', '.join(plan.dimensions)}"
        )
    index = []
    for name, values in plan.dimensions.items():
        if name not in wanted and values.size > 1:
            raise UsageError(
                f"--select must choose one of the {values.size} values of {name} in {path}, "
                f"got none; add {name}={values[0]:g}"
            )
        index.append(index_on(values, name, wanted[name], path) if name in wanted else 0)
    return plan, int(np.ravel_multi_index(index, plan.shape))


def parse_selection(selection: str, system: str) -> dict[str, float]:
    """Values by name from "friction=0.35,torque=0.1"; UsageError for any other form.

    Values without a unit are in those of `system`.
    """
    from escapement.study.plan import unit_kind

    wanted = {}
    for part in filter(None, (part.strip() for part in selection.split(","))):
        name, _, text = part.partition("=")
        name = name.strip()
        if name in wanted:
            raise UsageError(f"--select must give {name} once, got {selection!r}; leave one out")
        if not (name and text):
            raise UsageError(
                f"--select must be NAME=VALUE[,NAME=VALUE...], got {part!r}; "
                "for example friction=0.35,torque=0.1"
            )
        rule: dict[str, Any] = {"remedy": "give the value of a case", "minimum": -math.inf}
        entry = Quantity(long_name=name, unit=unit_kind(name), system=system, **rule)
        wanted[name] = entry.parse(f"--select {name}", text)
    return wanted
