"""Run time against error of the engines and of SciPy's solvers."""

import sys
from typing import TYPE_CHECKING

from escapement.base.text import print_columns
from escapement.cli import _arguments, _log, _output
from escapement.cli._arguments import Arguments, Parser

if TYPE_CHECKING:
    from escapement.benchmark.work_precision import Results


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_folder(parser, "tables (CSV), the figure and the machine's description")
    parser.add_argument("--quick", action="store_true", help="ten seconds instead of many minutes")


def execute(args: Arguments) -> int:
    """Measure, print, and fill the folder."""
    from escapement.benchmark import work_precision

    with _output.folder(args.output):
        results = work_precision.run(quick=args.quick, note=_output.note)
        try:
            _output.tell(args, results.as_dict(), table=lambda: print_tables(results))
            sys.stdout.flush()
        finally:  # neither a full disk nor a reader that left may cost many minutes of work
            for path in work_precision.write(results, args.output) if args.output else []:
                _output.note(f"wrote {path}")
                _log.record("saved", file=str(path))
    return 0


def print_tables(results: "Results") -> None:
    """The machine and the standings."""
    print(", ".join(f"{name} {value}" for name, value in results.machine.items()), end="\n\n")
    print_columns(
        [("problem", "solver", "error", "time", "times energy", "first call"),
         ("", "", "", "us", "", "s")],
        [
            (row.problem, row.solver, row.error, 1e6 * row.time, row.ratio, row.first)
            for row in results.standings
        ],
    )  # fmt: skip
