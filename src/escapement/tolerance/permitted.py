"""The inverse of a budget: ranges of the numbers with which a wanted share of the parts is good.

Every range is scaled about its nominal value, in shares of the range given: all ranges by one
factor, and each alone while the other numbers keep their nominal values. The share of good cases
is computed at the same points of a Sobol' sequence for every factor, so that it falls steadily, and
once more from random cases for the factor found.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from escapement.base.progress import set_stage
from escapement.base.units import factor as factor_of
from escapement.mechanisms.protocol import FloatArray
from escapement.study.parse import parse_plan
from escapement.study.plan import StudyPlan, unit_kind
from escapement.study.running import run_plan
from escapement.tolerance import intervals
from escapement.tolerance.intervals import Estimate
from escapement.tolerance.scatter import Limits
from escapement.tolerance.spread import Spread, form_of, grouped

MOST = 64.0
"""Greatest factor that is tried."""
CLOSE = 1e-4
"""Factors that differ by less, as a share, are equal."""
_ALONE, _TOGETHER = 1024, 8192
"""Points at which the share of one number's cases, and of several, is computed; no more than the
sample has cases."""


class Permitted(NamedTuple):
    """Ranges with which a wanted share of the cases is within all limits, in SI.

    factor : by which the ranges given are multiplied; 0 if the nominal design is outside.
    ranges : ends of each number; for a normal distribution three standard deviations from the mean.
        A list of errors has one range.
    inside : share within the limits of random cases from these ranges.
    bounded : whether the limits bound them; otherwise a number reaches the end of what is possible,
        or the figures hardly depend on it.
    """

    factor: float
    ranges: dict[str, Limits]
    inside: Estimate
    bounded: bool


@dataclass(frozen=True)
class Inverse:
    """What to scale: the plan of a budget, the spread of each number, and the limits in SI."""

    plan: StudyPlan
    spreads: Mapping[str, Spread]
    limits: Mapping[str, Limits]

    @cached_property
    def groups(self) -> dict[str, list[str]]:
        """Numbers by the name of their range: those of a list have one."""
        return grouped({name: form_of(self.plan, name) for name in self.plan.sampled})

    def permitted(self, wanted: float) -> dict[str, Permitted]:
        """The ranges for a wanted share: of all numbers, under "all", and of each alone."""
        scaled = {"all": [*self.groups]}
        scaled |= {key: [key] for key in self.groups if len(self.groups) > 1}
        return {key: self._scaled(wanted, keys) for key, keys in scaled.items()}

    def _scaled(self, wanted: float, keys: list[str]) -> Permitted:
        set_stage(f"ranges of {', '.join(keys)}")
        names = [name for key in keys for name in self.groups[key]]
        table = self.plan.configuration["sample"]
        most = min(_ALONE if len(names) == 1 else _TOGETHER, table["size"])
        draws = self._draws("sobol", 1 << (most.bit_length() - 1))

        @cache
        def missing(factor: float) -> float:
            return wanted - float(self._good(factor, names, draws).mean())

        random = self._draws("random", table["size"], table["seed"] + 1)
        reach = min(self._reach(names, drawn) for drawn in (draws, random))
        factor, bounded = _greatest(missing, min(MOST, reach))
        spans = {key: self.spreads[self.groups[key][0]] for key in keys}
        ranges = {key: self._ends(key, span, factor) for key, span in spans.items()}
        inside = intervals.share(self._good(factor, names, random))
        return Permitted(factor, ranges, inside, bounded)

    def _ends(self, key: str, span: Spread, factor: float) -> Limits:
        low, high = (self._at(self.groups[key][0], x, span.nominal, factor)
                     for x in np.array([span.low, span.high]))  # fmt: skip
        return float(low), float(high)

    def _at(self, name: str, values: Any, nominal: float, factor: float) -> Any:
        """Values at a multiple of their distance from the nominal value."""
        if self._logarithmic(name):
            return nominal * (values / nominal) ** factor
        return nominal + factor * (values - nominal)

    def _logarithmic(self, name: str) -> bool:
        form = form_of(self.plan, name)
        return bool(form.get("log")) or "log_standard_deviation" in form

    def _draws(self, method: str, size: int, seed: int = 0) -> dict[str, FloatArray]:
        """Values of every number in the units of the study, from its own distributions."""
        table = {**self.plan.configuration["sample"], "method": method, "size": size, "seed": seed}
        return self._planned(table).sampled

    def _planned(self, sample: dict[str, Any]) -> StudyPlan:
        mechanism = None if isinstance(self.plan.build, type) else self.plan.build
        # a figure without limits might take longer than all others
        asked = {"sample": sample, "results": [*self.limits]}
        return parse_plan(self.plan.configuration | asked, mechanism=mechanism)

    def _good(self, factor: float, names: list[str], draws: dict[str, FloatArray]) -> Any:
        """Whether each case is within all limits, if only these numbers vary."""
        columns = {}
        for name, values in draws.items():
            nominal = self._nominal(name)
            share = factor if name in names else 0.0
            columns[name] = self._at(name, values, nominal, share)
        results = run_plan(self._planned({"method": "list", **columns})).results
        system = self.plan.configuration["units"]
        good: Any = True
        for figure, (low, high) in self.limits.items():
            values = results[figure] * factor_of(unit_kind(figure), system)
            good = good & (values >= low) & (values <= high)
        return good

    def _nominal(self, name: str) -> float:
        return float(self.spreads[name].nominal / self.plan.parameters[name].to_si(1.0))

    def _reach(self, names: Iterable[str], draws: dict[str, FloatArray]) -> float:
        """The greatest factor at which no number breaks its rule."""
        reach = math.inf
        for name in names:
            if self._logarithmic(name):
                continue
            entry, nominal = self.plan.parameters[name], self._nominal(name)
            away = np.array([draws[name].min(), draws[name].max()]) - nominal
            for end, side in zip((entry.minimum, entry.maximum), away.tolist(), strict=True):
                if side * (end - nominal) > 0.0 and math.isfinite(end):
                    reach = min(reach, (end - nominal) / side * (1.0 - CLOSE))
        return reach


def _greatest(missing: Any, most: float) -> tuple[float, bool]:
    """The greatest factor at which nothing is missing, and whether anything is beyond it."""
    from scipy.optimize import brentq

    if missing(0.0) > 0.0:
        return 0.0, True
    low, high = 0.0, min(1.0, most)
    while missing(high) <= 0.0:
        if high == most:
            return most, False
        low, high = high, min(2.0 * high, most)
    return float(brentq(missing, low, high, xtol=CLOSE * high)), True
