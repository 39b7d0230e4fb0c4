"""The verdict on a measurement, and warnings that a user of its figures must know."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from escapement.measurement.readings import wraps
from escapement.measurement.shaft_errors import SURE, chance, told_backlash

_ALIKE = 0.05  # a smaller correlation of neighbouring errors hardly changes a p-value
_CLOSE_TO_HALF_A_TURN = 0.8 * math.pi
_MUCH = 0.25  # errors above this share of a step mean that the mechanism is another one


class Verdict(NamedTuple):
    """Whether a mechanism is good, as far as its readings show.

    good : True if the errors are small for this mechanism, and neither backlash nor an error that
        repeats with a shaft is certain.
    text : one or two sentences that say what is wrong, and with which shaft.
    """

    good: bool
    text: str


def verdict_on(result: Any) -> Verdict:
    """The verdict on a `Measurement`."""
    rms, step = math.hypot(result.mean, result.standard_deviation), result.mechanism.follower_step
    if rms > _MUCH * abs(step):
        return Verdict(
            False,
            f"Not this mechanism: errors of {math.degrees(rms):.3g} degrees are large against the "
            f"follower's step of {math.degrees(abs(step)):.3g} degrees. Check the mechanism, which "
            "column is the input, and the unit of the angles.",
        )
    lacking = "" if result.backlash else " It turned one way only, so backlash cannot be seen."
    if wrong := [told for told, certain in _findings(result) if certain]:
        return Verdict(False, f"Not good: {'; '.join(wrong)}.{lacking}")
    size = f"{math.degrees(result.standard_deviation):.3g} degrees"
    text = f"Good: no error is certain to repeat with a shaft, and the errors scatter by {size}"
    if result.sensor_share:
        share = math.degrees(result.sensor_share.standard)
        text += f", where the encoders alone explain {share:.3g}"
    return Verdict(True, f"{text}.{lacking}")


def _findings(result: Any) -> Iterator[tuple[str, bool]]:
    """Errors that noise seldom causes: the words for each, and whether it is certain."""
    rest = result.rest_autocorrelation
    for error in result.shaft_errors:
        if error.p_value < SURE:
            certain = chance(error.p_value, rest) < SURE
            yield error.told(certain), certain
    for play in result.backlash:
        if play.p_value < SURE:
            certain = chance(play.p_value, rest) < SURE
            yield told_backlash(play, certain), certain


def remarks_on(result: Any) -> Iterator[str]:
    """Warnings for the user, the most serious first."""
    yield from _on_the_fit(result)
    yield from _on_repeated_errors(result)


def _on_the_fit(result: Any) -> Iterator[str]:
    """Warnings about the readings and their fit."""
    readings = result.readings
    if readings.synthetic:
        yield "these are synthetic data, computed and not measured"
    if readings.remark:
        yield readings.remark
    if not math.isfinite(result.published_test.statistic):
        far = result.errors[np.argmax(np.abs(result.errors - result.mean))]
        yield (
            f"an error of {math.degrees(far):.3g} degrees is "
            f"{abs(far - result.mean) / result.standard_deviation:.0f} standard deviations from "
            "the mean, where normal errors practically never are: chi_squared_published is infinite"
        )
    if math.isnan(result.fit.phase_error):
        yield "the output turns at a constant ratio in these samples, so they do not show the phase"
    known = np.flatnonzero(np.isfinite(readings.input))
    steps = np.abs(np.diff(readings.counted_input[known]))
    far = int(np.argmax(steps))
    if wraps(readings.input[known]) and steps[far] > _CLOSE_TO_HALF_A_TURN:
        line = readings.line[known[far + 1]]
        yield (
            f"the input moves by {math.degrees(steps[far]):.0f} degrees up to line {line}: its "
            "turns may be miscounted; take samples at smaller steps"
        )


def _on_repeated_errors(result: Any) -> Iterator[str]:
    """Warnings about errors that repeat or depend on each other."""
    # independent errors have a correlation beyond 3.3/sqrt(n) once in a thousand times
    least, rest = max(3.3 / math.sqrt(result.errors.size), _ALIKE), result.rest_autocorrelation
    alike = max(result.autocorrelation, rest)
    spoilt = "the tests of normality, the errors of phase and offset and the intervals of the mean"
    # an error that repeats makes neighbours alike, but the tests for such errors allow for it
    if rest > least:
        spoilt = "all tests, false alarms, standard errors and intervals of the mean"
    if alike > least:
        yield (
            f"neighbouring errors are alike (correlation {alike:.2f}), but {spoilt} "
            "assume that they are independent: do not trust those"
        )
    for told, certain in _findings(result):
        if not certain:
            yield f"{told}, or is noise with correlated neighbours"
    unknown = dict.fromkeys(it.shaft for it in result.shaft_errors if math.isnan(it.p_value))
    if unknown:
        yield (
            f"errors that repeat with the {' and the '.join(unknown)} are not judged: either the "
            "readings do not cover a whole turn, or they cannot separate these errors from others"
        )
    if result.periodogram.samples < result.errors.size:
        yield f"the periodogram covers the first {result.periodogram.turns:.0f} turns"
