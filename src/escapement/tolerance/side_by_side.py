"""`compare`: several designs side by side, at their own clocks or at one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.results import Result
from escapement.base.status import Status
from escapement.base.text import Shown
from escapement.base.units import degrees
from escapement.dynamics.figure_table import FIGURES
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines import simulate as simulation
from escapement.model.escapement import Escapement
from escapement.model.numbers import full_torque, numbers_of, with_number
from escapement.model.similar import similar
from escapement.tolerance.derivatives import slopes_of
from escapement.tolerance.differences import Slope

REBOUND = 0.25
"""Restitution with which the period is compared with that at the design's own."""
_BY = ("torque", "friction", "driver_inertia", "follower_inertia", "centre_distance")
_PEAKS = {
    "acceleration_max": "driver acceleration", "follower_acceleration_max": "follower acceleration",
    "contact_force_max": "contact force",
}  # fmt: skip
_FIGURES = ("period", "rise_time", "settling_time", *_PEAKS)
COMPARED: dict[str, Result] = {
    "torque": Result("torque", "torque of the drive"),
    "total_inertia": Result("inertia", "sum of both moments of inertia"),
    "turn_deg": Result("degrees", "angle that the driver turns in a period"),
    **{name: FIGURES[name] for name in _FIGURES[:3]},
    **{
        f"period_by_{name}": Result("ratio", f"per cent of period per per cent of {name}")
        for name in _BY
    },
    "period_by_shorter_centre_distance": Result(
        "ratio", "per cent of period per per cent where the axes are too close"
    ),
    "period_with_rebound": Result(
        "ratio", f"change of the period with a restitution of {REBOUND:g}, as a share of it"
    ),
    "friction_share": Result("ratio", "share of the work lost in friction of the contact"),
    "blow_share": Result("ratio", "share of the work lost in blows, their friction included"),
    **{name: FIGURES[name] for name in _PEAKS},
    **{
        f"{name}_in_blows": Result(FIGURES[name].kind, f"greatest {text} with the stiffness")
        for name, text in _PEAKS.items()
    },
}  # fmt: skip
"""What is compared, by its name."""


@dataclass(frozen=True, repr=False)
class Compared(Shown):
    """One of the designs that `compare` puts side by side.

    name : of the design.
    escapement : the design; scaled if all were to have one period.
    figures : its figures of merit.
    values : what is compared, by the names in `COMPARED`, in SI; NaN where it does not exist.
    reasons : why, for each value that does not exist.
    """

    name: str
    escapement: Escapement
    figures: Figures
    values: Mapping[str, float]
    reasons: Mapping[str, str]

    def _shown(self) -> list[tuple[str, Any, str]]:
        return [("name", self.name, ""), *((key, x, "") for key, x in self.values.items())]


def compare(
    *escapements: Escapement, equal_period: bool = False, stiffness: float | None = None
) -> tuple[Compared, ...]:
    """Several designs side by side: period, rise, sensitivities, losses, accelerations, forces.

    Parameters
    ----------
    *escapements : Escapement
        Two or more designs.
    equal_period : bool
        Whether each is given the torque and the period of the first, by similarity: its torques
        are multiplied by one factor, and its inertias by another.
    stiffness : float, optional
        Stiffness of the bodies where they touch [N/m], for accelerations and forces in blows.

    Returns
    -------
    tuple of Compared
        One for each design. Sensitivities are d ln T/d ln q; where the axes can only be too far
        apart or too close, both are given.

    Raises
    ------
    InvalidValue
        If there are fewer than two designs, or one has no terminal cycle.
    """
    if len(escapements) < 2:
        raise validate.fail("escapements", "two or more designs", len(escapements), "give another")
    designs = [_cycle(one, k) for k, one in enumerate(escapements)]
    if equal_period:
        first, leading = designs[0]
        for k, (one, figures) in enumerate(designs):
            torque, time = full_torque(first) / full_torque(one), leading.period / figures.period
            designs[k] = _cycle(similar(one, torque, time), k)
    kinds = [one.mechanism.kind for one, _ in designs]
    names = [f"{kind} {k}" if kinds.count(kind) > 1 else kind for k, kind in enumerate(kinds, 1)]
    return tuple(
        _compared(name, *design, stiffness) for name, design in zip(names, designs, strict=True)
    )


