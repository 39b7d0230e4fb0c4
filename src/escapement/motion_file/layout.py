"""Names, units and descriptions of what a motion file holds."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from escapement.motion import Motion
from escapement.trajectory import Events

CONTENT = "motion"
"""Root attribute `content`, by which a motion is told from a study."""
SCHEMA_VERSION = 1
"""Version of the file layout: raised when an older reader would misread a newer file."""


class Column(NamedTuple):
    """A dataset: its key in `escapement.units`, its name for people, its values."""

    quantity: str
    long_name: str
    values: Any = None


SAMPLES = {
    "t": Column("time", "time from the first pin entry"),
    "theta": Column("angle", "driver angle from the first dead centre"),
    "theta_dot": Column("speed", "driver velocity"),
    "theta_ddot": Column("acceleration", "driver acceleration"),
    "phi": Column("angle", "follower angle"),
    "phi_dot": Column("speed", "follower velocity"),
    "phi_ddot": Column("acceleration", "follower acceleration"),
    "contact_moment": Column("torque", "moment of the pin on the follower"),
    "contact_force": Column("force", "force between pin and slot, with a crank radius"),
}
"""Columns over `t`, computed block by block."""


def event_groups(motion: Motion) -> Mapping[str, Mapping[str, Column]]:
    """Everything else, by dimension: the first column of a group is its scale."""
    pieces = motion.trajectory
    return {
        "handoff": {
            "handoff_times": Column("time", "end of each engagement", motion.handoff_times),
            "handoff_velocities": Column(
                "speed", "driver velocity at each handoff", motion.handoff_velocities
            ),
        },
        "reversal": _events("reversal", "pin reversal", motion.reversals),
        "extremum": {
            **_events("extremum", "extremum of the driver velocity", motion.extrema),
            "extremum_maximum": Column("ratio", "kind of extremum", motion.extrema.maximum),
        },
        "piece": {
            "piece_start": Column("time", "start of each piece", pieces.start),
            "piece_engagement": Column("ratio", "engagement, from 0", pieces.engagement),
            "piece_sign": Column(
                "ratio", "side of the slot that carries the force, 0 while locked", pieces.sign
            ),
            "piece_friction_loss": Column(
                "energy", "work lost in friction over each piece", pieces.friction_loss
            ),
        },
    }


def _events(kind: str, text: str, events: Events) -> dict[str, Column]:
    return {
        f"{kind}_time": Column("time", f"time of each {text}", events.time),
        f"{kind}_engagement": Column("ratio", "engagement, from 0", events.engagement),
        f"{kind}_theta": Column("angle", SAMPLES["theta"].long_name, events.theta),
        f"{kind}_theta_dot": Column("speed", "driver velocity", events.theta_dot),
    }
