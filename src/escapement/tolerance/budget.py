"""`budget`: what the tolerances of a drawing do to figures of merit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from escapement import simulation, units, validate
from escapement.errors import InvalidValue
from escapement.files import AnyPath
from escapement.mechanism import FloatArray
from escapement.model import Escapement
from escapement.status import Status
from escapement.study.parse import parse_plan, plan_from
from escapement.study.plan import StudyPlan, unit_kind
from escapement.study.result import Study
from escapement.study.run import run_plan
from escapement.study.varied import correlation_matrix, drawn_values
from escapement.text import Shown
from escapement.tolerance import intervals
from escapement.tolerance.differences import needs_differences, slopes_by
from escapement.tolerance.figures import figures_of
from escapement.tolerance.indices import sobol_indices
from escapement.tolerance.intervals import Estimate, estimate
from escapement.tolerance.law import numbers_of
from escapement.tolerance.sensitivities import corners_of
from escapement.tolerance.spread import Spread, spreads_of
from escapement.tolerance.worst_case import Worst, worst_case

LEVELS = (0.01, 0.05, 0.5, 0.95, 0.99)
"""Shares of cases whose quantiles are given."""
Limits = tuple[float, float]


@dataclass(frozen=True, repr=False)
class Scatter(Shown):
    """What the tolerances do to one figure, in SI.

    nominal : its value without them.
    worst : its ends when every number is at the worst place of its tolerance; of a normal
        distribution without ends these are three standard deviations out.
    sigma : standard deviation to first order, the root of the sum of squares.
    slopes : its derivative by each number; where it has a corner, that of the steeper side.
    contributions : share of each number in the variance to first order, greatest first.
    balanced : by which factor each tolerance may change so that all contribute alike to the same
        sigma: below 1 it is to be tightened, above 1 it may be relaxed.
    mean, deviation : of the sample.
    quantiles : by share of the cases.
    inside : share of the cases within the limits; those without an answer are outside.
    capability : C_pk, the distance of the mean from the nearer limit over 3 deviations.
    limits : the least and greatest value allowed.
    first, total : Sobol' indices of each number, empty unless they were asked for.
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


@dataclass(frozen=True, repr=False)
class Budget(Shown):
    """What tolerances do to figures of merit.

    figures : the `Scatter` of each figure.
    spreads : mean, standard deviation and ends of each number.
    study : the sample.
    failed : share of its cases without an answer.
    seed, size : of the sample.
    message : what could not be said, and why.
    """

    figures: dict[str, Scatter]
    spreads: dict[str, Spread]
    study: Study
    failed: Estimate
    seed: int
    size: int
    message: str

    def _shown(self) -> list[tuple[str, Any, str]]:
        rows: list[tuple[str, Any, str]] = [("cases", self.size, ""), ("seed", self.seed, "")]
        for name, scatter in self.figures.items():
            rows += [(f"{name} sigma/nominal", scatter.sigma / scatter.nominal, "")]
            rows += [(f"{name} yield", scatter.inside.value, "")] if scatter.inside else []
        return rows


def budget(
    escapement: Escapement,
    tolerances: Mapping[str, Any],
    *,
    limits: Mapping[str, Limits] | None = None,
    figures: Sequence[str] = (),
    method: str = "random",
    size: int = 10_000,
    seed: int = 0,
    correlations: Sequence[tuple[str, str, float]] = (),
    indices: int = 0,
    path: AnyPath | None = None,
    workers: int = 1,
) -> Budget:
    """Scatter of figures of merit from the tolerances of a drawing.

    Parameters
    ----------
    escapement : Escapement
        The nominal design.
    tolerances : Mapping
        The distribution of each number that scatters [SI], as in the sample of a study:
        {"tolerance": 1e-5}, {"relative_standard_deviation": 0.02}, {"low": 0.15, "high": 0.25}.
        A list, such as slot_angle_errors, is drawn for each part alone.
    limits : Mapping, optional
        Least and greatest value that is allowed of figures [SI], (low, high).
    figures : sequence of str, optional
        Figures besides those with limits. Default: the period.
    method : str
        "random" or "latin-hypercube", of which twenty are drawn; "random" gives the intervals
        that hold without further assumptions.
    size, seed : int
        Cases of the sample, and where its random numbers begin.
    correlations : sequence of (name, name, number), optional
        Correlations between numbers; those of their normal scores, where they are not normal.
    indices : int
        Cases n for Sobol' indices, for which (numbers + 2) n more are solved; 0 for none.
    path : path, optional
        File for the sample, as of `sweep`.
    workers : int
        Threads that compute.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, or the nominal design has no terminal cycle.
    """
    sample: dict[str, Any] = {"method": method, "size": size, "seed": seed, **tolerances}
    if method == "latin-hypercube":
        sample["hypercubes"] = 20
    if correlations:
        sample["correlations"] = [list(pair) for pair in correlations]
    wanted = [*dict.fromkeys([*(limits or {}), *figures])] or ["period"]
    plan = plan_from(escapement, {}, sample=sample, results=wanted)
    options: Any = {"indices": indices, "path": path, "workers": workers}
    return budget_of(plan, limits or {}, given=numbers_of(escapement.held), **options)


