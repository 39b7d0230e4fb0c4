"""`escapement reproduce`: a source's printed numbers beside computed ones."""

import argparse
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.cli import _arguments, _output
from escapement.cli._arguments import Parser, one_of
from escapement.files import replace_file
from escapement.text import as_csv, as_json

if TYPE_CHECKING:
    from escapement.sources.report import Reproduction

SUMMARY = "A source's printed numbers beside computed ones, why they differ, and the figures."

SOURCES = ("meyer", "filemon", "dijksman", "prikhodko")
"""Folders of `escapement.sources`; `reproduce(units)` of each gives a `Reproduction`."""
ALL = "all"


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
    what = "tables (CSV, JSON) and figures, for all a folder of each source in it"
    _arguments.add_folder(parser, what)
    _arguments.add_common(parser)


def execute(args: argparse.Namespace) -> int:
    """Recompute, print, and fill the folder."""
    record: dict[str, Any] = {}
    with _output.folder(args.output):
        for source in SOURCES if args.source == ALL else [args.source]:
            if record and not args.json:
                print("\n")
            inner = None if args.output is None or args.source != ALL else args.output / source
            with _output.folder(inner):
                record[source] = _reproduce(source, inner or args.output, args)
    if args.json:
        _output.print_json(record if args.source == ALL else record[args.source])
    return 0


def _reproduce(source: str, folder: Path | None, args: argparse.Namespace) -> dict[str, Any]:
    """Recompute one source, write and print what is wanted; its record."""
    module = import_module(f"escapement.sources.{source}")
    made: Reproduction = module.reproduce(args.units)
    if folder is not None:
        contents = {".json": as_json(made.record), ".csv": as_csv(made.table)}
        for suffix, text in contents.items():
            replace_file(folder / (made.name + suffix), [text.encode()])
        made.draw(folder)
        _output.note(f"tables and figures in {folder}")
    if not args.json:
        made.show()
    return made.record
