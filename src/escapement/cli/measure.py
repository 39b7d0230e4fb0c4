"""`escapement measure`: measured positions against theory, with statistics."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement import validate
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Parser, UsageError, checked, number, one_of, whole
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

    columns = {"input": args.input_column, "output": args.output_column}
    readings = read_readings(args.data, **columns, angle_unit=args.angle_unit)
    options = {"bins": args.bins, "confidence": args.confidence, "zeros": zeros}
    result = measure(readings, mechanism, encoder=encoder, **options)
    _write(result, args)
    record = summarise(result)
    if args.json:
        _output.print_json(record)
    else:
        _print_table(record)
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
    given = {"--phase": args.phase, "--offset": args.offset}
    missing = [name for name, value in given.items() if value is None]
    if len(missing) == 1:
        (other,) = given.keys() - missing
        raise UsageError(
            f"{missing[0]} must be given beside {other}, got that alone; give both or none"
        )
    if missing:
        return None
    return math.radians(args.phase), math.radians(args.offset)


def _write(result: "Measurement", args: argparse.Namespace) -> None:
    if args.output is not None:
        from escapement.measurement import write_errors

        write_errors(result, args.output, force=args.force)
    if args.plot is not None:
        from escapement.plots import save
        from escapement.plots.measurement import plot_measurement

        save(plot_measurement(result), args.plot)


def summarise(result: "Measurement") -> dict[str, Any]:
    """What `measure` reports, by JSON key; angles in degrees."""
    fit, spectrum, peak = result.fit, result.periodogram, result.periodogram.peak
    errors, power = result.errors, float(result.periodogram.power[result.periodogram.peak])
    tests = result.chi_squared_test, result.published_test, result.anderson_darling_test
    return _in_degrees({
        "samples": errors.size,
        "missing": result.readings.missing,
        "synthetic": result.readings.synthetic,
        "input_travel_deg": float(result.input.max() - result.input.min()),
        "sense": fit.sense,
        "phase_deg": fit.phase,
        "phase_error_deg": fit.phase_error,
        "offset_deg": fit.offset,
        "offset_error_deg": fit.offset_error,
        "mean_deg": result.mean,
        "standard_deviation_deg": result.standard_deviation,
        "error_min_deg": float(errors.min()),
        "error_max_deg": float(errors.max()),
        "confidence": result.confidence,
        "interval_deg": result.interval,
        "mean_interval_deg": result.mean_interval,
        "autocorrelation": result.autocorrelation,
        "bins": result.bins,
        "bin_edges_deg": result.histogram.edges.tolist(),
        "observed": result.histogram.observed,
        "expected": result.histogram.expected,
        **{
            key: {
                "statistic": float(test.statistic),
                "degrees_of_freedom": test.degrees_of_freedom or None,
                "p_value": float(test.p_value),
            }
            for key, test in zip(_TESTS, tests, strict=True)
        },
        "shaft_errors": [
            _in_degrees({
                "shaft": error.shaft,
                "order": error.order,
                "amplitude_deg": error.amplitude,
                "standard_error_deg": error.standard_error,
                "p_value": error.p_value,
                "turns": error.turns,
            })
            for error in result.shaft_errors
        ],
        "periodogram_peak": _in_degrees({
            "cycles_per_input_turn": float(spectrum.frequency[peak]),
            "amplitude_deg": float(spectrum.amplitude[peak]),
            "share_of_variance": power,
            "false_alarm_probability": float(spectrum.false_alarm_probability(power)),
        }),
        "sensor": result.sensor_share
        and _in_degrees({f"{key}_deg": x for key, x in result.sensor_share._asdict().items()}),
        "message": result.message,
    })  # fmt: skip


def _in_degrees(record: dict[str, Any]) -> dict[str, Any]:
    """A record whose keys that end in _deg hold degrees in place of radians."""

    def converted(value: Any) -> Any:
        return [*map(converted, value)] if isinstance(value, list | tuple) else math.degrees(value)

    return {
        key: converted(value) if key.endswith("_deg") else value for key, value in record.items()
    }


def _print_table(record: dict[str, Any]) -> None:
    plain = ("samples", "missing", "input_travel_deg", "sense", "phase_deg", "offset_deg")
    errors = ("mean_deg", "standard_deviation_deg", "error_min_deg", "error_max_deg")
    rows = [
        (words(key), record[key], "deg" if key.endswith("_deg") else "")
        for key in (*plain, *errors)
    ]
    share = f"{100.0 * record['confidence']:g} %"
    for name, key in (("errors", "interval_deg"), ("mean error", "mean_interval_deg")):
        low, high = record[key]
        rows.append((f"{share} of {name}", f"{low:.6g} to {high:.6g}", "deg"))
    if record["sensor"] is not None:
        rows += [
            (f"encoders, {name}", record["sensor"][f"{name}_deg"], "deg")
            for name in ("standard", "bound")
        ]
    rows.append(("autocorrelation", record["autocorrelation"], ""))
    rows.append(("bins", record["bins"], ""))
    classes = record["chi_squared"]["degrees_of_freedom"] + 1
    if classes != record["bins"]:
        rows.append(("bins of chi-squared", classes, ""))
    print_values(rows)
    _print_tests(record)
    _print_shafts(record)


def _print_tests(record: dict[str, Any]) -> None:
    print("\nnormality")
    rows = [
        [name, test["statistic"], test["degrees_of_freedom"], test["p_value"]]
        for name, test in ((name, record[key]) for key, name in _TESTS.items())
    ]
    print_columns([["test", "statistic", "degrees of freedom", "p"]], rows)


def _print_shafts(record: dict[str, Any]) -> None:
    print("\nerrors that come back")
    rows = [
        [_recurrence(error), error["amplitude_deg"], error["standard_error_deg"], error["p_value"]]
        for error in record["shaft_errors"]
    ]
    peak = record["periodogram_peak"]
    name = f"periodogram's peak, {peak['cycles_per_input_turn']:.4g} a turn of the input"
    rows.append([name, peak["amplitude_deg"], None, peak["false_alarm_probability"]])
    print_columns([["", "amplitude/deg", "+-", "p"]], rows)


def _recurrence(error: dict[str, Any]) -> str:
    often = "once" if error["order"] == 1 else "twice"
    return f"{often} a cell" if error["shaft"] == "cell" else f"{often} a turn, {error['shaft']}"
