"""A timer that runs down: turns, rate, and when and where it stops."""

from dataclasses import replace
from functools import partial

import escapement as esc
from escapement.base.quantity import Quantity, declared
from escapement.base.records import Record
from escapement.base.status import MESSAGES, Status
from escapement.base.text import as_csv
from escapement.cli import SOME_FAILED, _arguments, _output
from escapement.cli._arguments import Arguments, Parser
from escapement.engines.solver import Solver
from escapement.model.escapement import Run, model_settings
from escapement.model.inputs import Input, inputs_of

_RUN = {
    "turns": replace(declared(Run)["turns"], note=", in whole engagements"),
    "duration": replace(declared(Run)["duration"], note=", instead of turns"),
    "initial_speed": declared(Run)["initial_speed"],
    "rtol": declared(Solver)["rtol"],
}

_FAILED = (Status.PAINLEVE, Status.NOT_CONVERGED, Status.INVALID)
_TARGET = Quantity(
    name="target", long_name="time that the run should take", unit="time", metavar="S",
    exclusive=True, remedy="give the time",
)  # fmt: skip


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    model = model_settings()
    model["friction"] = _arguments.several(model["friction"])
    _arguments.add_group(parser, "model", model)
    _arguments.add_group(parser, "length of the run", _RUN | {"target": _TARGET})
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "FILE.csv", "write the end of each engagement")
    _arguments.add_plot(output, "draw speed and lateness over the turns")


def execute(args: Arguments) -> int:
    """Let it run down, write what was asked for, print the figures."""
    return _output.tell_found(args, _found, "friction")


def _found(args: Arguments) -> _output.Found:
    """What is told of one run, which is written and drawn where that is asked for."""
    from escapement.engines.run_down import RUNDOWN

    timer = _arguments.read_escapement(args)
    run = _run(args, timer)
    _output.save(args, partial(_table, run), lambda plots: plots.plot_rundown(run))
    stopped = run.message if run.message != MESSAGES[Status.OK] else ""
    record = Record(run.as_dict() | _against(args, run), RUNDOWN)
    code = SOME_FAILED if run.status in _FAILED else 0
    return _output.with_reasons(record, stopped), [*inputs_of(timer), *_asked(args)], code


def _run(args: Arguments, timer: esc.Escapement) -> "esc.Rundown":
    """The run that was asked for; of a timer that runs for ever, its turns in the target's time."""
    length = _arguments.typed(args, _RUN)
    if args.target is not None and _endless(args, timer):
        length["duration"] = replace(_TARGET, system=args.units).to_si(args.target)
    return esc.rundown(timer, **length)


def _endless(args: Arguments, timer: "esc.Escapement") -> bool:
    """Whether nothing ends the run of a timer."""
    return timer.curve is None and args.turns is None and args.duration is None


def _against(args: Arguments, run: "esc.Rundown") -> dict[str, float]:
    """How a run compares with its target, if there is one."""
    from escapement.engines.run_down import run_against

    if args.target is None or _endless(args, run.escapement):
        return {}
    target = replace(_TARGET, system=args.units).to_si(args.target)
    return run_against(run, target, _arguments.typed(args, _RUN).get("initial_speed", 0.0))


def _asked(args: Arguments) -> list[Input]:
    """How long a run was asked for."""
    start = {"initial_speed": 0.0} | _arguments.typed_by_name(args, _RUN)
    return [(name, x, _RUN[name].unit) for name, x in start.items()]


def _table(run: "esc.Rundown") -> str:
    """The end of each engagement as CSV."""
    columns = {
        "turns": run.turns, "time_s": run.times, "mean_speed_rad_per_s": run.mean_speeds,
        "rate_error": run.rate_errors, "lateness_s": run.lateness,
    }  # fmt: skip
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return as_csv([[*columns], *rows])
