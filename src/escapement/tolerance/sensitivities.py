"""`sensitivities`: the exact derivatives of figures of merit by the numbers of the model."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.base.text import Shown
from escapement.dynamics.figure_table import FIGURES, TRANSIENT
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines import simulate as simulation
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.model.numbers import numbers_of
from escapement.tolerance.differences import lossless, needs_differences, slopes_by
from escapement.tolerance.figure_duals import LIMITS, figures_of

JUMPS = ("rise_time", "settling_time")
"""Figures that jump where another extremum is the first one within the band."""
_STEPS = np.array([1e-4, 2e-4, 4e-4])
"""Square roots of the errors near a kink: an impact grows with the square root of an error."""
_TO_ZERO = np.linalg.inv(np.vander(_STEPS, increasing=True))[0]
_CYCLE = tuple(name for name in FIGURES if name not in (*TRANSIENT, *LIMITS))
_DIFFERENCES = "derivatives are differences; numbers that are 0 and rise times are left out"
Table = dict[str, dict[str, float]]


@dataclass(frozen=True, repr=False)
class Sensitivities(Shown):
    """Derivatives of figures of merit by the numbers of an escapement.

    absolute : by figure and number, dF/dq in SI: `absolute["period"]["torque"]`.
    relative : likewise d ln F/d ln q, per cent per cent; only where both are not zero.
    one_sided : by figure and error of a part of a perfect wheel, where figures have a kink: the
        derivatives below and above zero, infinite where a figure grows with the root of an error.
        Empty unless requested.
    doubts : by figure and number, the uncertainty of a derivative computed by differences; empty
        if all are exact.
    jumps : figures that have no derivative, because they jump.
    figures : the figures of merit themselves.
    message : the derivatives that are left out, and the reason.
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

    They are exact: the equation of motion, its events and the fixed point of the cycle are
    differentiated, and nothing is taken from differences of figures. A number that is 0 and
    cannot be negative, such as the radius of thin pins, has a one-sided derivative. With
    clearance, compliant contact or trains that lose power they are differences with their
    `doubts`; numbers that are 0 and rise times are then left out.

    Parameters
    ----------
    escapement : Escapement
        It needs a terminal cycle. Of a spring that runs down the derivatives are those at its full
        torque.
    errors : bool
        Whether to compute `one_sided` too, which takes some seconds. With perfect parts a figure
        has a kink: these derivatives are the limits for smaller and smaller errors.

    Returns
    -------
    Sensitivities
        The numbers have the names that the axes of studies have. Mechanisms without a
        `crank_radius` have no lengths. Errors of imperfect parts are among the numbers.

    Raises
    ------
    InvalidValue
        If there is no terminal cycle; the message gives the reason.
    """
    figures = simulation.terminal(escapement)
    if figures.status is not Status.OK or figures.motion is None:
        raise InvalidValue(f"escapement must have a terminal cycle: {figures.message}")
    escapement = escapement.held
    numbers = numbers_of(escapement)
    if needs_differences(escapement):
        nothing = Sensitivities({}, {}, {}, {}, JUMPS, figures, _DIFFERENCES)
        return _by_differences(escapement, numbers, nothing)
    ends = {name: numbers.pop(name) for name in lossless(escapement)}
    duals, message = figures_of(escapement, figures, tuple(numbers))
    absolute: Table = {}
    relative: Table = {}
    for figure, dual in duals.items():
        found, value = dict(zip(numbers, dual.slopes.tolist(), strict=True)), float(dual)
        absolute[figure] = found
        relative[figure] = {
            name: slope * numbers[name] / value
            for name, slope in found.items()
            if numbers[name] != 0.0 and value != 0.0
        }
    corners = corners_of(escapement, error_axes(escapement.mechanism)) if errors else {}
    exact = Sensitivities(absolute, relative, corners, {}, JUMPS, figures, message)
    return _by_differences(escapement, ends, exact) if ends else exact


def _by_differences(
    escapement: Escapement, numbers: Mapping[str, float], found: Sensitivities
) -> Sensitivities:
    """Add the derivatives by numbers that are not 0, each with its uncertainty."""
    for name, value in numbers.items():
        if value == 0.0:
            continue
        for figure, (slope, doubt) in slopes_by(escapement, name, value).items():
            found.absolute.setdefault(figure, {})[name] = slope
            found.doubts.setdefault(figure, {})[name] = doubt
            if nominal := getattr(found.figures, figure):
                found.relative.setdefault(figure, {})[name] = slope * value / nominal
    return found


def corners_of(
    escapement: Escapement, wanted: Sequence[str], figures: Sequence[str] = _CYCLE
) -> dict[str, dict[str, tuple[float, float]]]:
    """Derivatives of figures by errors of parts on either side of perfect ones.

    All pins are equal, and so are all slots: the derivatives for the first one hold for each.
    """
    solved: dict[str, list[dict[str, float]]] = {}
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for name in wanted:
        key = re.sub(r"_\d+$", "", name)
        if key not in solved:
            cycle = [name for name in figures if name not in TRANSIENT]
            solved[key] = [_side(escapement, key, sign, cycle) for sign in (-1.0, 1.0)]
        below, above = solved[key]
        for figure in below:
            found.setdefault(figure, {})[name] = below[figure], above[figure]
    return found


def _side(
    escapement: Escapement, key: str, sign: float, figures: Sequence[str]
) -> dict[str, float]:
    """Limits of the derivatives by an error on one side of zero."""
    mechanism: Any = escapement.mechanism
    count = mechanism.error_counts.get(key)
    unit = 1.0 if "angle" in key else mechanism.crank_radius
    tables = []
    for step in _STEPS:
        error = sign * step**2 * unit
        some: Any = (error, *(0.0,) * (count - 1)) if count else error
        varied = replace(escapement, mechanism=replace(mechanism, **{key: some}))
        names = (f"{key}_0" if count else key,)
        duals, _ = figures_of(varied, simulation.terminal(varied), names, figures)
        tables.append({figure: float(dual.slopes[0]) for figure, dual in duals.items()})
    return {name: _limit(np.array([table[name] for table in tables])) for name in tables[0]}


def _limit(slopes: FloatArray) -> float:
    """The limit of derivatives at ever smaller errors; infinite if they grow as one over a root."""
    near, middle, far = abs(slopes)
    if near > 1.5 * middle and middle > 1.5 * far:
        return float(np.copysign(np.inf, slopes[0]))
    return float(_TO_ZERO @ slopes)


def error_axes(mechanism: Any) -> list[str]:
    """One error of each kind that the parts of a perfect wheel may have, by its name in studies."""
    if not mechanism.error_counts or not mechanism.perfect:
        return []
    names = ["centre_distance_error", *(f"{name}_0" for name in mechanism.error_counts)]
    return [name for name in names if "angle" in name or mechanism.crank_radius]
