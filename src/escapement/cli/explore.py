"""Command `explore`: a page that shows a motion, and computes it anew while you drag a number.

Without torque and inertias it begins with a design of its own.
"""

from escapement.base.files import PAGES
from escapement.base.quantity import declared
from escapement.base.units import factor
from escapement.cli import _arguments, _output, run
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.engines.solver import Solver
from escapement.mechanisms import DEFAULT_KIND
from escapement.model.escapement import Run
from escapement.model.inputs import inputs_of

_ASKED = ("torque", "no_load_speed", "driver_inertia", "follower_inertia")
_LENGTH = {"engagements": declared(Run)["engagements"]}


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    run.add_study(parser.add_argument_group("one case of a study, instead of mechanism and model"))
    _arguments.add_mechanism(parser)
    _arguments.add_group(parser, "model", run.model())
    _arguments.add_group(parser, "length of the motion", _LENGTH)
    parser.set_defaults(**dict.fromkeys(declared(Solver)))
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "page.html", "write the page", PAGES)


def execute(args: Arguments) -> int:
    """Write a page with the given design."""
    if args.output is None:
        raise UsageError("--output must name the page to write, got none; add -o page.html")
    from escapement.explorer import page, stops

    asked = (getattr(args, name) for name in ("kind", "study", *_ASKED))
    if all(value in (None, DEFAULT_KIND) for value in asked):
        for name, value in stops()[0]["designs"][0]["design"].items():
            if getattr(args, name) is None:
                scale = factor(args.settings[name].unit, args.units)
                setattr(args, name, value if scale == 1.0 else value / scale)
    escapement, settings = run.read_case(args)
    speed, length = settings["initial_speed"], args.engagements or _LENGTH["engagements"].default
    text = page(escapement, initial_speed=speed, engagements=length)
    _output.save(args, lambda: text)
    record = {"output": str(args.output), "bytes": len(text.encode())}
    start = [("initial_speed", speed, "speed"), ("engagements", length, "ratio")]
    known = [*inputs_of(escapement), *start]
    _output.tell(args, record, known, lambda: _output.note(f"open {args.output} in a browser"))
    return 0
