"""The verdict on a fit of beats: whether errors of the parts explain them, and which parts err.

It is "no" where the residuals contradict the model, "cannot say" where the beats are too few to
contradict it or do not determine the parts, and "yes" where both were possible and passed.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from escapement.measurement.verdict import Verdict

SURE = 1e-3
"""Noise alone causes a smaller p-value in less than one of a thousand fits."""
_ALIKE = 0.1  # a smaller correlation of neighbouring residuals hardly changes an interval


def alike(correlation: float, samples: int) -> bool:
    """Whether neighbouring residuals are more alike than independent noise makes them."""
    return abs(correlation) > max(_ALIKE, 4.0 / math.sqrt(samples))


def verdict_on(fit: Any) -> Verdict:
    """The verdict on a `BeatFit`."""
    if wrong := [*_contradictions(fit)]:
        return Verdict(
            False, f"Angle errors of the parts do not explain the beats: {'; '.join(wrong)}."
        )
    if doubts := [*_doubts(fit)]:
        return Verdict(
            None, f"Cannot say whether angle errors of the parts explain the beats: {doubts[0]}."
        )
    return Verdict(True, f"Angle errors of the parts explain the beats. {_found(fit)}")


def _contradictions(fit: Any) -> Iterator[str]:
    """What in the residuals noise does not cause."""
    if fit.p_value < SURE:
        yield f"the residuals are greater than the noise explains (p {fit.p_value:.1g})"
    if alike(fit.autocorrelation, fit.rounds.samples):
        yield f"neighbouring residuals are alike (correlation {fit.autocorrelation:.2f})"


def _doubts(fit: Any) -> Iterator[str]:
    """Why the beats could not contradict the parts that were found, or do not determine them."""
    if not np.isfinite([*fit.pin_angle_errors, *fit.slot_angle_errors, fit.rate]).all():
        yield "they do not determine all of these errors; the message says which, and why"
    if math.isnan(fit.p_value):
        if fit.unknowns >= fit.rounds.pattern:
            yield (
                f"{fit.unknowns} unknowns can explain any beats of {fit.rounds.pattern} pairs of "
                "a pin and a slot; if either kind of part is good, fit the other one alone"
            )
        else:
            yield (
                "no pair of a pin and a slot was measured twice, so that the noise is not known; "
                "measure longer, or give the noise"
            )


def _found(fit: Any) -> str:
    """The parts that are certainly in error, and the rate."""
    level, shown = f"{100.0 * fit.confidence:g} %", []
    for name, sizes, halves in (
        ("pin", fit.pin_angle_errors, fit.pin_half_widths),
        ("slot", fit.slot_angle_errors, fit.slot_half_widths),
    ):
        low, high = np.degrees(sizes - halves), np.degrees(sizes + halves)
        shown += [
            f"{name} {k} ({low[k]:.3g} to {high[k]:.3g} degrees)"
            for k in np.flatnonzero((low > 0.0) | (high < 0.0))
        ]
    parts = ", ".join(shown) if shown else "no part"
    ends = fit.rate - fit.rate_half_width, fit.rate + fit.rate_half_width
    return (
        f"Their {level} intervals leave out zero for {parts}. The beats take {ends[0]:.5g} to "
        f"{ends[1]:.5g} times as long as those of the design."
    )
