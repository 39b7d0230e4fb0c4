"""What is reported of a measurement, of a measured motion, and of beats."""

import math
from typing import Any

import numpy as np

from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.units import SYSTEMS
from escapement.measurement.beats import BeatFit
from escapement.measurement.estimate import Estimate, Fit
from escapement.measurement.readings import Readings
from escapement.measurement.timekeeping import Timekeeping

TESTS = "chi_squared_published", "anderson_darling"
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
RESULTS = dict.fromkeys(
    ("beat_error", "scatter", "release_time", "noise", "time", "late", "late_interval"),
    Result("time"),
) | {
    "period": Result("time", "mean time of a beat"),
    "beats_per_hour": Result(label="beats an hour", digits=8),
    "beats_per_hour_interval": Result(label="interval", digits=8),
    "rate": Result(label="rate [s/d]"),
    "rate_interval": Result(label="interval [s/d]"),
    "beat_error_interval": Result("time", label="interval"),
    "drift": Result(label="drift [s/d in an hour]"),
    "drift_interval": Result(label="interval [s/d in an hour]"),
}


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
        apart = fit.speeds - fit.computed_speeds
        record["motion"] = {
            "samples": fit.time.size,
            **_of_motion(fit, units),
            **_attributes(fit, "confidence", "noise"),
            "speed_max": float(fit.speeds.max()),
            "speed_max_computed": float(fit.computed_speeds.max()),
            "speed_deviation": float(np.sqrt(np.mean(apart**2))),
            "message": fit.message,
        }
    messages = dict.fromkeys(one.message for one in found if one.message)
    return record | {"message": "; ".join(messages)}


def _of_positions(result: Any) -> dict[str, Any]:
    """What is reported of a `Measurement`, by JSON key; angles in degrees."""
    errors, spectrum, sensor = result.errors, result.periodogram, result.sensor_share
    power = float(spectrum.power[spectrum.peak])
    tests = result.published_test, result.anderson_darling_test
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


def record_of_beats(
    beats: Readings, keeping: Timekeeping | None, fit: Fit | None = None, units: str = SYSTEMS[0]
) -> Record:
    """All figures of beats, by JSON key.

    keeping : their `timekeeping`, None in a run-up.
    fit : that of parts, or of a run-up, if one was made.
    units : the system of units of fitted numbers.
    """
    values: dict[str, Any] = {
        "beats": beats.samples, "missed": beats.missing, "other_sounds": len(beats.doubles),
        "sounds_of_a_beat": beats.sounds, "period": beats.period,
    }  # fmt: skip
    if keeping is not None:
        values |= _of_timekeeping(keeping)
    if fit is not None:
        values["parts" if isinstance(fit, BeatFit) else "run_up"] = _of_fit(fit, units)
    values["message"] = "; ".join(filter(None, [*beats.remarks, fit.message if fit else ""]))
    return Record(values, RESULTS)


def _of_timekeeping(keeping: Timekeeping) -> dict[str, Any]:
    found: dict[str, Any] = {"confidence": keeping.confidence}
    for one in (keeping.beats_per_hour, keeping.rate, keeping.beat_error, keeping.drift):
        if not one.doubt:
            found |= {one.name: one.value, f"{one.name}_interval": [one.low, one.high]}
    found |= {"scatter": keeping.scatter, "share_of_instants": keeping.jitter}
    if len(keeping.offsets) > 2:
        found["positions"] = [
            {"position": k, "late": one.value, "late_interval": [one.low, one.high]}
            for k, one in enumerate(keeping.offsets)
        ]
    found["allan_deviation"] = [one._asdict() for one in keeping.stability]
    return found


def _of_fit(fit: Any, units: str) -> dict[str, Any]:
    """The verdict, and what was found with the ends of its intervals, angles in degrees."""

    def angles(kind: str) -> list[dict[str, Any]]:
        some: list[Estimate] = [one for one in fit.numbers if one.name.startswith(kind)]
        each = [[*map(math.degrees, (one.value, one.low, one.high))] for one in some]
        return [{"error_deg": error, "interval_deg": ends} for error, *ends in each]

    found = {"verdict": fit.verdict.text, "good": fit.verdict.good}
    if isinstance(fit, BeatFit):
        parts = {"pins": angles("pin"), "slots": angles("slot")}
        return found | {"measured_over_computed": fit.rate} | parts
    return found | {"noise": fit.noise} | _of_motion(fit, units)


def _of_motion(fit: Any, units: str) -> dict[str, Any]:
    """What is reported of every fit of a motion from rest."""
    found = {"release_time": fit.release.value, "fitted": fit.record(units)}
    return found | _attributes(fit, "autocorrelation", "p_value")
