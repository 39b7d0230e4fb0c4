"""Command `measure`: compare encoder readings with theory, and a measured motion with a model."""

import math
from pathlib import Path
from typing import Any

import escapement as esc
from escapement.base import headings, validate
from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.quantity import Quantity
from escapement.base.text import print_columns, print_values, words
from escapement.base.units import SYSTEMS, printed
from escapement.cli import _arguments, _log, _output
from escapement.cli._arguments import (
    Arguments,
    Parser,
    UsageError,
    add_number,
    one_of,
    option,
)
from escapement.mechanisms import DEFAULT_KIND, kind_of
from escapement.mechanisms.wheel_checks import LENGTHS
from escapement.model.escapement import model_settings
from escapement.model.inputs import inputs_of, inputs_of_mechanism

np = Lazy("numpy")
_TESTS = {
    "chi_squared": "chi-squared",
    "chi_squared_published": "chi-squared as published",
    "anderson_darling": "Anderson-Darling",
}
_KEYS = (
    "samples", "missing", "input_travel_deg", "sense", "phase_deg", "offset_deg",
    "mean_deg", "standard_deviation_deg", "error_min_deg", "error_max_deg",
)  # fmt: skip


_MOTION_KEYS = {
    "samples": "ratio", "release_time": "time", "noise_deg": "degrees",
    "autocorrelation": "ratio", "p_value": "ratio", "speed_max": "speed",
    "speed_max_computed": "speed", "speed_deviation": "speed",
}  # fmt: skip


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    text = "a file with a column of the input's angles and one of the output's"
    parser.add_argument("data", type=Path, metavar="DATA.csv", help=text)
    _arguments.add_mechanism(parser)
    columns = parser.add_argument_group("columns of DATA.csv")
    text = "of the input (default: input, in, driver, theta or phi1)"
    columns.add_argument("--input-column", metavar="NAME", help=text)
    text = "of the output (default: output, out, follower, phi or phi3)"
    columns.add_argument("--output-column", metavar="NAME", help=text)
    text = "of the times, which --fit needs (default: time, t or timestamp)"
    columns.add_argument("--time-column", metavar="NAME", help=text)
    unit = one_of("--time-unit", tuple(headings.TIMES))
    text = "unit of the times (default: as in the column's name, else s)"
    columns.add_argument("--time-unit", type=unit, metavar="|".join(headings.TIMES), help=text)
    unit = one_of("--angle-unit", (*headings.UNITS, headings.COUNTS))
    text = (
        "unit of both angles; counts need --resolution (default: as in the columns' names, else "
        "deg)"
    )
    columns.add_argument("--angle-unit", type=unit, metavar="deg|rad|turn|counts", help=text)
    text, remedy = "how many lines to skip at the beginning of the file", "give how many lines"
    add_number(columns, "skip_rows", text, "N", minimum=0, whole=True, remedy=remedy)
    zeros = parser.add_argument_group("zeros of the encoders, which are fitted unless given")
    rule: dict[str, Any] = {"unit": "degrees", "minimum": -math.inf, "remedy": "give an angle"}
    text = "driver angle from dead centre at which the input reads zero"
    add_number(zeros, "phase", text, "DEG", **rule)
    text = "reading of the output at which the follower angle is zero"
    add_number(zeros, "offset", text, "DEG", **rule)
    statistics = parser.add_argument_group("statistics")
    text = (
        "classes: a number, or sturges (default), scott, freedman-diaconis, square-root; the "
        "chi-squared test uses fewer where that is needed to expect five errors in each"
    )
    statistics.add_argument("--bins", type=_class_rule, default="sturges", metavar="K", help=text)
    text, remedy = "level of the intervals (default: 0.99)", "give a share, as 0.99"
    add_number(statistics, "confidence", text, "P", exclusive=True, remedy=remedy)
    text = (
        "counts of the encoders in a turn, or of input and output, as 6400,4096; with it the "
        "errors that they cause are printed"
    )
    statistics.add_argument("--resolution", type=_resolution, metavar="N[,N]", help=text)
    text = "greatest deviation of the encoders as a share of a turn (default: 0)"
    add_number(statistics, "linearity", text, "SHARE", remedy="give a share, 0.003 for 0.3 %")
    motion = parser.add_argument_group("motion from rest at pin entry; it needs a column of times")
    text = (
        "compare speeds with the motion of the model below, and fit these numbers of the model, "
        "as friction,torque; 'none' compares only"
    )
    motion.add_argument("--fit", metavar="NAME,...", help=text)
    _arguments.add_group(parser, "model", model_settings())
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "FILE.csv", "write the error of every sample")
    _arguments.add_plot(output, "draw errors, histogram and periodogram")


