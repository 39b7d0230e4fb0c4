"""Drive torque, power and pin reversals at constant driver speed."""

from typing import TYPE_CHECKING

import escapement as esc
from escapement.base.quantity import declared
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError, option
from escapement.constant_speed import Case
from escapement.model.inputs import inputs_of_mechanism, inputs_of_settings

if TYPE_CHECKING:
    pass

_THICK = ("pin_radius", "roller_radius")


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    _arguments.add_group(parser, "model", declared(Case))
    _arguments.add_plot(parser.add_argument_group("output"), "draw the torque")


def execute(args: Arguments) -> int:
    """Print the figures; draw the torque where asked for."""
    from escapement.constant_speed.drive_record import doubt_of, record_of

    _arguments.require(args, declared(Case))
    for name in _THICK:
        if getattr(args, name):
            remedy = (
                "without friction it changes nothing, and with friction only thin pins are known"
            )
            raise UsageError(f"{option(name)} must be left out at constant speed: {remedy}")
    mechanism = _arguments.read_mechanism(args)
    result = esc.drive_torque(mechanism, **_arguments.typed(args, declared(Case)))
    _output.save(args, plot=lambda plots: plots.plot_drive_torque(result, units=args.units))
    known = [*inputs_of_mechanism(mechanism), *inputs_of_settings(result, mechanism.meshed)]
    _output.tell(args, _output.with_reasons(record_of(result), doubt_of(result)), known)
    return 0
