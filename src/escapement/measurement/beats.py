"""From measured beats to parts: angle errors of pins and slots, by least squares."""

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.measurement.beat_unknowns import Parts
from escapement.measurement.estimate import Estimate, Fit, checked_confidence
from escapement.measurement.loggers import check_unit
from escapement.measurement.part_estimates import (
    BeatSolution,
    joined_estimates,
    pairs_of,
    solutions,
    undetermined,
)
from escapement.measurement.readings import Readings
from escapement.measurement.rounds import Rounds, rounds_of
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

PARTS = ("both", "pins", "slots")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class BeatFit(Fit):
    """Angle errors of pins and slots that explain measured beats.

    Only differences between pins, and between slots, change a beat, so errors are relative to the
    mean of all pins, or of all slots. An interval is the estimate -+ its half width.

    `numbers` are the rate, all pins and all slots. `residuals` are measured minus computed beats,
    in turn, NaN if missing, shape (N,) [s]. `p_value` is that of the difference of the mean beats
    and `computed`.

    Attributes
    ----------
    pin_angle_errors, slot_angle_errors : ndarray, shapes (m,) and (n,)
        Estimates [rad]; NaN if the beats do not determine them. For a slot with only bounds, the
        middle of its interval.
    pin_half_widths, slot_half_widths : ndarray, shapes (m,) and (n,)
        Half the widths of the intervals [rad].
    combinations : tuple of Estimate
        Other angles that are determined; empty if all single errors are.
    computed : ndarray, shape (pattern,)
        Beats of one pattern with these errors, times `rate` [s].
    rounds : Rounds
        The measured beats, a pattern in each row of its `table`.
    unknowns : int
        Number of unknowns of the fit.
    """

    pin_angle_errors: FloatArray
    slot_angle_errors: FloatArray
    pin_half_widths: FloatArray
    slot_half_widths: FloatArray
    combinations: tuple[Estimate, ...]
    computed: FloatArray = field(repr=False)
    rounds: Rounds = field(repr=False)
    unknowns: int

    _model: ClassVar[str] = "A design with angle errors of its parts"

    @property
    def rate(self) -> float:
        """Measured time divided by computed time, which corrects an inexact torque [-]."""
        rate, *_ = self.numbers
        return rate.value

    @property
    def rate_half_width(self) -> float:
        """Half the width of its interval [-]."""
        rate, *_ = self.numbers
        return rate.half_width

    @property
    def residual(self) -> float:
        """Root mean square of the residuals [s]."""
        return float(np.sqrt(np.nanmean(self.residuals**2)))

    def numbers_in_words(self) -> str:
        """The parts that are in error, and the rate."""
        rate, *parts = self.numbers
        shown = [
            f"{one.name} ({math.degrees(one.low):.3g} to {math.degrees(one.high):.3g} degrees)"
            for one in parts
            if one.low > 0.0 or one.high < 0.0
        ]
        return (
            f" with {100.0 * self.confidence:g} % intervals that leave out zero for "
            f"{', '.join(shown) or 'no part'}; they take {rate.low:.5g} to {rate.high:.5g} times "
            "as long as those of the design"
        )


