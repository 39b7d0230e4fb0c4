"""The gear-driven Geneva wheel on the command line."""

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from escapement import validate
from escapement.cli._arguments import optional_si, quantity_keywords
from escapement.cli._cell import wheel
from escapement.cli._kinds import require
from escapement.cli._parser import checked, one_of, whole
from escapement.curves import CURVES
from escapement.units import degrees

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from escapement.mechanisms import GearDriven

OPTIONS: dict[str, dict[str, Any]] = {
    "stations": {
        "type": whole("--stations", 3, "the wheel needs 3 stations or more"),
        "metavar": "N",
        "help": "stations of the wheel",
    },
    "lobes": {
        "type": checked(
            lambda text: validate.rational("--lobes", text, "give a number such as 2 or 1/2")
        ),
        "metavar": "M",
        "help": "unreal lobes between two of the pin's path, a whole number or a fraction",
    },
    "curve": {
        "type": one_of("--curve", CURVES),
        "metavar": "NAME",
        "help": f"pin's path: {', '.join(CURVES)}",
    },
    "pins": {
        "type": whole("--pins", 1, "give the number of pins, or leave it out"),
        "metavar": "P",
        "help": "pins on the planet (default: 1)",
    },
    "unused_lobes": {
        "type": whole("--unused-lobes", 0, "give 0 to use every lobe"),
        "metavar": "J",
        "help": "lobes that find no slot between two that do (default: 0)",
    },
    "solution": {
        "type": whole("--solution", 1, "they count from 1"),
        "metavar": "I",
        "help": "which mechanism, in order of alpha, where there are several (default: 1)",
    },
    "fixed_radius": quantity_keywords("fixed_radius"),
}

_LENGTHS = ("carrier", "arm", "entry_radius", "closest_radius")
QUANTITIES = dict.fromkeys(("planet_radius", *_LENGTHS), "length")


def read(args: argparse.Namespace) -> "GearDriven":
    """The mechanism the arguments describe."""
    require(args, "stations", "lobes", "curve")
    from escapement.mechanisms import GearDriven

    given = {name: getattr(args, name) for name in ("pins", "unused_lobes", "solution")}
    return GearDriven(
        args.stations,
        args.lobes,
        args.curve,
        fixed_radius=optional_si(args, "fixed_radius"),
        **{name: value for name, value in given.items() if value is not None},
    )


def describe(mechanism: "GearDriven") -> dict[str, Any]:
    """Geometry of a gear-driven wheel by JSON key, and of every other solution."""
    from escapement.mechanisms.gear_equation import lobe_ratios

    count = len(lobe_ratios(mechanism.stations, mechanism.lobes, mechanism.curve))
    solutions = [_with_solution(mechanism, place) for place in range(1, count + 1)]
    rows = [_geometry(other) for other in solutions]
    return _geometry(mechanism) | _lengths(mechanism) | {"solutions": rows}


def _with_solution(mechanism: "GearDriven", place: int) -> "GearDriven":
    """Another solution with the same pins and lobes, or with one pin where these do not fit."""
    from escapement.errors import InvalidValue

    try:
        return replace(mechanism, solution=place)
    except InvalidValue:
        return replace(mechanism, solution=place, pins=1, unused_lobes=0)


def _geometry(mechanism: "GearDriven") -> dict[str, Any]:
    return {
        "stations": mechanism.stations,
        **wheel(mechanism),
        "gear_ratio": float(mechanism.gear_ratio),
        "alpha_deg": degrees(mechanism.alpha),
        "carrier_over_fixed": mechanism.carrier_over_fixed,
        "arm_over_fixed": mechanism.arm_over_fixed,
        "entry_radius_over_fixed": mechanism.entry_radius_over_fixed,
        "closest_radius_over_fixed": mechanism.closest_radius_over_fixed,
        "turns_with_driver": mechanism.turns_with_driver,
    }


def _lengths(mechanism: "GearDriven") -> dict[str, float]:
    """Its lengths [m], where the size of the fixed gear is known."""
    if mechanism.fixed_radius is None:
        return {}
    planet = mechanism.fixed_radius / abs(float(mechanism.gear_ratio))
    others = {
        name: getattr(mechanism, f"{name}_over_fixed") * mechanism.fixed_radius for name in _LENGTHS
    }
    return {"planet_radius": planet} | others


def draw(mechanism: "GearDriven", theta: float) -> "Axes":
    """The drive to scale at a carrier angle [rad]."""
    from escapement.plots.gear_driven import plot_gear_driven

    return plot_gear_driven(mechanism, theta)
