"""What a fit of beats says about each part: its error, the interval, or why it is not known."""

import math
from collections.abc import Iterator
from itertools import combinations, groupby
from typing import NamedTuple

import numpy as np

from escapement.base.lazy import Lazy
from escapement.measurement.beat_unknowns import Parts
from escapement.measurement.estimate import (
    Estimate,
    between,
    interval_root,
    reach_of,
    spanned,
)
from escapement.measurement.rounds import Rounds
from escapement.mechanisms.protocol import FloatArray

special = Lazy("scipy.special")
_STEP = 1e-6  # step of the differences that approximate derivatives by the unknowns
_RISE = 0.5  # the sum of squares rises at the end of an interval by this share of what it should
_CURVED = (
    "their intervals would not hold, because beats are no straight function of them within the "
    "noise; measure longer"
)
_JOINED = (
    "very different sets of errors, and those between them, explain the beats equally well; "
    "measure longer"
)
_TOO_GREAT = "they may be so great that the wheel would not run; measure longer"


class BeatSolution(NamedTuple):
    """Unknowns that make the sum of squares least, with one of the slots as the last one."""

    parts: Parts
    unknowns: FloatArray
    cost: float


class Uncertainty(NamedTuple):
    """How surely the unknowns are known, from the fit linearised at its solution.

    computed : beats of one pattern [s].
    root : matrix of `interval_root`.
    unit : half the width of an interval of a beat: noise times reach [s].
    noise : standard deviation of the noise of a single beat [s].
    p_value : probability that noise alone causes residuals of the mean beats this large [-]; NaN
        if the noise is not known, or if so many unknowns leave no residuals.
    """

    computed: FloatArray
    root: FloatArray
    unit: float
    noise: float
    p_value: float


def uncertainty_of(
    at: BeatSolution, rounds: Rounds, noise: float | None, confidence: float
) -> Uncertainty:
    """Uncertainty of a solution; intervals follow Student's law unless the noise is given."""

    def computed(unknowns: FloatArray) -> FloatArray:
        beats = at.parts.beats(unknowns)
        assert beats is not None, "a fit ends at a wheel that runs, and so do all close to it"
        return beats

    beats, size = computed(at.unknowns), at.unknowns.size
    left = float(np.sum((rounds.root @ (rounds.means - beats)) ** 2))
    judged, within, p_value = rounds.pattern - size, rounds.samples - rounds.pattern, math.nan
    freedom = math.inf if noise is not None else rounds.samples - size
    if noise is not None:
        p_value = float(special.chdtrc(judged, left / noise**2)) if judged > 0 else math.nan
    elif judged > 0 and within > 0 and rounds.scatter > 0.0:
        share = (left / judged) / (rounds.scatter / within)
        p_value = float(special.fdtrc(judged, within, share))
    sigma = noise or math.sqrt((left + rounds.scatter) / freedom)
    steps = at.unknowns + _STEP * np.eye(size)
    slopes = np.column_stack([(computed(one) - beats) / _STEP for one in steps])
    reach = reach_of(confidence, freedom)
    root = interval_root(rounds.root @ slopes, sigma, reach)
    return Uncertainty(beats, root, reach * sigma, sigma, p_value)


def estimates_of(at: BeatSolution, rounds: Rounds, known: Uncertainty) -> list[Estimate]:
    """The rate, then all pins, then all slots, of one solution."""
    parts, unknowns, root = at.parts, at.unknowns, known.root
    curved = _curved(at, rounds, known)
    pin_slice = slice(1, parts.impacts.start)
    pins = parts.errors(unknowns).pins.tolist()
    widths = _lengths(parts.pin_delays @ root[pin_slice]).tolist()
    found = [Estimate("rate", float(unknowns[0]), float(np.linalg.norm(root[0])))]
    found += [Estimate(f"pin {k}", *one) for k, one in enumerate(zip(pins, widths, strict=True))]
    found += _slots(parts, unknowns, root)
    doubtful = {
        "rate": curved[0],
        "pin": curved[pin_slice].any(),
        "slot": curved[parts.impacts].any(),
    }
    return [one.doubted(_CURVED) if doubtful[one.name.split()[0]] else one for one in found]