def _resolution(text: str) -> tuple[int, int]:
    """Counts in a turn of input and output; one number is that of both."""
    remedy = "give the counts in a turn, as 4096, or those of input and output, as 6400,4096"
    rule = Quantity(name="resolution", long_name=remedy, minimum=2, whole=True, remedy=remedy)
    words = text.split(",")
    try:
        if len(words) > 2:
            raise validate.fail("--resolution", "one number or two", text, remedy)
        counts = [int(rule.parse("--resolution", word)) for word in words]
    except InvalidValue as error:
        raise UsageError(str(error)) from None
    return counts[0], counts[-1]


def _class_rule(text: str) -> int | str:
    """A number of classes, or the name of a rule, which `measure` checks."""
    return int(text) if text.lstrip("+-").isdecimal() else text


def execute(args: Arguments) -> int:
    """Print the statistics; write the files and draw the figures that were asked for."""
    _output.check_wanted(args, file="FILE.csv")
    if args.linearity is not None and args.resolution is None:
        raise UsageError(
            f"--linearity must come with --resolution N, got {args.linearity!r} alone; "
            "give the counts in a turn too"
        )
    # both zeros are fitted together, so one of them alone cannot be held
    zeros = args.phase, args.offset
    if zeros.count(None) == 1:
        lacking, given = ("phase", "offset") if args.phase is None else ("offset", "phase")
        raise UsageError(
            f"--{lacking} must come with --{given}, got only --{given}; give both or neither"
        )
    options = {
        "encoder": args.resolution
        and tuple(esc.Encoder(count, args.linearity or 0.0) for count in args.resolution),
        "bins": args.bins,
        "confidence": args.confidence or 0.99,
        "zeros": None if None in zeros else tuple(map(math.radians, zeros)),
    }
    escapement = _read_model(args)
    mechanism = escapement.mechanism if escapement else _arguments.read_mechanism(args)
    readings = _read(args)
    result = fit = None
    if readings.samples or escapement is None:
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
    picture = _output.drawn(
        args.plot,
        lambda plots: plots.plot_speeds(fit) if result is None else plots.plot_measurement(result),
    )
    if result is not None and args.output is not None:
        from escapement.measurement import write_errors

        write_errors(result, args.output, force=args.force)
        _log.record("saved", file=str(args.output))
    picture()
    record = _joined(result, fit, args.units)
    known = inputs_of(escapement) if escapement else inputs_of_mechanism(mechanism)
    _output.tell(args, record, lambda: _print(record), record["message"], known)
    return 0


def _read_model(args: Arguments) -> "esc.Escapement | None":
    """The escapement whose motion is compared, None without --fit."""
    if args.fit is not None:
        escapement: esc.Escapement = _arguments.read_escapement(args)
        return escapement
    # the sizes of a wheel change no angles
    sizes = (*LENGTHS, "fixed_radius")
    others = kind_of(args.kind or DEFAULT_KIND).other_sizes()
    also = (name for name, size in others.items() if size.of in sizes)
    names = (*model_settings(), *sizes, *also)
    given = {option(name): getattr(args, name) for name in names}
    given |= {"--time-column": args.time_column, "--time-unit": args.time_unit}
    for name, value in given.items():
        if value is not None:
            raise UsageError(
                f"{name} must come with --fit, got {name} alone; add --fit friction,torque"
            )
    return None


