"""The Geneva wheel on the command line."""

import argparse
from typing import TYPE_CHECKING, Any

from escapement.cli._arguments import optional_si, quantity_keywords
from escapement.cli._cell import wheel
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
        "help": "pins of the driver (default: 1; geneva, where it exists, continuous engagement)",
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
    record = {
        "stations": mechanism.slots,
        **wheel(mechanism),
        "centre_distance_over_crank_radius": mechanism.centre_distance,
    }
    if mechanism.crank_radius is not None:
        record["centre_distance"] = mechanism.centre_distance * mechanism.crank_radius
    return record


def draw(mechanism: "Geneva", theta: float) -> "Axes":
    """The drive to scale at a driver angle [rad]."""
    from escapement.plots import plot_mechanism

    return plot_mechanism(mechanism, theta)
