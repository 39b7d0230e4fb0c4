"""The verdict on a measurement, and warnings that a user of its figures must know.

The null hypothesis is that this mechanism was turned, and that its errors are independent noise of
the encoders. The verdict is "not good" where a test contradicts this with certainty, "cannot say"
where the readings are too few, too noisy or too much alike for the tests, or where a test is near
its limit, and "good" where all tests were possible and passed.
"""

import math
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any

import numpy as np

from escapement.base.lazy import Lazy
from escapement.measurement.causes import ROUNDING, Cause, causes_of
from escapement.measurement.estimate import SURE, Verdict
from escapement.measurement.other_reading import other_reading
from escapement.measurement.readings import TURN, wraps

special = Lazy("scipy.special")
_ALIKE = 0.05  # a smaller correlation of neighbouring errors hardly changes a p-value
_CLOSE_TO_HALF_A_TURN = 0.8 * math.pi
_MUCH = 0.25  # errors above this share of a step mean that the mechanism is another one
_SMALL = 0.05  # errors of this share of a step leave a pin no way into its slot
_CELLS = 2  # an error that repeats must be seen twice before it can be told from others
_DETECTED = 5.0  # standard errors of an error that is seen nineteen times in twenty


def verdict_on(result: Any) -> Verdict:
    """The verdict on a `Measurement`, from the first test with a reason."""
    causes = [*_causes(result)]
    lacking = "" if result.backlash else " It turned one way only, so backlash cannot be seen."
    for good, head, test, remedy in _TESTS:
        if reasons := [*test(result, causes)]:
            hint = " " + (other_reading(result, _CELLS, _SMALL) or remedy) if remedy else lacking
            return Verdict(good, f"{head}: {'; '.join(reasons)}.{hint}")
    return Verdict(True, _good(result) + lacking)


def _causes(result: Any) -> Iterator[Cause]:
    """The causes of errors that were found."""
    return causes_of(result, _SMALL * abs(result.mechanism.follower_step))


def _other_mechanism(result: Any, causes: list[Cause]) -> Iterator[str]:
    """Why the readings are not those of this mechanism."""
    step = abs(result.mechanism.follower_step)
    cells = _cells(result)
    if cells > 1.0 and np.ptp(result.output) < min(0.5 * step, result.spread):
        yield (
            f"the output moves by {_deg(np.ptp(result.output))} in all while the input turns "
            f"through {cells:.3g} cells"
        )
        return
    alike = unexplained(result) < SURE
    # where something remains unexplained, so may be what was found
    size = result.spread if alike else result.scatter
    great = f"large against the follower's step of {_deg(step)}"
    if cells > _MUCH and size > (_SMALL if alike else _MUCH) * step:
        words = f", and neighbours are alike (correlation {result.autocorrelation:.2f})"
        yield f"errors of {_deg(size)} are {great}{words * alike}"
        return
    some = (cause for cause in causes if cause.certain and cause.effect > 1.0)
    yield from (f"{cause.text}, which is {great}" for cause in islice(some, 1))


def _too_short(result: Any, causes: list[Cause]) -> Iterator[str]:
    """Why the shafts did not move far enough to judge anything."""
    mechanism = result.mechanism
    # the cells count as whole if one mean step after the last sample completes them
    if _cells(result) < _CELLS * (1.0 - 1e-9) * (result.errors.size - 1) / result.errors.size:
        yield (
            f"the input moved by {_deg(np.ptp(result.input))} and the output by "
            f"{_deg(np.ptp(result.output))}, but errors can be told from noise only over {_CELLS} "
            f"whole cells, {_deg(_CELLS * mechanism.cell_angle)} of the input and "
            f"{_deg(_CELLS * abs(mechanism.follower_step))} of the output"
        )


def _wrong(result: Any, causes: list[Cause]) -> Iterator[str]:
    """What is certain."""
    return (cause.text for cause in causes if cause.certain)


def _cells(result: Any) -> float:
    """Cells between the least and the greatest input."""
    return float(np.ptp(result.input)) / float(result.mechanism.cell_angle)


