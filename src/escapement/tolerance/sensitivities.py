"""`sensitivities`: derivatives of figures of merit by the numbers of the model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from escapement.base.errors import InvalidValue
from escapement.base.quantity import quantities
from escapement.base.status import Status
from escapement.base.text import Shown
from escapement.dynamics.figure_table import FIGURES, TRANSIENT
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines import simulate as simulation
from escapement.model.escapement import Escapement
from escapement.model.numbers import numbers_of, with_number
from escapement.tolerance.derivatives import JUMPS, Slopes, slopes_of, told
from escapement.tolerance.differences import NO_CHANGE

Table = dict[str, dict[str, float]]


@dataclass(frozen=True, repr=False)
class Sensitivities(Shown):
    """Derivatives of figures of merit by the numbers of an escapement.

    absolute : by figure and number, dF/dq in SI: `absolute["period"]["torque"]`.
    relative : likewise d ln F/d ln q, per cent per cent; only where both are not zero.
    one_sided : by figure and number, where the figure has a kink: the derivatives below and above
        the number, infinite where a figure grows with the root of a distance. Errors of the parts
        of a perfect wheel are among the numbers only if requested.
    doubts : by figure and number, the estimated error of each derivative in `absolute`.
    jumps : figures that have no derivative, because they jump.
    figures : the figures of merit themselves.
    message : the derivatives that are left out.
    """

    absolute: Table
    relative: Table
    one_sided: dict[str, dict[str, tuple[float, float]]]
    doubts: Table
    jumps: tuple[str, ...]
    figures: Figures
    message: str

    def _shown(self) -> list[tuple[str, Any, str]]:
        period = self.relative["period"].items()
        rows = [(f"period by {name}", slope, "% per %") for name, slope in period]
        return [*rows, ("message", self.message, "")]


def sensitivities(escapement: Escapement, *, errors: bool = False) -> Sensitivities:
    """Derivatives of every figure of the terminal cycle by every number of the model.

    They are extrapolated differences of figures, each with its estimated error in `doubts`. The
    figures of scenes without clearance and with rigid walls are exact to some 1e-14, and their
    derivatives to 1e-8 of the derivative or of the figure over the number, whichever is greater.
    A number that can only change in one direction, such as the radius of thin pins or an
    efficiency of 1, has a one-sided derivative.

    Parameters
    ----------
    escapement : Escapement
        It needs a terminal cycle. Of a spring that runs down the derivatives are those at its full
        torque.
    errors : bool
        Whether to include an error of each kind that the parts of a perfect wheel may have. With
        perfect parts a figure has a kink: its derivatives are in `one_sided`.

    Returns
    -------
    Sensitivities
        The numbers have the names that the axes of studies have. Mechanisms without a
        `crank_radius` have no lengths. Errors of imperfect parts are among the numbers. With
        clearance or compliant contact rise times are left out.

    Raises
    ------
    InvalidValue
        If there is no terminal cycle; the message gives the reason.
    """
    figures = simulation.terminal(escapement)
    if figures.status is not Status.OK or figures.motion is None:
        raise InvalidValue(f"escapement must have a terminal cycle: {figures.message}")
    escapement = escapement.held
    # a slip speed of 0 is no value: the engine then chooses one
    numbers = {n: x for n, x in numbers_of(escapement).items() if x or n != "slip_speed"}
    idle = _idle(numbers)
    given = {name: value for name, value in numbers.items() if name not in idle}
    given |= dict.fromkeys(error_axes(escapement.mechanism), 0.0) if errors else {}
    wanted = _wanted(escapement, figures)

    def solve(name: str, value: float) -> Figures:
        return simulation.terminal(with_number(escapement, name, value))

    slopes = slopes_of(solve, escapement, figures, given, wanted)
    slopes |= {name: dict.fromkeys(wanted, NO_CHANGE) for name in idle}
    return _collected(slopes, numbers, figures, wanted)


def _idle(numbers: Mapping[str, float]) -> list[str]:
    """Numbers that have no effect, because another one that they need is 0."""
    needs = ((name, entry.needs) for name, entry in quantities(Escapement).items() if entry.needs)
    return [name for name, other in needs if name in numbers and numbers.get(other) == 0.0]


def _wanted(escapement: Escapement, figures: Figures) -> list[str]:
    """The figures that have a value, and derivatives."""
    left_out = ("energy_residual", *JUMPS, *(TRANSIENT if escapement.contact else ()))
    names = [name for name in FIGURES if name not in left_out]
    return [name for name in names if math.isfinite(getattr(figures, name))]


def _collected(
    slopes: Mapping[str, Slopes], numbers: Mapping[str, float], figures: Figures, wanted: list[str]
) -> Sensitivities:
    """The tables of derivatives, by figure and number."""
    absolute: Table = {figure: {} for figure in wanted}
    relative: Table = {figure: {} for figure in wanted}
    doubts: Table = {figure: {} for figure in wanted}
    one_sided: dict[str, dict[str, tuple[float, float]]] = {}
    lost: dict[str, list[str]] = {}
    for name in sorted(slopes, key=[*numbers, *slopes].index):
        for figure, slope in slopes[name].items():
            if slope.missing:
                lost.setdefault(figure, []).append(name)
            elif slope.below != slope.above or name not in numbers:
                one_sided.setdefault(figure, {})[name] = slope.below, slope.above
            else:
                absolute[figure][name], doubts[figure][name] = slope.below, slope.doubt
                value = getattr(figures, figure)
                if value and numbers[name]:
                    relative[figure][name] = slope.below * numbers[name] / value
    message = "; ".join(told(figure, names) for figure, names in lost.items()) or "done"
    return Sensitivities(
        absolute, relative, one_sided, doubts, jumps=JUMPS, figures=figures, message=message
    )


def error_axes(mechanism: Any) -> list[str]:
    """One error of each kind that the parts of a perfect wheel may have, by its name in studies."""
    if not mechanism.error_counts or not mechanism.perfect:
        return []
    names = ["centre_distance_error", *(f"{name}_0" for name in mechanism.error_counts)]
    return [name for name in names if "angle" in name or mechanism.crank_radius]
