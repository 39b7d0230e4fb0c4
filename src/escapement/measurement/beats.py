"""From measured beats to parts: angle errors of pins and slots, by least squares."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.measurement.beat_unknowns import Parts, starts
from escapement.measurement.estimate import (
    SURE,
    Estimate,
    Tangent,
    Verdict,
    checked_confidence,
)
from escapement.measurement.loggers import check_unit
from escapement.measurement.part_estimates import (
    BeatSolution,
    joined_estimates,
    pairs_of,
    undetermined,
)
from escapement.measurement.rounds import Rounds, checked_wheel, rounds_of
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

optimize = Lazy("scipy.optimize")
PARTS = ("both", "pins", "slots")
_ROUGH = {"xtol": 1e-3, "ftol": 1e-2, "gtol": 1e-12, "max_nfev": 8}
_EXACT = {"xtol": 1e-9, "ftol": 1e-10, "gtol": 1e-12, "max_nfev": 30}
_NEAR = 1e3  # a rough fit that is worse than the best, and than noise, so many times is left
_ALIKE = 0.1  # a smaller correlation of neighbouring residuals hardly changes an interval
_FAILED = 1e3  # residual of a wheel that cannot run, which explains no beats


@dataclass(frozen=True, eq=False, repr=False)
class BeatFit(Shown):
    """Angle errors of pins and slots that explain measured beats.

    Only differences between pins, and between slots, change a beat, so errors are relative to the
    mean of all pins, or of all slots. An interval is the estimate -+ its half width.

    Attributes
    ----------
    escapement : Escapement
        The given design with errors that explain the beats; they are the estimates if these are
        determined.
    pin_angle_errors, slot_angle_errors : ndarray, shapes (m,) and (n,)
        Estimates [rad]; NaN if the beats do not determine them. For a slot with only bounds, the
        middle of its interval.
    pin_half_widths, slot_half_widths : ndarray, shapes (m,) and (n,)
        Half the widths of the intervals [rad].
    combinations : tuple of Estimate
        Other angles that are determined; empty if all single errors are.
    rate, rate_half_width : float
        Measured time divided by computed time, which corrects an inexact torque [-]; NaN if the
        beats do not determine it.
    computed : ndarray, shape (pattern,)
        Beats of one pattern with these errors, times `rate` [s].
    rounds : Rounds
        The measured beats, a pattern in each row of its `table`.
    noise : float
        Standard deviation of one beat, as given or found [s].
    p_value : float
        Probability that noise alone causes such a difference of the mean beats and `computed`;
        NaN if this cannot be judged.
    autocorrelation : float
        Correlation of neighbouring residuals, made independent [-].
    unknowns : int
        Number of unknowns of the fit.
    confidence : float
        Confidence level of the intervals [-].
    message : str
        Warnings about these figures, "" if there are none.
    """

    escapement: Escapement
    pin_angle_errors: FloatArray
    slot_angle_errors: FloatArray
    pin_half_widths: FloatArray
    slot_half_widths: FloatArray
    combinations: tuple[Estimate, ...]
    rate: float
    rate_half_width: float
    computed: FloatArray = field(repr=False)
    rounds: Rounds = field(repr=False)
    noise: float
    p_value: float
    autocorrelation: float
    unknowns: int
    confidence: float
    message: str

    @property
    def verdict(self) -> Verdict:
        """Whether angle errors of the parts explain the beats, and which parts are in error.

        It is "no" where the residuals contradict the model, "cannot say" where the beats are too
        few to contradict it or do not determine the parts, and "yes" where both were possible and
        passed.
        """
        if wrong := [text for text, _ in self._contradictions()]:
            return Verdict(
                False, f"Angle errors of the parts do not explain the beats: {'; '.join(wrong)}."
            )
        subject = "angle errors of the parts explain the beats"
        if doubt := self._doubt():
            return Verdict(None, f"Cannot say whether {subject}: {doubt}.")
        return Verdict(True, f"A{subject[1:]}. {self._found()}")

    def _contradictions(self) -> Iterator[tuple[str, str]]:
        """What in the residuals noise does not cause, and what follows."""
        if self.p_value < SURE:
            yield (
                f"the residuals are greater than the noise explains (p {self.p_value:.1g})",
                "something besides these angles differs from the design, for example the friction, "
                "a length or the centre distance",
            )
        if abs(self.autocorrelation) > max(_ALIKE, 4.0 / math.sqrt(self.rounds.samples)):
            yield (
                f"neighbouring residuals are alike (correlation {self.autocorrelation:.2f})",
                "the intervals assume that the noise of each beat is independent: do not trust "
                "their widths",
            )

    def _doubt(self) -> str:
        """Why the beats could not contradict the parts, or do not determine them, else ""."""
        if not np.isfinite([*self.pin_angle_errors, *self.slot_angle_errors, self.rate]).all():
            return "they do not determine all of these errors; the message says which, and why"
        if not math.isnan(self.p_value):
            return ""
        if self.unknowns >= self.rounds.pattern:
            return (
                f"{self.unknowns} unknowns can explain any beats of {self.rounds.pattern} pairs "
                "of a pin and a slot; if either kind of part is good, fit the other one alone"
            )
        return (
            "no pair of a pin and a slot was measured twice, so that the noise is not known; "
            "measure longer, or give the noise"
        )

    def _found(self) -> str:
        """The parts that are certainly in error, and the rate."""
        shown = []
        for name, sizes, halves in (
            ("pin", self.pin_angle_errors, self.pin_half_widths),
            ("slot", self.slot_angle_errors, self.slot_half_widths),
        ):
            low, high = np.degrees(sizes - halves), np.degrees(sizes + halves)
            shown += [
                f"{name} {k} ({low[k]:.3g} to {high[k]:.3g} degrees)"
                for k in np.flatnonzero((low > 0.0) | (high < 0.0))
            ]
        ends = self.rate - self.rate_half_width, self.rate + self.rate_half_width
        return (
            f"Their {100.0 * self.confidence:g} % intervals leave out zero for "
            f"{', '.join(shown) or 'no part'}. The beats take {ends[0]:.5g} to {ends[1]:.5g} times "
            "as long as those of the design."
        )

    def _remarks(self, found: list[Estimate], reasons: list[str]) -> Iterator[str]:
        """What a user of the fit must know, one sentence at a time."""
        yield from (*self.rounds.faults, *filter(None, reasons))
        yield from undetermined(found)
        if self.unknowns >= self.rounds.pattern and np.isfinite(self.slot_angle_errors).all():
            yield (
                "there are as many unknowns as pairs of a pin and a slot, so other sets of errors "
                "may explain the beats equally well; the intervals hold only near the set that was "
                "found"
            )
        yield from (f"{text}; {meaning}" for text, meaning in self._contradictions())

    @property
    def residuals(self) -> FloatArray:
        """Measured minus computed beats, in turn, NaN if missing, shape (N,) [s]."""
        return (self.rounds.table - self.computed).ravel()

    @property
    def residual(self) -> float:
        """Root mean square of the residuals [s]."""
        return float(np.sqrt(np.nanmean(self.residuals**2)))


def fit_beats(
    beats: ArrayLike,
    escapement: Escapement,
    *,
    noise: float | None = None,
    parts: str = "both",
    confidence: float = 0.95,
    times: bool = False,
) -> BeatFit:
    """Find the angle errors of pins and slots from measured beats.

    Parameters
    ----------
    beats : array_like, shape (N,)
        Times of the engagements in turn [s], from one change of pin to the next, in the terminal
        cycle; NaN or masked where one is missing. The first is that of pin 0 in slot 0, which
        gives the parts their numbers. Each pin must have met each of its slots once; more rounds
        make the intervals narrower.
    escapement : Escapement
        The design, with a Geneva wheel. Known errors of lengths count; angle errors do not.
    noise : float, optional
        Standard deviation of one beat [s], > 0. Default: from the residuals of the fit.
    parts : str
        Which of them may have errors: "both", "pins" or "slots".
    confidence : float
        Confidence level of the intervals, in (0, 1) [-].
    times : bool
        Whether `beats` are time stamps instead: the N + 1 instants of the changes of pin [s], by
        any clock. Their jitter makes neighbouring beats alternate, and the fit allows for it.

    Returns
    -------
    BeatFit
        Its `message` says what cannot be determined, where the model does not explain the beats,
        and which ticks were missed, doubled or out of place.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, the beats are too few, or their mean is more than ten
        times or less than a tenth of the design's.

    Notes
    -----
    The noise is assumed to be normal and independent from beat to beat, or from time stamp to time
    stamp. Where stamps are given, or durations show with certainty that they are differences of
    stamps, the result is the mean over all shares of both, weighted by their restricted
    likelihood; so the intervals allow for a share that few beats do not determine.

    Intervals that are much too short or too long, and that alone or with their neighbours make a
    whole number of beats, are mended: the parts of an echo are joined, and a beat whose own
    duration is not known is left out. A tick that is missed at the very beginning cannot be
    noticed; pins and slots then count from the first beat that there is. A step from slot to
    slot is measured where the pin strikes; where the pin picks the follower up, it is only known
    to be less than the free step. If the axes are too far apart, all steps up to 2 tan(pi/n)
    times the relative error of their distance cause no strike: give the real distance.
    """
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    wheel: Any = checked_wheel(escapement.mechanism)
    rounds = rounds_of(beats, wheel, times)
    if noise is not None:
        noise = validate.positive("noise", noise, "give the standard deviation of a beat in s")
    validate.choice("parts", parts, PARTS)
    share = checked_confidence(confidence)
    pins, slots = parts != "slots", parts != "pins"
    unknown = Parts(escapement, pins, slots).size
    if noise is None and rounds.samples <= unknown:
        raise InvalidValue(
            f"beats must be more than the {unknown} unknowns, got {rounds.samples}; "
            "measure longer, or give their noise"
        )
    _check_times(escapement, rounds)
    variance = noise**2 if noise else rounds.scatter / max(rounds.samples - rounds.pattern, 1)
    best, *others = _solutions(rounds, starts(escapement, pins, slots, rounds.means), variance)
    known = best.tangent(noise, share)
    if parts == "both" and math.gcd(wheel.pins, wheel.slots) > 1:
        found, combinations = pairs_of(best.parts, rounds, known)
        reasons = [""]
    else:
        # a fit that is worse by no more than the edge of an interval may be true as well
        edge, sets = best.cost + known.unit**2, [best]
        for one in others:
            if one.cost <= edge and not any(one.same_as(it) for it in sets):
                sets.append(one)
        each = [known, *(it.tangent(noise, share) for it in sets[1:])]
        found, several = joined_estimates(sets, each)
        combinations, told = best.told_steps(known)
        combinations, reasons = combinations if len(sets) == 1 else (), [several, told]
    fit = _fit_of(best, known, found, combinations, share, best.p_value(noise))
    vars(fit)["message"] = "; ".join(fit._remarks(found, reasons))
    return fit


def _fit_of(
    best: BeatSolution, known: Tangent, found: list[Estimate],
    combinations: tuple[Estimate, ...], share: float, p_value: float,
) -> BeatFit:  # fmt: skip
    rounds, computed = best.rounds, best.computed
    rest, near = rounds.independent(computed), np.diff(rounds.known) == 1
    alike = 0.0
    if near.any() and rest.any():
        alike = float(np.mean((rest[1:] * rest[:-1])[near]) / np.mean(rest**2))
    (pins, pin_widths), (slots, slot_widths) = (
        np.array([one[1:3] for one in found if one.name.startswith(kind)]).T
        for kind in ("pin", "slot")
    )
    return BeatFit(
        escapement=best.parts.built(best.unknowns), pin_angle_errors=pins, slot_angle_errors=slots,
        pin_half_widths=pin_widths, slot_half_widths=slot_widths, combinations=combinations,
        rate=found[0].value, rate_half_width=found[0].half_width, computed=computed, rounds=rounds,
        noise=known.noise, p_value=p_value, autocorrelation=alike, unknowns=best.unknowns.size,
        confidence=share, message="",
    )  # fmt: skip


def _check_times(escapement: Escapement, rounds: Rounds) -> None:
    """Raise InvalidValue if the beats are not of the order of the design's, as in another unit."""
    _, computed = Parts(escapement, False, False).perfect()
    mean, design = float(rounds.means.mean()), float(computed.mean())
    torque = escapement.torque if isinstance(escapement.torque, float | int) else None
    took = f"a mean beat of {mean:.3g} s, where the design takes {design:.3g} s"
    check_unit("beats", mean / design, took, torque)


def _solutions(
    rounds: Rounds, begin: Iterable[tuple[Parts, FloatArray]], variance: float
) -> list[BeatSolution]:
    """The fits from all starts that are nearly as good as the best, which is the first."""
    mean = rounds.means.mean()

    def improved(parts: Parts, start: FloatArray, tolerances: dict[str, float]) -> BeatSolution:
        def rest(at: FloatArray) -> FloatArray:
            computed = parts.beats(at)
            if computed is None:
                return np.full(rounds.pattern, _FAILED)
            return np.asarray(rounds.root @ (computed - rounds.means) / mean)

        found = optimize.least_squares(rest, start, bounds=parts.bounds(start[0]), **tolerances)
        return BeatSolution(parts, rounds, found.x, 2.0 * float(found.cost) * mean**2)

    rough = sorted((improved(*one, _ROUGH) for one in begin), key=lambda it: it.cost)
    near = [it for it in rough if it.cost <= _NEAR * (rough[0].cost + variance)]
    exact = (improved(it.parts, it.unknowns, _EXACT) for it in near)
    return sorted(exact, key=lambda it: it.cost)
