"""The verdict on a measurement, and warnings that a user of its figures must know.

The null hypothesis is that this mechanism was turned, and that its errors are independent noise of
the encoders. The verdict is "not good" where a test contradicts this with certainty, "cannot say"
where the readings are too few, too noisy or too much alike for the tests, or where a test is near
its limit, and "good" where all tests were possible and passed.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from escapement.base.lazy import Lazy
from escapement.measurement.estimate import SURE, Verdict
from escapement.measurement.findings import DOUBT_PARTS, Glitch, Key, interval
from escapement.measurement.positions import fit_zeros
from escapement.measurement.readings import TURN, wraps

special = Lazy("scipy.special")
_NOISE, _ROUNDING = "noise", "the rounding of the encoders"
_CORRELATED = "noise with correlated neighbours"
_NAMED = 3  # lines of readings far out that are named
_TINY = 5e-324  # it stands for a p-value that is too small for a double
_ALIKE = 0.05  # a smaller correlation of neighbouring errors hardly changes a p-value
_CLOSE_TO_HALF_A_TURN = 0.8 * math.pi
_MUCH = 0.25  # errors above this share of a step mean that the mechanism is another one
_SMALL = 0.05  # errors of this share of a step leave a pin no way into its slot
_CELLS = 2  # an error that repeats must be seen twice before it can be told from others
_DETECTED = 5.0  # standard errors of an error that is seen nineteen times in twenty
_UNITS = {"turn": 360.0, "rad": 180.0 / math.pi}
"""Degrees in a unit that angles may be in when they are taken for degrees."""


class Cause(NamedTuple):
    """A cause of errors that independent noise seldom shows.

    text : words for it.
    doubt : what else it may be, "" if it is certain.
    effect : its greatest error as a share of what still leaves this mechanism possible [-].
    """

    text: str
    doubt: str
    effect: float = 0.0


def verdict_on(result: Any) -> Verdict:
    """The verdict on a `Measurement`, from the first test with a reason."""
    causes = [*_causes(result)]
    lacking = "" if result.backlash else " It turned one way only, so backlash cannot be seen."
    certain = [cause.text for cause in causes if not cause.doubt]
    tests = (
        (False, "Not this mechanism", _other_mechanism(result, causes),
         "Check the mechanism, which column is the input, and the unit of the angles."),
        (None, "Cannot say", _too_short(result),
         "Turn it further, or check the unit of the angles and the columns."),
        (False, "Not good", certain, ""),
        (None, "Cannot say", [*_doubts(result, causes)], ""),
    )  # fmt: skip
    for good, head, reasons, remedy in tests:
        if reasons:
            hint = " " + (_other_reading(result) or remedy) if remedy else lacking
            return Verdict(good, f"{head}: {'; '.join(reasons)}.{hint}")
    return Verdict(True, _good(result) + lacking)


def _causes(result: Any) -> Iterator[Cause]:
    """The causes of errors that a measurement shows.

    Errors of a shaft or a slot may be twice as large as those of a cell, which are of the shape by
    which a mechanism is recognised. A slip has no limit.
    """
    small, through = _SMALL * abs(result.mechanism.follower_step), _through(result)
    rooms = {"cell": small, "input": 2.0 * small / through if through else 0.0}
    listed: list[tuple[Any, Key, float, float]] = [
        (wave, (wave.shaft, wave.order), SURE, wave.amplitude) for wave in result.shaft_errors
    ]
    listed += [
        (part, (part.shaft, "parts"), DOUBT_PARTS, abs(part.size)) for part in result.slot_errors
    ]
    listed += [(play, (play.shaft, "lag"), SURE, 0.0) for play in result.backlash]
    listed += [(one, ("change", one.line), math.inf, 0.0) for one in result.changes]
    for found, key, level, size in listed:
        if found.p_value < level:
            doubt = _doubt(result, found.p_value, key)
            room = rooms.get(found.shaft, 2.0 * small) or math.inf
            yield Cause(found.text, doubt, size / room)
    for doubt in ("", _NOISE):
        if some := [one for one in result.glitches if (one.p_value >= SURE) == bool(doubt)]:
            yield Cause(_far_out(some), doubt)
    if result.fit.phase_error == 0.0:
        # the zeros of the encoders are known, so that the mean error tells something
        error = result.standard_deviation / math.sqrt(result.errors.size)
        p_value = math.erfc(abs(result.mean) / error / math.sqrt(2.0))
        if p_value < SURE:
            alike = _chance(p_value, result.autocorrelation) >= SURE
            words = f"the mean error is {interval(result.mean, error)} with the zeros given"
            yield Cause(words, _CORRELATED * alike)


def _far_out(some: list[Glitch]) -> str:
    """Readings far out, in one sentence."""
    lines, rest = [str(one.line) for one in some], len(some) - _NAMED
    named = f"line{'s' * (len(lines) > 1)} {', '.join(lines[:_NAMED])}"
    named += f" and {rest} more" if rest > 0 else ""
    size = f"{'up to ' * (len(lines) > 1)}{_deg(max(abs(one.size) for one in some))}"
    return f"the reading in {named} is off by {size}"


def _doubt(result: Any, p_value: float, key: Key) -> str:
    """What else an error may be, "" if nothing."""
    if key in result.rounded:
        return _ROUNDING
    if _chance(p_value, result.rest_autocorrelation) >= SURE:
        return _CORRELATED if p_value < SURE else _NOISE
    return ""


def _chance(p_value: float, correlation: float) -> float:
    """The p-value of an F test, corrected for correlated noise."""
    # In the fit of a slow wave, n errors with correlation r count as n (1 - r)/(1 + r) independent
    # ones. In an F test with two degrees of freedom p is then raised to that share.
    worth = (1.0 - correlation) / (1.0 + correlation) if correlation > 0.0 else 1.0
    return float(max(p_value, _TINY) ** worth)


def _other_mechanism(result: Any, causes: list[Cause]) -> list[str]:
    """Why the readings are not those of this mechanism."""
    step, cells = abs(result.mechanism.follower_step), _cells(result)
    if cells > 1.0 and np.ptp(result.output) < min(0.5 * step, result.spread):
        return [
            f"the output moves by {_deg(np.ptp(result.output))} in all while the input turns "
            f"through {cells:.3g} cells"
        ]
    alike = _unexplained(result) < SURE
    # where something remains unexplained, so may be what was found
    size = result.spread if alike else result.scatter
    great = f"large against the follower's step of {_deg(step)}"
    if cells > _MUCH and size > (_SMALL if alike else _MUCH) * step:
        words = f", and neighbours are alike (correlation {result.autocorrelation:.2f})"
        return [f"errors of {_deg(size)} are {great}{words * alike}"]
    some = [cause.text for cause in causes if not cause.doubt and cause.effect > 1.0]
    return [f"{text}, which is {great}" for text in some[:1]]


def _too_short(result: Any) -> list[str]:
    """Why the shafts did not move far enough to judge anything."""
    mechanism = result.mechanism
    # the cells count as whole if one mean step after the last sample completes them
    if _cells(result) >= _CELLS * (1.0 - 1e-9) * (result.errors.size - 1) / result.errors.size:
        return []
    return [
        f"the input moved by {_deg(np.ptp(result.input))} and the output by "
        f"{_deg(np.ptp(result.output))}, but errors can be told from noise only over {_CELLS} "
        f"whole cells, {_deg(_CELLS * mechanism.cell_angle)} of the input and "
        f"{_deg(_CELLS * abs(mechanism.follower_step))} of the output"
    ]


def _doubts(result: Any, causes: list[Cause]) -> Iterator[str]:
    """What keeps a mechanism from being called good although nothing is certain."""
    step = abs(result.mechanism.follower_step)
    yield from (f"perhaps {one.text}, or this is {one.doubt}" for one in causes if one.doubt)
    if any(cause.doubt == _ROUNDING for cause in causes):
        yield (
            f"errors below half a step of the encoders ({_deg(0.5 * max(result.steps))}) cannot "
            "be told from their rounding, which repeats where positions do: stop at other "
            "positions in every turn, or, if you do so already, use finer encoders"
        )
    if _unexplained(result) < SURE:
        yield (
            f"neighbouring errors are alike (correlation {result.rest_autocorrelation:.2f}), which "
            "neither independent noise nor any error that was looked for explains"
        )
    if result.scatter > _SMALL * step:
        yield (
            f"the errors scatter by {_deg(result.scatter)}, which is much for steps of {_deg(step)}"
        )


def _other_reading(result: Any) -> str:
    """What to try where the angles would fit this mechanism if read otherwise, else "".

    Tried are other units, and the columns exchanged.
    """
    columns = np.array([result.input, result.output])
    tries = {unit: size * columns for unit, size in _UNITS.items()} | {"": columns[::-1]}
    step = abs(result.mechanism.follower_step)
    least = _CELLS * result.mechanism.cell_angle * (result.errors.size - 1) / result.errors.size
    for unit, (angle, output) in tries.items():
        if np.ptp(angle) < 0.999 * least or np.ptp(output) < 0.5 * min(_CELLS * step, TURN):
            continue
        error = float(fit_zeros(result.mechanism, angle, output).errors.std())
        if error < _SMALL * step:
            how = f"Read in the unit {unit}" if unit else "With input and output exchanged"
            hint = f": give --angle-unit {unit}, in Python angle_unit={unit!r}" * bool(unit)
            return f"{how}, the angles fit this mechanism within {_deg(error)}{hint}."
    return ""


def _good(result: Any) -> str:
    """What was looked for and not found, and how small it might have been."""
    least = _DETECTED * result.scatter * math.sqrt(2.0 / result.errors.size)
    text = (
        "Good: the errors are noise without an error of a shaft or of a slot, without a change for "
        f"good and without a reading far out, and scatter by {_deg(result.standard_deviation)}"
    )
    if result.sensor_share:
        alone = math.degrees(result.sensor_share.standard)
        text += f", where the encoders alone explain {alone:.3g}"
    text += (
        f". An error of the output of {_deg(max(least, result.hidden))} that repeats would have "
        "been seen."
    )
    if unknown := _unjudged(result):
        text += f" Errors that repeat with the {unknown} cannot be told from others."
    return text


def _through(result: Any) -> float:
    """Root mean square of the transmission [-]."""
    return math.sqrt(float(np.mean(result.fit.slope**2)))


def _cells(result: Any) -> float:
    """Cells between the least and the greatest input."""
    return float(np.ptp(result.input)) / float(result.mechanism.cell_angle)


def _unexplained(result: Any) -> float:
    """Probability that independent noise, read by these encoders, makes neighbours so alike."""
    # rounding and linearity may make neighbours alike, as far as they explain the variance
    share = 0.0
    if result.scatter > 0.0:
        explained = math.hypot(result.steps[1], _through(result) * result.steps[0]) / math.sqrt(
            12.0
        )
        if result.sensor_share:
            explained = result.sensor_share.standard
        share = min(1.0, (explained / result.scatter) ** 2)
    excess = result.rest_autocorrelation - share
    return float(special.ndtr(-excess * math.sqrt(result.errors.size)))


def _unjudged(result: Any) -> str:
    """Shafts of which an error could not be judged, in words; "" if there are none."""
    names = (it.shaft for it in result.shaft_errors if math.isnan(it.p_value))
    return " and the ".join(dict.fromkeys(names))


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.3g} degrees"


def remarks_on(result: Any) -> Iterator[str]:
    """Warnings for the user, the most serious first."""
    yield from result.readings.remarks
    if not math.isfinite(result.published_test.statistic):
        far = result.errors[np.argmax(np.abs(result.errors - result.mean))]
        yield (
            f"an error of {_deg(far)} is "
            f"{abs(far - result.mean) / result.standard_deviation:.0f} standard deviations from "
            "the mean, where normal errors practically never are: chi_squared_published is infinite"
        )
    if math.isnan(result.fit.phase_error):
        yield "the output turns at a constant ratio in these samples, so they do not show the phase"
    yield from _on_the_input(result.readings)
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
            yield f"perhaps {cause.text}, or this is {cause.doubt}"
    if unknown := _unjudged(result):
        yield (
            f"errors that repeat with the {unknown} are not judged: either the readings do not "
            "cover a whole turn, or they cannot separate these errors from others"
        )
    if result.periodogram.samples < result.errors.size:
        yield f"the periodogram covers the first {result.periodogram.turns:.0f} turns"


def _on_the_input(readings: Any) -> Iterator[str]:
    """Warnings about turns of the input that may be miscounted."""
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
