"""An indexing drive at constant driver speed: times, torque, power, forces, impacts, ringing."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Choice, Setting, declared
from escapement.base.records import Record
from escapement.base.spoken import as_spoken
from escapement.base.text import as_csv, words
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.constant_speed.index_case import IndexCase
from escapement.constant_speed.index_record import INDEX, doubt_of, record_of
from escapement.dynamics.figure_table import FIGURES, OF_MOTOR
from escapement.mechanisms import DEFAULT_KIND
from escapement.mechanisms.cam_indexer import LAWS
from escapement.model.escapement import Inertia
from escapement.model.inputs import Input, inputs_of_mechanism, inputs_of_settings
from escapement.model.motor import MOTOR
from escapement.model.train import train_numbers, trains_of

if TYPE_CHECKING:
    from escapement.constant_speed import IndexingDrive

_ROWS, _STARTS = 721, 4
_INERTIA = replace(declared(Inertia)["driver_inertia"], required=False, needs="motor")
_GEARBOX = {
    name: replace(entry, needs="motor", long_name=entry.long_name.replace("barrel", "gearbox"))
    for name, entry in train_numbers().items() if entry.section == "barrel"
}  # fmt: skip
_MOTOR: dict[str, Setting] = {"motor": MOTOR, "driver_inertia": _INERTIA, **_GEARBOX}
_OF_MOTOR = {
    "velocity_mean": FIGURES["velocity_mean"]._replace(label="mean speed with the motor"),
    **{name: FIGURES[name] for name in OF_MOTOR},
}
_AGAINST = Choice(
    name="against", long_name=f"law of a cam to compare with: {', '.join(LAWS)}",
    allowed=tuple(LAWS), metavar="LAW",
)  # fmt: skip


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser, tables=True)
    _arguments.add_group(parser, "model", declared(IndexCase))
    _arguments.add_group(parser, "motor", _MOTOR)
    _arguments.add_setting(parser.add_argument_group("comparison"), _AGAINST)
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "FILE.csv", "write states over the driver angle, in SI")
    _arguments.add_plot(output, "draw motion, torque, force and ringing")
    _arguments.tell_results(parser, INDEX)


def execute(args: Arguments) -> int:
    """Print the figures; write and draw what was asked for."""
    if isinstance(args.slots, tuple):
        if args.against or args.motor is not None:
            name = "against" if args.against else "motor"
            raise UsageError(f"--{name} must come with one number of slots; leave it out")
        return _output.tell_several(args, _of_one)
    drive = _drive(args)
    motored, started, inputs = _with_motor(args, drive)
    other = esc.cam_drive(drive, args.against) if args.against else None
    more = {"against": other, "motor": started, "units": args.units}
    _output.save(args, partial(_table, drive), lambda plots: plots.plot_index(drive, **more))
    known, record, table = [*_inputs(drive), *inputs], record_of(drive) | motored, None
    doubt = doubt_of(drive)
    if other is not None:
        beside = record_of(other)
        heads = words(args.kind or DEFAULT_KIND), words(args.against)
        table = partial(_output.side_by_side, args, (record, beside), heads)
        record = record | Record({"against": {"law": args.against, **beside.values}})
        if drive.friction:
            doubt = "the cam has no friction: give the efficiency of its drive"
    _output.tell(args, _output.with_reasons(record, doubt), known, table)
    return 0


def _with_motor(
    args: Arguments, drive: "IndexingDrive"
) -> "tuple[Record, esc.Motion | None, list[Input]]":
    """Figures of the drive with the motor that was given, its start, and its numbers; none without
    one.

    Raises
    ------
    InvalidValue
        When the motor does not carry the load.
    """
    given = _arguments.typed_by_name(args, _MOTOR)
    if (motor := given.pop("motor", None)) is None:
        return Record({}), None, []
    args.motor = None  # its numbers are told instead
    if (inertia := given.pop("driver_inertia", None)) is None:
        raise InvalidValue(
            "--driver-inertia must come with --motor, got none; give that of the crank"
        )
    train = trains_of(given).get("barrel")
    escapement = drive.driven_by(motor, driver_inertia=inertia, gearbox=train)
    figures = esc.terminal(escapement)
    if figures.status.failed:
        torque, speed = (
            as_spoken(motor.stall_torque, "torque"),
            as_spoken(motor.no_load_speed, "speed"),
        )
        raise InvalidValue(
            f"--motor must carry the load and all losses, got {torque} at rest and {speed} without "
            f"a load; {figures.message}"
        )
    found = Record({name: getattr(figures, name) for name in _OF_MOTOR}, _OF_MOTOR)
    inputs = ("motor_stall_torque", motor.stall_torque, "torque"), (
        "motor_no_load_speed", motor.no_load_speed, "speed"
    )  # fmt: skip
    return found, esc.simulate(escapement, _STARTS), [*inputs]


def _drive(args: Arguments) -> "IndexingDrive":
    """The drive that the arguments describe."""
    _arguments.require(args, declared(IndexCase))
    mechanism = _arguments.read_mechanism(args)
    return esc.index(mechanism, **_arguments.typed(args, declared(IndexCase)))


def _inputs(drive: "IndexingDrive") -> list[Input]:
    mechanism = drive.mechanism
    return [*inputs_of_mechanism(mechanism), *inputs_of_settings(drive, mechanism.meshed)]


def _of_one(args: Arguments) -> _output.Found:
    """What is told of a drive in a table of several."""
    drive = _drive(args)
    return _output.with_reasons(record_of(drive), doubt_of(drive)), _inputs(drive), 0


def _table(drive: "IndexingDrive") -> str:
    """States of the engagement, or of all in a turn of the follower, as CSV."""
    import numpy as np

    wheel = drive.mechanism
    angles = np.linspace(wheel.breaks[0], wheel.breaks[-1], _ROWS)
    begins = wheel.cell_angle * np.arange(drive.indexes)
    state = drive.at((begins[:, None] + angles).reshape(-1))
    columns = {
        "driver_deg": np.degrees(state.theta), "follower_deg": np.degrees(state.phi),
        "speed_rad_per_s": state.phi_dot, "acceleration_rad_per_s2": state.phi_ddot,
        "torque_N_m": state.torque, "moment_N_m": state.contact_moment,
        "force_N": state.contact_force, "deflection_rad": state.deflection,
    }  # fmt: skip
    kept = {name: column.tolist() for name, column in columns.items() if not np.isnan(column).any()}
    return as_csv([[*kept], *zip(*kept.values(), strict=True)])
