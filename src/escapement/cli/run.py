"""Command `run`: one motion from pin entry, and its figures of merit."""

import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.files import FILMS, FORMATS, MOTIONS
from escapement.base.quantity import Setting, declared, quantities
from escapement.base.status import MESSAGES, Status
from escapement.base.text import print_values
from escapement.cli import SOME_FAILED, _arguments, _log, _output
from escapement.cli._arguments import ArgumentGroup, Arguments, Parser, UsageError, option
from escapement.cli.sweep import load_case
from escapement.engines.solver import Solver
from escapement.model.escapement import Escapement, Run, model_settings
from escapement.model.inputs import inputs_of

if TYPE_CHECKING:
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
    _arguments.add_mechanism(parser)
    length = {name: entry for name, entry in declared(Run).items() if name not in _START}
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
    _arguments.add_output(output, "FILE.h5", text)
    _arguments.add_plot(output, "draw the velocities", "or film the motion")
    _arguments.add_report(output)


def model() -> dict[str, Setting]:
    """The settings of an escapement and its motion, without the mechanism."""
    every = model_settings() | _START
    return dict(sorted(every.items(), key=lambda item: not item[1].required))


def execute(args: Arguments) -> int:
    """Simulate and print the figures; write the files that were asked for."""
    _output.check_wanted(args, "FILE.h5", MOTIONS, FORMATS + FILMS)
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
    _balance(motion)
    for save in _files(motion, args, settings["initial_speed"]):
        save()
    length = "engagements" if args.duration is None else "duration"
    taken = args.duration or args.engagements or quantities(Run)["engagements"].default
    inputs = [*inputs_of(escapement), ("initial_speed", settings["initial_speed"], "speed")]
    inputs += [(length, taken, quantities(Run)[length].unit), ("rtol", motion.rtol, "ratio")]
    record = _summarise(motion, figures, args.units)
    if jammed is not None:
        record |= _by_rule(jammed)
        record["message"] += f"; by the rule for jams: {jammed.message}"
    _output.tell(
        args,
        record,
        lambda: _print_table(record, args.units),
        record["message"] if record["message"] != MESSAGES[Status.OK] else "",
        inputs,
    )
    failed = motion.status.failed or figures.status.failed
    return SOME_FAILED if failed and jammed is None else 0


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


def _files(motion: "esc.Motion", args: Arguments, speed: float) -> list[_output.Save]:
    """What was asked for, ready to be saved."""
    report = _output.reported(args, motion.escapement, speed=speed)
    if motion.end_time == 0.0:
        wanted = [str(path) for path in (args.output, args.plot) if path is not None]
        if wanted:
            _output.note(f"there is no motion to write, so no {' and no '.join(wanted)} was made")
        return [report]
    picture = _output.drawn_motion(args.plot, motion, lambda plots: plots.plot_velocities(motion))
    return [partial(_save_motion, motion, args), picture, report]


def _save_motion(motion: "esc.Motion", args: Arguments) -> None:
    if args.output is not None:
        from escapement.base.progress import Progress

        shown: dict[str, Any] = {"what": "engagements", "log": _log.progress}
        with Progress(quiet=motion.handoff_times.size < _LONG, **shown) as progress:
            options = {"units": args.units, "force": args.force, "progress": progress}
            esc.write_motion(motion, args.output, **options)
        _log.record("saved", file=str(args.output))


def _summarise(motion: "esc.Motion", figures: "esc.Figures", units: str) -> dict[str, Any]:
    """What `run` reports, by JSON key, in the user's units."""
    from escapement.dynamics.figure_table import FIGURES

    found = {
        name: _output.in_units(getattr(figures, name), figure.kind, units)
        for name, figure in FIGURES.items()
    }
    if motion.escapement.mechanism.crank_radius is None:
        del found["contact_force_max"]
    if len(figures.beats) > 1:
        found["beats"] = figures.beats
    else:
        del found["beat_error"]
        if not motion.escapement.contact:
            del found["blow_max"]
    outcome = motion if motion.status is not Status.OK else figures
    meshed = motion.escapement.mechanism.path.table
    may_lack = {"critical_friction"} if meshed else set()
    may_lack |= {"last_reversal_angle"} if figures.motion is not None else set()
    reasons = _output.not_given({name: found[name] for name in FIGURES if name in may_lack})
    if not reasons or outcome.message != MESSAGES[Status.OK]:
        reasons.insert(0, outcome.message)
    if motion.status is Status.SPENT:
        reasons.insert(1, figures.message)
    return found | {
        "handoff_times": motion.handoff_times,
        "handoff_velocities": motion.handoff_velocities,
        "energy_residual": motion.ledger.residual,
        "status": outcome.status.label,
        "message": "; ".join(reasons),
        "engine": motion.engine,
    }


def _by_rule(cycle: "JamCycle") -> dict[str, Any]:
    """Results of the rule for jams, by JSON key."""
    return {
        "jam_rule_period": cycle.period,
        "jam_rule_handoff_velocity": cycle.handoff_velocity,
        "jam_rule_velocity_max": cycle.velocity_max,
        "jam_rule_angles_deg": [math.degrees(angle) for angle in cycle.jam_angles],
        "jam_rule_error": cycle.error,
    }


def _balance(motion: "esc.Motion") -> None:
    """Compute the energy balance; long motions show their progress."""
    from escapement.base.progress import Progress

    shown: dict[str, Any] = {"what": "engagements balanced", "log": _log.progress}
    with Progress(quiet=motion.handoff_times.size < _LONG, **shown) as progress:
        motion.balance(progress)


def _print_table(record: dict[str, Any], units: str) -> None:
    """The results."""
    from escapement.dynamics.figure_table import FIGURES

    times, speeds = record["handoff_times"], record["handoff_velocities"]
    found = record | {"handoffs": len(times)}
    if len(times):
        found |= {"last_handoff": times[-1], "last_handoff_velocity": speeds[-1]}
    kinds = {name: figure.kind for name, figure in FIGURES.items()}
    kinds |= {"handoffs": "ratio", "last_handoff": "time", "last_handoff_velocity": "speed"}
    kinds |= {"jam_rule_period": "time", "jam_rule_handoff_velocity": "speed"}
    kinds |= {"jam_rule_velocity_max": "speed", "jam_rule_angles_deg": "degrees"}
    kinds |= {"jam_rule_error": "ratio"}
    if found["uniqueness_friction"] == found["critical_friction"]:
        del found["uniqueness_friction"]
    order = [key for key in (*kinds, "status", "engine") if key in found]
    print_values(_output.rows({key: found[key] for key in order}, kinds, units))
