"""Command `measure`: compare readings of encoders, motions and beats with theory."""

import math
from functools import partial
from pathlib import Path
from typing import Any

import escapement as esc
from escapement.base import headings
from escapement.base.errors import InvalidValue
from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.units import SYSTEMS
from escapement.cli import _arguments, _output, measure_beats
from escapement.cli._arguments import Arguments, Parser, UsageError, add_choice, add_number
from escapement.mechanisms import DEFAULT_KIND, kind_of
from escapement.mechanisms.wheel_checks import LENGTHS
from escapement.model.escapement import model_settings
from escapement.model.inputs import inputs_of, inputs_of_mechanism

_COLUMNS = {
    "--input-column": "of the input (default: input, in, driver, theta or phi1)",
    "--output-column": "of the output (default: output, out, follower, phi or phi3)",
    "--time-column": "of the times, which --fit needs (default: time, t or timestamp)",
}
_TESTS = {
    "chi_squared_published": "chi-squared as published",
    "anderson_darling": "Anderson-Darling",
}
_HIDDEN = dict.fromkeys(
    ("verdict", "good", "confidence", "bin_edges_deg", "observed", "expected", "fitted", "message",
     *_TESTS), Result(tabled=False),
)  # fmt: skip
"""What has no line of its own in the tables."""
_MOTION = {"release_time": Result("time")} | dict.fromkeys(
    ("speed_max", "speed_max_computed", "speed_deviation"), Result("speed")
)


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    text = (
        "a file with a column of the input's angles and one of the output's, or a recording of "
        "beats, .wav"
    )
    parser.add_argument("data", type=Path, metavar="DATA", help=text)
    _arguments.add_mechanism(parser)
    columns = parser.add_argument_group("columns of DATA")
    for name, text in _COLUMNS.items():
        columns.add_argument(name, metavar="NAME", help=text)
    text = "unit of the times (default: as in the column's name, else s)"
    add_choice(columns, "time_unit", text, tuple(headings.TIMES))
    text = (
        "unit of both angles; counts need --resolution (default: as in the columns' names, else "
        "deg)"
    )
    add_choice(columns, "angle_unit", text, (*headings.UNITS, headings.COUNTS))
    text, remedy = "how many lines to skip at the beginning of the file", "give how many lines"
    add_number(columns, "skip_rows", text, "N", minimum=0, whole=True, remedy=remedy)
    zeros = parser.add_argument_group("zeros of the encoders, which are fitted unless given")
    rule: dict[str, Any] = {"unit": "degrees", "minimum": -math.inf, "remedy": "give an angle"}
    text = "driver angle from dead centre at which the input reads zero"
    add_number(zeros, "phase", text, "DEG", needs="offset", **rule)
    text = "reading of the output at which the follower angle is zero"
    add_number(zeros, "offset", text, "DEG", needs="phase", **rule)
    statistics = parser.add_argument_group("statistics")
    text = "classes: a number, or sturges (default), scott, freedman-diaconis, square-root"
    statistics.add_argument("--bins", type=_class_rule, default="sturges", metavar="K", help=text)
    text, remedy = "level of the intervals (default: 0.99)", "give a share, as 0.99"
    add_number(statistics, "confidence", text, "P", exclusive=True, remedy=remedy)
    text = (
        "counts of the encoders in a turn, or of input and output, as 6400,4096; with it the "
        "errors that they cause are printed"
    )
    remedy = "give the counts in a turn, as 4096, or those of input and output, as 6400,4096"
    rule = {"metavar": "N[,N]", "minimum": 2, "whole": True, "remedy": remedy}
    _arguments.add_setting(
        statistics, _arguments.Several(name="resolution", long_name=text, **rule)
    )
    text = "greatest deviation of the encoders as a share of a turn (default: 0)"
    remedy = "give a share, 0.003 for 0.3 %"
    add_number(statistics, "linearity", text, "SHARE", remedy=remedy, needs="resolution")
    motion = parser.add_argument_group("motion from rest at pin entry; it needs a column of times")
    text = (
        "compare speeds with the motion of the model below, and fit these numbers of the model, "
        "as friction,torque; 'none' compares only; of beats also pins, slots or both, whose "
        "errors are found"
    )
    motion.add_argument("--fit", metavar="NAME,...", help=text)
    _arguments.add_group(parser, "model", model_settings())
    measure_beats.add_options(parser)
    output = parser.add_argument_group("output")
    text = "write the error of every sample, or the instant of every beat"
    _arguments.add_output(output, "FILE.csv", text, also="--save-beats")
    _arguments.add_plot(output, "draw errors, histogram and periodogram, or beats")


