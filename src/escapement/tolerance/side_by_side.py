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
from escapement.model.numbers import full_torque, with_number
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
COMPARED: dict[str, Result] = {
    "torque": Result("torque", "torque of the drive"),
    "total_inertia": Result("inertia", "sum of both moments of inertia"),
    "turn_deg": Result("degrees", "angle that the driver turns in a period"),
    **{name: FIGURES[name] for name in ("period", "rise_time", "settling_time")},
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
        (first, leading), *_ = designs
        designs = [
            _cycle(
                similar(
                    one, full_torque(first) / full_torque(one), leading.period / figures.period
                ),
                k,
            )
            for k, (one, figures) in enumerate(designs)
        ]
    kinds = [one.mechanism.kind for one, _ in designs]
    return tuple(
        _compared(f"{kind} {k + 1}" if kinds.count(kind) > 1 else kind, *design, stiffness)
        for k, (kind, design) in enumerate(zip(kinds, designs, strict=True))
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
    values = dict.fromkeys(COMPARED, math.nan)
    reasons = dict[str, str]()
    referred: Any = escapement.referred
    values["torque"] = full_torque(escapement)
    values["total_inertia"] = referred["driver_inertia"] + referred["follower_inertia"]
    values["turn_deg"] = degrees(escapement.mechanism.cell_angle)
    for key in ("period", "rise_time", "settling_time", *_PEAKS):
        values[key] = float(getattr(figures, key))
        if key == "contact_force_max" and not escapement.mechanism.crank_radius:
            reasons[key] = "a force needs a crank_radius"
    found = _sensitivities(escapement, figures) | _rebound(escapement, figures)
    found |= _losses(figures) | _blows(escapement, stiffness)
    for key, value in found.items():
        if isinstance(value, str):
            reasons[key] = value
        else:
            values[key] = value
    return Compared(name, escapement, figures, values, reasons)


def _sensitivities(escapement: Escapement, figures: Figures) -> dict[str, float | str]:
    """Relative derivatives of the period, or the reason why there is none."""
    mechanism: Any = escapement.mechanism
    given = {"torque": full_torque(escapement), "friction": escapement.friction}
    given |= {
        f"{body}_inertia": getattr(escapement.inertia, body) for body in ("driver", "follower")
    }
    given = {name: value for name, value in given.items() if value}
    found: dict[str, float | str] = {}
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


def _rebound(escapement: Escapement, figures: Figures) -> dict[str, float | str]:
    """Change of the period with another restitution."""
    key = "period_with_rebound"
    if not escapement.contact:
        return {key: "pins fit their slots exactly, without blows"}
    try:
        found = simulation.terminal(replace(escapement, restitution=REBOUND))
    except InvalidValue as error:
        return {key: str(error)}
    if found.status is not Status.OK:
        return {key: f"with a restitution of {REBOUND:g}: {found.message}"}
    return {key: found.period / figures.period - 1.0}


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
    keys = [f"{name}_in_blows" for name in _PEAKS]
    if stiffness is None:
        return dict.fromkeys(keys, "no stiffness is given")
    if not escapement.contact:
        return dict.fromkeys(keys, "pins fit their slots exactly, without blows")
    try:
        yielding = replace(escapement, stiffness=stiffness)
        found = simulation.terminal(yielding)
    except InvalidValue as error:
        return dict.fromkeys(keys, str(error))
    if found.status is not Status.OK:
        return dict.fromkeys(keys, f"with this stiffness: {found.message}")
    return {key: float(getattr(found, name)) for key, name in zip(keys, _PEAKS, strict=True)}
