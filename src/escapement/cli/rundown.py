"""A timer that runs down: turns, rate, and when and where it stops."""

from dataclasses import replace
from typing import Any

import escapement as esc
from escapement.base.files import write_file
from escapement.base.quantity import Quantity, declared
from escapement.base.status import MESSAGES, Status
from escapement.base.text import as_csv
from escapement.cli import SOME_FAILED, _arguments, _output
from escapement.cli._arguments import Arguments, Parser
from escapement.engines.solver import Solver
from escapement.model.escapement import Run, model_settings
from escapement.model.inputs import inputs_of

_TURNS = Quantity(
    name="turns", key="turns", long_name="driver turns to run, in whole engagements", metavar="N",
    exclusive=True, remedy="give how often the driver turns",
)  # fmt: skip
_RUN = {
    "turns": _TURNS,
    "duration": replace(declared(Run)["duration"], note=", instead of turns"),
    "initial_speed": declared(Run)["initial_speed"],
    "rtol": declared(Solver)["rtol"],
}
_KINDS = dict.fromkeys(
    ("nominal_period", "first_period", "last_period", "end_time", "lateness"),
    "time",
) | {"time": "time", "mean_speed": "speed"}
_ROWS = 11
"""Lines of the table over the turns."""


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
    _output.check_wanted(args, file="FILE.csv")
    import numpy as np

    timer = _arguments.read_escapement(args)
    run = esc.rundown(timer, **_arguments.typed(args, _RUN))
    picture = _output.drawn(args.plot, lambda plots: plots.plot_rundown(run))
    if args.output is not None:
        header = ("turns", "time_s", "mean_speed_rad_per_s", "rate_error", "lateness_s")
        table = as_csv([header, *np.column_stack(_columns(run)).tolist()])
        write_file(args.output, [table.encode()], args.force)
    picture()
    stopped = run.message if run.message != MESSAGES[Status.OK] else ""
    start = {"initial_speed": 0.0} | _arguments.typed_by_name(args, _RUN)
    known = [*inputs_of(timer), *((name, x, _RUN[name].unit) for name, x in start.items())]
    _output.report(args, summarise(run), _KINDS, stopped, known)
    failed = (Status.PAINLEVE, Status.NOT_CONVERGED, Status.INVALID)
    return SOME_FAILED if run.status in failed else 0


def _columns(run: "esc.Rundown") -> tuple[Any, ...]:
    """The columns for each engagement."""
    return run.turns, run.times, run.mean_speeds, run.rate_errors, run.lateness


def summarise(run: "esc.Rundown") -> dict[str, Any]:
    """What `rundown` reports, by JSON key, in SI."""
    import numpy as np

    record: dict[str, Any] = {
        "turns": run.end_turns,
        "end_time": run.end_time,
        "engagements": run.times.size,
        "nominal_period": run.nominal_period,
    }
    if run.times.size:
        names = ("turns", "time", "mean_speed", "rate_error_percent", "lateness")
        chosen = np.unique(np.linspace(0, run.times.size - 1, _ROWS).astype(int))
        table = np.column_stack(_columns(run))[chosen] * (1.0, 1.0, 1.0, 100.0, 1.0)
        record |= {
            "first_period": run.periods[0],
            "last_period": run.periods[-1],
            "rate_error_percent": 100.0 * (run.nominal_period * run.times.size / run.times[-1] - 1),
            "lateness": run.lateness[-1],
            "over_the_turns": [dict(zip(names, row, strict=True)) for row in table.tolist()],
        }
    return record | {"status": run.status.label}
