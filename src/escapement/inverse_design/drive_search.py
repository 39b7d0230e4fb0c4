"""`design_drive`: the drives or timers that satisfy a requirement best, by studies of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import qmc

from escapement.base.files import AnyPath
from escapement.base.progress import set_stage
from escapement.base.text import Shown, show
from escapement.base.units import factor, printed
from escapement.constant_speed.indexing import IndexingDrive
from escapement.inverse_design.drive_requirement import (
    GREATER,
    SCATTER,
    DriveRequirement,
    drive_requirement,
)
from escapement.inverse_design.front import spread_out, undominated
from escapement.mechanisms.protocol import FloatArray, Mechanism
from escapement.model.escapement import Escapement
from escapement.study.parse import parse_plan
from escapement.study.plan import StudyPlan
from escapement.study.running import run_plan
from escapement.study.subject import DRIVE, ESCAPEMENT

_FIRST, _AROUND = 12, 5  # powers of two: points that are tried at first, and around a design
_FEWER = 9, 4  # the same at most of timers, which take far longer than drives
_STARTS = 8  # at least so many designs are improved, the best of which need not lead farthest
_SHRINKS = (0.1, 0.03, 0.01, 0.003, 0.001)
"""Half the widths of the boxes around designs in which better ones are looked for, in turn, as
shares of the ranges."""


@dataclass(frozen=True, repr=False)
class DriveDesign(Shown):
    """An indexing drive or an escapement that satisfies a requirement.

    drive : as `escapement.index` returns it, or the escapement at its middle friction.
    chosen : the numbers that were searched, in SI.
    values : the figures of the objectives and of the bounds, in SI.
    """

    drive: IndexingDrive | Escapement
    chosen: dict[str, float]
    values: dict[str, float]

    @property
    def mechanism(self) -> Mechanism:
        """Its mechanism."""
        return self.drive.mechanism


@dataclass(frozen=True, repr=False)
class DriveDesigns(Shown):
    """Result of `design_drive`.

    requirement : the requirement.
    designs : of which none is better than another in all objectives, by the first objective.
    tried : number of points that were evaluated.
    message : the reason if there is no design.
    """

    requirement: DriveRequirement
    designs: tuple[DriveDesign, ...]
    tried: int
    message: str


@dataclass(frozen=True)
class _Points:
    """Points in a unit cube over the ranges, and the figures there in the user's units."""

    shares: FloatArray
    values: dict[str, FloatArray]
    good: np.ndarray

    def __or__(self, other: _Points) -> _Points:
        values = {n: np.concatenate([x, other.values[n]]) for n, x in self.values.items()}
        shares = np.concatenate([self.shares, other.shares])
        return _Points(shares, values, np.concatenate([self.good, other.good]))


def design_drive(
    requirement: Mapping[str, Any] | AnyPath, *, count: int = 40, seed: int = 0
) -> DriveDesigns:
    """Find the drives or timers that satisfy a requirement, none better in everything than another.

    The ranges are searched at a Sobol' sequence; then better drives are looked for around those
    that satisfy the bounds and are not dominated, ever closer to them.

    Parameters
    ----------
    requirement : Mapping or path
        A study without axes, of an indexing drive or, with `study` = "escapement", of a timer of
        any kind, whose `friction` may be [low, high]. Three keys more are `ranges`, a table with
        the two ends of every number to search; `bounds`, a table with the least and the greatest
        value of figures; and `objectives`, a list of figures to improve. A single number as bound
        is the greatest value, but the least for those in `drive_requirement.GREATER`, which are
        also the ones that should be great.
    count : int
        Greatest number of designs, which then lie far apart.
    seed : int
        Seed of the sequence.

    Returns
    -------
    DriveDesigns
        If no point satisfies all bounds, its message names the one that prevents it.

    Raises
    ------
    InvalidValue, MissingInput, InputFileError
        As `drive_requirement`.
    """
    asked = drive_requirement(requirement)
    size = len(asked.ranges)
    first, more = _FIRST, _AROUND
    if asked.subject is ESCAPEMENT:
        first, more = min(3 + 2 * size, _FEWER[0]), min(1 + size, _FEWER[1])
    points = _tried(asked, qmc.Sobol(size, seed=seed).random_base2(first))
    tried = points.good.size
    if not points.good.any():
        return DriveDesigns(asked, (), tried, _reason(asked, points))
    around = qmc.Sobol(size, seed=seed).random_base2(more) - 0.5
    kept = max(count, _STARTS)
    best = _best(asked, points, kept, _STARTS)
    for number, shrink in enumerate(_SHRINKS, 1):
        set_stage(f"improving the designs, round {number} of {len(_SHRINKS)}")
        near = best.shares[:, None, :] + 2.0 * shrink * around
        found = _tried(asked, np.clip(near.reshape(-1, size), 0.0, 1.0))
        tried += found.good.size
        best = _best(asked, best | found, kept, _STARTS)
    best = _best(asked, best, count)
    plan = _plan(asked, best.shares)
    order = np.argsort(_costs(asked, best)[:, 0], kind="stable")
    designs = tuple(_made(asked, plan, best, int(case)) for case in order)
    return DriveDesigns(asked, designs, tried, "done")


