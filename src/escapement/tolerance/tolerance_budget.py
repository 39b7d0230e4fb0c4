"""`tolerance_budget`: effects of the tolerances of a drawing on figures of merit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from numbers import Real
from typing import Any

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.files import AnyPath
from escapement.base.progress import set_stage
from escapement.base.status import Status
from escapement.base.text import Shown
from escapement.base.validate import known_keys
from escapement.dynamics.figure_table import FIGURES
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.model.numbers import numbers_of
from escapement.study.cases import solved
from escapement.study.parse import parse_plan, plan_from
from escapement.study.parse.columns import drawn_values
from escapement.study.plan import StudyPlan
from escapement.study.result import Study
from escapement.study.running import run_plan
from escapement.tolerance import intervals
from escapement.tolerance.derivatives import told
from escapement.tolerance.indices import sobol_indices
from escapement.tolerance.intervals import Estimate
from escapement.tolerance.permitted import Inverse, Permitted
from escapement.tolerance.scatter import FEWEST, Limits, Problem, Scatter, scatter_of
from escapement.tolerance.spread import Spread, form_of, spreads_of

WIDTHS = ("tolerance", "relative_tolerance")
"""Limits of a figure by their distance from its nominal value."""


@dataclass(frozen=True, repr=False)
class Budget(Shown):
    """Effects of tolerances on figures of merit.

    figures : the `Scatter` of each figure.
    spreads : mean, standard deviation and ends of each number.
    study : the sample.
    failed : share of its cases that could not be computed.
    seed, size : of the sample.
    permitted : by wanted yield, the ranges that give it: of all numbers scaled by one factor, under
        "all", and of each alone while the others keep their nominal values.
    message : limitations of the result, and their reasons.
    """

    figures: dict[str, Scatter]
    spreads: dict[str, Spread]
    study: Study
    failed: Estimate
    seed: int
    size: int
    message: str
    permitted: dict[float, dict[str, Permitted]] = field(default_factory=dict)

    def _shown(self) -> list[tuple[str, Any, str]]:
        rows: list[tuple[str, Any, str]] = [("cases", self.size, ""), ("seed", self.seed, "")]
        for name, scatter in self.figures.items():
            if scatter.nominal and math.isfinite(scatter.sigma):
                rows += [(f"{name} sigma/nominal", scatter.sigma / scatter.nominal, "")]
            rows += [(f"{name} yield", scatter.inside.value, "")] if scatter.inside else []
        return rows


def budget(
    escapement: Escapement,
    tolerances: Mapping[str, Any],
    *,
    limits: Mapping[str, Limits | Mapping[str, float]] | None = None,
    figures: Sequence[str] = (),
    size: int = 10_000,
    seed: int = 0,
    correlations: Sequence[tuple[str, str, float]] = (),
    indices: int = 0,
    yields: Sequence[float] = (),
    path: AnyPath | None = None,
    workers: int = 1,
    **run: Any,
) -> Budget:
    """Scatter of figures of merit from the tolerances of a drawing.

    Parameters
    ----------
    escapement : Escapement
        The nominal design.
    tolerances : Mapping
        The distribution of each number that scatters [SI], as in the sample of a study:
        {"tolerance": 1e-5}, {"relative_standard_deviation": 0.02}, {"low": 0.15, "high": 0.25}.
        A list, such as slot_angle_errors, is drawn independently for each part.
    limits : Mapping, optional
        Least and greatest allowed value of figures [SI], (low, high); infinite for none. Or a
        distance from the nominal value: {"relative_tolerance": 0.05} or {"tolerance": 0.002}.
    figures : sequence of str, optional
        Figures besides those with limits. Default: the period.
    size, seed : int
        Number of cases of the sample, and the seed of its random numbers.
    correlations : sequence of (name, name, number), optional
        Correlations between numbers; for distributions that are not normal, those of the normal
        scores.
    indices : int
        Cases n for Sobol' indices, for which (numbers + 2) n more are solved; 0 for none.
    yields : sequence of float, optional
        Shares of good cases, such as (0.95, 0.99), for which to find the permitted ranges; a case
        is good if all figures are within their limits. Each takes some 10 000 cases a number.
    path : path, optional
        File for the sample, as of `sweep`.
    workers : int
        Threads that compute.
    **run : float, optional
        `turns` of the driver, of which `run_time` is the time, and `initial_speed` [rad/s].

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, or the nominal design has no terminal cycle.
    """
    sample: dict[str, Any] = {"method": "random", "size": size, "seed": seed, **tolerances}
    if len(correlations):
        sample["correlations"] = [*correlations]
    named = [figures] if isinstance(figures, str) else figures
    wanted = [*dict.fromkeys([*(limits or {}), *named])] or ["period"]
    for name in wanted:
        validate.choice("limits" if name in (limits or {}) else "figures", name, (*FIGURES,))
    known_keys(run, ("turns", "initial_speed"), "of budget")
    plan = plan_from(escapement, {}, sample=sample, results=wanted, **run)
    options: Any = {"indices": indices, "yields": yields, "path": path, "workers": workers}
    return budget_of(plan, limits or {}, given=numbers_of(escapement.held), **options)


def budget_of(
    plan: StudyPlan,
    limits: Mapping[str, Any],
    *,
    given: Mapping[str, float] | None = None,
    indices: int = 0,
    yields: Sequence[float] = (),
    **options: Any,
) -> Budget:
    """The budget of a planned sample; arguments and errors as of `budget`, `limits` in SI.

    `given` are nominal values of numbers that the plan draws between two ends; by default they
    are the means.
    """
    drawn = plan.configuration.get("sample", {})
    if "sweep" in plan.configuration or drawn.get("method") != "random":
        raise InvalidValue(
            "a budget must have a sample alone, with method 'random', of which the cases are "
            f"independent, got {drawn.get('method', 'a sweep')!r}; leave [sweep] out"
        )
    checked = {name: _checked(plan, name, pair) for name, pair in limits.items()}
    wanted = _wanted(yields, limits)
    if indices:
        validate.integer("indices", indices, 2, "give 0 for none")
        if drawn.get("correlations"):
            raise InvalidValue(
                "indices must be 0 with correlations, because they assume independent numbers"
            )
    _try_cases(plan)
    spreads = spreads_of(plan, given or {})
    plan.fixed_si.update({name: spread.nominal for name, spread in spreads.items()})
    found = solved(plan, plan.fixed_si)
    if found.status is not Status.OK:
        raise InvalidValue(f"the nominal design must have a terminal cycle: {found.message}")
    ends = {name: _around(pair, getattr(found, name)) for name, pair in checked.items()}
    set_stage(f"solving {plan.cases} cases")
    study = run_plan(plan, **options)
    names = [name for name in plan.results if name != "status"]
    problem = Problem(plan, (*spreads,))
    set_stage("derivatives")
    slopes = problem.slopes(names, np.array([spread.nominal for spread in spreads.values()]))
    scatters = {
        name: scatter_of(problem, study, spreads, name, slopes[name], ends) for name in names
    }
    if indices:
        _add_indices(plan, scatters, indices, int(drawn["seed"]))
    inverse = Inverse(plan, spreads, ends)
    permitted = {share: inverse.permitted(share) for share in wanted}
    failed = intervals.share(study.results["status"] != Status.OK)
    lost = "cases that could not be computed count as outside the limits"
    notes = [plan.idle] if plan.idle else []
    notes += [lost] if failed.value else []
    notes += filter(None, (_without(name, scatter) for name, scatter in scatters.items()))
    message = "; ".join(notes) or "done"
    return Budget(
        figures=scatters, spreads=spreads, study=study, failed=failed, seed=int(drawn["seed"]),
        size=int(drawn["size"]), message=message, permitted=permitted,
    )  # fmt: skip


def _checked(plan: StudyPlan, name: str, ends: Any) -> Limits | tuple[str, float]:
    """The limits of a figure, of which one may be infinite; or the kind and size of a tolerance."""
    validate.choice("limits", name, tuple(key for key in plan.results if key != "status"))
    if isinstance(ends, Mapping):
        known_keys(ends, WIDTHS, f"in limits.{name}")
        if len(ends) != 1:
            remedy = "write for example { relative_tolerance = 0.05 }"
            raise validate.fail(f"limits.{name}", "one tolerance", dict(ends), remedy)
        ((key, size),) = ends.items()
        return key, validate.positive(f"limits.{name}.{key}", size, "give a tolerance")
    pair = isinstance(ends, Sequence | np.ndarray) and not isinstance(ends, str) and len(ends) == 2
    if not pair or any(type(x) is bool or not isinstance(x, Real) or x != x for x in ends):
        remedy = "write -inf or inf for none"
        raise validate.fail(f"limits.{name}", "two numbers, (low, high)", ends, remedy)
    low, high = map(float, ends)
    if not low < high:
        raise validate.fail(f"limits.{name}", "(low, high), low below high", ends, "swap them")
    return low, high


def _around(ends: Limits | tuple[str, float], nominal: float) -> Limits:
    """Limits that were checked, from a tolerance those around the nominal value."""
    if not isinstance(ends[0], str):
        return ends
    width = ends[1] * abs(nominal) if ends[0] == WIDTHS[1] else ends[1]
    return nominal - width, nominal + width


def _wanted(yields: Sequence[float], limits: Mapping[str, Any]) -> list[float]:
    """Wanted shares of good cases."""
    if len(yields) and not limits:
        raise InvalidValue("yields must come with limits of figures, got none; give limits")
    rule, remedy = "between 0 and 1", "give for example 0.95"
    found = [validate.number("yields", share, remedy) for share in yields]
    for share in found:
        if not 0.0 < share < 1.0:
            raise validate.fail("yields", rule, share, remedy)
    return found


def _try_cases(plan: StudyPlan) -> None:
    """Refuse a plan of which none of the first cases can be built, before any of it is solved."""
    for case in range(min(FEWEST, plan.cases)):
        try:
            plan.escapement(case)
        except InvalidValue as error:
            why = error
        else:
            return
    raise why


def _without(figure: str, scatter: Scatter) -> str:
    """What a figure lacks, and the reason; "" if nothing."""
    lacking = [name for name, slope in scatter.slopes.items() if not math.isfinite(slope)]
    notes = []
    if lacking:
        without = "so that its scatter to first order and the shares are left out"
        notes += [f"{told(figure, lacking)}, {without}"]
    if not math.isfinite(scatter.worst.low + scatter.worst.high):
        notes += [f"{figure} has no value at one of its worst cases"]
    return "; ".join(notes)


def _add_indices(plan: StudyPlan, scatters: dict[str, Scatter], size: int, seed: int) -> None:
    """Add the Sobol' indices of every figure."""
    names = list(plan.sampled)
    solved: dict[str, FloatArray] = {}

    def evaluate(shares: FloatArray, figure: str) -> FloatArray:
        if not solved:
            columns = {}
            for name, share in zip(names, shares, strict=True):
                entry, nominal = plan.parameters[name], plan.fixed_si.get(name) or 0.0
                form = form_of(plan, name)
                columns[name] = drawn_values(form, entry, nominal / entry.to_si(1.0), share)
            again = {"sample": {"method": "list", **columns}}
            mechanism = None if isinstance(plan.build, type) else plan.build
            solved.update(
                run_plan(parse_plan(plan.configuration | again, mechanism=mechanism)).results
            )
        values = solved[figure].astype(float)
        return np.where(np.isfinite(values), values, np.nanmean(values))

    for figure, scatter in scatters.items():
        find = partial(evaluate, figure=figure)
        first, total = sobol_indices(find, len(names), size, seed)
        scatter.first.update(zip(names, first, strict=True))
        scatter.total.update(zip(names, total, strict=True))
