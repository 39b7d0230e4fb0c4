"""A source's printed numbers beside the true ones, why they differ, and the figures."""

from importlib import import_module
from pathlib import Path
from typing import Any

import escapement as esc
from escapement.base.files import FORMATS, replace_file
from escapement.base.text import as_csv, as_json
from escapement.base.units import SYSTEMS
from escapement.cli import _arguments, _log, _output
from escapement.cli._arguments import Arguments, Parser, one_of
from escapement.cli._inputs import as_record, inputs_of_command, print_inputs

SOURCES = ("meyer", "filemon", "dijksman", "prikhodko")
"""Folders of `escapement.sources`; `reproduce(units)` of each gives a `Reproduction`."""
ALL = "all"
UNITS = "units of Meyer's torques and inertias (default: in-lbf-s, his own)"


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "source",
        type=one_of("SOURCE", (*SOURCES, ALL)),
        metavar="SOURCE",
        help="meyer: the 49 printed runs of Appendix E (1973); filemon: Table I (1960); "
        "dijksman: gear-driven wheels (1974); "
        "prikhodko: the planetary drive with elliptical gears (2020); all: each after the other",
    )
    what = "tables (CSV, JSON) and figures; with all, each source has a folder in it"
    _arguments.add_folder(parser, what)
    formats = [suffix[1:] for suffix in FORMATS]
    _arguments.add_choice(
        parser, "format", f"format of the figures in DIR (default: {formats[0]})", formats, "output"
    )


def execute(args: Arguments) -> int:
    """Recompute, print, and fill the folder."""
    from escapement.base.progress import set_stage

    several = args.source == ALL
    records: dict[str, Any] = {}
    inputs = {"inputs": as_record(inputs_of_command(args), args.units or SYSTEMS[1])}
    with _output.folder(args.output):
        for source in SOURCES if several else (args.source,):
            set_stage(source)
            if records and not args.json:
                print("\n")
            # files of two sources could have the same name
            folder = args.output / source if args.output and several else args.output
            records[source] = _reproduce(source, folder, args, inputs)
    if args.json:
        _output.print_json(inputs | (records if several else records[args.source]))
    return 0


def _reproduce(
    source: str, folder: Path | None, args: Arguments, inputs: dict[str, Any]
) -> dict[str, Any]:
    """Recompute one source, and write and print the results; returns its record.

    `inputs` are what the JSON begins with.
    """
    with _output.folder(folder):
        made = import_module(f"escapement.sources.{source}").reproduce(args.units)
        if folder is not None:
            texts = {".json": as_json(inputs | made.record), ".csv": as_csv(made.table)}
            for suffix, text in texts.items():
                replace_file(folder / (made.name + suffix), [text.encode()])
            for name, plot in made.panels().items():
                esc.plots.save(plot(), folder / f"{name}.{args.format or FORMATS[0][1:]}")
            _output.note(f"tables and figures in {folder}")
            _log.record("saved", file=str(folder))
    if not args.json:
        if source in (args.source, SOURCES[0]):
            print_inputs(inputs_of_command(args), args.units or SYSTEMS[1])
        made.show()
    return dict(made.record)