def _plan(asked: DriveRequirement, shares: FloatArray) -> StudyPlan:
    """The study at points of the unit cube, at each with every friction."""
    columns, times = {}, max(len(asked.frictions), 1)
    for (name, (low, high)), share in zip(asked.ranges.items(), shares.T, strict=True):
        entry = asked.entries[name]
        if entry.whole or entry.half:
            beyond = 0.5 * entry.half
            low, high = np.ceil(low - beyond), np.floor(high - beyond)
            column = beyond + np.minimum(np.floor(low + share * (high - low + 1.0)), high)
            column = column.astype(int) if entry.whole else column
        elif low > 0.0:
            column = low * (high / low) ** share
        else:
            column = low + share * (high - low)
        columns[name] = np.repeat(column, times).tolist()
    names = {*asked.objectives, *asked.bounds} - {SCATTER}
    if asked.frictions:
        names, columns["friction"] = names | {"period"}, asked.frictions * len(shares)
    sample = {"method": "list", **columns}
    return parse_plan({**asked.study, "results": sorted(names), "sample": sample})


def _tried(asked: DriveRequirement, shares: FloatArray) -> _Points:
    """Points, and their figures; good are those within the bounds."""
    results = run_plan(_plan(asked, shares)).results
    # a column for each friction, of which the middle one has the figures
    found = {name: np.reshape(x, (len(shares), -1)) for name, x in results.items()}
    good = (found.pop("status") == 0).all(axis=1)
    values = {name: x[:, x.shape[1] // 2].astype(float) for name, x in found.items()}
    if asked.frictions:
        values[SCATTER] = 0.5 * np.ptp(found["period"], axis=1) / values["period"]
    for name, (low, high) in asked.bounds.items():
        good &= (values[name] >= low) & (values[name] <= high)
    for name in asked.objectives:
        good &= np.isfinite(values[name])
    return _Points(shares, values, good)


def _costs(asked: DriveRequirement, points: _Points) -> FloatArray:
    """What should be small, a column for each objective."""
    signs = [-1.0 if name in GREATER else 1.0 for name in asked.objectives]
    columns = [sign * points.values[n] for n, sign in zip(asked.objectives, signs, strict=True)]
    return np.column_stack(columns)


def _best(asked: DriveRequirement, points: _Points, count: int, least: int = 1) -> _Points:
    """The points within the bounds that no other one dominates, so many of them.

    If there are fewer than `least`, those follow that only these dominate.
    """
    chosen = np.flatnonzero(points.good)
    costs = _costs(asked, points)[chosen]
    front = undominated(costs)
    while front.size < min(least, len(costs)):
        others = np.setdiff1d(np.arange(len(costs)), front)
        front = np.append(front, others[undominated(costs[others])])
    chosen = chosen[front[spread_out(costs[front], count)]]
    values = {name: x[chosen] for name, x in points.values.items()}
    return _Points(points.shares[chosen], values, points.good[chosen])


def _made(asked: DriveRequirement, plan: StudyPlan, points: _Points, case: int) -> DriveDesign:
    """The design at a point."""
    values = {
        name: float(x[case]) * factor(asked.figures[name].kind, asked.system)
        for name, x in points.values.items()
    }
    times = max(len(asked.frictions), 1)
    case = case * times + times // 2
    given = plan.values(case)
    made = plan.drive(case) if asked.subject is DRIVE else plan.escapement(case)
    return DriveDesign(made, {name: given[name] for name in asked.ranges}, values)


def _reason(asked: DriveRequirement, points: _Points) -> str:
    """The bound that no point satisfies, or all if each is satisfied by some point."""
    for name, (low, high) in asked.bounds.items():
        values = points.values[name][np.isfinite(points.values[name])]
        unit = printed(asked.figures[name].kind, asked.system)
        if not values.size:
            return f"{name} does not exist for any of these; look what it needs"
        for rule, limit, end, word in (
            ("at most", high, values.min(), "least"), ("at least", low, values.max(), "greatest"),
        ):  # fmt: skip
            if end > limit if rule == "at most" else end < limit:
                wanted, reached = (f"{show(float(x))} {unit}".rstrip() for x in (limit, end))
                return f"{name} must be {rule} {wanted}, and the {word} found is {reached}"
    return "none satisfies all bounds together; relax " + " or ".join(asked.bounds or ["them"])
