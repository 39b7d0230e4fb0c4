"""What a fit of beats says about each part: its error, the interval, or why it is not known."""

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from escapement.base.lazy import Lazy
from escapement.measurement.beat_unknowns import Parts, starts
from escapement.measurement.estimate import Estimate, Tangent, f_test, spanned, tangent_of
from escapement.measurement.rounds import Rounds
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

optimize, special = Lazy("scipy.optimize"), Lazy("scipy.special")
_ROUGH = {"xtol": 1e-3, "ftol": 1e-2, "gtol": 1e-12, "max_nfev": 8}
_EXACT = {"xtol": 1e-9, "ftol": 1e-10, "gtol": 1e-12, "max_nfev": 30}
_NEAR = 1e3  # a rough fit that is worse than the best, and than noise, so many times is left
_STEP = 1e-6  # step of the differences that approximate derivatives by the unknowns
_RISE = 0.5  # the sum of squares rises at the end of an interval by this share of what it should
_CURVED = (
    "their intervals would not hold, because beats are no straight function of them within the "
    "noise; measure longer"
)
_SEVERAL = "very different sets of errors explain the beats equally well; measure longer"
_TOO_GREAT = "they may be so great that the wheel would not run; measure longer"
_PAIRED = (
    "each of {} pins meets only {} of {} slots, so the beats cannot separate errors of pins from "
    "errors of slots: combinations gives for each pair the angle by which it drives longer than "
    "the mean; if the pins are known to be good, use parts='slots', if the slots are, use "
    "parts='pins'"
)


