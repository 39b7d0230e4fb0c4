"""Figures that suit the study or the motion in a file."""

from dataclasses import replace
from pathlib import Path

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.files import FILMS, FORMATS, PAGES, check_input, file_format
from escapement.base.units import SYSTEMS
from escapement.cli import _output
from escapement.cli._arguments import Arguments, Parser, UsageError

UNITS = "units of the figure (default: those of a study; SI for a motion), and of a CSV table"


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    add = parser.add_argument
    add("file", type=Path, metavar="FILE.h5", help="of run -o or sweep, also .csv and .parquet")
    text = (
        ".png, .pdf or .svg; of a motion also a film, .gif, .mp4 or .webm, or .html, a page that "
        "plays it; replaced if it exists (default: FILE.png beside FILE.h5)"
    )
    add("-o", "--output", type=Path, metavar="OUT", help=text)
    text = (
        "only the cases at these values, in the units of the file or with their own: slots=6 of a "
        "study of slots, friction and torque"
    )
    add("--select", metavar="NAME=VALUE,...", help=text)
    text = "only these results, of those that the study keeps: period,rise_time"
    add("--result", metavar="NAME,...", help=text)


def execute(args: Arguments) -> int:
    """Draw the file."""
    check_input(args.file, "file")
    path = args.output or args.file.with_suffix(".png")
    from escapement.motion_file import is_motion, read_motion
    from escapement.study.table_files import is_table

    # a file of a motion says so itself; every other one is taken for a study
    holds, units = "motion", SYSTEMS[0]
    moving = not is_table(args.file) and is_motion(args.file)
    file_format(path, FORMATS + FILMS + PAGES if moving else FORMATS)
    _output.check_output(path, args.file, drawn=True)
    if moving:
        for option, value in {"--select": args.select, "--result": args.result}.items():
            if value is not None:
                raise UsageError(
                    f"{option} must come with a study, got {value!r} and a motion; leave it out"
                )
        shown = read_motion(args.file)
        plot = _output.moving(path, shown, lambda plots: plots.motion_plots.plot_motion(shown))
        content = _output.picture(plot)
    else:
        from escapement.study.selection import parse_selection

        holds, study = "study", _study(args)
        units = study.configuration.get("units", SYSTEMS[0])
        selected = parse_selection(args.select or "", units)
        try:
            study = study.at(**selected)
        except InvalidValue as error:
            raise UsageError(f"--select, of {args.file}: {error}") from None
        args.units = args.units or units
        study = in_units(study, args.units)
        wanted = args.result and [name.strip() for name in args.result.split(",")]
        content = _output.picture(lambda plots: plots.plot_study(study, wanted))
    _output.save_as(path, content)
    record = {"input": str(args.file), "holds": holds, "output": str(path)}
    args.units = args.units or units
    _output.tell(args, record, table=lambda: _output.note(f"{holds} drawn in {path}"))
    return 0


def _study(args: Arguments) -> "esc.Study":
    """The study in an HDF5 file or a table."""
    from escapement.study.table_files import is_table, read_table

    if not is_table(args.file):
        return esc.read_study(args.file)
    try:
        return read_table(args.file, args.units)
    except InvalidValue as error:
        raise UsageError(f"{args.file}: {error}") from None


def in_units(study: "esc.Study", system: str) -> "esc.Study":
    """A study in a unit system; its file says in which unit each of its numbers is."""
    from escapement.study.plan import unit_kind
    from escapement.study.selection import in_system

    axes, sampled, results = dict(study.axes), dict(study.sampled), dict(study.results)
    units = dict(study.units)
    for values in (axes, sampled, results):
        for name in values:
            scale, units[name] = in_system(unit_kind(name), units[name], system)
            values[name] = values[name] * scale
    return replace(study, axes=axes, sampled=sampled, results=results, units=units)
