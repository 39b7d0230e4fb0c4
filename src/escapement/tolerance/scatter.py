"""The scatter of one figure of merit: worst case, first order, and its sample."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from escapement import simulation, units
from escapement.errors import InvalidValue
from escapement.mechanism import FloatArray
from escapement.model import Escapement
from escapement.status import Status
from escapement.study.plan import StudyPlan, unit_kind
from escapement.study.result import Study
from escapement.study.varied import correlation_matrix
from escapement.text import Shown
from escapement.tolerance import intervals
from escapement.tolerance.differences import needs_differences, slopes_by
from escapement.tolerance.figures import figures_of
from escapement.tolerance.intervals import Estimate, estimate
from escapement.tolerance.law import numbers_of
from escapement.tolerance.sensitivities import corners_of
from escapement.tolerance.spread import Spread
from escapement.tolerance.worst_case import Worst, worst_case

LEVELS = (0.01, 0.05, 0.5, 0.95, 0.99)
"""Shares of cases whose quantiles are given."""
Limits = tuple[float, float]


@dataclass(frozen=True, repr=False)
class Scatter(Shown):
    """Effect of the tolerances on one figure, in SI.

    nominal : its value without them.
    worst : its ends with every number at the worst value within its tolerance; for a normal
        distribution without ends these are three standard deviations from the mean.
    sigma : standard deviation to first order, the root of the sum of squares.
    slopes : its derivative by each number; at a kink, that of the steeper side.
    contributions : share of each number in the variance to first order, greatest first.
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


def _slopes(plan: StudyPlan, names: Sequence[str], figure: str, place: FloatArray) -> FloatArray:
    """Derivatives of a figure at values of some numbers; NaN where there are none."""
    nothing = np.full(len(names), math.nan)
    try:
        timer = plan.built(plan.fixed_si | dict(zip(names, place.tolist(), strict=True)))
    except InvalidValue:
        return nothing
    known = numbers_of(timer.held)
    found = simulation.terminal(timer)
    if found.status is not Status.OK or any(name not in known for name in names):
        return nothing
    if needs_differences(timer):
        own = zip(names, place.tolist(), strict=True)
        each = [slopes_by(timer, name, value, (figure,)) if value else {} for name, value in own]
        return np.array([found.get(figure, (math.nan,))[0] for found in each])
    fast = not figure.startswith("rise_time")
    duals, _ = figures_of(timer.held, found, tuple(names), cycle_only=fast)
    return duals[figure].slopes if figure in duals else nothing


def _value(plan: StudyPlan, names: Sequence[str], figure: str, place: FloatArray) -> float:
    """A figure at values of some numbers; NaN where it has none."""
    try:
        timer = plan.built(plan.fixed_si | dict(zip(names, place.tolist(), strict=True)))
    except InvalidValue:
        return math.nan
    return float(getattr(simulation.terminal(timer), figure))


def scatter_of(
    plan: StudyPlan,
    nominal: Escapement,
    study: Study,
    spreads: Mapping[str, Spread],
    figure: str,
    limits: Mapping[str, Limits],
) -> Scatter:
    """The scatter of one figure."""
    system = plan.configuration["units"]
    values = study.results[figure] * units.factor(unit_kind(figure), system)
    answered = np.isfinite(values)
    if answered.sum() < 20:
        raise InvalidValue(f"{figure} must have a value in at least 20 cases, got {answered.sum()}")
    names, kept = list(spreads), values[answered]
    places = np.array([s.nominal for s in spreads.values()])
    bounds = np.array([[s.low, s.high] for s in spreads.values()])
    columns = np.array([plan.every(name) for name in names])[:, answered]
    tried = columns[:, [int(kept.argmin()), int(kept.argmax())]].T
    own = (plan, names, figure)
    worst = worst_case(partial(_value, *own), partial(_slopes, *own), bounds, places, tried)
    slopes, variances, total = _first_order(plan, nominal, spreads, figure)
    parts = variances / total if total > 0.0 else variances
    order = np.argsort(-parts)
    shares = {names[i]: float(parts[i]) for i in order}
    active = [name for name, part in shares.items() if part > 1e-6]
    balanced = {name: math.sqrt(1.0 / (len(active) * shares[name])) for name in active}
    groups = plan.configuration["sample"].get("hypercubes", 1) if answered.all() else 1
    inside = capability = ends = None
    if figure in limits:
        ends = limits[figure]
        inside = intervals.share((values >= ends[0]) & (values <= ends[1]), groups)
        capable = partial(intervals.capability, low=ends[0], high=ends[1])
        capability = estimate(capable, kept, groups)
    return Scatter(
        nominal=float(getattr(simulation.terminal(nominal), figure)),
        worst=worst,
        sigma=math.sqrt(total),
        slopes=dict(zip(names, slopes.tolist(), strict=True)),
        contributions=shares,
        balanced=balanced,
        mean=estimate(intervals.mean, kept, groups),
        deviation=estimate(intervals.deviation, kept, groups),
        quantiles={level: intervals.quantile(kept, level, groups) for level in LEVELS},
        inside=inside,
        capability=capability,
        limits=ends,
    )


def _first_order(
    plan: StudyPlan, nominal: Escapement, spreads: Mapping[str, Spread], figure: str
) -> tuple[FloatArray, FloatArray, float]:
    """Derivatives, contributions to the variance, and the variance to first order."""
    names = list(spreads)
    known = numbers_of(nominal.held)
    smooth = [name for name in names if name in known]
    places = np.array([spreads[name].nominal for name in smooth])
    slopes = np.zeros(len(names))
    slopes[[names.index(n) for n in smooth]] = _slopes(plan, smooth, figure, places)
    sigma = np.array([s.sigma for s in spreads.values()])
    pairs = plan.configuration["sample"].get("correlations", [])
    matrix = correlation_matrix(pairs, names) if pairs else np.eye(len(names))
    scaled = slopes * sigma
    variances = scaled * (matrix @ scaled)
    sharp = [name for name in names if name not in known]
    corners = corners_of(nominal.held, sharp).get(figure, {}) if sharp else {}
    for name in sharp:
        # a figure that rises by b x above 0 and by a x below it has this variance
        below, above = corners.get(name, (math.nan, math.nan))
        i, size = names.index(name), spreads[name].magnitude
        slopes[i] = above if abs(above) > abs(below) else below
        mean = 0.5 * (above - below) * size
        variances[i] = 0.5 * (above**2 + below**2) * sigma[i] ** 2 - mean**2
    return slopes, variances, float(variances.sum())
