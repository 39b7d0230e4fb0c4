"""What `escapement run` reports, for programs and for people."""

from typing import TYPE_CHECKING, Any

from escapement.cli import _output
from escapement.status import MESSAGES, Status
from escapement.text import print_values, words
from escapement.units import unit_name

if TYPE_CHECKING:
    from escapement.metrics import Figures
    from escapement.motion import Motion

FIGURES = {
    "velocity_max": "speed",
    "velocity_min": "speed",
    "velocity_mean": "speed",
    "velocity_average_published": "speed",
    "period": "time",
    "rise_time": "time",
    "settling_time": "time",
    "critical_friction": "ratio",
    "acceleration_max": "acceleration",
    "follower_acceleration_max": "acceleration",
    "contact_moment_max": "torque",
    "contact_force_max": "force",
}
"""Figures of merit as printed, with the kind of unit of each; the force with a crank radius."""


def summarise(motion: "Motion", figures: "Figures", units: str) -> dict[str, Any]:
    """What `run` reports, by JSON key, in the user's units."""
    outcome = motion if motion.status.failed else figures
    values = figures.as_dict()
    if getattr(motion.escapement.mechanism, "crank_radius", None) is None:
        del values["contact_force_max"]
    return {
        **{
            key: _output.in_units(values[key], kind, units)
            for key, kind in FIGURES.items()
            if key in values
        },
        "handoff_times": motion.handoff_times,
        "handoff_velocities": motion.handoff_velocities,
        "energy_residual": motion.ledger.residual,
        "status": outcome.status.label,
        "message": _message(outcome.message, values),
        "engine": motion.engine,
    }


def _message(message: str, values: dict[str, Any]) -> str:
    """What became of the run, and why it names no critical friction where there is none."""
    reasons = _output.not_given(values)
    return "; ".join(reasons if reasons and message == MESSAGES[Status.OK] else [message, *reasons])


def print_table(record: dict[str, Any], units: str) -> None:
    """The same as a table."""
    rows = [
        (words(key), record[key], unit_name(kind, units))
        for key, kind in FIGURES.items()
        if key in record
    ]
    times, speeds = record["handoff_times"], record["handoff_velocities"]
    rows.append(("handoffs", len(times), ""))
    if len(times):
        rows += [("last handoff", times[-1], "s"), ("velocity there", speeds[-1], "rad s-1")]
    rows += [(words(key), record[key], "") for key in ("energy_residual", "status", "engine")]
    print_values(rows)
