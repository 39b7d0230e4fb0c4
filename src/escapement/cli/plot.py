"""`escapement plot`: the right figures for what a file holds."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from escapement.cli import _arguments, _cases, _output
from escapement.cli._arguments import Parser, UsageError
from escapement.errors import InvalidValue
from escapement.files import check_input
from escapement.status import Status

if TYPE_CHECKING:
    from escapement.study.result import Study

SUMMARY = "The right figures for what a file holds: a study or a motion."


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    add = parser.add_argument
    add("file", type=Path, metavar="FILE.h5", help="written by sweep or run -o")
    text = ".png, .pdf or .svg, replaced where it exists (default: FILE.png beside FILE.h5)"
    add("-o", "--output", type=Path, metavar="OUT", help=text)
    text = (
        "only the cases at these values, in the units of the file: slots=6 of a study of "
        "slots, friction and torque"
    )
    add("--select", metavar="NAME=VALUE,...", help=text)
    text = "units of the axes of a study (default: those of the file); motions are drawn in SI"
    _arguments.add_common(parser, units=None, text=text)


def execute(args: argparse.Namespace) -> int:
    """Draw the file."""
    check_input(args.file, "file")
    path = args.output or args.file.with_suffix(".png")
    _output.check_picture(path, args.file)
    from escapement import plots
    from escapement.motion_file import is_motion, read_motion
    from escapement.study.reader import read_study

    gaps = ""
    if is_motion(args.file):
        for option, value in (("--select", args.select), ("--units", args.units)):
            if value not in (None, "SI"):
                raise UsageError(
                    f"{option} must come with a study, got {value!r} and a motion; leave it out"
                )
        holds, figure = "motion", plots.motion.plot_motion(read_motion(args.file))
    else:
        study = _selected(read_study(args.file), args)
        gaps = _gaps(study)
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
    answered = study.results["status"] == Status.OK
    lost = answered & np.isnan(study.results["rise_time"])
    counts["without a rise time"] = int(np.count_nonzero(lost))
    return ", ".join(f"{n} {what}" for what, n in counts.items() if n)


def _selected(study: "Study", args: argparse.Namespace) -> "Study":
    try:
        return study.at(**_cases.parse(args.select or ""))
    except InvalidValue as error:
        raise UsageError(f"--select, of {args.file}: {error}") from None


def in_units(study: "Study", system: str | None) -> "Study":
    """A study with its parameters in another unit system; None leaves them."""
    from dataclasses import replace

    axes, sampled, units = dict(study.axes), dict(study.sampled), dict(study.units)
    for values in (axes, sampled):
        for name in values:
            scale, units[name] = _cases.in_system(units[name], system)
            values[name] = values[name] * scale
    return replace(study, axes=axes, sampled=sampled, units=units)
