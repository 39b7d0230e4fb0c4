"""What a reader of the figures must know before trusting them."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from escapement.measurement.readings import wraps

if TYPE_CHECKING:
    from escapement.measurement.comparison import Measurement
    from escapement.measurement.shafts import ShaftError

_SURE = 1e-3
"""A p-value below it is told to the reader."""
_ALIKE = 0.05  # a smaller correlation spoils no p-value
_TELLING = 3.0  # an amplitude of fewer standard errors is all but hidden
_LEAST = 5e-324  # it stands for a p-value that is too small for a double
_CLOSE_TO_HALF_A_TURN = 0.8 * math.pi


def cautions(result: "Measurement") -> Iterator[str]:
    """Sentences for the reader, the gravest first."""
    if result.readings.synthetic:
        yield "synthetic data, computed and not measured"
    if result.readings.remark:
        yield result.readings.remark
    yield from _on_the_fit(result)
    yield from _on_independence(result)
    yield from _on_shafts(result)


def _on_the_fit(result: "Measurement") -> Iterator[str]:
    rms = math.hypot(result.mean, result.standard_deviation)
    if rms > 0.25 * abs(result.mechanism.follower_step):
        yield (
            f"errors of {math.degrees(rms):.3g} degrees are large against a step of "
            f"{math.degrees(abs(result.mechanism.follower_step)):.3g}: check the mechanism, "
            "which column is the input, and the unit of the angles"
        )
    if not math.isfinite(result.published_test.statistic):
        far = int(np.argmax(np.abs(result.errors - result.mean)))
        away = abs(result.errors[far] - result.mean) / result.standard_deviation
        yield (
            f"an error of {math.degrees(result.errors[far]):.3g} degrees is {away:.0f} standard "
            "deviations out, where a normal law expects nothing: chi_squared_published is infinite"
        )
    if math.isnan(result.fit.phase_error):
        yield "the output turns evenly over these samples, so the phase cannot be told"
    readings = result.readings
    known = np.flatnonzero(np.isfinite(readings.input))
    if wraps(readings.input[known]):
        steps = np.abs(np.diff(readings.counted_input[known]))
        far = int(np.argmax(steps))
        if steps[far] > _CLOSE_TO_HALF_A_TURN:
            line = readings.line[known[far + 1]]  # type: ignore[index]
            yield (
                f"the input goes on by {math.degrees(steps[far]):.0f} degrees at line {line}: "
                "its turns may be miscounted, measure closer"
            )


def _on_independence(result: "Measurement") -> Iterator[str]:
    least = max(3.3 / math.sqrt(result.errors.size), _ALIKE)
    alike, rest = result.autocorrelation, result.rest_autocorrelation
    # a wave that is found makes neighbours alike, but spoils no test for waves
    if rest > least:
        spoilt = "all tests, false alarms, standard errors and intervals of the mean"
    else:
        spoilt = "tests of normality, errors of phase and offset and intervals of the mean"
    if max(alike, rest) > least:
        yield (
            f"neighbouring errors are alike (correlation {max(alike, rest):.2f}), while {spoilt} "
            "take them for independent: do not trust those"
        )


def _on_shafts(result: "Measurement") -> Iterator[str]:
    for error in result.shaft_errors:
        if error.p_value < _SURE:
            yield _on_shaft(error, result.rest_autocorrelation)
    unknown = dict.fromkeys(it.shaft for it in result.shaft_errors if math.isnan(it.p_value))
    if unknown:
        yield (
            f"errors that come back with {' and '.join(unknown)} are not judged: not measured all "
            "round, or not to be told from others"
        )
    if result.periodogram.samples < result.errors.size:
        yield f"the periodogram covers the first {result.periodogram.turns:.0f} turns"


def _on_shaft(error: "ShaftError", correlation: float) -> str:
    """What comes back, with reserve where correlated noise may look the same."""
    # To a slow wave n errors of correlation r are worth n (1 - r)/(1 + r) independent ones.
    # In an F test with two degrees of freedom p is then raised to that share.
    worth = (1.0 - correlation) / (1.0 + correlation) if correlation > 0.0 else 1.0
    sure = max(error.p_value, _LEAST) ** worth < _SURE
    where = "cell" if error.shaft == "cell" else f"turn of the {error.shaft}"
    when = f"{'comes' if sure else 'may come'} back {'once' if error.order == 1 else 'twice'}"
    amplitude, doubt = math.degrees(error.amplitude), math.degrees(error.standard_error)
    size = f"{amplitude:.3g} +- {doubt:.2g} degrees"
    if _TELLING * doubt < amplitude:
        text = f"an error of {size} {when} a {where}"
    else:
        hidden = "its size all but hidden by phase, offset and others"
        text = f"an error {when} a {where}, {hidden} ({size})"
    return text if sure else f"{text}, or is noise whose neighbours are alike"
