"""What is reported of a measurement, and of a measured motion."""

import math
from typing import Any

import numpy as np

TESTS = "chi_squared", "chi_squared_published", "anderson_darling"
"""Tests of normality, by JSON key."""
_ANGLES = {
    *("phase", "phase_error", "offset", "offset_error", "mean", "standard_deviation", "interval"),
    *("mean_interval", "amplitude", "size", "width", "standard_error", "noise", "scatter"),
    *("output_resolution", "input_resolution", "output_linearity", "input_linearity"),
    *("standard", "bound"),
}
"""Attributes that are angles [rad], which are reported in degrees under a key with "_deg"."""
_ERRORS = "shaft_errors", "slot_errors", "backlash", "changes", "glitches"
"""Errors with a cause."""


def record_of(result: Any, fit: Any, units: str) -> dict[str, Any]:
    """What is reported, by JSON key: the verdict first, then the figures of both comparisons.

    Parameters
    ----------
    result : Measurement or None
        The comparison of positions.
    fit : MotionFit or None
        That of a motion.
    units : str
        The system of units of fitted numbers; angles are in degrees.
    """
    found = [one for one in (result, fit) if one is not None]
    verdicts = [one.verdict.good for one in found]
    record: dict[str, Any] = {
        "verdict": " ".join(one.verdict.text for one in found),
        "good": False if False in verdicts else None if None in verdicts else True,
    }
    if result is not None:
        record |= _of_positions(result)
    if fit is not None:
        record["motion"] = _of_motion(fit, units)
    messages = dict.fromkeys(one.message for one in found if one.message)
    return record | {"message": "; ".join(messages)}


def _of_motion(fit: Any, units: str) -> dict[str, Any]:
    """What is reported of a `MotionFit`, by JSON key, in the user's units."""
    apart = fit.speeds - fit.computed_speeds
    return {
        "samples": fit.time.size,
        "release_time": fit.start,
        "fitted": fit.record(units),
        **_attributes(fit, "confidence", "noise", "autocorrelation", "p_value"),
        "speed_max": float(fit.speeds.max()),
        "speed_max_computed": float(fit.computed_speeds.max()),
        "speed_deviation": float(np.sqrt(np.mean(apart**2))),
        "message": fit.message,
    }


def _of_positions(result: Any) -> dict[str, Any]:
    """What is reported of a `Measurement`, by JSON key; angles in degrees."""
    errors, spectrum, sensor = result.errors, result.periodogram, result.sensor_share
    power = float(spectrum.power[spectrum.peak])
    tests = result.chi_squared_test, result.published_test, result.anderson_darling_test
    return {
        "samples": errors.size,
        **_attributes(result.readings, "missing", "synthetic"),
        "input_travel_deg": math.degrees(result.input.max() - result.input.min()),
        **_attributes(result.fit, "sense", "phase", "phase_error", "offset", "offset_error"),
        **_attributes(result, "mean", "standard_deviation"),
        "error_min_deg": math.degrees(errors.min()),
        "error_max_deg": math.degrees(errors.max()),
        **_attributes(result, "confidence", "interval", "mean_interval", "autocorrelation", "bins"),
        "bin_edges_deg": [*map(math.degrees, result.histogram.edges)],
        **_attributes(result.histogram, "observed", "expected"),
        # JSON has null where a test knows no degrees of freedom
        **{
            key: test._asdict() | {"degrees_of_freedom": test.degrees_of_freedom or None}
            for key, test in zip(TESTS, tests, strict=True)
        },
        **{name: [_attributes(one) for one in getattr(result, name)] for name in _ERRORS},
        **_attributes(result, "scatter"),
        "periodogram_peak": {
            "cycles_per_input_turn": float(spectrum.frequency[spectrum.peak]),
            "amplitude_deg": math.degrees(spectrum.amplitude[spectrum.peak]),
            "share_of_variance": power,
            "false_alarm_probability": float(spectrum.false_alarm_probability(power)),
        },
        "sensor": sensor and _attributes(sensor),
    }


def _attributes(owner: Any, *names: str) -> dict[str, Any]:
    """Attributes of a result by JSON key, angles in degrees; all fields if no name is given."""
    found = {}
    for name in names or owner._fields:
        value = getattr(owner, name)
        if name in _ANGLES:
            several = isinstance(value, tuple)
            found[f"{name}_deg"] = [*map(math.degrees, value)] if several else math.degrees(value)
        else:
            found[name] = value
    return found
