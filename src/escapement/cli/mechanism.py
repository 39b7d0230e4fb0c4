"""`escapement mechanism`: geometry and transmission of a mechanism."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement import _validate
from escapement.cli import _arguments, _files, _output
from escapement.cli._parser import Parser, UsageError, number
from escapement.units import unit_name

if TYPE_CHECKING:
    from escapement.mechanisms import Geneva

SUMMARY = "Geometry, transmission, motion ratio and dwell of a mechanism."


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    inertia = parser.add_argument_group("inertia, for the critical friction")
    _arguments.add_quantity(inertia, "driver_inertia")
    _arguments.add_quantity(inertia, "follower_inertia")
    drawing = parser.add_argument_group("drawing")
    drawing.add_argument(
        "--plot",
        type=Path,
        metavar="FILE",
        help="draw it to scale; .png, .pdf or .svg, replaced where it exists",
    )
    drawing.add_argument(
        "--angle",
        type=number("--angle", _validate.number, "give a driver angle in degrees"),
        metavar="DEG",
        help="driver angle of the drawing from dead centre (default: 0)",
    )
    _arguments.add_common(parser)


def execute(args: argparse.Namespace) -> int:
    """Print the geometry; draw it where asked for."""
    if args.plot is not None:
        _files.check_picture(args.plot)
    elif args.angle is not None:
        raise UsageError("--angle must come with --plot FILE, got none; it turns the drawing")
    mechanism = _arguments.read_mechanism(args)
    record = describe(mechanism)
    inertia = _arguments.read_inertia(args)
    if inertia is not None:
        from escapement.dynamics import critical_friction

        record["critical_friction"] = critical_friction(mechanism, inertia)
    if mechanism.crank_radius is not None:
        distance = mechanism.centre_distance * mechanism.crank_radius
        record["centre_distance"] = _output.in_units(distance, "length", args.units)
    if args.plot is not None:
        _draw(mechanism, args)
    if args.json:
        _output.print_json(record)
    else:
        units = {"centre_distance": unit_name("length", args.units)}
        _output.print_values(
            (_output.words(key), value, units.get(key, "deg" if key.endswith("_deg") else ""))
            for key, value in record.items()
        )
    return 0


def describe(mechanism: "Geneva") -> dict[str, Any]:
    """Geometry of a Geneva wheel, by JSON key."""
    import math

    # twelve decimals: sixty degrees should read as sixty
    cell = round(math.degrees(mechanism.cell_angle), 12)
    return {
        "stations": mechanism.slots,
        "motion_ratio": mechanism.motion_ratio,
        "cell_angle_deg": cell,
        "follower_step_deg": round(math.degrees(mechanism.follower_step), 12),
        "slots": mechanism.slots,
        "pins": mechanism.pins,
        "continuous": mechanism.continuous,
        "dwell_deg": cell * (1.0 - mechanism.motion_ratio),
        "transmission_max": float(mechanism.transmission(0.0).g),
        "centre_distance_over_crank_radius": mechanism.centre_distance,
    }


def _draw(mechanism: "Geneva", args: argparse.Namespace) -> None:
    import math

    from escapement.plots import plot_mechanism

    _files.save_axes(plot_mechanism(mechanism, math.radians(args.angle or 0.0)), args.plot)
