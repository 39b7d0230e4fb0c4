"""The planetary drive with elliptical gears on the command line."""

import argparse
from typing import TYPE_CHECKING, Any

from escapement.cli._arguments import quantity_keywords, si
from escapement.cli._cell import cell
from escapement.cli._kinds import require

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from escapement.mechanisms import EllipticalPlanetary

TOLERANCES = (0.01, 0.1, 1.0)
"""Deviations of the output that the report takes for standing still [degrees]."""

OPTIONS: dict[str, dict[str, Any]] = {
    "sun_radius": quantity_keywords("sun_radius", note=", a + c of the ellipses"),
    "planet_radius": quantity_keywords("planet_radius", note=", a - c, less than the sun's"),
}

_LENGTHS = ("centre_distance", "semi_major_axis", "semi_minor_axis", "focal_distance")
QUANTITIES = dict.fromkeys(_LENGTHS, "length")


def read(args: argparse.Namespace) -> "EllipticalPlanetary":
    """The drive the arguments describe."""
    from escapement.mechanisms import EllipticalPlanetary

    require(args, *OPTIONS)
    return EllipticalPlanetary(si(args, "sun_radius"), si(args, "planet_radius"))


def describe(mechanism: "EllipticalPlanetary") -> dict[str, Any]:
    """Geometry of the drive, by JSON key."""
    import math

    from escapement.mechanisms.elliptical_teeth import fewest_teeth

    turned = cell(mechanism)
    rests = [(deg, mechanism.dwell_within(math.radians(deg))) for deg in TOLERANCES]
    return {
        "stations": mechanism.stations,
        **turned,
        "stop_interval_deg": turned["cell_angle_deg"],
        "output_per_stop_deg": -turned["follower_step_deg"],
        "eccentricity": mechanism.eccentricity,
        "transmission_max": mechanism.ratio_max,
        "acceleration_function_max": mechanism.acceleration_max[0],
        **{name: getattr(mechanism, name) for name in _LENGTHS},
        "fewest_teeth": fewest_teeth(mechanism),
        "dwell_within": [
            {
                "tolerance_deg": deg,
                "dwell_deg": math.degrees(dwell),
                "share": min(dwell / mechanism.cell_angle, 1.0),
            }
            for deg, dwell in rests
        ],
    }


def draw(mechanism: "EllipticalPlanetary", theta: float) -> "Axes":
    """The drive to scale at a driver angle [rad]."""
    from escapement.plots.planetary import plot_planetary

    return plot_planetary(mechanism, theta)
