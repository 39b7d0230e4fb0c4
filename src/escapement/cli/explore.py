"""Command `explore`: a page that shows a motion, and computes it anew while you drag a number."""

import sys
import threading
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
    text = (
        "serve the page to a browser on this machine until Ctrl-C; the package then computes what "
        "the page cannot: every mechanism, clearance, tolerances, and all cases of a study"
    )
    output.add_argument("--serve", action="store_true", help=text)


def execute(args: Arguments) -> int:
    """Write a page with the given design, or serve it."""
    if isinstance(args.kind, Path):
        if args.study is not None:
            raise UsageError(
                f"--from must not come with the study {args.kind}, got both; leave one of them out"
            )
        args.study, args.kind = args.kind, None
    if args.serve:
        return _serve(args)
    if args.output is None:
        remedy = "add -o page.html, or --serve"
        raise UsageError(f"--output must name the page to write, got none; {remedy}")
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


def _serve(args: Arguments) -> int:
    """Serve the page until Ctrl-C."""
    for name in ("output", "force"):
        if getattr(args, name):
            raise UsageError(
                f"--{name} must not come with --serve, which writes no file; leave it out"
            )
    from escapement.explorer.serve import serving
    from escapement.explorer.served_page import server_of

    case = _study(args)
    if case is None:
        escapement, settings = run.read_case(args)
    else:
        plan = case["plan"]
        escapement, settings = plan.escapement(0), plan.values(0)
    length = {} if args.engagements is None else {"engagements": args.engagements}
    server = server_of(escapement, settings["initial_speed"], **length, **case or {})
    with serving(server):
        record = {"url": server.url}
        _log.record("serving", **record)
        _output.tell(
            args, record, lambda: _output.note(f"open {server.url} in a browser; Ctrl-C ends it"),
            "", _known(escapement, settings, args),
        )  # fmt: skip
        sys.stdout.flush()
        threading.Event().wait()
    return 0


def _known(escapement: Any, settings: dict[str, Any], args: Arguments) -> list[Input]:
    """The numbers that went in, with their defaults."""
    length = args.engagements or _LENGTH["engagements"].default
    start = [
        ("initial_speed", settings["initial_speed"], "speed"),
        ("engagements", length, "ratio"),
    ]
    return [*inputs_of(escapement), *start]


def _study(args: Arguments) -> dict[str, Any] | None:
    """Plan and results of a study file if it is to be shown with all its cases, else None."""
    path = args.study
    if path is None or args.select is not None or path.suffix.lower() == ".toml":
        return None
    import escapement as esc
    from escapement.study.parse import parse_plan
    from escapement.study.reader import read_configuration

    plan = parse_plan(read_configuration(path))
    return None if plan.cases == 1 else {"plan": plan, "study": esc.read_study(path)}
