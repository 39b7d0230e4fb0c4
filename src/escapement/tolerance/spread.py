"""The distribution of a number with a tolerance: its mean, standard deviation and ends."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import isclose
from typing import Any

import numpy as np

from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.wheel_checks import IMPERFECT
from escapement.study.parse.columns import drawn_values
from escapement.study.plan import StudyPlan

ENDS = 3.0
"""The worst case of a normal distribution is taken this many standard deviations out."""
_Z = np.linspace(-8.0, 8.0, 641)


@dataclass(frozen=True)
class Spread:
    """A number of a plan with a tolerance, in SI.

    nominal, mean, sigma : its nominal value, mean and standard deviation.
    low, high : its ends; for a normal distribution without ends, three standard deviations from
        the mean.
    above, below : of its distance from the nominal value, where it is greater and where it is less:
        the mean and the mean square over all cases.
    """

    nominal: float
    mean: float
    sigma: float
    low: float
    high: float
    above: tuple[float, float]
    below: tuple[float, float]

    def kinked(self, below: float, above: float) -> tuple[float, float]:
        """Variance of a figure with two slopes, and the slope of the line closest to it."""
        (more, up), (less, down) = self.above, self.below
        mean = above * more - below * less
        slope = (above * up + below * down - mean * (more - less)) / self.sigma**2
        return above**2 * up + below**2 * down - mean**2, slope


def spreads_of(plan: StudyPlan, given: Mapping[str, float]) -> dict[str, Spread]:
    """The spread of every sampled number, by name.

    A plan has no nominal value of a number that is drawn between two ends: it is the one in
    `given` [SI], or the mean.
    """
    from scipy.special import ndtr

    # the ends of a distribution without limits, its limits, and its whole width
    shares = np.concatenate([ndtr([-ENDS, ENDS]), [0.0, 1.0], ndtr(_Z)])
    density = np.exp(-0.5 * _Z**2)
    weights = density / density.sum()
    found = {}
    for name in plan.sampled:
        entry, form = plan.parameters[name], form_of(plan, name)
        nominal = plan.fixed_si.get(name)
        nominal = given.get(name) if nominal is None else nominal
        nominal = 0.0 if nominal is None and name.startswith(IMPERFECT) else nominal
        nominal_in_unit = None if nominal is None else nominal / entry.to_si(1.0)
        values: FloatArray = entry.to_si(drawn_values(form, entry, nominal_in_unit, shares))
        outermost, limits, inner = np.split(values, [2, 4])
        bounded = any(x in form for x in ("tolerance", "relative_tolerance", "low"))
        low, high = (limits if bounded else outermost).tolist()
        mean = float(weights @ inner)
        middle = mean if nominal is None else float(nominal)
        sigma = float(np.sqrt(weights @ (inner - mean) ** 2))
        above, below = (
            (float(weights @ side), float(weights @ side**2))
            for side in (np.maximum(inner - middle, 0.0), np.maximum(middle - inner, 0.0))
        )
        found[name] = Spread(
            nominal=middle, mean=mean, sigma=sigma, low=low, high=high, above=above, below=below
        )
    return found


def form_of(plan: StudyPlan, name: str) -> Mapping[str, Any]:
    """The distribution of a sampled number."""
    table: Mapping[str, Any] = plan.configuration["sample"]
    found: Mapping[str, Any] = table[name if name in table else name.rpartition("_")[0]]
    return found


def grouped(values: Mapping[str, Any]) -> dict[str, list[str]]:
    """Names of numbers, those of a list under its name if all of them have one value.

    Shares that differ by rounding errors count as one.
    """
    lists: dict[str, list[str]] = {}
    for name in values:
        lists.setdefault(re.sub(r"_\d+$", "", name), []).append(name)
    found: dict[str, list[str]] = {}
    for key, names in lists.items():
        first, *others = (values[name] for name in names)
        alike = (
            x == first or (type(x) is float and isclose(x, first, rel_tol=1e-6)) for x in others
        )
        found |= {key: names} if names != [key] and all(alike) else {name: [name] for name in names}
    return found
