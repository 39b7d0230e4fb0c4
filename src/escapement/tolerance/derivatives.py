"""Derivatives of figures of merit by many numbers of an escapement."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.dynamics.figures_of_merit import Figures
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.wheel_checks import IMPERFECT
from escapement.model.escapement import Escapement
from escapement.study.plan import unit_kind
from escapement.tolerance.differences import NONE, ROUNDING, Slope, slopes_by

JUMPS = ("rise_time", "settling_time")
"""Figures that jump where another extremum is the first one within the band."""
ALIKE = 1e-12
"""Beats that differ by less than this share are equal."""
QUOTIENT = 1e-8
"""Error of a contraction that is a difference quotient."""
SMALL = 0.01
"""Scale of the errors of perfect parts, in crank radii or radians."""

Solve = Callable[[str, float], Figures]
"""Figures at another value of one number; InvalidValue where it is not possible."""
Slopes = dict[str, Slope]
"""The derivatives of each figure by one number."""


def slopes_of(
    solve: Solve, escapement: Escapement, figures: Figures,
    numbers: Mapping[str, float], wanted: Sequence[str],
) -> dict[str, Slopes]:  # fmt: skip
    """Derivatives of wanted figures by numbers of an escapement, by number.

    A number beside which no other value is possible is left out.
    """
    names = [name for name in wanted if name not in JUMPS]
    middle, noise = _values(figures, names), _noise(escapement, figures, names)
    perfect, alike, found = escapement.mechanism.perfect, dict[str, list[Slope]](), {}
    for name, value in numbers.items():
        error = name.startswith(IMPERFECT) and value == 0.0
        # all pins of a perfect wheel are equal, and so are all slots
        key = re.sub(r"_\d+$", "", name) if error and perfect else name
        if key not in alike:
            known = False

            def evaluate(at: float, name: str = name) -> FloatArray:
                nonlocal known
                try:
                    values = _values(solve(name, at), names)
                except InvalidValue:
                    return np.full(len(names), math.nan)
                known = True
                return values

            scale = _scale(escapement, figures.velocity_max, name, value)
            alike[key] = slopes_by(evaluate, value, middle, scale, noise, root=error)
            alike[key] = alike[key] if known else []
        if alike[key]:
            found[name] = dict.fromkeys(wanted, NONE) | dict(zip(names, alike[key], strict=True))
    return found


def _values(figures: Figures, names: Iterable[str]) -> FloatArray:
    """Figures as an array; NaN without a terminal cycle."""
    values = {name: math.nan for name in names}
    if figures.outcome is Status.OK:
        values = {name: float(getattr(figures, name)) for name in names}
        if values.get("beat_error", math.inf) < ALIKE * figures.period:
            values["beat_error"] = 0.0
    return np.array([*values.values()])


def _noise(escapement: Escapement, figures: Figures, names: Sequence[str]) -> FloatArray:
    """Errors of figures besides the rounding of each."""
    # means over engagements that do not repeat are known within an interval
    interval = figures.spread.interval if figures.spread else {}
    noise = {name: interval.get(name, 0.0) for name in names}
    if "beat_error" in names:  # the difference of two times
        noise["beat_error"] += ROUNDING * figures.period
    if escapement.contact and "contraction" in names:
        # with contact it is itself a difference over a small step
        noise["contraction"] += QUOTIENT
    if escapement.stiffness and figures.motion is not None:
        rtol = figures.motion.rtol
        noise = {name: x + rtol * abs(getattr(figures, name)) for name, x in noise.items()}
    return np.array([*noise.values()])


def _scale(escapement: Escapement, speed: float, name: str, value: float) -> float:
    """Change of a number over which figures change: its value, or else its natural unit."""
    if value:
        return abs(value)
    mechanism, torque, clock = escapement.mechanism, escapement.torque_unit, escapement.time_unit
    length = mechanism.crank_radius or 1.0
    units = {"torque": torque, "rate": torque, "inertia": torque * clock**2}
    units |= {"drag": torque / speed**2, "viscous": torque / speed, "speed": speed}
    units |= {"length": length, "slip": length / clock, "stiffness": torque / length**2}
    units |= {"damping": torque * clock / length**2}
    unit = units.get(unit_kind(name), 1.0)
    if name.startswith(IMPERFECT):
        errors = mechanism.errors.items()
        sizes = (abs(x) / (1.0 if "angle" in key else length) for key, x in errors)
        return unit * max(sizes, default=SMALL)
    return unit


def told(figure: str, names: Iterable[str]) -> str:
    """That a figure has no derivative by some numbers."""
    every = ", ".join(dict.fromkeys(re.sub(r"_\d+$", "", name) for name in names))
    return f"{figure} has no derivative by {every}"
