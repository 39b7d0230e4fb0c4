"""`escapement reproduce`: a source's printed numbers beside computed ones."""

import argparse
from importlib import import_module
from pathlib import Path

from escapement.cli import _arguments, _files
from escapement.cli._parser import Parser, one_of

SUMMARY = "A source's printed numbers beside computed ones, why they differ, and the figures."

SOURCES = ("meyer", "filemon", "dijksman", "prikhodko")
"""Each has a module `_reproduce_<source>` with `reproduce(folder, as_json, units)`."""


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "source",
        type=one_of("SOURCE", SOURCES),
        metavar="SOURCE",
        help="meyer: the 49 printed runs of Appendix E (1973); filemon: Table I (1960); "
        "dijksman: gear-driven wheels (1974); "
        "prikhodko: the planetary drive with elliptical gears (2020)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help="folder for tables (CSV, JSON) and figures; created, files in it replaced",
    )
    _arguments.add_common(parser)


def execute(args: argparse.Namespace) -> int:
    """Recompute, print, and fill the folder."""
    if args.output is not None:
        _files.make_folder(args.output)
    source = import_module(f"escapement.cli._reproduce_{args.source}")
    source.reproduce(args.output, args.json, args.units)
    return 0