class BeatSolution(NamedTuple):
    """Unknowns that make the sum of squares least, with one of the slots as the last one.

    cost : sum of the squared residuals of the mean beats, made independent [s^2].
    """

    parts: Parts
    rounds: Rounds
    unknowns: FloatArray
    cost: float

    @classmethod
    def near(
        cls, parts: Parts, rounds: Rounds, start: FloatArray, **tolerances: float
    ) -> "BeatSolution":
        """The solution that a search from some unknowns finds."""
        mean = rounds.means.mean()

        def rest(at: FloatArray) -> FloatArray:
            return np.asarray(parts.residuals(at, rounds.means, rounds.root) / mean)

        found = optimize.least_squares(rest, start, bounds=parts.bounds(start[0]), **tolerances)
        return cls(parts, rounds, found.x, 2.0 * float(found.cost) * mean**2)

    @property
    def computed(self) -> FloatArray:
        """Beats of one pattern [s]."""
        beats = self.parts.beats(self.unknowns)
        assert beats is not None, "a fit ends at a wheel that runs"
        return beats

    def same_as(self, other: "BeatSolution") -> bool:
        """Whether both are the same errors of the parts."""
        return self.parts.errors(self.unknowns).same_as(other.parts.errors(other.unknowns))

    def _residuals(self, unknowns: FloatArray) -> FloatArray:
        return self.parts.residuals(unknowns, self.rounds.means, self.rounds.root)

    def tangent(self, noise: float | None, confidence: float) -> Tangent:
        """The fit linearised; intervals follow Student's law unless the noise is given."""
        rounds = self.rounds
        slopes = optimize.approx_fprime(self.unknowns, self._residuals, _STEP)
        squares, freedom = self.cost + rounds.scatter, rounds.samples - self.unknowns.size
        return tangent_of(slopes, squares, freedom, confidence, noise or 0.0)

    def p_value(self, noise: float | None) -> float:
        """Probability that noise alone causes residuals of the mean beats this large [-].

        NaN if the noise is not known, or if so many unknowns leave no residuals.
        """
        judged = self.rounds.pattern - self.unknowns.size
        if noise is None:
            return f_test(self.cost, judged, self.rounds.scatter, self.rounds.intervals.freedom)
        return float(special.chdtrc(judged, self.cost / noise**2)) if judged > 0 else math.nan

    def curved(self, known: Tangent) -> np.ndarray:
        """Which unknowns may lie beyond the intervals of the tangent: bool, shape (m,).

        Along the line on which an unknown is most uncertain, the sum of squares should rise by
        `unit` squared up to the end of its interval. If it rises much less, for example because
        there is a kink in between, values beyond that end are likely too.
        """
        low, high = self.parts.bounds(self.unknowns[0])
        found = np.zeros(self.unknowns.size, dtype=bool)
        for index, row in enumerate(known.root):
            width = float(np.linalg.norm(row))
            forward = known.root @ row / (width or 1.0)
            for end in (self.unknowns + forward, self.unknowns - forward):
                # bounds are physical, and the intervals of slots allow for those of impacts
                if width > 0.0 and (end >= low).all() and (end <= high).all():
                    rise = np.sum(self._residuals(end) ** 2) - self.cost
                    found[index] |= rise < _RISE * known.unit**2
        return found

    def estimates(self, known: Tangent) -> list[Estimate]:
        """The rate, then all pins, then all slots."""
        parts, curved = self.parts, self.curved(known)
        pins = slice(1, parts.impacts.start)
        late, far = parts.errors(self.unknowns).pins, _lengths(parts.pin_delays @ known.root[pins])
        kinds = (
            ("rate", self.unknowns[:1], _lengths(known.root[:1]), curved[:1]),
            ("pin {}", late, far, curved[pins]),
            ("slot {}", *self._slots(known), curved[parts.impacts]),
        )
        return [
            Estimate(name.format(k), value, width).doubted(_CURVED * bool(doubtful.any()))
            for name, values, widths, doubtful in kinds
            for k, (value, width) in enumerate(zip(values.tolist(), widths.tolist(), strict=True))
        ]

    def _slots(self, known: Tangent) -> tuple[FloatArray, FloatArray]:
        """Errors of the slots in the middle of their intervals, and half the widths.

        An impact shows the step of its slot. Of the slots without an impact the beats show only
        that each step is below its free step, and the sum of these steps. The angle of a slot is
        therefore extreme where all of them except one are as great as possible.
        """
        count = self.parts.wheel.slots
        if not self.parts.others.size:
            return np.zeros(count), np.zeros(count)
        struck, most, roots = self.steps(known)
        gather = np.tril(np.ones((count, count)))
        gather -= gather.mean(axis=0)
        # all other steps are as great as possible, and that of one follows from their sum
        each = [gather - gather[:, [slot]] for slot in np.flatnonzero(~struck)]
        middle = np.array([weights @ most for weights in each])
        width = np.array([_lengths(weights[:, struck] @ roots[struck]) for weights in each])
        low, high = (middle - width).min(axis=0), (middle + width).max(axis=0)
        return 0.5 * (low + high), 0.5 * (high - low)

    def steps(self, known: Tangent) -> tuple[np.ndarray, FloatArray, FloatArray]:
        """Which slots are struck, the greatest steps of all, and the roots of the struck ones."""
        parts, size = self.parts, self.parts.wheel.slots
        delays, roots = np.zeros(size), np.zeros((size, known.root.shape[1]))
        delays[parts.others] = self.unknowns[parts.impacts]
        roots[parts.others] = known.root[parts.impacts]
        # the last slot counts as one without an impact
        struck = delays > (limit := _lengths(roots))
        greatest = parts.free + 0.5 * parts.slope * (delays + limit) ** 2
        most = np.where(struck, parts.errors(self.unknowns).steps, greatest)
        return struck, most, parts.slope * delays[:, None] * roots

    def told_steps(self, known: Tangent) -> tuple[tuple[Estimate, ...], str]:
        """Steps from slot to slot that are struck, where others are not, and why; else nothing."""
        if not self.parts.others.size:
            return (), ""
        struck, most, roots = self.steps(known)
        unstruck, size = np.flatnonzero(~struck), self.parts.wheel.slots
        if unstruck.size == 1:
            return (), ""
        found = (
            Estimate(f"slot {i} less slot {(i - 1) % size}", float(most[i]), float(width))
            for i, width in enumerate(_lengths(roots))
            if struck[i]
        )
        return tuple(found), (
            f"no pin strikes slots {', '.join(map(str, unstruck))}: the beats do not show how far "
            "each of them is behind the slot before it, so the intervals of the slots are wide"
        )