def fit_beats(
    beats: ArrayLike | Readings, escapement: Escapement, *, noise: float | None = None,
    parts: str = "both", confidence: float = 0.95,
) -> BeatFit:  # fmt: skip
    """Find the angle errors of pins and slots from measured beats.

    Parameters
    ----------
    beats : array_like, shape (N,), or Readings
        Times of the engagements in turn [s], from one change of pin to the next, in the terminal
        cycle; NaN or masked where one is missing. Or the N + 1 instants of the changes of pin, by
        any clock, as `read_beats` or `Readings.of_beats` give them; their jitter makes neighbouring
        beats alternate, and the fit allows for it. The first beat is that of pin 0 in slot 0, which
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

    Returns
    -------
    BeatFit
        Its `message` says what cannot be determined, where the model does not explain the beats,
        and which ticks are out of place.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, the beats are too few, or their mean is more than ten
        times or less than a tenth of the design's.

    Notes
    -----
    The noise is assumed to be normal and independent from beat to beat, or from instant to
    instant. Where instants are given, or durations show with certainty that they are differences
    of instants, the result is the mean over all shares of both, weighted by their restricted
    likelihood; so the intervals allow for a share that few beats do not determine.

    Pins and slots count from the first beat that was heard. A step from slot to slot is measured
    where the pin strikes; where the pin picks the follower up, it is only known to be less than the
    free step. If the axes are too far apart, all steps up to 2 tan(pi/n) times the relative error
    of their distance cause no strike: give the real distance.
    """
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    wheel: Any = escapement.mechanism
    rounds = rounds_of(beats, wheel)
    if noise is not None:
        noise = validate.positive("noise", noise, "give the standard deviation of a beat in s")
    validate.choice("parts", parts, PARTS)
    share = checked_confidence(confidence)
    which = parts != "slots", parts != "pins"
    unknown = Parts(escapement, *which).size
    if noise is None and rounds.samples <= unknown:
        raise InvalidValue(
            f"beats must be more than the {unknown} unknowns, got {rounds.samples}; "
            "measure longer, or give their noise"
        )
    _check_times(escapement, rounds)
    best, *others = solutions(rounds, escapement, which, noise)
    known = best.tangent(noise, share)
    if parts == "both" and math.gcd(wheel.pins, wheel.slots) > 1:
        found, combinations = pairs_of(best.parts, rounds, known)
        reasons = []
    else:
        # a fit that is worse by no more than the edge of an interval may be true as well
        edge, sets = best.cost + known.unit**2, [best]
        for one in others:
            if one.cost <= edge and not any(one.same_as(it) for it in sets):
                sets.append(one)
        found, several = joined_estimates(sets, noise, share)
        combinations, told = best.told_steps(known)
        combinations, reasons = combinations if len(sets) == 1 else (), [several, told]
    pins, slots = (
        np.array([one[1:3] for one in found if one.name.startswith(kind)]).T
        for kind in ("pin", "slot")
    )
    doubt = _doubt(found, best, noise)
    fit = BeatFit(
        escapement=best.parts.built(best.unknowns), numbers=tuple(found), confidence=share,
        residuals=(rounds.table - best.computed).ravel(), noise=known.noise,
        p_value=best.p_value(noise), autocorrelation=_alike(rounds, best.computed),
        pin_angle_errors=pins[0], slot_angle_errors=slots[0], pin_half_widths=pins[1],
        slot_half_widths=slots[1], combinations=combinations, computed=best.computed, rounds=rounds,
        unknowns=best.unknowns.size, of_beats=True, doubt=doubt,
    )  # fmt: skip
    said = (*rounds.faults, *filter(None, reasons), *undetermined(found), *fit.contradictions)
    vars(fit)["message"] = "; ".join(said)
    return fit


def _doubt(found: list[Estimate], best: BeatSolution, noise: float | None) -> str:
    """Why the beats could not contradict the parts, or do not determine them, else ""."""
    pattern, unknowns = best.rounds.pattern, best.unknowns.size
    if any(one.doubt for one in found):
        return "they do not determine all of these errors; the message says which, and why"
    if unknowns >= pattern:
        return (
            f"{unknowns} unknowns can explain any beats of {pattern} pairs of a pin and a slot, "
            "and the intervals hold only near the set of errors that was found; if either kind of "
            "part is good, fit the other one alone"
        )
    if math.isnan(best.p_value(noise)):
        return (
            "no pair of a pin and a slot was measured twice, so that the noise is not known; "
            "measure longer, or give the noise"
        )
    return ""


def _alike(rounds: Rounds, computed: FloatArray) -> float:
    """Correlation of neighbouring residuals, made independent; 0 where there are none."""
    rest, near = rounds.independent(computed), np.diff(rounds.known) == 1
    if not (near.any() and rest.any()):
        return 0.0
    return float(np.mean((rest[1:] * rest[:-1])[near]) / np.mean(rest**2))


def _check_times(escapement: Escapement, rounds: Rounds) -> None:
    """Raise InvalidValue if the beats are not of the order of the design's, as in another unit."""
    _, computed = Parts(escapement, False, False).perfect()
    mean, design = float(rounds.means.mean()), float(computed.mean())
    torque = escapement.torque if isinstance(escapement.torque, float | int) else None
    took = f"a mean beat of {mean:.3g} s, where the design takes {design:.3g} s"
    check_unit("beats", mean / design, took, torque)
