"""A timer that runs down: turns, rate, and when and where it stops."""

from dataclasses import replace
from functools import partial

import escapement as esc
from escapement.base.quantity import declared
from escapement.base.records import Record
from escapement.base.status import MESSAGES, Status
from escapement.base.text import as_csv
from escapement.cli import SOME_FAILED, _arguments, _output
from escapement.cli._arguments import Arguments, Parser
from escapement.engines.solver import Solver
from escapement.model.escapement import Run, model_settings
from escapement.model.inputs import inputs_of

_RUN = {
    "turns": replace(declared(Run)["turns"], note=", in whole engagements"),
    "duration": replace(declared(Run)["duration"], note=", instead of turns"),
    "initial_speed": declared(Run)["initial_speed"],
    "rtol": declared(Solver)["rtol"],
}


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    _arguments.add_group(parser, "model", model_settings())
    _arguments.add_group(parser, "length of the run", _RUN)
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "FILE.csv", "write the end of each engagement")
    _arguments.add_plot(output, "draw speed and lateness over the turns")


def execute(args: Arguments) -> int:
    """Let it run down, write what was asked for, print the figures."""
    from escapement.engines.run_down import RUNDOWN

    timer = _arguments.read_escapement(args)
    run = esc.rundown(timer, **_arguments.typed(args, _RUN))
    _output.save(args, partial(_table, run), lambda plots: plots.plot_rundown(run))
    start = {"initial_speed": 0.0} | _arguments.typed_by_name(args, _RUN)
    known = [*inputs_of(timer), *((name, x, _RUN[name].unit) for name, x in start.items())]
    stopped = run.message if run.message != MESSAGES[Status.OK] else ""
    _output.tell(args, _output.with_reasons(Record(run.as_dict(), RUNDOWN), stopped), known)
    failed = (Status.PAINLEVE, Status.NOT_CONVERGED, Status.INVALID)
    return SOME_FAILED if run.status in failed else 0


def _table(run: "esc.Rundown") -> str:
    """The end of each engagement as CSV."""
    columns = {
        "turns": run.turns, "time_s": run.times, "mean_speed_rad_per_s": run.mean_speeds,
        "rate_error": run.rate_errors, "lateness_s": run.lateness,
    }  # fmt: skip
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return as_csv([[*columns], *rows])
