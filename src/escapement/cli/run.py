"""`escapement run`: one motion and its figures of merit."""

import argparse
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.cli import SOME_FAILED, _arguments, _output
from escapement.cli._arguments import Parser, UsageError, option
from escapement.errors import InvalidValue
from escapement.model import Escapement, Inertia, Run
from escapement.quantity import Numbers, Quantity, Setting, declared, quantities
from escapement.solver import Solver
from escapement.status import MESSAGES, Status
from escapement.text import print_values, show, words
from escapement.units import SYSTEMS, factor, unit_name

if TYPE_CHECKING:
    from escapement.metrics import Figures
    from escapement.motion import Motion

SUMMARY = "One motion from pin entry, and its figures of merit."

_LONG = 10_000  # engagements from which writing them takes seconds, and shows its progress
_LONGEST_PLOT = 10_000  # engagements: a gigabyte of points
_START = "initial_speed"
_Input = tuple[str, Any, str]  # its name, its value in SI and its kind of unit


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
    _arguments.add_mechanism(parser)
    length = {name: entry for name, entry in declared(Run).items() if name != _START}
    _arguments.add_group(parser, "model", _model())
    _arguments.add_group(parser, "length of the motion", length)
    _arguments.add_group(parser, "solver", declared(Solver))
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "FILE.h5", "write the motion")
    _arguments.add_plot(output, "draw the velocities")
    _arguments.add_common(parser)


def _model() -> dict[str, Setting]:
    """What an escapement and its motion are made of, beside the mechanism."""
    start = {_START: declared(Run)[_START]}
    every = declared(Escapement) | declared(Inertia) | start
    return dict(sorted(every.items(), key=lambda item: not item[1].required))


def execute(args: argparse.Namespace) -> int:
    """Simulate, write what was asked for, print the figures."""
    _output.check_wanted(args, file="FILE.h5")
    escapement, settings = _read_case(args)
    from escapement.simulation import simulate, terminal

    motion = simulate(escapement, args.engagements, duration=args.duration, **settings)
    _check_plot(motion, args)
    # the figures are those of the terminal cycle, however short the motion
    figures = terminal(escapement, **settings)
    _write(motion, args)
    length = "engagements" if args.duration is None else "duration"
    taken = args.duration or args.engagements or quantities(Run)["engagements"].default
    inputs = [*_settings_of(escapement), (_START, settings[_START], "speed")]
    inputs += [(length, taken, quantities(Run)[length].unit), ("rtol", motion.rtol, "ratio")]
    outcome = motion if motion.status.failed else figures
    record = _summarise(motion, figures, args.units) | {
        "status": outcome.status.label,
        "message": _message(outcome.message, figures),
        "engine": motion.engine,
    }
    if args.json:
        told = {name: _in_systems(value, unit) for name, value, unit in inputs}
        _output.print_json({"inputs": {"units": args.units} | told} | record)
    else:
        _print_table(inputs, record, args.units)
    if record["message"] != MESSAGES[Status.OK]:
        _output.note(record["message"])
    return SOME_FAILED if outcome.status.failed else 0


def _read_case(args: argparse.Namespace) -> "tuple[Escapement, dict[str, Any]]":
    """What to simulate, and the settings of `simulate`: of the arguments or of a study."""
    given = _arguments.typed(args, declared(Solver))
    if args.study is None:
        if args.select is not None:
            raise UsageError(f"--select must come with --from, got {args.select!r}; add --from")
        start = {_START: 0.0} | _arguments.typed(args, {_START: declared(Run)[_START]})
        return _arguments.read_escapement(args), given | start
    _refuse_beside_study(args)
    from escapement.cli._cases import load_case

    plan, case = load_case(args.study, args.select)
    # another engine than the study's does not take its tolerances
    own = {} if "engine" in given else plan.solver.given
    speed = plan.values(case)[_START]
    try:
        escapement = plan.escapement(case)
    except InvalidValue as error:
        raise UsageError(
            f"--select must name a case that can be built, got {args.select!r}: {error}"
        ) from None
    return escapement, own | given | {_START: speed}


def _refuse_beside_study(args: argparse.Namespace) -> None:
    """Whatever the study says must not be said twice."""
    said = ["KIND"] if args.kind is not None else []
    said += [option(name) for name in _model() if getattr(args, name) is not None]
    said += [option(name) for name in _arguments.mechanism_options(args)]
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
        from escapement import plots

        plots.save(plots.plot_velocities(motion), args.plot)


def _summarise(motion: "Motion", figures: "Figures", units: str) -> dict[str, Any]:
    """The numbers that `run` reports, by JSON key, in the user's units."""
    from escapement.metrics import FIGURES

    found = {
        key: _output.in_units(getattr(figures, key), unit, units) for key, unit in FIGURES.items()
    }
    if getattr(motion.escapement.mechanism, "crank_radius", None) is None:
        del found["contact_force_max"]
    return found | {
        "handoff_times": motion.handoff_times,
        "handoff_velocities": motion.handoff_velocities,
        "energy_residual": motion.ledger.residual,
    }


def _message(message: str, figures: "Figures") -> str:
    """What became of the run, and why it names no critical friction where there is none."""
    reasons = _output.not_given({"critical_friction": figures.critical_friction})
    return "; ".join(reasons if reasons and message == MESSAGES[Status.OK] else [message, *reasons])


def _settings_of(escapement: Escapement) -> list[_Input]:
    """Every number and choice of an escapement: its name, its value in SI and its unit."""
    mechanism: Any = escapement.mechanism
    found: list[_Input] = [("kind", mechanism.kind, "ratio")]
    for owner in (mechanism, escapement.inertia, escapement):
        for name, entry in declared(type(owner)).items():
            value, unit = getattr(owner, entry.key), "ratio"
            if isinstance(entry, Quantity):
                if not entry.fits(mechanism.meshed):
                    continue
                unit = entry.unit
            # the angles of a table are too many to be shown
            if value is not None and not isinstance(entry, Numbers):
                found.append((name, str(value) if isinstance(value, Fraction) else value, unit))
    return found


def _in_systems(value: Any, unit: str) -> Any:
    """A value in SI and in inches and pounds, by system; alone where these are the same."""
    scales = {system: factor(unit, system) for system in SYSTEMS}
    alike = len({*scales.values()}) == 1
    return value if alike else {system: value / scale for system, scale in scales.items()}


def _print_table(inputs: list[_Input], record: dict[str, Any], units: str) -> None:
    """What was simulated, with units in both systems, and what came of it."""
    from escapement.metrics import FIGURES

    (other,) = (system for system in SYSTEMS if system != units)
    rows = []
    for name, value, unit in inputs:
        # speeds are the same in both systems: only this row tells of numbers typed in the other
        shown = unit_name(unit, units)
        if shown != unit_name(unit, other):
            shown += f" = {show(_output.in_units(value, unit, other))} {unit_name(unit, other)}"
        rows.append((words(name), _output.in_units(value, unit, units), shown))
    rows += [
        (words(key), record[key], unit_name(unit, units))
        for key, unit in FIGURES.items()
        if key in record
    ]
    times, speeds = record["handoff_times"], record["handoff_velocities"]
    rows.append(("handoffs", len(times), ""))
    if len(times):
        rows += [("last handoff", times[-1], "s"), ("velocity there", speeds[-1], "rad s-1")]
    rows += [(words(key), record[key], "") for key in ("energy_residual", "status", "engine")]
    print_values(rows)
