"""Any drive from a table of its angles, on the command line."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement import validate
from escapement.cli._cell import cell
from escapement.cli._kinds import require
from escapement.cli._parser import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from escapement.mechanisms import Tabulated

OPTIONS: dict[str, dict[str, Any]] = {
    "table": {
        "type": Path,
        "metavar": "FILE.csv",
        "help": "driver and follower angles, two columns, in degrees unless their headings "
        "say radians: one whole cell, "
        "or any rows with --cell-angle and --follower-step",
    },
    "measured": {
        "action": "store_true",
        "help": "the rows scatter: a smooth curve goes between them",
    },
    "cell_angle": {
        "type": number("--cell-angle", validate.positive, "give an angle in degrees"),
        "metavar": "DEG",
        "help": "driver angle after which the motion repeats itself, for any rows",
    },
    "follower_step": {
        "type": number("--follower-step", validate.positive, "give an angle in degrees"),
        "metavar": "DEG",
        "help": "what the follower turns in it",
    },
}
QUANTITIES: dict[str, str] = {}
_SAMPLES = 721


def read(args: argparse.Namespace) -> "Tabulated":
    """The drive the arguments describe."""
    import math

    from escapement.mechanisms import Tabulated

    require(args, "table")
    angles = {
        name: math.radians(getattr(args, name))
        for name in ("cell_angle", "follower_step")
        if getattr(args, name) is not None
    }
    return Tabulated.from_csv(args.table, measured=bool(args.measured), **angles)


def describe(mechanism: "Tabulated") -> dict[str, Any]:
    """What the table says, and how well it knows, by JSON key."""
    import math

    import numpy as np

    theta = np.linspace(*mechanism.breaks, _SAMPLES)
    table, doubt = mechanism.transmission(theta), mechanism.deviation(theta)
    return {
        "rows": len(mechanism.theta),
        **cell(mechanism),
        "noise_deg": math.degrees(mechanism.noise),
        "transmission_max": float(table.g.max()),
        "transmission_min": float(table.g.min()),
        "transmission_deviation": float(doubt.g.max()),
        "acceleration_function_max": float(table.dg.max()),
        "acceleration_function_min": float(table.dg.min()),
        "acceleration_function_deviation": float(doubt.dg.max()),
    }


def draw(mechanism: "Tabulated", theta: float) -> "Axes":
    """The rows and the curve through them; the driver angle plays no part."""
    from escapement.plots.tabulated import plot_table

    return plot_table(mechanism)
