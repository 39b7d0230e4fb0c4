"""Measured positions of input and output against theory, with statistics."""

import math
from pathlib import Path
from typing import Any

import escapement as esc
from escapement.cli import _arguments, _log, _output
from escapement.cli._arguments import Arguments, Parser, UsageError, add_number, one_of
from escapement.text import print_columns, print_values
from escapement.units import SYSTEMS

_TESTS = {
    "chi_squared": "chi-squared",
    "chi_squared_published": "chi-squared as published",
    "anderson_darling": "Anderson-Darling",
}
_KEYS = (
    "samples", "missing", "input_travel_deg", "sense", "phase_deg", "offset_deg",
    "mean_deg", "standard_deviation_deg", "error_min_deg", "error_max_deg",
)  # fmt: skip


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    text = "a column of the input, one of the output"
    parser.add_argument("data", type=Path, metavar="DATA.csv", help=text)
    _arguments.add_mechanism(parser)
    columns = parser.add_argument_group("columns of DATA.csv")
    text = "of the input (default: input, in, driver, theta or phi1)"
    columns.add_argument("--input-column", metavar="NAME", help=text)
    text = "of the output (default: output, out, follower, phi or phi3)"
    columns.add_argument("--output-column", metavar="NAME", help=text)
    unit = one_of("--angle-unit", ("deg", "rad"))
    text = "unit of both (default: as in the columns' names, else deg)"
    columns.add_argument("--angle-unit", type=unit, metavar="deg|rad", help=text)
    zeros = parser.add_argument_group("zeros of the encoders, fitted where not given")
    rule: dict[str, Any] = {"unit": "degrees", "minimum": -math.inf, "remedy": "give an angle"}
    text = "driver angle from dead centre where the input reads zero"
    add_number(zeros, "phase", text, "DEG", **rule)
    text = "reading of the output at follower angle zero"
    add_number(zeros, "offset", text, "DEG", **rule)
    statistics = parser.add_argument_group("statistics")
    text = (
        "classes: a number, or sturges (default), scott, freedman-diaconis, square-root; "
        "the chi-squared test takes no more than leave five errors in each"
    )
    statistics.add_argument("--bins", type=_class_rule, default="sturges", metavar="K", help=text)
    text, remedy = "of the intervals (default: 0.99)", "give a share, as 0.99"
    add_number(statistics, "confidence", text, "P", exclusive=True, remedy=remedy)
    text = "counts a turn of the encoders: adds what they explain"
    rule = {"minimum": 2, "whole": True, "remedy": "give the counts of a turn, as 4096"}
    add_number(statistics, "resolution", text, "N", **rule)
    text = "greatest deviation of the encoders as a share of a turn (default: 0)"
    add_number(statistics, "linearity", text, "SHARE", remedy="give a share, 0.003 for 0.3 %")
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "FILE.csv", "write the error of every sample")
    _arguments.add_plot(output, "draw errors, histogram and periodogram")


def _class_rule(text: str) -> int | str:
    """A number of classes, or the name of a rule, which `measure` checks."""
    return int(text) if text.lstrip("+-").isdecimal() else text


def execute(args: Arguments) -> int:
    """Print the statistics; write and draw what was asked for."""
    _output.check_wanted(args, file="FILE.csv")
    if args.linearity is not None and args.resolution is None:
        raise UsageError(
            f"--linearity must come with --resolution N, got {args.linearity!r} alone; "
            "give the counts of a turn too"
        )
    # both zeros are fitted together, so one of them alone cannot be held
    zeros = args.phase, args.offset
    if zeros.count(None) == 1:
        lacking, given = ("phase", "offset") if args.phase is None else ("offset", "phase")
        raise UsageError(
            f"--{lacking} must be given beside --{given}, got that alone; give both or none"
        )
    options = {
        "encoder": args.resolution and esc.Encoder(args.resolution, args.linearity or 0.0),
        "bins": args.bins,
        "confidence": args.confidence or 0.99,
        "zeros": None if None in zeros else tuple(map(math.radians, zeros)),
    }
    mechanism = _arguments.read_mechanism(args)
    columns = {"input": args.input_column, "output": args.output_column}
    readings = esc.read_readings(args.data, **columns, angle_unit=args.angle_unit)
    result = esc.measure(readings, mechanism, **options)
    if args.output is not None:
        from escapement.measurement import write_errors

        write_errors(result, args.output, force=args.force)
        _log.record("saved", file=str(args.output))
    _output.draw(args.plot, lambda plots: plots.plot_measurement(result))
    record = summarise(result)
    _output.tell(args, record, lambda: _print_tables(record), result.message)
    return 0


