"""The verdict on a measurement, and warnings that a user of its figures must know."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from escapement.measurement.backlash import Backlash
from escapement.measurement.encoder import step_of
from escapement.measurement.readings import wraps
from escapement.measurement.shaft_errors import IN_95, SURE, ShaftError, chance, told_backlash

_ALIKE = 0.05  # a smaller correlation of neighbouring errors hardly changes a p-value
_CLOSE_TO_HALF_A_TURN = 0.8 * math.pi
_MUCH = 0.25  # errors above this share of a step mean that the mechanism is another one
_NOISE, _ROUNDING = "noise with correlated neighbours", "the rounding of the encoders"


class Verdict(NamedTuple):
    """Whether a mechanism is good, as far as its readings show.

    good : True if the tests that would contradict it were possible and passed, False if the
        readings contradict it, None if they cannot say.
    text : one or two sentences that say what is wrong, and where, or why they cannot say.
    """

    good: bool | None
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
    findings = dict(_findings(result))
    if wrong := [told for told, doubt in findings.items() if not doubt]:
        return Verdict(False, f"Not good: {'; '.join(wrong)}.{lacking}")
    size = f"{math.degrees(result.standard_deviation):.3g} degrees"
    text = f"Good: no error is certain to repeat with a shaft, and the errors scatter by {size}"
    if result.sensor_share:
        share = math.degrees(result.sensor_share.standard)
        text += f", where the encoders alone explain {share:.3g}"
    if _ROUNDING in findings.values():
        lacking += (
            " Errors below half a step of the encoders "
            f"({math.degrees(0.5 * _step(result)):.3g} degrees) cannot be told from their "
            "rounding, which repeats where positions do: stop at other positions in every turn, "
            "or, if you do so already, use finer encoders."
        )
    return Verdict(True, f"{text}.{lacking}")


def _findings(result: Any) -> Iterator[tuple[str, str]]:
    """Errors that independent noise seldom causes: the words for each, and what else it may be."""
    rest, step = result.rest_autocorrelation, _step(result)
    for found in (*result.shaft_errors, *result.backlash):
        if found.p_value < SURE:
            doubt = _NOISE if chance(found.p_value, rest) >= SURE else ""
            doubt = doubt or (_ROUNDING if _may_be_rounding(result, found, step) else "")
            told = told_backlash if isinstance(found, Backlash) else ShaftError.told
            yield told(found, not doubt), doubt


def _step(result: Any) -> float:
    """Step of the encoders, 0 if it is unknown [rad]."""
    return float(result.encoder.quantum if result.encoder else step_of(result.output))


def _may_be_rounding(result: Any, found: ShaftError | Backlash, step: float) -> bool:
    """Whether rounding to this step alone may look like an error that was found."""
    if isinstance(found, Backlash):
        size, share = abs(found.width), 0.5
    else:
        size, share = found.amplitude, math.sqrt(0.5)
    if size < 0.5 * step:
        return True
    # a fit that can hardly separate an error from others may find it greater than all that was read
    through = float(np.mean(result.fit.slope**2))
    effect = size * share * (math.sqrt(through) if found.shaft == "input" else 1.0)
    vague = effect > result.standard_deviation or size - IN_95 * found.standard_error < 0.5 * step
    most = 0.5 * step * math.sqrt(1.0 + through)
    return bool(vague and result.standard_deviation < most)


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
    for told, doubt in _findings(result):
        if doubt:
            yield f"{told}, or is {doubt}"
    unknown = dict.fromkeys(it.shaft for it in result.shaft_errors if math.isnan(it.p_value))
    if unknown:
        yield (
            f"errors that repeat with the {' and the '.join(unknown)} are not judged: either the "
            "readings do not cover a whole turn, or they cannot separate these errors from others"
        )
    if result.periodogram.samples < result.errors.size:
        yield f"the periodogram covers the first {result.periodogram.turns:.0f} turns"
