"""Command `explore`: a page that shows a motion, and computes it anew while you drag a number."""

import argparse
from pathlib import Path
from typing import Any

from escapement.base.files import PAGES, file_format, write_file
from escapement.base.quantity import declared
from escapement.cli import _arguments, _log, _output, run
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.engines.solver import Solver
from escapement.model.escapement import Run
from escapement.model.inputs import Input, inputs_of

_LENGTH = {"engagements": declared(Run)["engagements"]}


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    run.add_study(parser.add_argument_group("one case of a study, instead of mechanism and model"))
    _arguments.add_mechanism(parser, file="CONFIG.toml")
    _arguments.add_group(parser, "model", run.model())
    _arguments.add_group(parser, "length of the motion", _LENGTH)
    parser.set_defaults(**dict.fromkeys(declared(Solver)))
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "page.html", "write the page")
    # it is known in order to say what to do instead
    output.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)


def execute(args: Arguments) -> int:
    """Write a page with the given design."""
    if args.serve:
        raise UsageError(
            "--serve must be left out, because the page computes by itself; write it with "
            "-o page.html, or play the motion of what it cannot compute with "
            "'escapement run ... --plot motion.html'"
        )
    if isinstance(args.kind, Path):
        if args.study is not None:
            raise UsageError(
                f"--from must not come with the study {args.kind}, got both; leave one of them out"
            )
        args.study, args.kind = args.kind, None
    if args.output is None:
        raise UsageError("--output must name the page to write, got none; add -o page.html")
    file_format(args.output, PAGES)
    inputs = [args.study] if args.study is not None else []
    _output.check_output(args.output, *inputs, force=args.force)
    escapement, settings = run.read_case(args)
    from escapement.explorer import page

    length = {} if args.engagements is None else {"engagements": args.engagements}
    text = page(escapement, initial_speed=settings["initial_speed"], **length)
    write_file(args.output, [text.encode()], args.force)
    _log.record("saved", file=str(args.output))
    record = {"output": str(args.output), "bytes": len(text.encode())}
    _output.tell(args, record, lambda: _output.note(f"open {args.output} in a browser"), "",
        _known(escapement, settings, args))  # fmt: skip
    return 0


def _known(escapement: Any, settings: dict[str, Any], args: Arguments) -> list[Input]:
    """The numbers that went in, with their defaults."""
    length = args.engagements or _LENGTH["engagements"].default
    start = [
        ("initial_speed", settings["initial_speed"], "speed"),
        ("engagements", length, "ratio"),
    ]
    return [*inputs_of(escapement), *start]
