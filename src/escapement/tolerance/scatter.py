"""The scatter of one figure of merit: worst case, first order, and its sample."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from escapement.base import units
from escapement.base.errors import InvalidValue
from escapement.base.progress import set_stage
from escapement.base.status import MESSAGES, Status
from escapement.base.text import Shown, words
from escapement.dynamics.figure_table import TRANSIENT
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines import simulate as simulation
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.wheel_checks import IMPERFECT
from escapement.model.escapement import Escapement
from escapement.model.numbers import numbers_of
from escapement.study.parse.sample import correlation_matrix
from escapement.study.plan import StudyPlan, unit_kind
from escapement.study.result import Study
from escapement.tolerance import intervals
from escapement.tolerance.differences import lossless, needs_differences, slopes_by
from escapement.tolerance.figure_duals import figures_of
from escapement.tolerance.intervals import Estimate, estimate
from escapement.tolerance.spread import Spread
from escapement.tolerance.worst_case import Worst, worst_case

LEVELS = (0.01, 0.05, 0.5, 0.95, 0.99)
"""Shares of cases whose quantiles are given."""
FEWEST = 20
"""Cases that an estimate needs at least."""
ROUNDS = 200
"""Rounds of the iteration for equal shares of correlated numbers."""
OF_ERRORS = ("beat_error", "blow_max")
"""Figures that are 0 for perfect parts."""
Limits = tuple[float, float]
Corners = Mapping[str, Mapping[str, tuple[float, float]]]
"""By figure and number, the derivatives below and above."""


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


def _solved(plan: StudyPlan, names: Sequence[str], point: FloatArray) -> tuple[Escapement, Figures]:
    """An escapement with values of some numbers, and its figures."""
    values = plan.fixed_si | dict(zip(names, point.tolist(), strict=True))
    timer = plan.built(values)
    return timer, simulation.terminal(timer, initial_speed=values["initial_speed"] or 0.0)


def _slopes(plan: StudyPlan, names: Sequence[str], figure: str, point: FloatArray) -> FloatArray:
    """Derivatives of a figure at values of some numbers; NaN where there are none."""
    nothing = np.full(len(names), math.nan)
    try:
        timer, found = _solved(plan, names, point)
    except InvalidValue:
        return nothing
    if found.status is not Status.OK:
        return nothing
    values = dict(zip(names, point.tolist(), strict=True))
    slopes, known = dict.fromkeys(names, 0.0), numbers_of(timer.held)
    if figure in TRANSIENT and (values | plan.fixed_si)["initial_speed"]:
        return nothing
    # errors of perfect parts have two derivatives; of what is left a cycle does not depend
    slopes |= {name: math.nan for name in names if name.startswith(IMPERFECT)}
    apart = names if needs_differences(timer) else lossless(timer)
    exact = [name for name in names if name in known and name not in apart]
    for name in {*names} & {*apart} & {*known}:
        found_by = slopes_by(timer, name, values[name], (figure,)) if values[name] else {}
        slopes[name] = found_by.get(figure, (math.nan,))[0]
    if exact:
        slopes |= _exact(timer, found, exact, figure)
    return np.array([slopes[name] for name in names])


def _exact(
    timer: Escapement, found: Figures, names: Sequence[str], figure: str
) -> dict[str, float]:
    """Derivatives of a figure by numbers for which the equation of motion is differentiated."""
    if figure in OF_ERRORS and not timer.mechanism.errors:
        return dict.fromkeys(names, 0.0)
    duals, _ = figures_of(timer.held, found, tuple(names), (figure,))
    slopes = duals[figure].slopes.tolist() if figure in duals else [math.nan] * len(names)
    return dict(zip(names, slopes, strict=True))


def _value(plan: StudyPlan, names: Sequence[str], figure: str, point: FloatArray) -> float:
    """A figure at values of some numbers; NaN where it has none."""
    try:
        return float(getattr(_solved(plan, names, point)[1], figure))
    except InvalidValue:
        return math.nan


def scatter_of(
    plan: StudyPlan,
    nominal: Escapement,
    study: Study,
    spreads: Mapping[str, Spread],
    figure: str,
    limits: Mapping[str, Limits],
    corners: Corners,
) -> Scatter:
    """The scatter of one figure; `corners` has its two slopes by errors of perfect parts."""
    set_stage(f"worst case of {words(figure)}")
    system = plan.configuration["units"]
    values = study.results[figure] * units.factor(unit_kind(figure), system)
    answered = np.isfinite(values)
    if answered.sum() < FEWEST:
        codes = study.results["status"][~answered]
        why = Status(int(np.bincount(codes).argmax())) if codes.any() else Status.OK
        remedy = MESSAGES[why] if why else "give a larger size"
        rule = f"{figure} must have a value in at least {FEWEST} of {values.size} cases"
        raise InvalidValue(f"{rule}, got {answered.sum()}; {remedy}")
    names, kept = list(spreads), values[answered]
    points = np.array([s.nominal for s in spreads.values()])
    bounds = np.array([[s.low, s.high] for s in spreads.values()])
    columns = np.array([plan.every(name) for name in names])[:, answered]
    tried = columns[:, [int(kept.argmin()), int(kept.argmax())]].T
    inputs = (plan, names, figure)
    sides = {name: corners.get(figure, {}).get(name, (math.nan, math.nan)) for name in names}
    # a kink with slopes of one sign is as good as a slope of that sign
    alike = np.array(
        [below if below * above > 0.0 else math.nan for below, above in sides.values()]
    )

    def slopes_at(point: FloatArray) -> FloatArray:
        found = _slopes(*inputs, point)
        at_kink = np.isnan(found) & (point == points)
        return np.where(at_kink, alike, found)

    worst = worst_case(partial(_value, *inputs), slopes_at, bounds, points, tried)
    slopes, covariance = _first_order(plan, nominal, spreads, figure, corners)
    variances, total = covariance.sum(axis=1), float(covariance.sum())
    order: Any = np.argsort(-variances) if math.isfinite(total) else ()
    shares = {names[i]: float(variances[i] / (total or 1.0)) for i in order}
    active = np.flatnonzero(covariance.diagonal() > 1e-6 * total)
    factors = equal_factors(covariance[np.ix_(active, active)])
    factor_of = dict(zip([names[i] for i in active], factors.tolist(), strict=True))
    groups = plan.configuration["sample"].get("hypercubes", 1) if answered.all() else 1
    inside = capability = ends = None
    if figure in limits:
        ends = limits[figure]
        inside = intervals.share((values >= ends[0]) & (values <= ends[1]), groups)
        capable = partial(intervals.capability, low=ends[0], high=ends[1])
        capability = estimate(capable, kept, groups)
    return Scatter(
        nominal=_value(*inputs, points),
        worst=worst,
        sigma=math.sqrt(total) if math.isfinite(total) else math.nan,
        slopes=dict(zip(names, slopes.tolist(), strict=True)),
        contributions=shares,
        balanced={name: factor_of[name] for name in shares if name in factor_of},
        mean=estimate(intervals.mean, kept, groups),
        deviation=estimate(intervals.deviation, kept, groups),
        quantiles={level: intervals.quantile(kept, level, groups) for level in LEVELS},
        inside=inside,
        capability=capability,
        limits=ends,
    )


def _first_order(
    plan: StudyPlan,
    nominal: Escapement,
    spreads: Mapping[str, Spread],
    figure: str,
    corners: Corners,
) -> tuple[FloatArray, FloatArray]:
    """Derivatives, and covariances of the effects of the numbers, to first order."""
    names = list(spreads)
    points = np.array([s.nominal for s in spreads.values()])
    slopes = _slopes(plan, names, figure, points)
    lines = slopes.copy()
    variances = (slopes * [s.sigma for s in spreads.values()]) ** 2
    for i, name in enumerate(names):
        if name in corners.get(figure, {}):
            below, above = corners[figure][name]
            slopes[i] = above if abs(above) > abs(below) else below
            variances[i], lines[i] = spreads[name].kinked(below, above)
    pairs = plan.configuration["sample"].get("correlations", [])
    matrix = correlation_matrix(pairs, names) if pairs else np.eye(len(names))
    scaled = lines * [s.sigma for s in spreads.values()]
    with np.errstate(invalid="ignore"):  # of an infinite slope
        covariance = np.where(matrix == 0.0, 0.0, matrix * np.outer(scaled, scaled))
    np.fill_diagonal(covariance, variances)
    return slopes, covariance


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
