"""The causes of errors that readings show, in words, and what else each of them may be."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from escapement.measurement.estimate import SURE
from escapement.measurement.findings import DOUBT_PARTS, Glitch, Key, interval

_NOISE, ROUNDING = "noise", "the rounding of the encoders"
_ALIKE = "noise with correlated neighbours"
_NAMED = 3  # lines of readings far out that are named
_LEAST = 5e-324  # it stands for a p-value that is too small for a double


class Cause(NamedTuple):
    """A cause of errors that independent noise seldom shows.

    text : words for it.
    doubt : what else it may be, "" if it is certain.
    effect : its greatest error as a share of what still leaves this mechanism possible [-].
    """

    text: str
    doubt: str
    effect: float = 0.0

    @property
    def certain(self) -> bool:
        """Whether the readings show it with certainty."""
        return not self.doubt


def causes_of(result: Any, small: float) -> Iterator[Cause]:
    """The causes that a `Measurement` shows; `small` is an error that a mechanism may have [rad].

    Errors of a shaft or a slot may be twice as large, those of a cell may not: they are of the
    shape by which a mechanism is recognised. A slip has no limit.
    """
    through = math.sqrt(float(np.mean(result.fit.slope**2)))
    listed: list[tuple[Any, Key, float, float]] = []
    for wave in result.shaft_errors:
        room = small if wave.shaft == "cell" else 2.0 * small
        listed.append((wave, (wave.shaft, wave.order), SURE, wave.amplitude / room))
    listed += [
        (part, (part.shaft, "parts"), DOUBT_PARTS, 0.5 * abs(part.size) / small)
        for part in result.slot_errors
    ]
    listed += [(play, (play.shaft, "lag"), SURE, 0.0) for play in result.backlash]
    listed += [(one, ("change", one.line), math.inf, 0.0) for one in result.changes]
    for found, key, level, effect in listed:
        if found.p_value < level:
            doubt = _doubt(result, found.p_value, key)
            size = effect * (through if found.shaft == "input" else 1.0)
            yield Cause(found.text(not doubt), doubt, size)
    yield from _far_out(result.glitches)
    if result.fit.phase_error == 0.0:
        yield from _mean(result)


def _far_out(glitches: tuple[Glitch, ...]) -> Iterator[Cause]:
    """Readings far out, in one sentence for those that are certain and one for the others."""
    for certain in (True, False):
        some = [one for one in glitches if (one.p_value < SURE) == certain]
        if not some:
            continue
        lines, rest = [str(one.line) for one in some], len(some) - _NAMED
        named = f"lines {', '.join(lines[:_NAMED])}" if len(lines) > 1 else f"line {lines[0]}"
        named += f" and {rest} more" if rest > 0 else ""
        size = math.degrees(max(abs(one.size) for one in some))
        off = f"off by {'up to ' if len(lines) > 1 else ''}{size:.3g} degrees"
        verb = "is" if certain else "may be"
        yield Cause(f"the reading in {named} {verb} {off}", "" if certain else _NOISE)


def _mean(result: Any) -> Iterator[Cause]:
    """The mean error where the zeros of the encoders are known."""
    error = result.standard_deviation / math.sqrt(result.errors.size)
    p_value = math.erfc(abs(result.mean) / error / math.sqrt(2.0))
    if p_value < SURE:
        alike = chance(p_value, result.autocorrelation) >= SURE
        verb, doubt = ("may be", _ALIKE) if alike else ("is", "")
        yield Cause(
            f"the mean error {verb} {interval(result.mean, error)} with the zeros given", doubt
        )


def _doubt(result: Any, p_value: float, key: Key) -> str:
    """What else an error may be, "" if nothing."""
    if key in result.rounded:
        return ROUNDING
    if chance(p_value, result.rest_autocorrelation) >= SURE:
        return _ALIKE if p_value < SURE else _NOISE
    return ""


def chance(p_value: float, correlation: float) -> float:
    """The p-value of an F test, corrected for correlated noise."""
    # In the fit of a slow wave, n errors with correlation r count as n (1 - r)/(1 + r) independent
    # ones. In an F test with two degrees of freedom p is then raised to that share.
    worth = (1.0 - correlation) / (1.0 + correlation) if correlation > 0.0 else 1.0
    return float(max(p_value, _LEAST) ** worth)
