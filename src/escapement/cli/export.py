"""Parts of a mechanism as a DXF or SVG file for cutting, after a check of the motion."""

import math
from typing import TYPE_CHECKING, Any

import escapement as esc
from escapement.base.files import CUTS, file_format, write_file
from escapement.base.quantity import Quantity, declared
from escapement.base.units import factor, printed
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.mechanisms import DEFAULT_KIND, kind_of
from escapement.model.inputs import inputs_of_mechanism, inputs_of_settings
from escapement.outlines.fits import Fits

if TYPE_CHECKING:
    from escapement.outlines.interference import Nearest
    from escapement.outlines.part import Part

_NO_TEETH = ("teeth", 0, "ratio")
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
_WALLS = {
    "least_wall": Quantity(
        name="least_wall", key="least_wall", long_name="thinnest wall without a warning",
        unit="length", metavar="T", remedy="give the thickness",
        note=" (default: 0.3 mm, or the kerf if that is more)",
    ),
}  # fmt: skip
_LEAST_WALL = 3e-4  # [m]
_SIZES = 1e-3, 2.0  # parts beyond these were probably typed in another unit [m]
_LENGTHS = ("width", "height", "wall", "least_gap", "gap", "x", "y")
_INERTIAS = ("driver_inertia", "follower_inertia")
_KINDS = dict.fromkeys(_LENGTHS, "length") | dict.fromkeys(_INERTIAS, "inertia")
_KINDS["mass"] = "mass"


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    _arguments.add_group(parser, "fits", _FITS)
    _arguments.add_group(parser, "warnings", _WALLS)
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
    if any(getattr(args, name) is not None for name in _DISCS):
        _arguments.require(args, _DISCS, ", both or none")
    given = _arguments.typed(args, _FITS)
    if "clearance" not in kind_of(args.kind or DEFAULT_KIND).options() and args.clearance:
        # a Geneva wheel has its own clearance, which this option sets
        given["clearance"] = factor("length", args.units) * args.clearance
        args.clearance = None
    fits, mechanism, data = Fits(**given), _arguments.read_mechanism(args), None
    if args.output is None:
        gaps = esc.motion_check(mechanism, fits)
    else:
        how = {name: getattr(args, name) for name in ("segments", "r12")}
        suffix, inches = file_format(args.output, CUTS), args.units != "SI"
        from escapement.outlines.part_files import drawn

        data, gaps = drawn(mechanism, suffix, fits, inches=inches, **how)
    parts = esc.parts_of(mechanism, fits)
    record = _summary(args, mechanism, fits, parts, gaps)
    warning = _warning(args, mechanism, fits, record["parts"])
    # nothing is written before every number is known to be possible
    if data is not None:
        write_file(args.output, [data], args.force)
    # no number of teeth leaves it to the gears, or there are none
    chosen = [row for row in inputs_of_settings(fits, mechanism.meshed) if row != _NO_TEETH]
    known = [*inputs_of_mechanism(mechanism), *chosen]
    _output.report(args, record, _KINDS, warning, known)
    return 0


def _summary(
    args: Arguments, mechanism: Any, fits: Fits, parts: "tuple[Part, ...]", gaps: "list[Nearest]"
) -> dict[str, Any]:
    """What `export` reports, by JSON key, in SI."""
    record: dict[str, Any] = {"kind": mechanism.kind, "least_gap": gaps[0].gap}
    discs = _arguments.typed(args, _DISCS)
    if discs and isinstance(mechanism, esc.Geneva):
        inertia = esc.disc_inertia(mechanism, **discs, fits=fits)
        record |= {"driver_inertia": inertia.driver, "follower_inertia": inertia.follower}
    rows = []
    for part in parts:
        size = {"width": part.size.real, "height": part.size.imag, "wall": part.wall.width}
        rows.append({"part": part.name, **size, "holes": len(part.holes)})
        if discs:
            rows[-1]["mass"] = part.mass(**discs)
    record["parts"] = rows
    record["least_gaps"] = [
        {
            "bodies": " and ".join(pair.names), "gap": pair.gap,
            "angle_deg": math.degrees(pair.theta), "x": pair.point.real, "y": pair.point.imag,
        }
        for pair in gaps
    ]  # fmt: skip
    return record


def _warning(args: Arguments, mechanism: Any, fits: Fits, rows: list[dict[str, Any]]) -> str:
    """What a workshop would ask about: no clearance, thin walls, very large or small parts."""
    texts = []
    if not (mechanism.meshed or mechanism.clearance or fits.clearance):
        texts.append("the slots are as wide as the pins; give a --clearance to make them")

    unit = printed("length", args.units)
    example = "12 mm" if args.units == "SI" else "0.5 in"

    def length(size: float) -> str:
        shown = _output.in_units(size, "length", args.units)
        return f"{shown:.3g} {unit}"

    least = _arguments.typed(args, _WALLS).get("least_wall", max(_LEAST_WALL, fits.kerf))
    thin = [f"{row['part']} {length(row['wall'])}" for row in rows if row["wall"] <= least]
    if thin:
        texts.append(
            f"walls of {length(least)} or less may not survive the cut: {', '.join(thin)}; "
            "choose a larger crank or thinner shafts and pins, or state what you can make with "
            "--least-wall"
        )
    for row in rows:
        across = max(row["width"], row["height"])
        if not _SIZES[0] <= across <= _SIZES[1]:
            texts.append(
                f"{row['part']} is {length(across)} across; a length without a unit is in {unit}: "
                f"write for example '{example}'"
            )
            break
    return "; ".join(f"warning: {text}" for text in texts)