def summarise(result: Any) -> dict[str, Any]:
    """What `measure` reports of a `Measurement`, by JSON key; angles in degrees."""
    fit, errors, spectrum = result.fit, result.errors, result.periodogram
    power, sensor = float(spectrum.power[spectrum.peak]), result.sensor_share
    tests = result.chi_squared_test, result.published_test, result.anderson_darling_test
    shaft_keys = "shaft", "order", "amplitude_deg", "standard_error_deg", "p_value", "turns"
    return {
        "samples": errors.size,
        "missing": result.readings.missing,
        "synthetic": result.readings.synthetic,
        "input_travel_deg": math.degrees(result.input.max() - result.input.min()),
        **_read(fit, "sense", "phase_deg", "phase_error_deg", "offset_deg", "offset_error_deg"),
        **_read(result, "mean_deg", "standard_deviation_deg"),
        "error_min_deg": math.degrees(errors.min()),
        "error_max_deg": math.degrees(errors.max()),
        **_read(result, "confidence", "interval_deg", "mean_interval_deg"),
        **_read(result, "autocorrelation", "bins"),
        "bin_edges_deg": [*map(math.degrees, result.histogram.edges)],
        **_read(result.histogram, "observed", "expected"),
        # JSON has null where a test knows no degrees of freedom
        **{
            key: test._asdict() | {"degrees_of_freedom": test.degrees_of_freedom or None}
            for key, test in zip(_TESTS, tests, strict=True)
        },
        "shaft_errors": [_read(error, *shaft_keys) for error in result.shaft_errors],
        "periodogram_peak": {
            "cycles_per_input_turn": float(spectrum.frequency[spectrum.peak]),
            "amplitude_deg": math.degrees(spectrum.amplitude[spectrum.peak]),
            "share_of_variance": power,
            "false_alarm_probability": float(spectrum.false_alarm_probability(power)),
        },
        "sensor": sensor and _read(sensor, *(f"{name}_deg" for name in sensor._fields)),
        "message": result.message,
    }


def _read(owner: Any, *keys: str) -> dict[str, Any]:
    """Attributes of a result, angles in degrees where the key says so."""
    found = {key: getattr(owner, key.removesuffix("_deg")) for key in keys}
    for key in keys:
        if key.endswith("_deg"):
            several = isinstance(found[key], tuple)
            found[key] = [*map(math.degrees, found[key])] if several else math.degrees(found[key])
    return found


def _print_tables(record: dict[str, Any]) -> None:
    """Results of one number each and the intervals, tests of normality, errors that come back."""
    shown = {key: record[key] for key in _KEYS}
    share = f"{100.0 * record['confidence']:g} %"
    for name, key in (("errors", "interval_deg"), ("mean error", "mean_interval_deg")):
        shown[f"{share} of {name}_deg"] = "{:.6g} to {:.6g}".format(*record[key])
    if sensor := record["sensor"]:
        shown |= {f"encoders, {key}": sensor[key] for key in ("standard_deg", "bound_deg")}
    shown |= {key: record[key] for key in ("autocorrelation", "bins")}
    # the chi-squared test may have fewer classes, which then hold five errors each
    classes = record["chi_squared"]["degrees_of_freedom"] + 1
    if classes != record["bins"]:
        shown["bins of chi-squared"] = classes
    print_values(_output.rows(shown, {}, SYSTEMS[0]))
    print("\nnormality")
    rows = [[name, *record[key].values()] for key, name in _TESTS.items()]
    print_columns([["test", "statistic", "degrees of freedom", "p"]], rows)
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