def unexplained(result: Any) -> float:
    """Probability that independent noise, read by these encoders, makes neighbours so alike."""
    # rounding and linearity may make neighbours alike, as far as they explain the variance
    share = 0.0
    if result.scatter > 0.0:
        through = math.sqrt(float(np.mean(result.fit.slope**2)))
        explained = math.hypot(result.steps[1], through * result.steps[0]) / math.sqrt(12.0)
        if result.sensor_share:
            explained = result.sensor_share.standard
        share = min(1.0, (explained / result.scatter) ** 2)
    excess = result.rest_autocorrelation - share
    return float(special.ndtr(-excess * math.sqrt(result.errors.size)))


def _doubts(result: Any, causes: list[Cause]) -> Iterator[str]:
    """What keeps a mechanism from being called good although nothing is certain."""
    step = abs(result.mechanism.follower_step)
    yield from (f"{cause.text}, or is {cause.doubt}" for cause in causes)
    if any(cause.doubt == ROUNDING for cause in causes):
        yield (
            f"errors below half a step of the encoders ({_deg(0.5 * max(result.steps))}) cannot "
            "be told from their rounding, which repeats where positions do: stop at other "
            "positions in every turn, or, if you do so already, use finer encoders"
        )
    if unexplained(result) < SURE:
        yield (
            f"neighbouring errors are alike (correlation {result.rest_autocorrelation:.2f}), which "
            "neither independent noise nor any error that was looked for explains"
        )
    if result.scatter > _SMALL * step:
        yield (
            f"the errors scatter by {_deg(result.scatter)}, which is much for steps of {_deg(step)}"
        )


_TESTS: tuple[tuple[bool | None, str, Callable[[Any, list[Cause]], Iterator[str]], str], ...] = (
    (
        False, "Not this mechanism", _other_mechanism,
        "Check the mechanism, which column is the input, and the unit of the angles.",
    ),
    (
        None, "Cannot say", _too_short,
        "Turn it further, or check the unit of the angles and the columns.",
    ),
    (False, "Not good", _wrong, ""),
    (None, "Cannot say", _doubts, ""),
)  # fmt: skip
"""In this order: the verdict where a test has reasons, its head, the test, and a remedy."""


def _good(result: Any) -> str:
    """What was looked for and not found, and how small it might have been."""
    detectable = max(
        _DETECTED * result.scatter * math.sqrt(2.0 / result.errors.size), result.hidden
    )
    text = (
        "Good: the errors are noise without an error of a shaft or of a slot, without a change for "
        f"good and without a reading far out, and scatter by {_deg(result.standard_deviation)}"
    )
    if result.sensor_share:
        text += f", where the encoders alone explain {_deg(result.sensor_share.standard)[:-8]}"
    text += f". An error of the output of {_deg(detectable)} that repeats would have been seen."
    if unknown := _unjudged(result):
        text += f" Errors that repeat with the {unknown} cannot be told from others."
    return text


def _unjudged(result: Any) -> str:
    """Shafts of which an error could not be judged, in words; "" if there are none."""
    names = (it.shaft for it in result.shaft_errors if math.isnan(it.p_value))
    return " and the ".join(dict.fromkeys(names))


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.3g} degrees"


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
    line = readings.line[known[far + 1]]
    if wraps(readings.input[known]) and steps[far] > _CLOSE_TO_HALF_A_TURN:
        yield (
            f"the input moves by {math.degrees(steps[far]):.0f} degrees up to line {line}: its "
            "turns may be miscounted; take samples at smaller steps"
        )
    elif steps[far] > TURN:
        yield (
            f"the input jumps by {steps[far] / TURN:.3g} turns up to line {line}: its counter may "
            "start again there; give angles that go on counting"
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
    # where the verdict cannot say, it names the other doubts itself
    for cause in _causes(result):
        if cause.doubt and result.verdict.good is False:
            yield f"{cause.text}, or is {cause.doubt}"
    if unknown := _unjudged(result):
        yield (
            f"errors that repeat with the {unknown} are not judged: either the readings do not "
            "cover a whole turn, or they cannot separate these errors from others"
        )
    if result.periodogram.samples < result.errors.size:
        yield f"the periodogram covers the first {result.periodogram.turns:.0f} turns"