def _slots(parts: Parts, unknowns: FloatArray, root: FloatArray) -> Iterator[Estimate]:
    """Errors of the slots.

    An impact shows the step of its slot. Of the slots without an impact the beats show only that
    each step is below its free step, and the sum of these steps. The angle of a slot is therefore
    extreme where all of them except one are as great as possible.
    """
    slots = parts.wheel.slots
    low, high = np.full(slots, math.inf), np.full(slots, -math.inf)
    if not parts.others.size:
        low = high = np.zeros(slots)
    struck, most, slot_roots = _steps(parts, unknowns, root)
    gather = np.tril(np.ones((slots, slots)))
    gather -= gather.mean(axis=0)
    for slot in np.flatnonzero(~struck) if parts.others.size else ():
        # here all other steps are as great as possible, and this one follows from their sum
        weights = gather - gather[:, [slot]]
        width = _lengths(weights[:, struck] @ slot_roots[struck])
        low = np.minimum(low, weights @ most - width)
        high = np.maximum(high, weights @ most + width)
    for k, ends in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
        yield between(f"slot {k}", *ends)


def _steps(
    parts: Parts, unknowns: FloatArray, root: FloatArray
) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """Which slots are struck, the greatest steps of all, and the roots of the struck ones."""
    size = parts.wheel.slots
    delays, limit, roots = np.zeros(size), np.zeros(size), np.zeros((size, root.shape[1]))
    delays[parts.others], limit[parts.others] = (
        unknowns[parts.impacts],
        _lengths(root[parts.impacts]),
    )
    roots[parts.others] = parts.slope * delays[parts.others, None] * root[parts.impacts]
    # the last slot counts as one without an impact
    struck = delays > limit
    greatest = parts.free + 0.5 * parts.slope * (delays + limit) ** 2
    return struck, np.where(struck, parts.errors(unknowns).steps, greatest), roots


def steps_of(at: BeatSolution, known: Uncertainty) -> tuple[tuple[Estimate, ...], str]:
    """Steps from slot to slot that are struck, where others are not, and why; else nothing."""
    parts = at.parts
    if not parts.others.size:
        return (), ""
    struck, most, roots = _steps(parts, at.unknowns, known.root)
    unstruck = np.flatnonzero(~struck)
    if unstruck.size == 1:
        return (), ""
    names = (f"slot {i} less slot {(i - 1) % parts.wheel.slots}" for i in np.flatnonzero(struck))
    rows = zip(names, most[struck].tolist(), _lengths(roots[struck]).tolist(), strict=True)
    reason = (
        f"no pin strikes slots {', '.join(map(str, unstruck))}: the beats do not show how far each "
        "of them is behind the slot before it, so the intervals of the slots are wide"
    )
    return tuple(Estimate(*row) for row in rows), reason


def pairs_of(
    parts: Parts, rounds: Rounds, known: Uncertainty
) -> tuple[list[Estimate], tuple[Estimate, ...]]:
    """The result where each pin meets only some slots: no single part, but the sum of each pair."""
    pins, slots = parts.wheel.pins or 1, parts.wheel.slots
    mean = rounds.means.mean()
    speed = parts.wheel.cell_angle / mean
    rows = zip(
        (speed * (rounds.means - mean)).tolist(), (speed * known.unit * rounds.spread).tolist(),
        strict=True,
    )  # fmt: skip
    pairs = tuple(
        Estimate(f"pin {k % pins} in slot {k % slots}", *row) for k, row in enumerate(rows)
    )
    reason = (
        f"each of {pins} pins meets only {slots // math.gcd(pins, slots)} of {slots} slots, so "
        "the beats cannot separate errors of pins from errors of slots: combinations gives for "
        "each pair the angle by which it drives longer than the mean; if the pins are known to "
        "be good, use parts='slots', if the slots are, use parts='pins'"
    )
    names = ["rate", *(f"pin {k}" for k in range(pins)), *(f"slot {k}" for k in range(slots))]
    return [Estimate(name, math.nan, math.nan, reason) for name in names], pairs