def _read(args: Arguments) -> "esc.Readings":
    """The readings, with times if a motion is compared."""
    counts = "--angle-unit counts"
    if args.angle_unit == "counts" and args.resolution is None:
        raise UsageError(
            f"{counts} must come with --resolution N, got none; give the counts in a turn"
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


def _joined(result: Any, fit: Any, units: str) -> dict[str, Any]:
    """What is reported: the verdict first, then the figures of both comparisons."""
    texts, messages, record = [], [], dict[str, Any]()
    if result is not None:
        texts.append(result.verdict.text)
        messages.append(result.message)
        record = summarise(result)
    if fit is not None:
        texts.append(fit.verdict.text)
        messages.append(fit.message)
        record["motion"] = _summarise_motion(fit, units)
    verdicts = [one.verdict.good for one in (result, fit) if one is not None]
    good = False if False in verdicts else None if None in verdicts else True
    message = "; ".join(dict.fromkeys(filter(None, messages)))
    return {"verdict": " ".join(texts), "good": good} | record | {"message": message}


def _summarise_motion(fit: Any, units: str) -> dict[str, Any]:
    """What is reported of a `MotionFit`, by JSON key, in the user's units."""
    from escapement.study.plan import unit_kind

    fitted = {}
    for name, value, ends in zip(fit.parameters, fit.values, fit.intervals, strict=True):
        kind = unit_kind(name)
        ends = [_output.in_units(float(x), kind, units) for x in (value, *ends)]
        fitted[name] = {"value": ends[0], "interval": ends[1:], "unit": printed(kind, units)}
    apart = fit.speeds - fit.computed_speeds
    return {
        "samples": fit.time.size,
        "release_time": fit.start,
        "fitted": fitted,
        "confidence": fit.confidence,
        "noise_deg": math.degrees(fit.noise),
        "autocorrelation": fit.autocorrelation,
        "p_value": None if math.isnan(fit.p_value) else fit.p_value,
        "speed_max": float(fit.speeds.max()),
        "speed_max_computed": float(fit.computed_speeds.max()),
        "speed_deviation": float(np.sqrt(np.mean(apart**2))),
        "message": fit.message,
    }


def _print(record: dict[str, Any]) -> None:
    """Print the verdict, and tables of both comparisons."""
    print(record["verdict"])
    if "samples" in record:
        print()
        _print_tables(record)
    if motion := record.get("motion"):
        print("\nmotion")
        share = f"{100.0 * motion['confidence']:g} %"
        rows: list[tuple[str, Any, str]] = []
        for name, found in motion["fitted"].items():
            rows.append((words(name), found["value"], found["unit"]))
            low, high = found["interval"]
            rows.append((f"  {share} interval", f"{low:.6g} to {high:.6g}", found["unit"]))
        shown = {key: motion[key] for key in _MOTION_KEYS}
        print_values(rows + _output.rows(shown, _MOTION_KEYS, SYSTEMS[0]))


def summarise(result: Any) -> dict[str, Any]:
    """What `measure` reports of a `Measurement`, by JSON key; angles in degrees."""
    fit, errors, spectrum = result.fit, result.errors, result.periodogram
    power, sensor = float(spectrum.power[spectrum.peak]), result.sensor_share
    tests = result.chi_squared_test, result.published_test, result.anderson_darling_test
    backlash_keys = "shaft", "width_deg", "standard_error_deg", "p_value"
    part_keys = "shaft", "number", "parts", "size_deg", "standard_error_deg", "p_value"
    change_keys = "shaft", "line", "size_deg", "standard_error_deg", "p_value"
    shaft_keys = "shaft", "order", "amplitude_deg", "standard_error_deg", "p_value", "turns"
    return {
        "samples": errors.size,
        "missing": result.readings.missing,
        "synthetic": result.readings.synthetic,
        "input_travel_deg": math.degrees(result.input.max() - result.input.min()),
        **_attributes(
            fit, "sense", "phase_deg", "phase_error_deg", "offset_deg", "offset_error_deg"
        ),
        **_attributes(result, "mean_deg", "standard_deviation_deg"),
        "error_min_deg": math.degrees(errors.min()),
        "error_max_deg": math.degrees(errors.max()),
        **_attributes(result, "confidence", "interval_deg", "mean_interval_deg"),
        **_attributes(result, "autocorrelation", "bins"),
        "bin_edges_deg": [*map(math.degrees, result.histogram.edges)],
        **_attributes(result.histogram, "observed", "expected"),
        # JSON has null where a test knows no degrees of freedom
        **{
            key: test._asdict() | {"degrees_of_freedom": test.degrees_of_freedom or None}
            for key, test in zip(_TESTS, tests, strict=True)
        },
        "shaft_errors": [_attributes(error, *shaft_keys) for error in result.shaft_errors],
        "slot_errors": [_attributes(part, *part_keys) for part in result.slot_errors],
        "backlash": [_attributes(backlash, *backlash_keys) for backlash in result.backlash],
        "changes": [_attributes(change, *change_keys) for change in result.changes],
        "glitches": [_attributes(one, "line", "size_deg", "p_value") for one in result.glitches],
        "scatter_deg": math.degrees(result.scatter),
        "periodogram_peak": {
            "cycles_per_input_turn": float(spectrum.frequency[spectrum.peak]),
            "amplitude_deg": math.degrees(spectrum.amplitude[spectrum.peak]),
            "share_of_variance": power,
            "false_alarm_probability": float(spectrum.false_alarm_probability(power)),
        },
        "sensor": sensor and _attributes(sensor, *(f"{name}_deg" for name in sensor._fields)),
    }


def _attributes(owner: Any, *keys: str) -> dict[str, Any]:
    """Attributes of a result, angles in degrees where the key says so."""
    found = {key: getattr(owner, key.removesuffix("_deg")) for key in keys}
    for key in keys:
        if key.endswith("_deg"):
            several = isinstance(found[key], tuple)
            found[key] = [*map(math.degrees, found[key])] if several else math.degrees(found[key])
    return found


def _print_tables(record: dict[str, Any]) -> None:
    """Print single results with their intervals, tests of normality, and errors that repeat."""
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
    print("\nerrors that repeat, backlash and changes")
    rows = []
    for error in record["shaft_errors"]:
        shaft, often = error["shaft"], "once" if error["order"] == 1 else "twice"
        name = f"{often} a cell" if shaft == "cell" else f"{often} a turn, {shaft}"
        rows.append([name, error["amplitude_deg"], error["standard_error_deg"], error["p_value"]])
    for part in record["slot_errors"]:
        name = f"worst {'pin' if part['shaft'] == 'input' else 'slot'}, number {part['number']}"
        rows.append([name, part["size_deg"], part["standard_error_deg"], part["p_value"]])
    for backlash in record["backlash"]:
        name = f"backlash, {backlash['shaft']}"
        rows.append(
            [name, backlash["width_deg"], backlash["standard_error_deg"], backlash["p_value"]]
        )
    for change in record["changes"]:
        name = f"change behind line {change['line']}, {change['shaft']}"
        rows.append([name, change["size_deg"], change["standard_error_deg"], change["p_value"]])
    for one in record["glitches"]:
        rows.append([f"far out, line {one['line']}", one["size_deg"], None, one["p_value"]])
    peak = record["periodogram_peak"]
    name = f"periodogram's peak, {peak['cycles_per_input_turn']:.4g} a turn of the input"
    rows.append([name, peak["amplitude_deg"], None, peak["false_alarm_probability"]])
    print_columns([["", "amplitude/deg", "+-", "p"]], rows)
