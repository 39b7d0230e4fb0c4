"""Derivatives by differences, where the equation of motion cannot be differentiated.

They are needed for clearance and impact, for compliant contact, and for trains that lose power.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.dynamics.figure_table import FIGURES, TRANSIENT
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines import simulate as simulation
from escapement.model.escapement import Escapement
from escapement.model.numbers import with_number

STEPS = (1e-2, 2e-3, 4e-4)
"""Relative steps of a number; for each figure the step with the smallest error is used."""
_LEFT_OUT = ("energy_residual", "rise_time", "settling_time")
"""Figures that consist of rounding errors, or that jump."""
Slope = tuple[float, float]
"""A derivative and its uncertainty."""


def needs_differences(escapement: Escapement) -> bool:
    """Whether derivatives come from differences alone."""
    lossy = any(train.efficiency < 1.0 for train in escapement.trains.values())
    return bool(escapement.contact) or lossy


def lossless(escapement: Escapement) -> list[str]:
    """Efficiencies of trains that are 1: figures have derivatives only on one side of them."""
    trains = escapement.trains.items()
    return [f"{role}_efficiency" for role, train in trains if train.efficiency == 1.0]


def slopes_by(
    escapement: Escapement, name: str, value: float, figures: Sequence[str] = ()
) -> dict[str, Slope]:
    """Derivatives of figures of merit by one number that is not 0.

    Each comes from Richardson's extrapolation of central differences over steps h and 2 h, or of
    differences below a number that cannot be greater. Its error is estimated by the extrapolation
    itself, plus the error of the means if engagements do not repeat. A figure that is missing at
    one of the steps is left out.

    Parameters
    ----------
    escapement : Escapement
    name, value : of the number [SI].
    figures : sequence of str
        Default: all that have derivatives. Rise times are computed only if they are named.
    """
    names = figures or [name for name in FIGURES if name not in (*_LEFT_OUT, *TRANSIENT)]
    best: dict[str, Slope] = {}
    for share in STEPS:
        step = share * abs(value)
        found = {k: _terminal(escapement, name, value + k * step) for k in (-2, -1, 1, 2)}
        if found[1].status is Status.INVALID:
            found |= {k: _terminal(escapement, name, value + k * step) for k in (-4, 0)}
        for figure in names:
            values = {k: float(getattr(each, figure)) for k, each in found.items()}
            near, far = (_difference(values, k) / step for k in (1, 2))
            ends = (-1, 0) if 0 in found else (-1, 1)
            noise = math.hypot(*(_interval(found[k], figure) for k in ends)) / step
            more = (near - far) / 3.0
            doubt = abs(more) + noise
            if math.isfinite(doubt) and doubt < best.get(figure, (0.0, math.inf))[1]:
                best[figure] = near + more, doubt
    return best


def _difference(values: Mapping[int, float], k: int) -> float:
    """The difference over k steps on either side, or below where the value in the middle is
    given, divided by k; its error is of second order.
    """
    if 0 in values:
        return (3.0 * values[0] - 4.0 * values[-k] + values[-2 * k]) / (2.0 * k)
    return (values[k] - values[-k]) / (2.0 * k)


def _terminal(escapement: Escapement, name: str, value: float) -> Figures:
    """Figures at another value of a number; NaN if that value is not possible."""
    try:
        return simulation.terminal(with_number(escapement, name, value))
    except InvalidValue:
        return Figures(status=Status.INVALID)


def _interval(figures: Figures, figure: str) -> float:
    """Half the interval of a mean, 0 where engagements repeat."""
    return 0.0 if figures.spread is None else figures.spread.interval.get(figure, 0.0)