def _cycle(escapement: Escapement, number: int) -> tuple[Escapement, Figures]:
    held = escapement.held
    figures = simulation.terminal(held)
    if figures.status is not Status.OK:
        raise InvalidValue(f"design {number + 1} must have a terminal cycle: {figures.message}")
    return held, figures


def _compared(
    name: str, escapement: Escapement, figures: Figures, stiffness: float | None
) -> Compared:
    """All values of one design, and the reasons for those that are missing."""
    referred: Any = escapement.referred
    found: dict[str, Any] = {
        "torque": full_torque(escapement),
        "total_inertia": referred["driver_inertia"] + referred["follower_inertia"],
        "turn_deg": degrees(escapement.mechanism.cell_angle),
    } | {key: float(getattr(figures, key)) for key in _FIGURES}
    if not escapement.mechanism.crank_radius:
        found["contact_force_max"] = "a force needs a crank_radius"
    found |= _sensitivities(escapement, figures) | _losses(figures)
    found["period_with_rebound"] = _rebound(escapement, figures)
    found |= _blows(escapement, stiffness)
    reasons = {key: value for key, value in found.items() if isinstance(value, str)}
    values = {key: math.nan if key in reasons else found.get(key, math.nan) for key in COMPARED}
    return Compared(name, escapement, figures, values, reasons)


def _sensitivities(escapement: Escapement, figures: Figures) -> dict[str, float | str]:
    """Relative derivatives of the period, or the reason why there is none."""
    mechanism: Any = escapement.mechanism
    numbers, found = numbers_of(escapement), dict[str, float | str]()
    given = {name: numbers[name] for name in _BY if numbers.get(name)}
    if not escapement.friction:
        found["period_by_friction"] = "there is no friction in the contact"
    apart, size = "centre_distance", float(mechanism.crank_radius or 0.0)
    if mechanism.pitch is not None and apart in mechanism.settings:
        given[apart] = distance = mechanism.axes_distance * size
    elif size and "centre_distance_error" in mechanism.settings:
        apart, distance = "centre_distance_error", size * mechanism.centre_distance
        given[apart] = mechanism.centre_distance_error
    else:
        apart, why = "", "it needs a kind whose centre distance may vary, and its size"
        found["period_by_centre_distance"] = why

    def solve(name: str, value: float) -> Figures:
        return simulation.terminal(with_number(escapement, name, value))

    slopes = slopes_of(solve, escapement, figures, given, ["period"])
    for name, value in given.items():
        slope: Slope | None = slopes.get(name, {}).get("period")
        key = "period_by_centre_distance" if name == apart else f"period_by_{name}"
        if slope is None or slope.missing:
            found[key] = f"the period has no derivative by {name}"
            continue
        scale = (distance if name == apart else value) / figures.period
        found[key] = scale * slope.above
        if name == apart and slope.below != slope.above:
            found["period_by_shorter_centre_distance"] = scale * slope.below
    return found


def _rebound(escapement: Escapement, figures: Figures) -> float | str:
    """Change of the period with another restitution."""
    found = _changed(escapement, restitution=REBOUND)
    return found if isinstance(found, str) else found.period / figures.period - 1.0


def _losses(figures: Figures) -> dict[str, float | str]:
    """Shares of the work of the drive in a period."""
    if figures.motion is None:
        return dict.fromkeys(("friction_share", "blow_share"), "there is no periodic motion")
    ledger = figures.motion.ledger
    return {
        "friction_share": ledger.friction / ledger.work, "blow_share": ledger.blows / ledger.work
    }  # fmt: skip


def _blows(escapement: Escapement, stiffness: float | None) -> dict[str, float | str]:
    """Greatest accelerations and force where the bodies yield."""
    found: Any = "no stiffness is given"
    if stiffness is not None:
        found = _changed(escapement, stiffness=stiffness)
    return {
        f"{name}_in_blows": found if isinstance(found, str) else float(getattr(found, name))
        for name in _PEAKS
    }


def _changed(escapement: Escapement, **change: float) -> Figures | str:
    """Figures of a design whose blows are changed, or the reason why there are none."""
    if not escapement.contact:
        return "pins fit their slots exactly, without blows"
    try:
        found = simulation.terminal(replace(escapement, **change))  # type: ignore[arg-type]
    except InvalidValue as error:
        return str(error)
    ((name, value),) = change.items()
    return found if found.status is Status.OK else f"with {name} {value:g}: {found.message}"
