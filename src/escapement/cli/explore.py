"""A page that shows an escapement move, and computes its motion anew while one drags."""

from pathlib import Path

from escapement.cli import _arguments, _log, _output, run
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.files import file_format, write_file
from escapement.model import Run
from escapement.quantity import declared
from escapement.solver import Solver

PAGES = (".html", ".htm")
"""Suffixes of a page."""
_LENGTH = {"engagements": declared(Run)["engagements"]}


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    run.add_study(parser.add_argument_group("one case of a study, instead of mechanism and model"))
    _arguments.add_mechanism(parser, file="CONFIG.toml")
    _arguments.add_group(parser, "model", run.model())
    _arguments.add_group(parser, "length of the motion", _LENGTH)
    parser.set_defaults(**dict.fromkeys(declared(Solver)))
    _arguments.add_output(parser.add_argument_group("output"), "page.html", "write the page")


def execute(args: Arguments) -> int:
    """Write the page with the design that was asked for."""
    if isinstance(args.kind, Path):
        if args.study is not None:
            raise UsageError(f"--from must not come with {args.kind}; leave one of them out")
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
    _output.tell(args, record, lambda: _output.note(f"open {args.output} in a browser"))
    return 0