def joined_estimates(
    sets: list[BeatSolution], known: list[Uncertainty], rounds: Rounds, edge: float
) -> tuple[list[Estimate], str]:
    """Estimates whose intervals cover those of all solutions, which fit equally well, and a remark.

    If sets of errors between them fit as well, no interval holds.
    """
    each = [estimates_of(at, rounds, one) for at, one in zip(sets, known, strict=True)]
    found = [spanned(same) for same in zip(*each, strict=True)]
    for one, other in combinations(sets, 2):
        if one.parts.last == other.parts.last:
            middle = 0.5 * (one.unknowns + other.unknowns)
            if 0.5 * _squares(one.parts, middle, rounds) <= edge:
                return [it.doubted(_JOINED) if it.half_width > 0.0 else it for it in found], ""
    several = (
        f"{len(sets)} sets of errors explain the beats equally well: each interval covers all of "
        "them, and each estimate is the middle of its interval"
    )
    return found, several if len(sets) > 1 else ""


def within_range(found: list[Estimate], parts: Parts) -> Iterator[Estimate]:
    """The same without errors whose intervals leave the range in which the wheel runs."""
    limits = dict(zip(("slot", "pin"), parts.range, strict=True))
    for one in found:
        limit = limits.get(one.name.split()[0], math.inf)
        yield one.doubted(_TOO_GREAT) if abs(one.value) + one.half_width > limit else one


def undetermined(found: list[Estimate]) -> Iterator[str]:
    """A sentence for each reason why some of the estimates are not known."""
    for doubt in dict.fromkeys(one.doubt for one in found if one.doubt):
        words = [one.name.split() for one in found if one.doubt == doubt]
        names = [
            f"{kind}s {', '.join(number for _, number in some)}"
            for kind, some in groupby((word for word in words if len(word) == 2), lambda it: it[0])
        ]
        names += ["the rate"] * (["rate"] in words)
        yield f"the beats do not determine {' and '.join(names)}: {doubt}"


def _lengths(rows: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(rows, axis=1))


def _squares(parts: Parts, unknowns: FloatArray, rounds: Rounds) -> float:
    """Sum of the squared residuals of the mean beats, made independent [s^2]."""
    computed = parts.beats(unknowns)
    # a wheel that cannot run explains no beats
    if computed is None:
        return math.inf
    return float(np.sum((rounds.root @ (computed - rounds.means)) ** 2))


def _curved(at: BeatSolution, rounds: Rounds, known: Uncertainty) -> np.ndarray:
    """Which unknowns may lie beyond the intervals of the tangent: bool, shape (m,).

    Along the line on which an unknown is most uncertain, the sum of squares should rise by
    `unit` squared up to the end of its interval. If it rises much less, for example because there
    is a kink in between, values beyond that end are likely too.
    """
    low, high = at.parts.bounds(at.unknowns[0])
    least, found = _squares(at.parts, at.unknowns, rounds), np.zeros(at.unknowns.size, dtype=bool)
    for index, row in enumerate(known.root):
        width = float(np.linalg.norm(row))
        forward = known.root @ row / (width or 1.0)
        for end in (at.unknowns + forward, at.unknowns - forward):
            # bounds are physical, and the intervals of slots allow for those of impacts
            if width > 0.0 and (end >= low).all() and (end <= high).all():
                rise = _squares(at.parts, end, rounds) - least
                found[index] |= rise < _RISE * known.unit**2
    return found
