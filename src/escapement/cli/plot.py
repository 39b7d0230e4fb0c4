"""`escapement plot`: the right figures for what a file holds."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from escapement.cli import _arguments, _output
from escapement.cli._arguments import Parser, UsageError
from escapement.errors import InputFileError, InvalidValue
from escapement.files.names import check_input
from escapement.status import Status

if TYPE_CHECKING:
    from escapement.study.result import Study

_CONVERTED = ("torque", "inertia", "length", "force")

SUMMARY = "The right figures for what a file holds: a study or a motion."


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    parser.add_argument("file", type=Path, metavar="FILE.h5", help="written by sweep or run -o")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="OUT",
        help=".png, .pdf or .svg, replaced where it exists (default: FILE.png beside FILE.h5)",
    )
    parser.add_argument(
        "--select",
        metavar="NAME=VALUE,...",
        help="only the cases at these values, in the units of the file: slots=6 of a study of "
        "slots, friction and torque",
    )
    _arguments.add_common(
        parser,
        units=None,
        text="units of the axes of a study (default: those of the file); motions are drawn in SI",
    )


def execute(args: argparse.Namespace) -> int:
    """Draw the file."""
    check_input(args.file, "file")
    path = args.file.with_suffix(".png") if args.output is None else args.output
    _output.check_picture(path, args.file)
    _check_hdf5(args.file)
    from escapement import plots
    from escapement.motion_file import is_motion, read_motion
    from escapement.study.reader import read_study

    gaps = ""
    if is_motion(args.file):
        if args.select is not None:
            raise UsageError(
                f"--select must come with a study, got {args.select!r} and a motion; leave it out"
            )
        if args.units not in (None, "SI"):
            raise UsageError(
                f"--units must be SI for a motion, got {args.units!r}; leave it out, only the "
                "axes of a study are drawn in other units"
            )
        from escapement.plots.motion import plot_motion

        holds, figure = "motion", plot_motion(read_motion(args.file))
    else:
        study = _selected(read_study(args.file), args)
        gaps = _gaps(study) if "status" in study.results else ""
        holds, figure = "study", plots.plot_study(in_units(study, args.units))
    plots.save(figure, path)
    if args.json:
        _output.print_json({"input": str(args.file), "holds": holds, "output": str(path)})
    else:
        _output.note(f"{holds} drawn in {path}")
    if gaps:
        _output.note(f"of {study.cases} cases these leave gaps: {gaps}")
    return 0


def _gaps(study: "Study") -> str:
    """How many cases have no number to draw, and why; "" for none."""
    import numpy as np

    counts = {label: n for label, n in study.outcomes.items() if label != Status.OK.label}
    if "rise_time" in study.results:
        answered = study.results["status"] == Status.OK
        counts["without a rise time"] = int(
            np.count_nonzero(answered & np.isnan(study.results["rise_time"]))
        )
    return ", ".join(f"{n} {what}" for what, n in counts.items() if n)


def _check_hdf5(file: Path) -> None:
    """Refuse what can be neither a study nor a motion; the readers look closer."""
    import h5py

    if os.access(file, os.R_OK) and not h5py.is_hdf5(file):
        raise InputFileError(
            f"file {file} must be an HDF5 file, and is not or is cut short; "
            "name one that escapement sweep or run -o wrote"
        )


def _selected(study: "Study", args: argparse.Namespace) -> "Study":
    from escapement.cli._cases import parse

    try:
        return study.at(**parse(args.select or ""))
    except InvalidValue as error:
        raise UsageError(f"--select, of {args.file}: {error}") from None


def in_units(study: "Study", system: str | None) -> "Study":
    """A study with its parameters in another unit system; None leaves them."""
    from dataclasses import replace

    from escapement.units import factor, unit_name

    own = study.configuration.get("units", "SI")
    if system in (None, own):
        return study
    axes, sampled, units = dict(study.axes), dict(study.sampled), dict(study.units)
    for values in (axes, sampled):
        for name in values:
            for quantity in _CONVERTED:
                if units[name] == unit_name(quantity, own):
                    values[name] = values[name] * (factor(quantity, own) / factor(quantity, system))
                    units[name] = unit_name(quantity, system)
                    break
    return replace(study, axes=axes, sampled=sampled, units=units)