def pairs_of(
    parts: Parts, rounds: Rounds, known: Tangent
) -> tuple[list[Estimate], tuple[Estimate, ...]]:
    """The result where each pin meets only some slots: no single part, but the sum of each pair."""
    pins, slots = parts.wheel.pins or 1, parts.wheel.slots
    mean = rounds.means.mean()
    speed = parts.wheel.cell_angle / mean
    values, widths = speed * (rounds.means - mean), speed * known.unit * rounds.spread
    pairs = tuple(
        Estimate(f"pin {k % pins} in slot {k % slots}", *row)
        for k, row in enumerate(zip(values.tolist(), widths.tolist(), strict=True))
    )
    reason = _PAIRED.format(pins, slots // math.gcd(pins, slots), slots)
    names = ["rate", *(f"pin {k}" for k in range(pins)), *(f"slot {k}" for k in range(slots))]
    return [Estimate(name, math.nan, math.nan, reason) for name in names], pairs


def solutions(
    rounds: Rounds, escapement: Escapement, which: tuple[bool, bool], noise: float | None
) -> list[BeatSolution]:
    """The fits from all starts that are nearly as good as the best, which is the first."""
    begin = starts(escapement, *which, rounds.means)
    variance = noise**2 if noise else rounds.scatter / max(rounds.intervals.freedom, 1)
    rough = [BeatSolution.near(parts, rounds, start, **_ROUGH) for parts, start in begin]
    most = _NEAR * (min(one.cost for one in rough) + variance)
    near = [one for one in sorted(rough, key=lambda it: it.cost) if one.cost <= most]
    exact = [BeatSolution.near(one.parts, rounds, one.unknowns, **_EXACT) for one in near]
    return sorted(exact, key=lambda it: it.cost)


def joined_estimates(
    sets: list[BeatSolution], noise: float | None, confidence: float
) -> tuple[list[Estimate], str]:
    """Estimates whose intervals cover those of all solutions, which fit equally well, and a remark.

    Solutions with different last slots differ in which slots are struck, and one of them is near
    the true errors. Several with the same unknowns lie on both sides of a kink, where none need be:
    then no interval holds. Nor does one that leaves the range in which the wheel runs.
    """
    each = [one.estimates(one.tangent(noise, confidence)) for one in sets]
    found, remark = [spanned(same) for same in zip(*each, strict=True)], ""
    if len({one.parts.last for one in sets}) < len(sets):
        found = [one.doubted(_SEVERAL * (one.half_width > 0.0)) for one in found]
    elif len(sets) > 1:
        remark = (
            f"{len(sets)} sets of errors explain the beats equally well: each interval covers all "
            "of them, and each estimate is the middle of its interval"
        )
    limits = dict(zip(("slot", "pin"), sets[0].parts.range, strict=True))
    most = [limits.get(one.name.split()[0], math.inf) for one in found]
    return [
        one.doubted(_TOO_GREAT * (abs(one.value) + one.half_width > limit))
        for one, limit in zip(found, most, strict=True)
    ], remark


def undetermined(found: Iterable[Estimate]) -> Iterator[str]:
    """A sentence for each reason why some of the estimates are not known."""
    for doubt in dict.fromkeys(one.doubt for one in found if one.doubt):
        words = [one.name.split() for one in found if one.doubt == doubt]
        each = {kind: [word[1] for word in words if word[0] == kind] for kind in ("pin", "slot")}
        names = [f"{kind}s {', '.join(some)}" for kind, some in each.items() if some]
        names += ["the rate"] * (["rate"] in words)
        yield f"the beats do not determine {' and '.join(names)}: {doubt}"


def _lengths(rows: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(rows, axis=1))
