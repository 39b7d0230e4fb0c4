"""Parts of a mechanism as a DXF or SVG file for cutting, after a check of the motion."""

import math
from typing import Any

import escapement as esc
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.files import CUTS
from escapement.fits import Fits
from escapement.inputs import inputs_of_mechanism, inputs_of_settings
from escapement.mechanisms import DEFAULT_KIND, kind_of
from escapement.quantity import Quantity, declared
from escapement.units import factor

_FITS = {name: entry for name, entry in declared(Fits).items() if name != "clearance"}
_DISCS = {
    "thickness": Quantity(
        name="thickness", key="thickness", long_name="thickness of the parts", unit="length",
        exclusive=True, required=True, metavar="T", remedy="give the thickness",
    ),
    "density": Quantity(
        name="density", key="density", long_name="density of their material", unit="density",
        exclusive=True, required=True, metavar="RHO", remedy="give the density",
    ),
}  # fmt: skip
_ROUNDING = 1e-12  # gaps of so many crank radii are 0 but for rounding
_KINDS = dict.fromkeys(("width", "height", "least_gap", "gap", "x", "y"), "length") | dict.fromkeys(
    ("driver_inertia", "follower_inertia"), "inertia"
)


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    _arguments.add_group(parser, "fits", _FITS)
    _arguments.add_group(parser, "discs, for mass and inertia", _DISCS)
    output = parser.add_argument_group("output")
    text = "write the parts: FILE.dxf, or FILE.svg; in inches with --units in-lbf-s, else in mm"
    _arguments.add_output(output, "FILE", text)
    text = "chords instead of arcs, for machines that can only cut lines"
    output.add_argument("--segments", action="store_true", help=text)
    text = "DXF of release 12, for old programs; it has no units"
    output.add_argument("--r12", action="store_true", help=text)
    parser.set_defaults(plot=None)


def execute(args: Arguments) -> int:
    """Check the motion, write the parts, print them and the least gaps."""
    _output.check_wanted(args, formats=CUTS)
    for name in ("segments", "r12"):
        if getattr(args, name) and args.output is None:
            raise UsageError(f"--{name} must come with --output FILE, got none; name a file")
    given = _arguments.typed(args, _FITS)
    if "clearance" not in kind_of(args.kind or DEFAULT_KIND).options() and args.clearance:
        # a Geneva wheel has its own clearance, which this option sets
        given["clearance"] = factor("length", args.units) * args.clearance
        args.clearance = None
    fits, mechanism = Fits(**given), _arguments.read_mechanism(args)
    if args.output is None:
        gaps = esc.motion_check(mechanism, fits)
    else:
        how = {name: getattr(args, name) for name in ("segments", "r12", "force")}
        gaps = esc.export(mechanism, args.output, fits, inches=args.units != "SI", **how)
    known = [*inputs_of_mechanism(mechanism), *inputs_of_settings(fits, mechanism.meshed)]
    record = _summary(args, mechanism, fits, gaps)
    _output.report(args, record, _KINDS, _warning(mechanism, fits), known)
    return 0


def _summary(args: Arguments, mechanism: Any, fits: Fits, gaps: Any) -> dict[str, Any]:
    """What `export` reports, by JSON key, in SI."""
    rounding = _ROUNDING * mechanism.crank_radius
    wide = [0.0 if abs(pair.gap) < rounding else pair.gap for pair in gaps]
    record: dict[str, Any] = {"kind": mechanism.kind, "least_gap": wide[0]}
    parts, discs = esc.parts_of(mechanism, fits), _arguments.typed(args, _DISCS)
    if discs:
        _arguments.require(args, _DISCS, ", both or none")
        if isinstance(mechanism, esc.Geneva):
            inertia = esc.disc_inertia(mechanism, **discs, fits=fits)
            record |= {"driver_inertia": inertia.driver, "follower_inertia": inertia.follower}
    rows = []
    for part in parts:
        low, high = part.edge.box
        size = {"width": high.real - low.real, "height": high.imag - low.imag}
        rows.append({"part": part.name, **size, "holes": len(part.holes)})
        if discs:
            rows[-1]["mass_kg"] = part.mass(**discs)
    record["parts"] = rows
    record["least_gaps"] = [
        {
            "bodies": " and ".join(pair.names), "gap": gap,
            "angle_deg": math.degrees(pair.theta), "x": pair.place.real, "y": pair.place.imag,
        }
        for pair, gap in zip(gaps, wide, strict=True)
    ]  # fmt: skip
    return record


def _warning(mechanism: Any, fits: Fits) -> str:
    """A warning for a drawing without clearance."""
    if mechanism.meshed or getattr(mechanism, "clearance", fits.clearance):
        return ""
    return "warning: the slots are as wide as the pins; give a --clearance to make them"
