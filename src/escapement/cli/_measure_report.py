"""What `escapement measure` reports, for programs and for people."""

import math
from typing import TYPE_CHECKING, Any

from escapement.text import print_columns, print_values, words

if TYPE_CHECKING:
    from escapement.measurement import Measurement, NormalityTest, Periodogram, ShaftError

_TESTS = {
    "chi_squared": "chi-squared",
    "chi_squared_published": "chi-squared as published",
    "anderson_darling": "Anderson-Darling",
}


def summarise(result: "Measurement") -> dict[str, Any]:
    """What `measure` reports, by JSON key; angles in degrees."""

    def degrees(values: Any) -> list[float]:
        return [math.degrees(value) for value in values]

    fit, sensor = result.fit, result.sensor_share
    return {
        "samples": result.errors.size,
        "missing": result.readings.missing,
        "synthetic": result.readings.synthetic,
        "input_travel_deg": math.degrees(float(result.input.max() - result.input.min())),
        "sense": fit.sense,
        "phase_deg": math.degrees(fit.phase),
        "phase_error_deg": math.degrees(fit.phase_error),
        "offset_deg": math.degrees(fit.offset),
        "offset_error_deg": math.degrees(fit.offset_error),
        "mean_deg": math.degrees(result.mean),
        "standard_deviation_deg": math.degrees(result.standard_deviation),
        "error_min_deg": math.degrees(float(result.errors.min())),
        "error_max_deg": math.degrees(float(result.errors.max())),
        "confidence": result.confidence,
        "interval_deg": degrees(result.interval),
        "mean_interval_deg": degrees(result.mean_interval),
        "autocorrelation": result.autocorrelation,
        "bins": result.bins,
        "bin_edges_deg": degrees(result.histogram.edges.tolist()),
        "observed": result.histogram.observed,
        "expected": result.histogram.expected,
        "chi_squared": _described(result.chi_squared_test),
        "chi_squared_published": _described(result.published_test),
        "anderson_darling": _described(result.anderson_darling_test),
        "shaft_errors": [_of_shaft(error) for error in result.shaft_errors],
        "periodogram_peak": _peak(result.periodogram),
        "sensor": None
        if sensor is None
        else {f"{name}_deg": math.degrees(value) for name, value in sensor._asdict().items()},
        "message": result.message,
    }


def _described(test: "NormalityTest") -> dict[str, Any]:
    return {
        "statistic": float(test.statistic),
        "degrees_of_freedom": test.degrees_of_freedom or None,
        "p_value": float(test.p_value),
    }


def _of_shaft(error: "ShaftError") -> dict[str, Any]:
    return {
        "shaft": error.shaft,
        "order": error.order,
        "amplitude_deg": math.degrees(error.amplitude),
        "standard_error_deg": math.degrees(error.standard_error),
        "p_value": error.p_value,
        "turns": error.turns,
    }


def _peak(spectrum: "Periodogram") -> dict[str, float]:
    peak = spectrum.peak
    return {
        "cycles_per_input_turn": float(spectrum.frequency[peak]),
        "amplitude_deg": math.degrees(float(spectrum.amplitude[peak])),
        "share_of_variance": float(spectrum.power[peak]),
        "false_alarm_probability": float(spectrum.false_alarm_probability(spectrum.power[peak])),
    }


def print_table(record: dict[str, Any]) -> None:
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
