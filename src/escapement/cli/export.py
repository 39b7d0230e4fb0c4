"""Parts of a mechanism as a file for cutting or printing, after a check of the motion."""

from functools import partial
from typing import Any

import escapement as esc
from escapement.base.files import CUTS, file_format, write_file
from escapement.base.quantity import Numbers, Quantity, Setting, Truth, declared
from escapement.base.spoken import as_spoken
from escapement.base.units import factor, printed
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.mechanisms import DEFAULT_KIND, kind_of
from escapement.mechanisms.other_sizes import diameters, numbers_of_sizes
from escapement.model.inputs import inputs_of_mechanism, inputs_of_settings
from escapement.outlines.fits import Fits

_NO_TEETH = ("teeth", 0, "ratio")
_ALSO = ("clearance", "teeth")
"""Fits whose option belongs to some kinds of mechanism, and is a fit with the others."""
_FITS = {name: entry for name, entry in declared(Fits).items() if name not in _ALSO}
_DISCS = {
    "thickness": Quantity(
        name="thickness", key="thickness", unit="length",
        long_name="thickness of the parts, for FILE.stl or with a density",
        exclusive=True, metavar="T", remedy="give the thickness",
    ),
    "density": Quantity(
        name="density", key="density", long_name="density of their material", unit="density",
        exclusive=True, metavar="RHO", remedy="give the density", needs="thickness",
    ),
}  # fmt: skip
_WALLS = {
    "least_wall": Quantity(
        name="least_wall", key="least_wall", long_name="thinnest wall without a warning",
        unit="length", metavar="T", remedy="give the thickness",
        note=" (default: 0.3 mm, or the kerf if that is more)",
    ),
}  # fmt: skip
_SIZES_OF_FITS = diameters(_FITS)
_DIAMETERS = {name: size.entry for name, size in _SIZES_OF_FITS.items()}
_HOW = {
    "segments": "chords instead of arcs, for machines that can only cut lines",
    "r12": "DXF of release 12, for old programs; it has no units",
    "no_crosses": "no crosses at axes and centres of holes",
}
_DRAWN = {
    "sheet": Numbers(
        name="sheet", key="sheet", long_name="size of the material, on which parts lie in rows",
        unit="length", metavar="WIDTH,HEIGHT", remedy="give width and height", needs="output",
    ),
    "title": Setting(
        name="title", key="title", metavar="TEXT", needs="output",
        long_name="title of a block with all dimensions beside the parts",
    ),
    "tolerance": Quantity(
        name="tolerance", key="tolerance", long_name="general tolerance of dimensions, for the "
        "title block", unit="length", metavar="T", remedy="give the tolerance", needs="output",
    ),
}  # fmt: skip
_LEAST_WALL = 3e-4  # [m]
_SIZES = 1e-3, 2.0  # parts beyond these were probably typed in another unit [m]


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    _arguments.add_group(parser, "fits", _FITS | _DIAMETERS)
    _arguments.add_group(parser, "warnings", _WALLS)
    _arguments.add_group(parser, "thickness, mass and inertia", _DISCS)
    output = parser.add_argument_group("output")
    text = "write the parts: FILE.dxf, .svg or .stl; in inches with --units in-lbf-s, else in mm"
    _arguments.add_output(output, "FILE", text, CUTS)
    for name, text in _HOW.items():
        entry = Truth(name=name, long_name=text, needs="output")
        _arguments.add_setting(output, entry, default=False)
    for drawn in _DRAWN.values():
        _arguments.add_setting(output, drawn)


def execute(args: Arguments) -> int:
    """Check the motion, write the parts, print them and the least gaps."""
    given = numbers_of_sizes(_SIZES_OF_FITS, _arguments.typed(args, _FITS | _DIAMETERS))
    vars(args).update(dict.fromkeys(_DIAMETERS))  # the radii are told
    for name in _ALSO:
        value = getattr(args, name)
        if name not in kind_of(args.kind or DEFAULT_KIND).options() and value is not None:
            scale = factor("length", args.units) if name == "clearance" else 1
            given[name] = declared(Fits)[name].check(name, scale * value)
            setattr(args, name, None)
    fits, mechanism, data = Fits(**given), _arguments.read_mechanism(args), None
    discs = _arguments.typed(args, _DISCS)
    if discs.keys() == {"thickness"} and (args.output is None or args.output.suffix != ".stl"):
        raise UsageError("--thickness must come with --density or -o FILE.stl; give one of them")
    if args.output is None:
        gaps = esc.motion_check(mechanism, fits)
    else:
        how = {name: getattr(args, name) for name in ("segments", "r12")}
        how |= {"crosses": not args.no_crosses} | _arguments.typed(args, _DRAWN)
        how["thickness"] = discs.get("thickness")
        suffix, inches = file_format(args.output, CUTS), args.units == "in-lbf-s"
        from escapement.outlines.part_files import drawn

        data, gaps = drawn(mechanism, suffix, fits, inches=inches, **how)
    from escapement.outlines.part_record import record_of

    parts = esc.parts_of(mechanism, fits)
    record = record_of(mechanism, fits, parts, gaps, discs if len(discs) > 1 else {})
    warning = _warning(args, mechanism, fits, record.values["parts"])
    # nothing is written before every number is known to be possible
    _output.save(args, lambda: partial(write_file, args.output, [data or b""], args.force))
    # no number of teeth leaves it to the gears, or there are none
    chosen = [row for row in inputs_of_settings(fits, mechanism.meshed) if row != _NO_TEETH]
    known = [*inputs_of_mechanism(mechanism), *chosen]
    _output.tell(args, _output.with_reasons(record, warning), known)
    return 0


def _warning(args: Arguments, mechanism: Any, fits: Fits, rows: list[dict[str, Any]]) -> str:
    """What a workshop would ask about: no clearance, thin walls, very large or small parts."""
    texts, length = list[str](), partial(as_spoken, quantity="length", figures=3)
    exact = not (mechanism.meshed or mechanism.clearance or fits.clearance)
    if exact and not mechanism.driver_features:
        texts.append("the slots are as wide as the pins; give a --clearance to make them")
    least = _arguments.typed(args, _WALLS).get("least_wall", max(_LEAST_WALL, fits.kerf))
    said = [f"{row['part']} {length(row['wall'])}" for row in rows if row["wall"] <= least]
    if thin := dict.fromkeys(said):
        texts.append(
            f"walls of {length(least)} or less may not survive the cut: {', '.join(thin)}; "
            "choose a larger crank or thinner shafts and pins, or state what you can make with "
            "--least-wall"
        )
    for row in rows:
        across = max(row["width"], row["height"])
        if not _SIZES[0] <= across <= _SIZES[1]:
            texts.append(
                f"{row['part']} is {length(across)} across; a length without a unit "
                f"is in {printed('length', args.units)}: write for example "
                f"'{'12 mm' if args.units == 'SI' else '0.5 in'}'"
            )
            break
    return "; ".join(f"warning: {text}" for text in texts)
