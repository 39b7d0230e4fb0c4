"""What is reported of times of beats, and of the parts or the motion that explain them."""

from typing import Any

import numpy as np

from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.units import SYSTEMS
from escapement.measurement.beat_times import BeatTimes
from escapement.measurement.beats import BeatFit
from escapement.measurement.estimate import Estimate
from escapement.measurement.motion_fit import MotionFit
from escapement.measurement.timekeeping import Timekeeping

RESULTS = {
    "duration": Result("time"),
    "period": Result("time", "mean time of a beat"),
    "beats_per_hour": Result(label="beats an hour", digits=8),
    "beats_per_hour_interval": Result(label="interval", digits=8),
    "rate": Result(label="rate [s/d]"),
    "rate_interval": Result(label="interval [s/d]"),
    "beat_error": Result("time"),
    "beat_error_interval": Result("time", label="interval"),
    "drift": Result(label="drift [s/d in an hour]"),
    "drift_interval": Result(label="interval [s/d in an hour]"),
    "scatter": Result("time"),
    "release_time": Result("time"),
    "noise": Result("time"),
    "time": Result("time"),
    "late": Result("time"),
    "late_interval": Result("time"),
}


def record_of_beats(
    beats: BeatTimes, keeping: Timekeeping | None, fit: Any = None, units: str = SYSTEMS[0]
) -> Record:
    """All figures of beats, by JSON key.

    keeping : their `timekeeping`, None in a run-up.
    fit : the `BeatFit` of parts, or the `MotionFit`, if one was made.
    units : the system of units of fitted numbers.
    """
    values: dict[str, Any] = {
        "beats": int(beats.heard.size),
        "missed": beats.missed,
        "other_sounds": int(beats.doubles.size),
        "sounds_of_a_beat": beats.sounds,
        "duration": beats.duration,
        "period": beats.period,
    }
    if keeping is not None:
        values |= _of_timekeeping(keeping)
    if isinstance(fit, BeatFit):
        values["parts"] = _of_parts(fit)
    if isinstance(fit, MotionFit):
        values["run_up"] = _of_run_up(fit, units)
    messages = [beats.message, getattr(fit, "message", "")]
    values["message"] = "; ".join(filter(None, messages))
    return Record(values, RESULTS)


def _of_timekeeping(keeping: Timekeeping) -> dict[str, Any]:
    found: dict[str, Any] = {"confidence": keeping.confidence}
    for name in ("beats_per_hour", "rate", "beat_error", "drift"):
        one: Estimate = getattr(keeping, name)
        if not one.doubt:
            found |= {name: one.value, f"{name}_interval": [one.low, one.high]}
    found |= {"scatter": keeping.scatter, "share_of_instants": keeping.jitter}
    if len(keeping.offsets) > 2:
        found["positions"] = [
            {"position": k, "late": one.value, "late_interval": [one.low, one.high]}
            for k, one in enumerate(keeping.offsets)
        ]
    found["allan_deviation"] = [one._asdict() for one in keeping.stability]
    return found


def _of_run_up(fit: MotionFit, units: str) -> dict[str, Any]:
    """The verdict, and the fitted numbers with the ends of their intervals."""
    return {
        "verdict": fit.verdict.text,
        "good": fit.verdict.good,
        "fitted": fit.record(units),
        "release_time": fit.release.value,
        "noise": fit.noise,
        "p_value": fit.p_value,
        "autocorrelation": fit.autocorrelation,
    }


def _of_parts(fit: BeatFit) -> dict[str, Any]:
    """The verdict, and angle errors in degrees with the ends of their intervals."""

    def table(errors: Any, halves: Any) -> list[dict[str, Any]]:
        middle, low, high = (
            np.degrees(x).tolist() for x in (errors, errors - halves, errors + halves)
        )
        return [
            {"error_deg": error, "interval_deg": [*ends]}
            for error, *ends in zip(middle, low, high, strict=True)
        ]

    return {
        "verdict": fit.verdict.text,
        "good": fit.verdict.good,
        "measured_over_computed": fit.rate,
        "pins": table(fit.pin_angle_errors, fit.pin_half_widths),
        "slots": table(fit.slot_angle_errors, fit.slot_half_widths),
    }
