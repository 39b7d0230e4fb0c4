"""The scatter of one figure of merit: worst case, first order, and its sample."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from escapement.base import units
from escapement.base.errors import InvalidValue
from escapement.base.progress import set_stage
from escapement.base.status import MESSAGES, Status
from escapement.base.text import Shown, words
from escapement.dynamics.figures_of_merit import Figures
from escapement.mechanisms.protocol import FloatArray
from escapement.study.cases import solved
from escapement.study.parse.sample import correlation_matrix
from escapement.study.plan import StudyPlan, unit_kind
from escapement.study.result import Study
from escapement.tolerance import intervals
from escapement.tolerance.derivatives import slopes_of
from escapement.tolerance.differences import NONE, Slope
from escapement.tolerance.intervals import Estimate, estimate
from escapement.tolerance.spread import Spread
from escapement.tolerance.worst_case import Worst, worst_case

LEVELS = (0.01, 0.05, 0.5, 0.95, 0.99)
"""Shares of cases whose quantiles are given."""
FEWEST = 20
"""Cases that an estimate needs at least."""
ROUNDS = 200
"""Rounds of the iteration for equal shares of correlated numbers."""
Limits = tuple[float, float]


@dataclass(frozen=True, repr=False)
class Scatter(Shown):
    """Effect of the tolerances on one figure, in SI.

    nominal : its value without them.
    worst : its ends with every number at the worst value within its tolerance; for a normal
        distribution without ends these are three standard deviations from the mean. NaN if the
        mechanism has no answer there.
    sigma : standard deviation to first order, the root of the sum of squares.
    slopes : its derivative by each number; at a kink, that of the steeper side; NaN or infinite
        if there is none. Then the sample alone tells the scatter: sigma is NaN, and contributions
        and balanced are empty.
    contributions : share of each number in the variance to first order, greatest first; it may be
        negative if numbers are correlated.
    balanced : factor for each tolerance with which all contribute equally to the same sigma:
        below 1 the tolerance has to be tightened, above 1 it may be widened.
    mean, deviation : of the sample.
    quantiles : by share of the cases.
    inside : share of the cases within the limits; cases that could not be computed are outside.
    capability : C_pk, the distance of the mean from the nearer limit over 3 deviations.
    limits : the least and greatest value allowed.
    first, total : Sobol' indices of each number, empty unless requested.
    """

    nominal: float
    worst: Worst
    sigma: float
    slopes: dict[str, float]
    contributions: dict[str, float]
    balanced: dict[str, float]
    mean: Estimate
    deviation: Estimate
    quantiles: dict[float, Estimate]
    inside: Estimate | None = None
    capability: Estimate | None = None
    limits: Limits | None = None
    first: dict[str, Estimate] = field(default_factory=dict)
    total: dict[str, Estimate] = field(default_factory=dict)


class Problem(NamedTuple):
    """A plan, some of its numbers that scatter, and figures of merit at values of these numbers."""

    plan: StudyPlan
    names: tuple[str, ...]

    def solved(self, point: FloatArray) -> Figures:
        """The figures at a point; InvalidValue where there are none."""
        values = dict(zip(self.names, point.tolist(), strict=True))
        return solved(self.plan, self.plan.fixed_si | values)

    def value(self, figure: str, point: FloatArray) -> float:
        """A figure at a point; NaN where it has none."""
        try:
            return float(getattr(self.solved(point), figure))
        except InvalidValue:
            return math.nan

    def slopes(self, figures: Sequence[str], point: FloatArray) -> dict[str, list[Slope]]:
        """The derivatives of each figure at a point by each number."""
        nothing = {figure: [NONE] * len(self.names) for figure in figures}
        numbers = dict(zip(self.names, point.tolist(), strict=True))
        try:
            nominal, middle = self.plan.built(self.plan.fixed_si | numbers), self.solved(point)
        except InvalidValue:
            return nothing
        if middle.status is not Status.OK:
            return nothing

        def solve(name: str, value: float) -> Figures:
            return self.solved(np.array([*(numbers | {name: value}).values()]))

        found = slopes_of(solve, nominal, middle, numbers, figures)
        return {f: [found[n][f] if n in found else NONE for n in numbers] for f in figures}


def scatter_of(
    problem: Problem, study: Study, spreads: Mapping[str, Spread], figure: str,
    slopes: Sequence[Slope], limits: Mapping[str, Limits],
) -> Scatter:  # fmt: skip
    """The scatter of one figure, of which `slopes` are the nominal derivatives by each number."""
    set_stage(f"worst case of {words(figure)}")
    plan, names = problem
    system = plan.configuration["units"]
    values = study.results[figure] * units.factor(unit_kind(figure), system)
    answered = np.isfinite(values)
    if answered.sum() < FEWEST:
        codes = study.results["status"][~answered]
        why = Status(int(np.bincount(codes).argmax())) if codes.any() else Status.OK
        remedy = MESSAGES[why] if why else "give a larger size"
        rule = f"{figure} must have a value in at least {FEWEST} of {values.size} cases"
        raise InvalidValue(f"{rule}, got {answered.sum()}; {remedy}")
    kept = values[answered]
    points = np.array([s.nominal for s in spreads.values()])
    bounds = np.array([[s.low, s.high] for s in spreads.values()])
    columns = np.array([plan.every(name) for name in names])[:, answered]
    tried = columns[:, [int(kept.argmin()), int(kept.argmax())]].T

    def slopes_at(point: FloatArray) -> FloatArray:
        nominal = (point == points).all()
        found = slopes if nominal else problem.slopes([figure], point)[figure]
        # a kink with slopes of one sign is as good as a slope of that sign
        return np.array([s.steeper if s.below * s.above >= 0.0 else math.nan for s in found])

    worst = worst_case(partial(problem.value, figure), slopes_at, bounds, points, tried)
    covariance = _covariance(plan, spreads, slopes)
    variances, total = covariance.sum(axis=1), float(covariance.sum())
    order: Any = np.argsort(-variances) if math.isfinite(total) else ()
    shares = {names[i]: float(variances[i] / (total or 1.0)) for i in order}
    active = np.flatnonzero(covariance.diagonal() > 1e-6 * total)
    factors = equal_factors(covariance[np.ix_(active, active)])
    factor_of = dict(zip([names[i] for i in active], factors.tolist(), strict=True))
    inside = capability = ends = None
    if figure in limits:
        ends = limits[figure]
        inside = intervals.share((values >= ends[0]) & (values <= ends[1]))
        capable = partial(intervals.capability, low=ends[0], high=ends[1])
        capability = estimate(capable, kept)
    return Scatter(
        nominal=problem.value(figure, points),
        worst=worst,
        sigma=math.sqrt(total) if math.isfinite(total) else math.nan,
        slopes={name: slope.steeper for name, slope in zip(names, slopes, strict=True)},
        contributions=shares,
        balanced={name: factor_of[name] for name in shares if name in factor_of},
        mean=estimate(intervals.mean, kept),
        deviation=estimate(intervals.deviation, kept),
        quantiles={level: intervals.quantile(kept, level) for level in LEVELS},
        inside=inside,
        capability=capability,
        limits=ends,
    )


def _covariance(
    plan: StudyPlan, spreads: Mapping[str, Spread], slopes: Sequence[Slope]
) -> FloatArray:
    """Covariances of the effects of the numbers, to first order."""
    names, every = list(spreads), list(spreads.values())
    pairs = plan.configuration["sample"].get("correlations", [])
    matrix = correlation_matrix(pairs, names) if pairs else np.eye(len(names))
    with np.errstate(invalid="ignore"):  # of an infinite slope
        kinked = [s.kinked(x.below, x.above) for s, x in zip(every, slopes, strict=True)]
        variances, lines = np.array(kinked).T
        scaled = lines * [s.sigma for s in every]
        covariance = np.where(matrix == 0.0, 0.0, matrix * np.outer(scaled, scaled))
    np.fill_diagonal(covariance, variances)
    return covariance


def equal_factors(covariance: FloatArray) -> FloatArray:
    """Factors of the effects with which all have equal shares of the same variance."""
    alone, wanted = covariance.diagonal(), covariance.sum() / max(len(covariance), 1)
    factors: FloatArray = np.sqrt(wanted / alone)
    if (covariance == np.diag(alone)).all():
        return factors
    # the share of each rises with its own factor: a quadratic equation for each in turn
    for _ in range(ROUNDS):
        for i, row in enumerate(covariance):
            others = row @ factors - row[i] * factors[i]
            factors[i] = (np.sqrt(others**2 + 4.0 * row[i] * wanted) - others) / (2.0 * row[i])
    return factors
