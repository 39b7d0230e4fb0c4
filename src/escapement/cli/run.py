"""`escapement run`: one motion and its figures of merit."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement import validate
from escapement.cli import SOME_FAILED, _arguments, _files, _kinds, _output
from escapement.cli._parser import Parser, UsageError, number, option, whole
from escapement.cli._run_report import print_table, summarise
from escapement.errors import InvalidValue
from escapement.status import MESSAGES, Status

if TYPE_CHECKING:
    from escapement.model import Escapement
    from escapement.motion import Motion

SUMMARY = "One motion from pin entry, and its figures of merit."

_REQUIRED = ("torque", "driver_inertia", "follower_inertia")
"""What an escapement needs, unless it comes from a study."""
_DEFAULTS = {"friction": 0.0, "load_torque": 0.0, "initial_speed": 0.0, "efficiency": 1.0}
"""What it has where nothing was typed; not argparse's, so that a typed default is seen."""
_LONG = 10_000  # engagements from which writing them takes seconds, and shows its progress
_LONGEST_PLOT = 10_000  # engagements: a gigabyte of points
_SOLVER = ("engine", "rtol", "atol", "method", "max_step")


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    study = parser.add_argument_group("one case of a study, instead of mechanism and model")
    study.add_argument(
        "--from", dest="study", type=Path, metavar="FILE.h5", help="written by escapement sweep"
    )
    study.add_argument(
        "--select",
        metavar="NAME=VALUE,...",
        help="a value of each axis in the units of FILE.h5, as friction=0.35,torque=0.1",
    )
    _kinds.add_mechanism(parser)
    model = parser.add_argument_group("model")
    for name in _REQUIRED:
        _arguments.add_quantity(model, name)
    for name, default in _DEFAULTS.items():
        _arguments.add_quantity(model, name, note=f" (default: {default:g})")
    length = parser.add_argument_group("length of the motion")
    length.add_argument(
        "--engagements",
        type=whole("--engagements", 1, "give how many to run"),
        metavar="N",
        help="engagements to run (default: 20)",
    )
    _arguments.add_quantity(length, "duration", note=", instead of engagements")
    _add_solver(parser)
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "FILE.h5", "write the motion")
    _arguments.add_plot(output, "draw the velocities")
    _arguments.add_common(parser)


def _add_solver(parser: Parser) -> None:
    solver = parser.add_argument_group("solver")
    solver.add_argument("--engine", metavar="NAME", help="energy (default) or ivp, the reference")
    solver.add_argument(
        "--rtol",
        type=number("--rtol", validate.number, "1e-10 is a good choice"),
        metavar="R",
        help="relative error of handoff times and speeds (default: 1e-12, with ivp 1e-10)",
    )
    solver.add_argument(
        "--atol",
        type=number("--atol", validate.non_negative, "leave it out"),
        metavar="A",
        help="with ivp: absolute tolerance as in SciPy's solve_ivp",
    )
    solver.add_argument(
        "--method",
        metavar="NAME",
        help="with ivp: DOP853 (default), RK45, RK23, Radau, BDF or LSODA",
    )
    _arguments.add_quantity(solver, "max_step", note=", with ivp")


def execute(args: argparse.Namespace) -> int:
    """Simulate, write what was asked for, print the figures."""
    _files.check_wanted(args, file="FILE.h5")
    escapement, settings = _read_case(args)
    from escapement.simulation import simulate, terminal

    motion = simulate(escapement, args.engagements, duration=args.duration, **settings)
    _check_plot(motion, args)
    figures = terminal(escapement, **settings)
    _write(motion, args)
    record = summarise(motion, figures, args.units)
    if args.json:
        _output.print_json(record)
    else:
        print_table(record, args.units)
    outcome = motion if motion.status.failed else figures
    if record["message"] != MESSAGES[Status.OK]:
        _output.note(record["message"])
    return SOME_FAILED if outcome.status.failed else 0


def _read_case(args: argparse.Namespace) -> "tuple[Escapement, dict[str, Any]]":
    """What to simulate, and the settings of `simulate`: of the arguments or of a study."""
    given = {name: getattr(args, name) for name in _SOLVER if getattr(args, name) is not None}
    if args.study is None:
        if args.select is not None:
            raise UsageError(f"--select must come with --from, got {args.select!r}; add --from")
        missing = [option(name) for name in _REQUIRED if getattr(args, name) is None]
        if missing:
            raise UsageError(
                f"the following arguments are required: {', '.join(missing)}; "
                "see 'escapement run --help'"
            )
        for name, default in _DEFAULTS.items():
            if getattr(args, name) is None:
                setattr(args, name, default)
        return _arguments.read_escapement(args), given | {"initial_speed": args.initial_speed}
    _refuse_beside_study(args)
    from escapement.cli._select import load_case

    plan, case = load_case(args.study, args.select)
    own = {} if "engine" in given else plan.solver.given
    speed = plan.values(case)["initial_speed"]
    try:
        escapement = plan.escapement(case)
    except InvalidValue as error:
        raise UsageError(
            f"--select must name a case that can be built, got {args.select!r}: {error}"
        ) from None
    return escapement, own | given | {"initial_speed": speed}


def _refuse_beside_study(args: argparse.Namespace) -> None:
    """Whatever the study says must not be said twice."""
    said = ["KIND"] if args.kind is not None else []
    said += [option(name) for name in (*_REQUIRED, *_DEFAULTS) if getattr(args, name) is not None]
    said += [option(name) for name in _kinds.given_options(args)]
    if said:
        raise UsageError(f"{said[0]} must not come with --from, which has its own; leave it out")


def _check_plot(motion: "Motion", args: argparse.Namespace) -> None:
    """Refuse a figure that takes minutes, and in which nothing could be told apart."""
    count = motion.handoff_times.size
    if args.plot is not None and count > _LONGEST_PLOT:
        raise UsageError(
            f"--plot must come with at most {_LONGEST_PLOT} engagements, got {count}; "
            "run fewer, or write the motion with --output"
        )


def _write(motion: "Motion", args: argparse.Namespace) -> None:
    if motion.end_time == 0.0:
        wanted = [str(path) for path in (args.output, args.plot) if path is not None]
        if wanted:
            _output.note(f"there is no motion to write: no {' and no '.join(wanted)} was made")
        return
    if args.output is not None:
        from escapement.motion_file import write_motion
        from escapement.progress import Progress

        short = motion.handoff_times.size < _LONG
        with Progress(quiet=short, what="samples") as progress:
            options = {"units": args.units, "force": args.force, "progress": progress}
            write_motion(motion, args.output, **options)
    if args.plot is not None:
        from escapement.plots import plot_velocities
        from escapement.plots.saving import save_axes

        save_axes(plot_velocities(motion), args.plot)
