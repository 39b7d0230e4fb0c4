"""The Geneva wheel on the command line."""

import argparse
from typing import TYPE_CHECKING, Any

from escapement.cli._arguments import optional_si, quantity_keywords
from escapement.cli._parser import whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from escapement.mechanisms import Geneva

DEFAULT_SLOTS = 4

OPTIONS: dict[str, dict[str, Any]] = {
    "slots": {
        "type": whole("--slots", 3, "a Geneva wheel needs 3 slots or more"),
        "metavar": "N",
        "help": f"slots of the wheel (default: {DEFAULT_SLOTS})",
    },
    "pins": {
        "type": whole("--pins", 1, "give the number of pins, or leave it out"),
        "metavar": "P",
        "help": "pins of the driver (default: continuous engagement where it exists, else 1)",
    },
    "internal": {
        "action": "store_true",
        "help": "internal wheel, driver inside",
    },
    "crank_radius": quantity_keywords("crank_radius"),
}

QUANTITIES = {"centre_distance": "length"}


def read(args: argparse.Namespace) -> "Geneva":
    """The wheel the arguments describe."""
    from escapement.mechanisms import Geneva

    return Geneva(
        slots=DEFAULT_SLOTS if args.slots is None else args.slots,
        pins=args.pins,
        internal=bool(args.internal),
        crank_radius=optional_si(args, "crank_radius"),
    )


def describe(mechanism: "Geneva") -> dict[str, Any]:
    """Geometry of a Geneva wheel, by JSON key."""
    import math

    # twelve decimals: sixty degrees should read as sixty
    cell = round(math.degrees(mechanism.cell_angle), 12)
    record = {
        "stations": mechanism.slots,
        "motion_ratio": mechanism.motion_ratio,
        "cell_angle_deg": cell,
        "follower_step_deg": round(math.degrees(mechanism.follower_step), 12),
        "slots": mechanism.slots,
        "pins": mechanism.pins,
        "continuous": mechanism.continuous,
        "dwell_deg": cell * (1.0 - mechanism.motion_ratio),
        "transmission_max": float(mechanism.transmission(0.0).g),
        "centre_distance_over_crank_radius": mechanism.centre_distance,
    }
    if mechanism.crank_radius is not None:
        record["centre_distance"] = mechanism.centre_distance * mechanism.crank_radius
    return record


def draw(mechanism: "Geneva", theta: float) -> "Axes":
    """The drive to scale at a driver angle [rad]."""
    from escapement.plots import plot_mechanism

    return plot_mechanism(mechanism, theta)