def budget_of(
    plan: StudyPlan,
    limits: Mapping[str, Limits],
    *,
    given: Mapping[str, float] | None = None,
    indices: int = 0,
    **options: Any,
) -> Budget:
    """The budget of a planned sample; arguments and errors as of `budget`, `limits` in SI.

    `given` are nominal values of numbers that the plan draws between two ends; by default they
    are the means.
    """
    drawn = plan.configuration.get("sample", {})
    if "sweep" in plan.configuration or drawn.get("method") not in ("random", "latin-hypercube"):
        raise InvalidValue(
            "a budget must have a sample alone, with method 'random' or 'latin-hypercube', got "
            f"{drawn.get('method', 'a sweep')!r}; leave [sweep] out"
        )
    for name, ends in limits.items():
        validate.choice("limits", name, tuple(plan.results))
        if not (len(ends) == 2 and ends[0] < ends[1]):
            raise validate.fail(f"limits.{name}", "(low, high), low below high", ends, "swap them")
    spreads = spreads_of(plan, given or {})
    plan.fixed_si.update({name: spread.nominal for name, spread in spreads.items()})
    nominal = plan.built(plan.fixed_si)
    found = simulation.terminal(nominal)
    if found.status is not Status.OK:
        raise InvalidValue(f"the nominal design must have a terminal cycle: {found.message}")
    study = run_plan(plan, **options)
    names = [name for name in plan.results if name != "status"]
    scatters = {name: _scatter(plan, nominal, study, spreads, name, limits) for name in names}
    if indices:
        _add_indices(plan, scatters, indices, int(drawn["seed"]))
    failed = intervals.share(study.results["status"] != Status.OK)
    message = "done" if failed.value == 0.0 else "cases without an answer count as outside limits"
    sized = int(drawn["size"])
    return Budget(scatters, spreads, study, failed, int(drawn["seed"]), sized, message)


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


def _scatter(
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
    """Derivatives, what each number adds to the variance, and the variance to first order."""
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


def _add_indices(plan: StudyPlan, scatters: dict[str, Scatter], size: int, seed: int) -> None:
    """Add the Sobol' indices of every figure."""
    table = plan.configuration["sample"]
    names = list(plan.sampled)
    if table.get("correlations"):
        raise InvalidValue("indices must be 0 with correlations, which they do not allow for")
    solved: dict[str, FloatArray] = {}

    def evaluate(shares: FloatArray, figure: str) -> FloatArray:
        if not solved:
            columns = {}
            for name, share in zip(names, shares, strict=True):
                entry, nominal = plan.parameters[name], plan.fixed_si.get(name) or 0.0
                form = table[name if name in table else name.rpartition("_")[0]]
                columns[name] = drawn_values(form, entry, nominal / entry.to_si(1.0), share)
            again = {"sample": {"method": "list", **columns}}
            own = None if isinstance(plan.build, type) else plan.build
            solved.update(run_plan(parse_plan(plan.configuration | again, mechanism=own)).results)
        values = solved[figure].astype(float)
        return np.where(np.isfinite(values), values, np.nanmean(values))

    for figure, scatter in scatters.items():
        find = partial(evaluate, figure=figure)
        first, total = sobol_indices(find, len(names), size, seed)
        scatter.first.update(zip(names, first, strict=True))
        scatter.total.update(zip(names, total, strict=True))
