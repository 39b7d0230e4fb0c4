"""From measured beats to parts: angle errors of pins and slots, by least squares."""

import math
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.measurement.beat_unknowns import Parts, starts
from escapement.measurement.beat_verdict import verdict_on
from escapement.measurement.curvature import curved
from escapement.measurement.estimate import (
    Combination,
    Doubt,
    PartEstimate,
    doubt_of,
    estimate,
    joint_estimate,
    remarks,
    spanned,
    within_range,
    without,
)
from escapement.measurement.rounds import Rounds, checked_wheel, rounds_of
from escapement.measurement.time_unit import check_unit
from escapement.measurement.verdict import Verdict
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

optimize = Lazy("scipy.optimize")
PARTS = ("both", "pins", "slots")
_ROUGH = {"xtol": 1e-3, "ftol": 1e-2, "gtol": 1e-12, "max_nfev": 8}
_NEAR = 1e3  # a rough fit that is worse by this factor is not made exact
_SAME = 1e-6  # errors that differ by less are the same [rad]
_EXACT = {"xtol": 1e-9, "ftol": 1e-10, "gtol": 1e-12, "max_nfev": 30}


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
    combinations : tuple of Combination
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
    combinations: tuple[Combination, ...]
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
        """Whether angle errors of the parts explain the beats, and which parts are in error."""
        return verdict_on(self)

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
    stamp; the shares of both come from restricted maximum likelihood, where durations show with
    certainty that they are differences of stamps, or where stamps are given.

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
    share = validate.number("confidence", confidence, remedy := "give a share, as 0.95")
    if not 0.0 < share < 1.0:
        raise validate.fail("confidence", "between 0 and 1", confidence, remedy)
    pins, slots = parts != "slots", parts != "pins"
    unknown = Parts(escapement, pins, slots).size
    if noise is None and rounds.samples <= unknown:
        raise InvalidValue(
            f"beats must be more than the {unknown} unknowns, got {rounds.samples}; "
            "measure longer, or give their noise"
        )
    _check_times(escapement, rounds)
    best, *others = _fitted(escapement, rounds, pins, slots)
    doubt = doubt_of(best.parts, best.unknowns, rounds, noise, share)
    if parts == "both" and math.gcd(wheel.pins, wheel.slots) > 1:
        known = joint_estimate(best.parts, rounds, doubt)
    else:
        # a fit that is worse by no more than the edge of an interval may be true as well
        edge = best.cost + 0.5 * (doubt.reach * doubt.noise / rounds.means.mean()) ** 2
        sets = [best] + [it for it in others if it.cost <= edge and not _alike(it, best)]
        doubts = [doubt_of(*it[:2], rounds, noise, share) for it in sets]
        solutions = [
            _estimate(it, rounds, doubt_of_set)
            for it, doubt_of_set in zip(sets, doubts, strict=True)
        ]
        known = spanned(solutions, _joined(sets, rounds, edge))
    known = within_range(known, best.parts)
    return BeatFit(
        escapement=best.parts.built(best.unknowns),
        pin_angle_errors=known.pins, slot_angle_errors=known.slots,
        pin_half_widths=known.pin_widths, slot_half_widths=known.slot_widths,
        combinations=known.combinations, rate=known.rate, rate_half_width=known.rate_width,
        computed=doubt.computed, rounds=rounds, noise=doubt.noise, p_value=doubt.p_value,
        autocorrelation=doubt.alike, unknowns=best.unknowns.size, confidence=share,
        message="; ".join(remarks(known, doubt, rounds)),
    )  # fmt: skip


def _check_times(escapement: Escapement, rounds: Rounds) -> None:
    """Raise InvalidValue if the beats are not of the order of the design's, as in another unit."""
    _, computed = Parts(escapement, False, False).perfect()
    mean, design = float(rounds.means.mean()), float(computed.mean())
    torque = escapement.torque if isinstance(escapement.torque, float | int) else None
    took = f"a mean beat of {mean:.3g} s, where the design takes {design:.3g} s"
    check_unit("beats", mean / design, took, torque)


class _Trial(NamedTuple):
    """Unknowns with one of the slots as the last one, and their residuals."""

    parts: Parts
    unknowns: FloatArray
    cost: float

    def left(self) -> float:
        """What to sort by."""
        return self.cost


def _fitted(escapement: Escapement, rounds: Rounds, pins: bool, slots: bool) -> list[_Trial]:
    """The fits from all starts that are nearly as good as the best, which is the first."""
    some = starts(escapement, pins, slots, rounds.means)
    rough = sorted((_improved(*one, rounds, _ROUGH) for one in some), key=_Trial.left)
    # where there are as many unknowns as beats, any start may lead to errors that explain them
    more = rough[0].unknowns.size < rounds.pattern
    near = [one for one in rough if not more or one.cost <= _NEAR * rough[0].cost]
    return sorted((_improved(*one[:2], rounds, _EXACT) for one in near), key=_Trial.left)


def _estimate(trial: _Trial, rounds: Rounds, doubt: Doubt) -> PartEstimate:
    """What one fit says, NaN where its intervals do not hold."""
    found = estimate(trial.parts, trial.unknowns, doubt.root)
    return without(found, trial.parts, curved(trial.parts, trial.unknowns, rounds, doubt))


def _joined(sets: list[_Trial], rounds: Rounds, edge: float) -> bool:
    """Whether sets of errors between those that were found explain the beats as well.

    The regions about each of them are then one, and greater than their intervals.
    """
    for one, other in combinations(sets, 2):
        if one.parts.last == other.parts.last:
            middle = 0.5 * (one.unknowns + other.unknowns)
            rest = _rest(one.parts, middle, rounds)
            if 0.5 * float(rest @ rest) <= edge:
                return True
    return False


def _alike(one: _Trial, other: _Trial) -> bool:
    """Whether two fits have found the same errors."""
    a, b = (trial.parts.errors(trial.unknowns) for trial in (one, other))
    # steps that are not struck may differ
    return bool(
        np.abs(a.pins - b.pins).max() < _SAME
        and np.abs(np.maximum(a.steps, 0.0) - np.maximum(b.steps, 0.0)).max() < _SAME
    )


def _improved(
    parts: Parts, start: FloatArray, rounds: Rounds, tolerances: dict[str, float]
) -> _Trial:
    """The unknowns with the least sum of squares."""
    found = optimize.least_squares(
        lambda at: _rest(parts, at, rounds), start, bounds=parts.bounds(start[0]), **tolerances
    )
    return _Trial(parts, found.x, float(found.cost))


def _rest(parts: Parts, unknowns: FloatArray, rounds: Rounds) -> FloatArray:
    """Computed less mean beats, made independent, as shares of the mean of all."""
    computed = parts.beats(unknowns)
    if computed is None:
        # a wheel that cannot run explains no beats
        return np.full(rounds.pattern, 1e3)
    return np.asarray(rounds.root @ (computed - rounds.means) / rounds.means.mean())
