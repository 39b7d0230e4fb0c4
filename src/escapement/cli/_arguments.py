"""Options that several commands share, and the objects they describe.

Values are checked as typed, in the user's units, so that a message shows what the user
wrote; the conversion to SI follows.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from escapement import validate
from escapement.cli._kinds import read_mechanism
from escapement.cli._parser import Parser, UsageError, number, one_of, option
from escapement.files.names import FORMATS
from escapement.units import SYSTEMS, factor

if TYPE_CHECKING:
    from escapement.model import Escapement, Inertia


class Quantity(NamedTuple):
    """A physical option: its kind of unit, its rule, and what to give."""

    unit: str
    rule: Callable[..., float]
    text: str


QUANTITIES = {
    "torque": Quantity("torque", validate.positive, "constant driving torque"),
    "driver_inertia": Quantity(
        "inertia", validate.positive, "moment of inertia of the driver and what turns with it"
    ),
    "follower_inertia": Quantity(
        "inertia", validate.positive, "moment of inertia of the follower and what turns with it"
    ),
    "friction": Quantity(
        "ratio", validate.non_negative, "coefficient of friction between pin and slot"
    ),
    "efficiency": Quantity(
        "share",
        validate.positive,
        "share of the power that a mesh passes on, in place of friction",
    ),
    "load_torque": Quantity(
        "torque", validate.non_negative, "constant torque opposing the follower"
    ),
    "crank_radius": Quantity(
        "length", validate.positive, "distance of the pins from the driver's axis"
    ),
    "fixed_radius": Quantity("length", validate.positive, "radius of the fixed gear"),
    "sun_radius": Quantity("length", validate.positive, "pitch radius of the fixed sun gear"),
    "planet_radius": Quantity("length", validate.positive, "pitch radius of the spur planet"),
    "initial_speed": Quantity(
        "speed", validate.non_negative, "driver speed at the first pin entry"
    ),
    "duration": Quantity("time", validate.positive, "time to run"),
    "max_step": Quantity("time", validate.positive, "longest step"),
}
_METAVARS = {
    "torque": "M",
    "inertia": "I",
    "ratio": "MU",
    "share": "E",
    "length": "R",
    "speed": "W",
    "time": "S",
}
_SHOWN = {
    "torque": " [N m, in-lbf]",
    "inertia": " [kg m^2, in-lbf-s^2]",
    "length": " [m, in]",
    "speed": " [rad/s]",
    "time": " [s]",
}


def add_quantity(
    parser: argparse._ActionsContainer,
    name: str,
    *,
    required: bool = False,
    default: float | None = None,
    note: str = "",
) -> None:
    """Add the option of one physical quantity."""
    keywords = quantity_keywords(name, note=note)
    parser.add_argument(option(name), required=required, default=default, **keywords)


def quantity_keywords(name: str, *, note: str = "") -> dict[str, Any]:
    """What `add_argument` takes for the option of one physical quantity."""
    quantity = QUANTITIES[name]
    return {
        "type": number(option(name), quantity.rule, f"give the {quantity.text}"),
        "metavar": _METAVARS[quantity.unit],
        "help": quantity.text + _SHOWN.get(quantity.unit, "") + note,
    }


def add_output(group: argparse._ActionsContainer, file: str, text: str) -> None:
    """Add a file to write, never over another unless it may: `_files.check_wanted` looks."""
    group.add_argument("-o", "--output", type=Path, metavar=file, help=text)
    group.add_argument("--force", action="store_true", help=f"replace {file} where it exists")


def add_plot(group: argparse._ActionsContainer, text: str) -> None:
    """Add a figure to draw; `_files.check_wanted` looks at its place."""
    names = f"{', '.join(FORMATS[:-1])} or {FORMATS[-1]}"
    group.add_argument(
        "--plot", type=Path, metavar="FILE", help=f"{text}; {names}, replaced where it exists"
    )


def add_common(
    parser: Parser,
    *,
    units: str | None = SYSTEMS[0],
    text: str = "units of what goes in and what comes out (default: SI)",
) -> None:
    """Add what every command takes."""
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    parser.add_argument(
        "--units",
        type=one_of("--units", SYSTEMS),
        default=units,
        metavar="|".join(SYSTEMS),
        help=text,
    )


def read_inertia(args: argparse.Namespace) -> "Inertia | None":
    """Both inertias, or None where neither is given."""
    from escapement.model import Inertia

    driver = optional_si(args, "driver_inertia")
    follower = optional_si(args, "follower_inertia")
    if driver is not None and follower is not None:
        return Inertia(driver=driver, follower=follower)
    if driver is None and follower is None:
        return None
    missing, given = "--driver-inertia", "--follower-inertia"
    if follower is None:
        missing, given = given, missing
    raise UsageError(f"{missing} must be given beside {given}, got that alone; give both or none")


def read_escapement(args: argparse.Namespace) -> "Escapement":
    """The escapement the arguments describe."""
    from escapement.model import Escapement, Inertia

    return Escapement(
        mechanism=read_mechanism(args),
        inertia=Inertia(driver=si(args, "driver_inertia"), follower=si(args, "follower_inertia")),
        torque=si(args, "torque"),
        friction=args.friction,
        load_torque=si(args, "load_torque"),
        efficiency=args.efficiency,
    )


def si(args: argparse.Namespace, name: str) -> float:
    """Value of a physical option in SI."""
    return float(getattr(args, name) * factor(QUANTITIES[name].unit, args.units))


def optional_si(args: argparse.Namespace, name: str) -> float | None:
    """Value of a physical option in SI; None where it is not given."""
    return None if getattr(args, name) is None else si(args, name)
