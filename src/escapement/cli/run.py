"""`escapement run`: one motion and its figures of merit."""

import argparse
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.cli import SOME_FAILED, _arguments, _output
from escapement.cli._arguments import Parser, UsageError, option
from escapement.errors import InvalidValue
from escapement.model import Escapement, Inertia, Run
from escapement.quantity import Numbers, Quantity, Setting, declared
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

FIGURES = {
    "velocity_max": "speed",
    "velocity_min": "speed",
    "velocity_mean": "speed",
    "velocity_average_published": "speed",
    "period": "time",
    "rise_time": "time",
    "settling_time": "time",
    "critical_friction": "ratio",
    "acceleration_max": "acceleration",
    "follower_acceleration_max": "acceleration",
    "contact_moment_max": "torque",
    "contact_force_max": "force",
}
"""Figures of merit as printed, with the kind of unit of each; the force with a crank radius."""


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
    model, length = parser.add_argument_group("model"), declared(Run)
    for entry in _model().values():
        _arguments.add_setting(model, entry)
    group = parser.add_argument_group("length of the motion")
    for name in ("engagements", "duration"):
        _arguments.add_setting(group, length[name])
    solver = parser.add_argument_group("solver")
    for entry in declared(Solver).values():
        _arguments.add_setting(solver, entry)
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
    figures = terminal(escapement, **settings)
    _write(motion, args)
    record = summarise(motion, figures, args.units)
    length = "engagements" if args.duration is None else "duration"
    taken = args.duration or args.engagements or declared(Run)["engagements"].default
    inputs = describe(escapement) | {_START: settings[_START], length: taken, "rtol": motion.rtol}
    if args.json:
        _output.print_json({"inputs": {"units": args.units} | inputs} | record)
    else:
        print_table(inputs, record, args.units)
    outcome = motion if motion.status.failed else figures
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
        from escapement.plots import plot_velocities
        from escapement.plots.saving import save

        save(plot_velocities(motion), args.plot)


def summarise(motion: "Motion", figures: "Figures", units: str) -> dict[str, Any]:
    """What `run` reports, by JSON key, in the user's units."""
    outcome = motion if motion.status.failed else figures
    values = figures.as_dict()
    if getattr(motion.escapement.mechanism, "crank_radius", None) is None:
        del values["contact_force_max"]
    return {
        **{
            key: _output.in_units(values[key], kind, units)
            for key, kind in FIGURES.items()
            if key in values
        },
        "handoff_times": motion.handoff_times,
        "handoff_velocities": motion.handoff_velocities,
        "energy_residual": motion.ledger.residual,
        "status": outcome.status.label,
        "message": _message(outcome.message, values),
        "engine": motion.engine,
    }


def _message(message: str, values: dict[str, Any]) -> str:
    """What became of the run, and why it names no critical friction where there is none."""
    reasons = _output.not_given(values)
    return "; ".join(reasons if reasons and message == MESSAGES[Status.OK] else [message, *reasons])


def describe(escapement: Escapement) -> dict[str, Any]:
    """Every number and choice of an escapement by name: with units, in each system of units."""
    mechanism: Any = escapement.mechanism
    found: dict[str, Any] = {"kind": mechanism.kind}
    for owner in (mechanism, escapement.inertia, escapement):
        for name, entry in declared(type(owner)).items():
            value = getattr(owner, entry.key)
            if value is None or isinstance(entry, Numbers):
                continue
            if isinstance(entry, Quantity):
                if not entry.fits(mechanism.meshed):
                    continue
                scales = {system: factor(entry.unit, system) for system in SYSTEMS}
                if len({*scales.values()}) > 1:
                    value = {system: value / scale for system, scale in scales.items()}
            found[name] = str(value) if isinstance(value, Fraction) else value
    return found


def print_table(inputs: dict[str, Any], record: dict[str, Any], units: str) -> None:
    """What was simulated, with units in both systems, and what came of it."""
    quantities = {
        name: entry.unit
        for owner in (Inertia, Escapement, Run)
        for name, entry in declared(owner).items()
        if isinstance(entry, Quantity)
    }
    (other,) = (system for system in SYSTEMS if system != units)
    rows: list[tuple[str, Any, str]] = []
    for name, value in inputs.items():
        unit = quantities.get(name, "length" if isinstance(value, dict) else "ratio")
        if isinstance(value, dict):
            also = f"{show(value[other])} {unit_name(unit, other)}"
            rows.append((words(name), value[units], f"{unit_name(unit, units)} = {also}"))
        else:
            rows.append((words(name), value, unit_name(unit, units)))
    rows += [
        (words(key), record[key], unit_name(kind, units))
        for key, kind in FIGURES.items()
        if key in record
    ]
    times, speeds = record["handoff_times"], record["handoff_velocities"]
    rows.append(("handoffs", len(times), ""))
    if len(times):
        rows += [("last handoff", times[-1], "s"), ("velocity there", speeds[-1], "rad s-1")]
    rows += [(words(key), record[key], "") for key in ("energy_residual", "status", "engine")]
    print_values(rows)
