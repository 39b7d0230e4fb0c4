"""`escapement measure`: measured positions against theory, with statistics."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement import validate
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Parser, UsageError, number, one_of, whole
from escapement.text import print_columns, print_values, words

if TYPE_CHECKING:
    from escapement.measurement import Encoder, Measurement

SUMMARY = "Measured positions of input and output against theory, with statistics."

_TESTS = {
    "chi_squared": "chi-squared",
    "chi_squared_published": "chi-squared as published",
    "anderson_darling": "Anderson-Darling",
}


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "data", type=Path, metavar="DATA.csv", help="a column of the input, one of the output"
    )
    _arguments.add_mechanism(parser)
    columns = parser.add_argument_group("columns of DATA.csv")
    for role, usual in (
        ("input", "input, in, driver, theta or phi1"),
        ("output", "output, out, follower, phi or phi3"),
    ):
        text = f"of the {role} (default: {usual})"
        columns.add_argument(f"--{role}-column", metavar="NAME", help=text)
    unit = one_of("--angle-unit", ("deg", "rad"))
    text = "unit of both (default: as in the columns' names, else deg)"
    columns.add_argument("--angle-unit", type=unit, metavar="deg|rad", help=text)
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
    add = parser.add_argument_group("statistics").add_argument
    share = number("--confidence", validate.positive, "give a share, as 0.99")
    linearity = number("--linearity", validate.non_negative, "give a share, 0.003 for 0.3 %")
    text = (
        "classes: a number, or sturges (default), scott, freedman-diaconis, square-root; "
        "the chi-squared test takes no more than leave five errors in each"
    )
    add("--bins", type=_class_rule, default="sturges", metavar="K", help=text)
    text = "of the intervals (default: 0.99)"
    add("--confidence", type=share, default=0.99, metavar="P", help=text)
    counts = whole("--resolution", 2, "give the counts of a turn, as 4096")
    text = "counts a turn of the encoders: adds what they explain"
    add("--resolution", type=counts, metavar="N", help=text)
    text = "greatest deviation of the encoders as a share of a turn (default: 0)"
    add("--linearity", type=linearity, metavar="SHARE", help=text)


def _class_rule(text: str) -> int | str:
    """A number of classes, or the name of a rule, which `measure` checks."""
    return int(text) if text.lstrip("+-").isdecimal() else text


def execute(args: argparse.Namespace) -> int:
    """Print the statistics; write and draw what was asked for."""
    _output.check_wanted(args, file="FILE.csv")
    encoder, zeros = _read_encoder(args), _read_zeros(args)
    mechanism = _arguments.read_mechanism(args)
    from escapement.measurement import measure, read_readings, write_errors

    columns = {"input": args.input_column, "output": args.output_column}
    readings = read_readings(args.data, **columns, angle_unit=args.angle_unit)
    options = {"bins": args.bins, "confidence": args.confidence, "zeros": zeros}
    result = measure(readings, mechanism, encoder=encoder, **options)
    if args.output is not None:
        write_errors(result, args.output, force=args.force)
    if args.plot is not None:
        from escapement import plots

        plots.save(plots.plot_measurement(result), args.plot)
    record = summarise(result)
    if args.json:
        _output.print_json(record)
    else:
        _print_table(record)
        _print_tests(record)
        _print_waves(record)
    if record["message"]:
        _output.note(record["message"])
    return 0


def _read_encoder(args: argparse.Namespace) -> "Encoder | None":
    from escapement.measurement import Encoder

    if args.resolution is not None:
        return Encoder(args.resolution, args.linearity or 0.0)
    if args.linearity is not None:
        raise UsageError(
            f"--linearity must come with --resolution N, got {args.linearity!r} alone; "
            "give the counts of a turn too"
        )
    return None


def _read_zeros(args: argparse.Namespace) -> tuple[float, float] | None:
    if args.phase is None and args.offset is None:
        return None
    if args.phase is None or args.offset is None:
        missing, given = ("phase", "offset") if args.phase is None else ("offset", "phase")
        raise UsageError(
            f"--{missing} must be given beside --{given}, got that alone; give both or none"
        )
    return math.radians(args.phase), math.radians(args.offset)


def summarise(result: "Measurement") -> dict[str, Any]:
    """What `measure` reports, by JSON key; angles in degrees."""
    fit, errors, spectrum = result.fit, result.errors, result.periodogram
    power, sensor = float(spectrum.power[spectrum.peak]), result.sensor_share
    tests = result.chi_squared_test, result.published_test, result.anderson_darling_test
    return {
        "samples": errors.size,
        "missing": result.readings.missing,
        "synthetic": result.readings.synthetic,
        "input_travel_deg": math.degrees(result.input.max() - result.input.min()),
        "sense": fit.sense,
        **_degrees(fit, "phase", "phase_error", "offset", "offset_error"),
        **_degrees(result, "mean", "standard_deviation"),
        "error_min_deg": math.degrees(errors.min()),
        "error_max_deg": math.degrees(errors.max()),
        "confidence": result.confidence,
        **_degrees(result, "interval", "mean_interval"),
        "autocorrelation": result.autocorrelation,
        "bins": result.bins,
        "bin_edges_deg": [*map(math.degrees, result.histogram.edges)],
        "observed": result.histogram.observed,
        "expected": result.histogram.expected,
        # JSON has null where a test knows no degrees of freedom
        **{
            key: test._asdict() | {"degrees_of_freedom": test.degrees_of_freedom or None}
            for key, test in zip(_TESTS, tests, strict=True)
        },
        "shaft_errors": [
            {
                "shaft": error.shaft,
                "order": error.order,
                **_degrees(error, "amplitude", "standard_error"),
                "p_value": error.p_value,
                "turns": error.turns,
            }
            for error in result.shaft_errors
        ],
        "periodogram_peak": {
            "cycles_per_input_turn": float(spectrum.frequency[spectrum.peak]),
            "amplitude_deg": math.degrees(spectrum.amplitude[spectrum.peak]),
            "share_of_variance": power,
            "false_alarm_probability": float(spectrum.false_alarm_probability(power)),
        },
        "sensor": sensor and _degrees(sensor, *sensor._fields),
        "message": result.message,
    }


def _degrees(owner: Any, *names: str) -> dict[str, Any]:
    """Angles of a result in degrees, each under a key that says so."""
    angles = {f"{name}_deg": getattr(owner, name) for name in names}
    return {
        key: [*map(math.degrees, x)] if isinstance(x, tuple) else math.degrees(x)
        for key, x in angles.items()
    }


def _print_table(record: dict[str, Any]) -> None:
    """Results of one number each, and the intervals."""
    keys = (
        "samples", "missing", "input_travel_deg", "sense", "phase_deg", "offset_deg",
        "mean_deg", "standard_deviation_deg", "error_min_deg", "error_max_deg",
    )  # fmt: skip
    rows = [(words(key), record[key], "deg" if key.endswith("_deg") else "") for key in keys]
    for name, key in (("errors", "interval_deg"), ("mean error", "mean_interval_deg")):
        low, high = record[key]
        share = f"{100.0 * record['confidence']:g} % of {name}"
        rows.append((share, f"{low:.6g} to {high:.6g}", "deg"))
    if sensor := record["sensor"]:
        rows += [(f"encoders, {key}", sensor[f"{key}_deg"], "deg") for key in ("standard", "bound")]
    rows += [(key, record[key], "") for key in ("autocorrelation", "bins")]
    # the chi-squared test may have fewer classes, which then hold five errors each
    classes = record["chi_squared"]["degrees_of_freedom"] + 1
    if classes != record["bins"]:
        rows.append(("bins of chi-squared", classes, ""))
    print_values(rows)


def _print_tests(record: dict[str, Any]) -> None:
    print("\nnormality")
    rows = [[name, *record[key].values()] for key, name in _TESTS.items()]
    print_columns([["test", "statistic", "degrees of freedom", "p"]], rows)


def _print_waves(record: dict[str, Any]) -> None:
    print("\nerrors that come back")
    rows = []
    for error in record["shaft_errors"]:
        shaft, often = error["shaft"], "once" if error["order"] == 1 else "twice"
        name = f"{often} a cell" if shaft == "cell" else f"{often} a turn, {shaft}"
        rows.append([name, error["amplitude_deg"], error["standard_error_deg"], error["p_value"]])
    peak = record["periodogram_peak"]
    name = f"periodogram's peak, {peak['cycles_per_input_turn']:.4g} a turn of the input"
    rows.append([name, peak["amplitude_deg"], None, peak["false_alarm_probability"]])
    print_columns([["", "amplitude/deg", "+-", "p"]], rows)