def _class_rule(text: str) -> int | str:
    """A number of classes, or the name of a rule, which `measure` checks."""
    return int(text) if text.lstrip("+-").isdecimal() else text


def execute(args: Arguments) -> int:
    """Print the statistics; write the files and draw the figures that were asked for."""
    if measure_beats.concern(args):
        return measure_beats.execute(args)
    # both zeros are fitted together, so one of them alone cannot be held
    zeros = args.phase, args.offset
    counts = args.resolution if isinstance(args.resolution, tuple) else (args.resolution,) * 2
    options = {
        "encoder": args.resolution
        and tuple(esc.Encoder(count, args.linearity or 0.0) for count in counts),
        "bins": args.bins,
        "confidence": args.confidence or 0.99,
        "zeros": None if None in zeros else tuple(map(math.radians, zeros)),
    }
    kind = kind_of(args.kind or DEFAULT_KIND)
    if kind.pitch is not None and args.fit is None:
        raise UsageError(
            f"angles of a {kind.kind} mechanism must come with --fit, since they depend on its "
            "motion; add --fit friction,torque"
        )
    # the sizes of a wheel change no angles
    sizes = (*LENGTHS, "fixed_radius")
    others = kind.other_sizes().items()
    idle = *sizes, *(name for name, size in others if size.of in sizes), "time_column", "time_unit"
    escapement = measure_beats.read_model(args, idle, "friction,torque")
    mechanism = escapement.mechanism if escapement else _arguments.read_mechanism(args)
    readings = _read(args)
    from escapement.measurement import write_errors
    from escapement.measurement.measurement_record import record_of

    result: Any = None
    fit = None
    if escapement is None or (readings.samples and mechanism.pitch is None):
        result = esc.measure(readings, mechanism, **options)
    elif args.output is not None:
        raise UsageError(
            "--output must come with a column of the output, got none; leave --output out"
        )
    if escapement is not None:
        names = [] if args.fit == "none" else [name.strip() for name in args.fit.split(",")]
        shares = {} if args.confidence is None else {"confidence": args.confidence}
        try:
            fit = esc.fit_motion(readings, escapement, names, **shares)
        except InvalidValue as error:
            raise UsageError(f"--fit: {error}") from None
    _output.save(
        args,
        lambda: partial(write_errors, result, args.output, force=args.force),
        lambda plots: plots.plot_measurement(result) if result else plots.plot_speeds(fit),
    )
    record = record_of(result, fit, args.units)
    known = inputs_of(escapement) if escapement else inputs_of_mechanism(mechanism)
    _output.tell(args, record, known, lambda: _print(record))
    return 0


def _read(args: Arguments) -> "esc.Readings":
    """The readings, with times if a motion is compared."""
    if args.angle_unit == headings.COUNTS and args.resolution is None:
        raise UsageError(
            "--angle-unit counts must come with --resolution N, got none; give the counts in a turn"
        )
    return esc.read_readings(
        args.data,
        input=args.input_column,
        output=args.output_column,
        time=None if args.fit is None else args.time_column or "time",
        angle_unit=args.angle_unit,
        resolution=args.resolution,
        skip_rows=args.skip_rows or 0,
        time_unit=args.time_unit,
    )


def _print(record: dict[str, Any]) -> None:
    """Print the verdict, and tables of both comparisons."""
    print(record["verdict"])
    if "samples" in record:
        share = f"{100.0 * record['confidence']:g} %"
        intervals = {
            "interval_deg": Result("degrees", label=f"{share} of errors"),
            "mean_interval_deg": Result("degrees", label=f"{share} of mean error"),
        }
        tests = {name: record[key] for key, name in _TESTS.items()}
        found = Record(record | {"normality": tests}, _HIDDEN | intervals)
        print()
        found.without("motion", *["sensor"] * (record["sensor"] is None)).show(SYSTEMS[0])
    if motion := record.get("motion"):
        interval = Result(label=f"{100.0 * motion['confidence']:g} % interval")
        print("\nmotion")
        results = _HIDDEN | _MOTION | {"interval": interval}
        Record(motion | {"fitted numbers": motion["fitted"]}, results).show(SYSTEMS[0])
