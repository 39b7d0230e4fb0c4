"""`escapement measure`: measured positions against theory, with statistics."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from escapement import validate
from escapement.cli import _arguments, _output
from escapement.cli._measure_report import print_table, summarise
from escapement.cli._parser import Parser, UsageError, checked, number, one_of, whole

if TYPE_CHECKING:
    from escapement.measurement import Encoder, Measurement

SUMMARY = "Measured positions of input and output against theory, with statistics."


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "data", type=Path, metavar="DATA.csv", help="a column of the input, one of the output"
    )
    _arguments.add_mechanism(parser)
    columns = parser.add_argument_group("columns of DATA.csv")
    columns.add_argument(
        "--input-column",
        metavar="NAME",
        help="of the input (default: input, in, driver, theta or phi1)",
    )
    columns.add_argument(
        "--output-column",
        metavar="NAME",
        help="of the output (default: output, out, follower, phi or phi3)",
    )
    columns.add_argument(
        "--angle-unit",
        type=one_of("--angle-unit", ("deg", "rad")),
        metavar="deg|rad",
        help="unit of both (default: as in the columns' names, else deg)",
    )
    zeros = parser.add_argument_group("zeros of the encoders, fitted where not given")
    for name, text in (
        ("--phase", "driver angle from dead centre where the input reads zero [deg]"),
        ("--offset", "reading of the output at follower angle zero [deg]"),
    ):
        rule = number(name, validate.number, "give an angle in degrees")
        zeros.add_argument(name, type=rule, metavar="DEG", help=text)
    _add_statistics(parser)
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "FILE.csv", "write the error of every sample")
    _arguments.add_plot(output, "draw errors, histogram and periodogram")
    _arguments.add_common(parser)


def _add_statistics(parser: Parser) -> None:
    statistics = parser.add_argument_group("statistics")
    statistics.add_argument(
        "--bins",
        type=checked(lambda text: int(text) if text.lstrip("+-").isdecimal() else text),
        default="sturges",
        metavar="K",
        help="classes: a number, or sturges (default), scott, freedman-diaconis, square-root; "
        "the chi-squared test takes no more than leave five errors in each",
    )
    statistics.add_argument(
        "--confidence",
        type=number("--confidence", validate.positive, "give a share, as 0.99"),
        default=0.99,
        metavar="P",
        help="of the intervals (default: 0.99)",
    )
    statistics.add_argument(
        "--resolution",
        type=whole("--resolution", 2, "give the counts of a turn, as 4096"),
        metavar="N",
        help="counts a turn of the encoders: adds what they explain",
    )
    statistics.add_argument(
        "--linearity",
        type=number("--linearity", validate.non_negative, "give a share, 0.003 for 0.3 %"),
        metavar="SHARE",
        help="greatest deviation of the encoders as a share of a turn (default: 0)",
    )


def execute(args: argparse.Namespace) -> int:
    """Print the statistics; write and draw what was asked for."""
    _output.check_wanted(args, file="FILE.csv")
    encoder, zeros = _read_encoder(args), _read_zeros(args)
    mechanism = _arguments.read_mechanism(args)
    from escapement.measurement import measure, read_readings

    readings = read_readings(
        args.data,
        input=args.input_column,
        output=args.output_column,
        angle_unit=args.angle_unit,
    )
    result = measure(
        readings,
        mechanism,
        bins=args.bins,
        confidence=args.confidence,
        encoder=encoder,
        zeros=zeros,
    )
    _write(result, args)
    record = summarise(result)
    if args.json:
        _output.print_json(record)
    else:
        print_table(record)
    if record["message"]:
        _output.note(record["message"])
    return 0


def _read_encoder(args: argparse.Namespace) -> "Encoder | None":
    if args.resolution is None:
        if args.linearity is not None:
            raise UsageError(
                f"--linearity must come with --resolution N, got {args.linearity!r} alone; "
                "give the counts of a turn too"
            )
        return None
    from escapement.measurement import Encoder

    return Encoder(args.resolution, args.linearity or 0.0)


def _read_zeros(args: argparse.Namespace) -> tuple[float, float] | None:
    import math

    given = {"--phase": args.phase, "--offset": args.offset}
    missing = [name for name, value in given.items() if value is None]
    if len(missing) == 1:
        (other,) = given.keys() - missing
        raise UsageError(
            f"{missing[0]} must be given beside {other}, got that alone; give both or none"
        )
    if missing:
        return None
    from escapement.measurement.readings import FARTHEST, WITHIN

    for name, angle in given.items():
        if abs(math.radians(angle)) > FARTHEST:
            raise validate.fail(name, WITHIN, angle, "give an angle in degrees")
    return math.radians(args.phase), math.radians(args.offset)


def _write(result: "Measurement", args: argparse.Namespace) -> None:
    if args.output is not None:
        from escapement.measurement import write_errors

        write_errors(result, args.output, force=args.force)
    if args.plot is not None:
        from escapement.plots import save
        from escapement.plots.measurement import plot_measurement

        save(plot_measurement(result), args.plot)
