"""Command `run`: one motion from pin entry, and its figures of merit."""

import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.files import MOTIONS
from escapement.base.quantity import Setting, declared, quantities
from escapement.base.records import Record
from escapement.base.status import Status
from escapement.cli import SOME_FAILED, _arguments, _log, _output
from escapement.cli._arguments import ArgumentGroup, Arguments, Parser, UsageError, option
from escapement.dynamics.figure_record import BEATS, ENGAGEMENTS, record_of_motion
from escapement.dynamics.figure_table import FIGURES
from escapement.engines.solver import Solver
from escapement.model.escapement import Escapement, Run, model_settings
from escapement.model.inputs import inputs_of

if TYPE_CHECKING:
    from escapement.base.progress import Progress
    from escapement.engines.contact.jam_rule import JamCycle

# From so many engagements on, writing takes seconds and shows its progress. More are not drawn:
# that would take minutes and a gigabyte, and single engagements would be too narrow to see.
_LONG = 10_000
_START = {"initial_speed": declared(Run)["initial_speed"]}


def add_study(group: ArgumentGroup) -> None:
    """Add the options that choose a case of a study instead of mechanism and model."""
    text = "written by escapement sweep, or its CONFIG.toml"
    group.add_argument("--from", dest="study", type=Path, metavar="FILE.h5", help=text)
    text = (
        "a value of each axis, in the units of FILE.h5 or with its own unit: "
        "friction=0.35,torque=0.1"
    )
    group.add_argument("--select", metavar="NAME=VALUE,...", help=text)


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    study = parser.add_argument_group("one case of a study, instead of mechanism and model")
    add_study(study)
    _arguments.add_mechanism(parser, tables=True)
    length = {name: declared(Run)[name] for name in ("engagements", "duration")}
    _arguments.add_group(parser, "model", model())
    _arguments.add_group(parser, "length of the motion", length)
    _arguments.add_group(parser, "solver", declared(Solver))
    text = (
        "for friction beyond the Painleve limit: compute the terminal cycle of rigid bodies by an "
        "approximate rule for their jams"
    )
    parser.add_argument("--jam-rule", action="store_true", help=text)
    output = parser.add_argument_group("output")
    text = "write the motion: .h5, .hdf5 or .nc (HDF5), or .csv (the samples)"
    _arguments.add_output(output, "FILE.h5", text, MOTIONS)
    _arguments.add_plot(output, "draw the velocities", "or film the motion")
    _arguments.add_report(output)
    _arguments.tell_results(parser, FIGURES | {"beats": BEATS} | ENGAGEMENTS)


def model() -> dict[str, Setting]:
    """The settings of an escapement and its motion, without the mechanism."""
    every = model_settings() | _START
    return dict(sorted(every.items(), key=lambda item: not item[1].required))


def execute(args: Arguments) -> int:
    """Simulate and print the figures; write the files that were asked for."""
    return _output.tell_found(args, _computed)


def _computed(args: Arguments) -> _output.Found:
    """What is told of one motion, which is written and drawn where that is asked for."""
    escapement, settings = read_case(args)
    # if the rule refuses the escapement, nothing is computed or written
    jammed = esc.jam_rule(escapement) if args.jam_rule else None
    motion = esc.simulate(escapement, args.engagements, duration=args.duration, **settings)
    count = motion.handoff_times.size
    if args.plot is not None and count > _LONG:
        raise UsageError(
            f"--plot must come with at most {_LONG} engagements, got {count}; "
            "ask for fewer, or write the motion with --output"
        )
    # the figures belong to the terminal cycle and do not depend on the length of the motion
    figures = esc.terminal(escapement, **settings)
    # the balance may change the status, which files and the report hold
    with _shown(motion, "engagements balanced") as progress:
        motion.balance(progress)
    _save(motion, args, settings["initial_speed"])
    length = "engagements" if args.duration is None else "duration"
    taken = args.duration or args.engagements or quantities(Run)["engagements"].default
    inputs = [*inputs_of(escapement), ("initial_speed", settings["initial_speed"], "speed")]
    inputs += [(length, taken, quantities(Run)[length].unit), ("rtol", motion.rtol, "ratio")]
    failed = motion.status.failed or figures.status.failed
    return _found(motion, figures, jammed), inputs, SOME_FAILED * (failed and jammed is None)


def read_case(args: Arguments) -> "tuple[Escapement, dict[str, Any]]":
    """The escapement and the settings of `simulate`, from the arguments or from a study."""
    given = _arguments.typed(args, declared(Solver))
    if args.study is None:
        if args.select is not None:
            raise UsageError(f"--select must come with --from, got {args.select!r}; add --from")
        start = {"initial_speed": 0.0} | _arguments.typed(args, _START)
        return _arguments.read_escapement(args), given | start
    # an option must not change what the study sets
    twice = ["KIND"] if args.kind is not None else []
    names = [*model(), *_arguments.owners()]
    twice += [option(name) for name in names if getattr(args, name) is not None]
    if twice:
        raise UsageError(
            f"{twice[0]} must not come with --from, because the study sets it; leave it out"
        )
    from escapement.study.selection import load_case

    plan, case = load_case(args.study, args.select)
    try:
        escapement = plan.escapement(case)
    except InvalidValue as error:
        raise UsageError(
            f"--select must name a case with a possible mechanism, got {args.select!r}: {error}"
        ) from None
    # the tolerances of the study are not used for another engine
    given_solver = {} if "engine" in given else plan.solver.given
    return escapement, given_solver | given | {"initial_speed": plan.values(case)["initial_speed"]}


def _save(motion: "esc.Motion", args: Arguments, speed: float) -> None:
    """Save the files that were asked for."""
    wanted = [str(path) for path in (args.output, args.plot) if path is not None]
    if motion.end_time == 0.0:
        if wanted:
            _output.note(f"there is no motion to write, so no {' and no '.join(wanted)} was made")
        write = draw = None
    else:
        write = partial(partial, _write, motion, args)
        draw = _output.moving(args.plot, motion, lambda plots: plots.plot_velocities(motion))
    _output.save(args, write, draw, lambda: _output.page_of(motion.escapement, initial_speed=speed))


def _write(motion: "esc.Motion", args: Arguments) -> None:
    options = {"units": args.units, "force": args.force}
    with _shown(motion, "engagements") as progress:
        esc.write_motion(motion, args.output, progress=progress, **options)


def _shown(motion: "esc.Motion", what: str) -> "Progress":
    """Progress, which only long motions show."""
    from escapement.base.progress import Progress

    return Progress(quiet=motion.handoff_times.size < _LONG, what=what, log=_log.progress)


def _found(motion: "esc.Motion", figures: "esc.Figures", jammed: "JamCycle | None") -> Record:
    """Figures of merit and engagements, those of the rule for jams, and what to know of them."""
    record, message = record_of_motion(motion, figures)
    if jammed is not None:
        record |= _by_rule(jammed)
        message += f"; by the rule for jams: {jammed.message}"
    outcome = motion if motion.status is not Status.OK else figures
    end = {"status": outcome.status.label, "message": message, "engine": motion.engine}
    return record | Record(end)


def _by_rule(cycle: "JamCycle") -> Record:
    """Results of the rule for jams."""
    same = "period", "handoff_velocity", "velocity_max"
    found: dict[str, Any] = {f"jam_rule_{name}": getattr(cycle, name) for name in same}
    found["jam_rule_angles_deg"] = [math.degrees(angle) for angle in cycle.jam_angles]
    found["jam_rule_error"] = cycle.error
    return Record(found, {f"jam_rule_{name}": FIGURES[name] for name in same})
