"""An indexing drive at constant driver speed: times, torque, power, forces, impacts, ringing."""

from functools import partial
from typing import TYPE_CHECKING

import escapement as esc
from escapement.base.quantity import Choice, declared
from escapement.base.records import Record
from escapement.base.text import as_csv, words
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.constant_speed.index_case import IndexCase
from escapement.mechanisms import DEFAULT_KIND
from escapement.mechanisms.cam_indexer import LAWS
from escapement.model.inputs import Input, inputs_of_mechanism, inputs_of_settings

if TYPE_CHECKING:
    from escapement.constant_speed import IndexingDrive

_ROWS = 721
_AGAINST = Choice(
    name="against", long_name=f"law of a cam to compare with: {', '.join(LAWS)}",
    allowed=tuple(LAWS), metavar="LAW",
)  # fmt: skip


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser, tables=True)
    _arguments.add_group(parser, "model", declared(IndexCase))
    _arguments.add_setting(parser.add_argument_group("comparison"), _AGAINST)
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "FILE.csv", "write states over the driver angle, in SI")
    _arguments.add_plot(output, "draw motion, torque, force and ringing")


def execute(args: Arguments) -> int:
    """Print the figures; write and draw what was asked for."""
    from escapement.constant_speed.index_record import doubt_of, record_of

    if isinstance(args.slots, tuple):
        if args.against:
            raise UsageError("--against must come with one number of slots; leave it out")
        return _output.tell_several(args, _of_one)
    drive = _drive(args)
    other = esc.cam_drive(drive, args.against) if args.against else None
    plot = lambda plots: plots.plot_index(drive, against=other, units=args.units)  # noqa: E731
    _output.save(args, partial(_table, drive), plot)
    known, record, table = _inputs(drive), record_of(drive), None
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
    from escapement.constant_speed.index_record import doubt_of, record_of

    drive = _drive(args)
    return _output.with_reasons(record_of(drive), doubt_of(drive)), _inputs(drive), 0


def _table(drive: "IndexingDrive") -> str:
    """States of the engagement as CSV."""
    import numpy as np

    entry, exit_ = drive.mechanism.breaks[0], drive.mechanism.breaks[-1]
    state = drive.at(np.linspace(entry, exit_, _ROWS))
    columns = {
        "driver_deg": np.degrees(state.theta), "follower_deg": np.degrees(state.phi),
        "speed_rad_per_s": state.phi_dot, "acceleration_rad_per_s2": state.phi_ddot,
        "torque_N_m": state.torque, "moment_N_m": state.contact_moment,
        "force_N": state.contact_force, "deflection_rad": state.deflection,
    }  # fmt: skip
    kept = {name: column.tolist() for name, column in columns.items() if not np.isnan(column).any()}
    return as_csv([[*kept], *zip(*kept.values(), strict=True)])
