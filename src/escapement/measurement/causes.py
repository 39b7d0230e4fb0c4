"""The causes of errors that readings show, in words, and what else each of them may be."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from escapement.measurement.changes import Change
from escapement.measurement.error_columns import Key
from escapement.measurement.glitches import Glitch
from escapement.measurement.shaft_errors import (
    DOUBT_PARTS,
    SURE,
    backlash_text,
    chance,
    interval,
)
from escapement.measurement.slot_errors import SlotError

_NOISE, ROUNDING = "noise", "the rounding of the encoders"
_ALIKE = "noise with correlated neighbours"
_NAMED = 3  # lines of readings far out that are named


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
    for found in result.shaft_errors:
        if found.p_value < SURE:
            doubt = _doubt(result, found, (found.shaft, found.order))
            effect = found.amplitude * (through if found.shaft == "input" else 1.0)
            room = small if found.shaft == "cell" else 2.0 * small
            yield Cause(found.text(not doubt), doubt, effect / room)
    for slot in result.slot_errors:
        if slot.p_value < DOUBT_PARTS:
            doubt = _doubt(result, slot, (slot.shaft, "parts"))
            effect = abs(slot.size) * (through if slot.shaft == "input" else 1.0)
            yield Cause(_slot_text(slot, not doubt), doubt, 0.5 * effect / small)
    for backlash in result.backlash:
        if backlash.p_value < SURE:
            doubt = _doubt(result, backlash, (backlash.shaft, "lag"))
            yield Cause(backlash_text(backlash, not doubt), doubt)
    for change in result.changes:
        doubt = _doubt(result, change, ("change", change.line))
        verb = "change" if not doubt else "may change"
        yield Cause(
            f"the errors {verb} for good behind line {change.line}, as if the {change.shaft} had "
            f"slipped by {_size_text(change)}",
            doubt,
        )
    yield from _far_out(result.glitches)
    if result.fit.phase_error == 0.0:
        yield from _mean(result)


def _far_out(glitches: tuple[Glitch, ...]) -> Iterator[Cause]:
    """Readings far out, in one sentence for those that are certain and one for the others."""
    for certain in (True, False):
        some = [one for one in glitches if (one.p_value < SURE) == certain]
        if not some:
            continue
        lines = [str(one.line) for one in some]
        rest = len(lines) - _NAMED
        named = f"lines {', '.join(lines[:_NAMED])}" if len(lines) > 1 else f"line {lines[0]}"
        named += f" and {rest} more" if rest > 0 else ""
        verb = "is" if certain else "may be"
        size = math.degrees(max(abs(one.size) for one in some))
        off = f"off by {'up to ' if len(lines) > 1 else ''}{size:.3g} degrees"
        yield Cause(f"the reading in {named} {verb} {off}", "" if certain else _NOISE)


def _mean(result: Any) -> Iterator[Cause]:
    """The mean error where the zeros of the encoders are known."""
    error = result.standard_deviation / math.sqrt(result.errors.size)
    p_value = math.erfc(abs(result.mean) / error / math.sqrt(2.0))
    if p_value < SURE:
        size = interval(abs(result.mean), error)
        alike = chance(p_value, result.autocorrelation) >= SURE
        verb, doubt = ("may be", _ALIKE) if alike else ("is", "")
        yield Cause(f"the mean error {verb} {size} with the zeros given", doubt)


def _size_text(change: Change) -> str:
    if math.isnan(change.size):
        return "an angle that cannot be told"
    return interval(abs(change.size), change.standard_error)


def _slot_text(slot: SlotError, certain: bool) -> str:
    part = "pin" if slot.shaft == "input" else "slot"
    verb = "is" if certain else "may be"
    direction = "ahead of" if slot.size > 0.0 else "behind"
    if math.isnan(slot.size):
        return f"{part} {slot.number} of {slot.parts} {verb} in error, by an angle that is hidden"
    return (
        f"{part} {slot.number} of {slot.parts}, counted from the one at the first sample, {verb} "
        f"{direction} the others by {interval(abs(slot.size), slot.standard_error)}"
    )


def _doubt(result: Any, found: Any, key: Key) -> str:
    """What else an error may be, "" if nothing."""
    if key in result.rounded:
        return ROUNDING
    if chance(found.p_value, result.rest_autocorrelation) >= SURE:
        return _ALIKE if found.p_value < SURE else _NOISE
    return ""


def encoders_explain(result: Any) -> float:
    """Standard deviation of errors that the encoders alone cause, as far as is known [rad]."""
    if result.sensor_share:
        return float(result.sensor_share.standard)
    through = math.sqrt(float(np.mean(result.fit.slope**2)))
    return math.hypot(result.steps[1], through * result.steps[0]) / math.sqrt(12.0)
