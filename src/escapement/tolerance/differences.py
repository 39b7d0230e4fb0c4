"""Derivatives of figures of merit by one number, from differences.

Figures are computed at the number and at steps on either side of it, each a quarter of the one
before. Richardson's extrapolation leads to a step of zero: from differences between both sides,
whose error has even powers of the step, and from differences on either side alone, whose error
has all powers. Of all extrapolated values the one with the smallest estimated error counts: the
widest steps reach beyond the next kink of a figure, and the smallest magnify its rounding errors.

If the two sides disagree, the figure has a kink. If no value is known well enough, as where a
figure jumps, there is no derivative.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from escapement.mechanisms.protocol import FloatArray

STEPS = 0.01 * 0.25 ** np.arange(6)
"""Steps as shares of the scale of a number."""
FEWEST = 4
"""Steps that are always tried."""
ENOUGH = 1e-9
"""Error, as the share in `SURE`, at which no smaller steps are tried."""
ROUNDING = 1e-14
"""Rounding error of a figure, as a share of it."""
SURE = 1e-3
"""Greatest error of a derivative, as a share of it or of the figure over the number."""
_ROOT = 1.7, 2.3
"""The difference quotients of a root grow by factors in this range from step to step."""

Evaluate = Callable[[float], FloatArray]
"""Figures at a value of the number, shape (n,); NaN where they do not exist."""


class Slope(NamedTuple):
    """The derivatives of a figure below and above a value of a number.

    They are equal unless the figure has a kink, or the number cannot be on one of the sides;
    NaN where there is no derivative, infinite where the figure grows with the root of a distance.
    `doubt` is their estimated error.
    """

    below: float
    above: float
    doubt: float = 0.0

    @property
    def missing(self) -> bool:
        """Whether there is no derivative on a side."""
        return math.isnan(self.below) or math.isnan(self.above)

    @property
    def steeper(self) -> float:
        """The derivative, at a kink that of the steeper side."""
        return self.above if abs(self.above) > abs(self.below) else self.below


NO_CHANGE = Slope(0.0, 0.0)
"""The figure does not depend on the number."""
NONE = Slope(math.nan, math.nan, math.nan)
"""There is no derivative."""


class _Side(NamedTuple):
    """A derivative from one kind of differences, its error, and the difference quotients."""

    slope: float
    doubt: float
    rough: FloatArray

    def is_sure(self, least: float) -> bool:
        """Whether its error is small enough, or at most a least one."""
        return self.doubt <= max(SURE * abs(self.slope), least)

    @property
    def limit(self) -> float:
        """Infinite if the difference quotients grow like one over a root, otherwise NaN."""
        low, high = _ROOT
        with np.errstate(divide="ignore", invalid="ignore"):
            growth = np.abs(self.rough[-2:] / self.rough[-3:-1])
        is_root = bool(((low < growth) & (growth < high)).all())
        return math.copysign(math.inf, self.rough[-1]) if is_root else math.nan


def slopes_by(
    evaluate: Evaluate,
    value: float,
    middle: FloatArray,
    scale: float,
    noise: FloatArray | float = 0.0,
    root: bool = False,
) -> list[Slope]:
    """Derivatives of figures by one number, from at most twelve values of it.

    Parameters
    ----------
    evaluate : callable
    value : float
        The number.
    middle : ndarray, shape (n,)
        The figures there.
    scale : float
        Change of the number over which figures change smoothly, > 0.
    noise : ndarray, shape (n,)
        Errors of the figures besides rounding.
    root : bool
        Whether figures on one side are series of powers of the root of the distance.
    """
    errors, size = ROUNDING * np.abs(middle) + noise, np.abs(middle) / scale
    power = 0.5 if root else 1.0
    below, above, slopes = [], [], list[Slope]()
    for count, step in enumerate(scale * STEPS, 1):
        below.append((middle - evaluate(value - step)) / step)
        above.append((evaluate(value + step) - middle) / step)
        if count < FEWEST:
            continue
        rough, steps = np.array([below, above]), scale * STEPS[:count, None]
        down, up = (_extrapolated(side, power, errors / steps) for side in rough)
        both = _extrapolated(rough.mean(axis=0), 2.0, errors / steps)
        least = SURE * size + 2.0 * errors / steps[1]
        every = zip(down, up, both, least.tolist(), strict=True)
        slopes = [_judged(*sides, root) for sides in every]
        # smaller steps would only magnify the errors of the figures
        enough = zip(slopes, size.tolist(), (4.0 * errors / steps[1]).tolist(), strict=True)
        if all(x.doubt <= ENOUGH * max(abs(x.steeper), y) + z for x, y, z in enough):
            break
    return slopes


def _extrapolated(rough: FloatArray, power: float, errors: FloatArray) -> list[_Side]:
    """The limits of difference quotients, whose error is a series of powers of step^power.

    Two quotients may agree by chance, so a value from wider steps must also agree with that from
    the smallest ones, within ten times the error of these.
    """
    rows = [[(rough[0], np.full(rough.shape[1], math.inf))]]
    column = rough
    for order in range(1, len(rough)):
        coarse, fine = column[:-1], column[1:]
        column = fine + (fine - coarse) / (4.0 ** (power * order) - 1.0)
        change = np.maximum(np.abs(column - fine), np.abs(column - coarse)) + errors[order:]
        rows.append(list(zip(column, change, strict=True)))
    best, doubt = np.full(rough.shape[1], math.nan), np.full(rough.shape[1], math.inf)
    for last in range(len(rough) - 1, 0, -1):
        for order in range(1, last + 1):
            found, error = rows[order][last - order]
            better = (error < doubt) & ~(np.abs(found - best) > 10.0 * doubt)
            best, doubt = np.where(better, found, best), np.where(better, error, doubt)
    return [_Side(*one) for one in zip(best.tolist(), doubt.tolist(), rough.T, strict=True)]


def _judged(down: _Side, up: _Side, both: _Side, least: float, root: bool) -> Slope:
    """The derivative of one figure from both sides, and from each side alone."""
    apart, room = abs(up.slope - down.slope), 10.0 * (up.doubt + down.doubt)
    # a kink near the number spoils one side alone, and then the mean is not that of both
    between = abs(0.5 * (up.slope + down.slope) - both.slope) < 0.1 * apart
    sure = both.is_sure(least) and not (apart > room and between)
    # roots on both sides may cancel in the differences between them
    if sure and (not root or (down.is_sure(least) and up.is_sure(least))):
        alike = (s for s in (down, up) if abs(s.slope - both.slope) <= 10.0 * both.doubt)
        best = min((both, *alike), key=attrgetter("doubt"))
        return Slope(best.slope, best.slope, best.doubt)
    # a figure that does not exist on a side has no difference quotients there
    sides = [side for side in (down, up) if np.isfinite(side.rough[-1])]
    limits = [side.limit if root else math.nan for side in sides]
    slopes = [s.slope if s.is_sure(least) else x for s, x in zip(sides, limits, strict=True)]
    if not sides or any(map(math.isnan, slopes)):
        return NONE
    return Slope(slopes[0], slopes[-1], max(side.doubt for side in sides))
