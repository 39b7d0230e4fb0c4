"""What a fit of beats says about the parts: estimates, intervals, and what stays unknown."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from escapement.base.lazy import Lazy
from escapement.measurement.beat_unknowns import Parts
from escapement.measurement.beat_verdict import SURE, alike
from escapement.measurement.rounds import Rounds
from escapement.mechanisms.protocol import FloatArray

special = Lazy("scipy.special")
_STEP = 1e-6  # step of the differences that approximate derivatives by the unknowns


class Combination(NamedTuple):
    """An angle that the beats determine although they do not determine the single errors.

    name : name of the angle.
    value, half_width : estimate, and half the width of its confidence interval [rad].
    """

    name: str
    value: float
    half_width: float


class Doubt(NamedTuple):
    """Uncertainty of the unknowns of a fit.

    computed : beats of one pattern, computed with the unknowns that were found [s].
    root : matrix A such that the interval of a linear combination c of the unknowns has
        half the width |c A|.
    reach : half the width of an interval, in standard deviations [-].
    noise : standard deviation of the noise of a single beat [s].
    p_value : probability that noise alone causes residuals of the mean beats this large [-]; NaN
        if the noise is not known, or if so many unknowns leave no residuals.
    alike : correlation of neighbouring residuals of the beats, made independent [-].
    """

    computed: FloatArray
    root: FloatArray
    reach: float
    noise: float
    p_value: float
    alike: float


class PartEstimate(NamedTuple):
    """The result of a fit.

    pins, slots : estimated angle errors [rad], NaN where they are not determined.
    pin_widths, slot_widths : half the widths of their confidence intervals [rad].
    rate, rate_width : measured over computed time, and half the width of its interval [-], NaN
        where the beats do not determine it.
    combinations : what is determined where single errors are not.
    reason : why single errors are not determined, "" if they are.
    """

    pins: FloatArray
    slots: FloatArray
    pin_widths: FloatArray
    slot_widths: FloatArray
    rate: float
    rate_width: float
    combinations: tuple[Combination, ...] = ()
    reason: str = ""


def doubt_of(
    parts: Parts, unknowns: FloatArray, rounds: Rounds, noise: float | None, confidence: float
) -> Doubt:
    """Uncertainty of the unknowns from the fit linearised at its solution.

    Intervals follow Student's distribution, or the normal one where the noise is given.
    """
    computed = _computed(parts, unknowns)
    left = float(np.sum((rounds.root @ (rounds.means - computed)) ** 2))
    freedom, judged = rounds.samples - unknowns.size, rounds.pattern - unknowns.size
    within, p_value = rounds.samples - rounds.pattern, math.nan
    if noise is None:
        sigma = math.sqrt((left + rounds.scatter) / freedom)
        reach = float(special.stdtrit(freedom, 0.5 + 0.5 * confidence))
        if judged > 0 and within > 0 and rounds.scatter > 0.0:
            share = (left / judged) / (rounds.scatter / within)
            p_value = float(special.fdtrc(judged, within, share))
    else:
        sigma, reach = noise, float(special.ndtri(0.5 + 0.5 * confidence))
        if judged > 0:
            p_value = float(special.chdtrc(judged, left / noise**2))
    beside = unknowns + _STEP * np.eye(unknowns.size)
    slopes = np.column_stack([(_computed(parts, one) - computed) / _STEP for one in beside])
    root = np.asarray(reach * sigma * np.linalg.pinv(rounds.root @ slopes))
    rest, near = rounds.white(computed), np.diff(rounds.known) == 1
    correlation = 0.0
    if near.any() and rest.any():
        correlation = float(np.mean((rest[1:] * rest[:-1])[near]) / np.mean(rest**2))
    return Doubt(computed, root, reach, sigma, p_value, correlation)


def _computed(parts: Parts, unknowns: FloatArray) -> FloatArray:
    beats = parts.beats(unknowns)
    assert beats is not None, "a fit ends at a wheel that runs, and so do all close to it"
    return beats


def estimate(parts: Parts, unknowns: FloatArray, root: FloatArray) -> PartEstimate:
    """Errors of single parts, and steps of slots where single errors are not determined.

    An impact shows the step of its slot. Of the slots without an impact the beats show only that
    each step is below its free step, and the sum of these steps. The angle of a slot is therefore
    extreme where all of them except one are as great as possible.
    """
    slots, (pins, steps) = parts.wheel.slots, parts.errors(unknowns)
    pin_widths = np.linalg.norm(parts.pin_delays @ root[1 : parts.impacts.start], axis=1)
    rate, rate_width = float(unknowns[0]), float(np.linalg.norm(root[0]))
    if not parts.others.size:
        return PartEstimate(
            pins=pins, slots=np.zeros(slots), pin_widths=pin_widths, slot_widths=np.zeros(slots),
            rate=rate, rate_width=rate_width,
        )  # fmt: skip
    limit, delays, slot_roots = np.zeros(slots), np.zeros(slots), np.zeros((slots, root.shape[1]))
    delays[parts.others], limit[parts.others] = (
        unknowns[parts.impacts],
        _lengths(root[parts.impacts]),
    )
    slot_roots[parts.others] = parts.slope * delays[parts.others, None] * root[parts.impacts]
    # the last slot counts as one without an impact
    unstruck, struck = np.flatnonzero(delays <= limit), np.flatnonzero(delays > limit)
    most = np.where(delays <= limit, parts.free + 0.5 * parts.slope * (delays + limit) ** 2, steps)
    gather = np.tril(np.ones((slots, slots)))
    gather -= gather.mean(axis=0)
    low, high = np.full(slots, math.inf), np.full(slots, -math.inf)
    for slot in unstruck:
        # here all other steps are as great as possible, and this one follows from their sum
        weights = gather - gather[:, [slot]]
        width = _lengths(weights[:, struck] @ slot_roots[struck])
        low = np.minimum(low, weights @ most - width)
        high = np.maximum(high, weights @ most + width)
    found = PartEstimate(
        pins=pins, slots=0.5 * (low + high), pin_widths=pin_widths, slot_widths=0.5 * (high - low),
        rate=rate, rate_width=rate_width,
    )  # fmt: skip
    if unstruck.size == 1:
        return found
    names = (f"slot {i} less slot {(i - 1) % slots}" for i in struck)
    rows = zip(names, steps[struck].tolist(), _lengths(slot_roots[struck]).tolist(), strict=True)
    reason = (
        f"no pin strikes slots {', '.join(map(str, unstruck))}: the beats do not show how far each "
        "of them is behind the slot before it, so the intervals of the slots are wide"
    )
    return found._replace(combinations=tuple(Combination(*row) for row in rows), reason=reason)


def _lengths(rows: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(rows, axis=1))


def spanned(solutions: list[PartEstimate], joined: bool) -> PartEstimate:
    """One result whose intervals cover those of all solutions, which fit equally well.

    If they are joined, sets of errors between them fit as well and no interval holds.
    """
    if len(solutions) == 1:
        return solutions[0]
    pins, slots, rate = (
        _span([(getattr(one, value), getattr(one, width)) for one in solutions])
        for value, width in (
            ("pins", "pin_widths"), ("slots", "slot_widths"), ("rate", "rate_width"),
        )
    )  # fmt: skip
    if joined:
        reason = (
            "very different sets of errors, and those between them, explain the beats equally "
            "well, so that the beats determine none; measure longer"
        )
        return _unknown(solutions[0].pins.size, solutions[0].slots.size, reason)
    reasons = dict.fromkeys(one.reason for one in solutions if one.reason)
    reason = (
        f"{len(solutions)} sets of errors explain the beats equally well: each interval covers "
        "all of them, and each estimate is the middle of its interval"
    )
    return PartEstimate(
        pins=pins[0], slots=slots[0], pin_widths=pins[1], slot_widths=slots[1],
        rate=float(rate[0]), rate_width=float(rate[1]), reason="; ".join((reason, *reasons)),
    )  # fmt: skip


def _unknown(pins: int, slots: int, reason: str) -> PartEstimate:
    """The result where the beats determine no part."""
    of_pins, of_slots = np.full(pins, math.nan), np.full(slots, math.nan)
    return PartEstimate(
        pins=of_pins, slots=of_slots, pin_widths=of_pins, slot_widths=of_slots,
        rate=math.nan, rate_width=math.nan, reason=reason,
    )  # fmt: skip


def _span(intervals: list[tuple[FloatArray, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    """Middle and half the width of the smallest interval that contains all given ones."""
    low = np.min([middle - half for middle, half in intervals], axis=0)
    high = np.max([middle + half for middle, half in intervals], axis=0)
    return 0.5 * (low + high), 0.5 * (high - low)


def joint_estimate(parts: Parts, rounds: Rounds, doubt: Doubt) -> PartEstimate:
    """The result where each pin meets only some slots.

    An error of a pin and one of its slots then change the same beats, so only the sum of both
    is determined for each pair.
    """
    pins, slots = parts.wheel.pins or 1, parts.wheel.slots
    mean = rounds.means.mean()
    speed = parts.wheel.cell_angle / mean
    widths = doubt.reach * doubt.noise * rounds.spread
    found = (
        Combination(f"pin {k % pins} in slot {k % slots}", float(value), float(width))
        for k, (value, width) in enumerate(
            zip(speed * (rounds.means - mean), speed * widths, strict=True)
        )
    )
    reason = (
        f"each of {pins} pins meets only {slots // math.gcd(pins, slots)} of {slots} slots, so "
        "the beats cannot separate errors of pins from errors of slots: combinations gives for "
        "each pair the angle by which it drives longer than the mean; if the pins are known to "
        "be good, use parts='slots', if the slots are, use parts='pins'"
    )
    return _unknown(pins, slots, reason)._replace(combinations=tuple(found))


def without(known: PartEstimate, parts: Parts, curved: np.ndarray) -> PartEstimate:
    """The result without what belongs to unknowns whose intervals do not hold: bool, shape (m,)."""
    pins, slots = curved[1 : parts.impacts.start].any(), curved[parts.impacts].any()
    return _left_out(
        known, np.full(known.pins.size, pins), np.full(known.slots.size, slots), bool(curved[0]),
        "their intervals would not hold, because beats are no straight function of them within the "
        "noise; measure longer",
    )  # fmt: skip


def within_range(known: PartEstimate, parts: Parts) -> PartEstimate:
    """The result without errors whose intervals leave the range in which the wheel runs."""
    of_slots, of_pins = parts.range
    pins, slots = (
        np.abs(value) + half > limit
        for value, half, limit in (
            (known.pins, known.pin_widths, of_pins), (known.slots, known.slot_widths, of_slots),
        )
    )  # fmt: skip
    reason = "they may be so great that the wheel would not run; measure longer"
    return _left_out(known, pins, slots, False, reason)


def _left_out(
    known: PartEstimate, pins: np.ndarray, slots: np.ndarray, rate: bool, reason: str
) -> PartEstimate:
    names = [
        f"{part}s {', '.join(map(str, np.flatnonzero(numbers)))}"
        for part, numbers in (("pin", pins), ("slot", slots))
        if numbers.any()
    ] + ["the rate"] * rate
    if not names:
        return known
    sentence = f"the beats do not determine {' and '.join(names)}: {reason}"
    return known._replace(
        pins=np.where(pins, math.nan, known.pins),
        pin_widths=np.where(pins, math.nan, known.pin_widths),
        slots=np.where(slots, math.nan, known.slots),
        slot_widths=np.where(slots, math.nan, known.slot_widths),
        rate=math.nan if rate else known.rate,
        rate_width=math.nan if rate else known.rate_width,
        reason="; ".join(filter(None, (known.reason, sentence))),
    )


def remarks(known: PartEstimate, doubt: Doubt, rounds: Rounds) -> Iterator[str]:
    """What a user of the fit must know, one sentence at a time."""
    yield from rounds.faults
    if known.reason:
        yield known.reason
    if doubt.root.shape[1] <= doubt.root.shape[0] and np.isfinite(known.slots).all():
        yield (
            "there are as many unknowns as pairs of a pin and a slot, so other sets of errors may "
            "explain the beats equally well; the intervals hold only near the set that was found"
        )
    if doubt.p_value < SURE:
        yield (
            f"the residuals are greater than the noise explains (p {doubt.p_value:.1g}): something "
            "besides these angles differs from the design, for example the friction, a length or "
            "the centre distance"
        )
    if alike(doubt.alike, rounds.samples):
        yield (
            f"neighbouring residuals are alike (correlation {doubt.alike:.2f}), but the intervals "
            "assume that the noise of each beat is independent: do not trust their widths"
        )
