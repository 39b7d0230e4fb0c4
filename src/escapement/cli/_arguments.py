"""The parser of all commands, options that several share, and the objects they describe.

Options of numbers follow from their declarations, see `escapement.base.quantity`. Values are
checked as typed, in the user's units or with a unit of their own, so that a message shows what
the user wrote; the conversion to SI follows.
"""

import argparse
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, NoReturn

from escapement import __version__
from escapement.base import spoken, validate
from escapement.base.errors import EscapementError, InvalidValue
from escapement.base.files import FILMS, FORMATS, PAGES
from escapement.base.quantity import Choice, Numbers, Quantity, Setting, Truth
from escapement.base.results import Result
from escapement.base.units import SYSTEMS, printed
from escapement.mechanisms import DEFAULT_KIND, KINDS, kind_of
from escapement.mechanisms.kind import Kind
from escapement.model.motor import MOTOR

Arguments = argparse.Namespace
"""What was typed."""
ArgumentGroup = argparse._ActionsContainer
"""A group of options in the help, or a parser."""

SLOTS = "slots"
"""The number of which several may be typed."""
_NEGATIVE = re.compile(r"-(\.?\d|inf|nan)", re.IGNORECASE)
_OPTION = re.compile(r"--?[a-z]")


class UsageError(EscapementError):
    """The command line cannot be understood."""


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Wraps help between words only: a name with a hyphen stays whole."""

    def _split_lines(self, text: str, width: int) -> list[str]:
        return textwrap.wrap(" ".join(text.split()), width, break_on_hyphens=False)


class Parser(argparse.ArgumentParser):
    """argparse without its surprises: no abbreviations, errors raised as one line."""

    def __init__(self, **options: Any) -> None:
        super().__init__(allow_abbrev=False, formatter_class=_Formatter, **options)
        # argparse by itself takes a number with an exponent, -3e-6, for an option
        self._negative_number_matcher = _NEGATIVE

    def error(self, message: str) -> NoReturn:
        """Raise what argparse found wrong, with where to read on."""
        # argparse itself would print a usage of many lines and end the process
        raise UsageError(f"{message}; see '{self.prog} --help'")

    @property
    def settings(self) -> dict[str, Setting]:
        """The declarations of its options, by name."""
        declared = {action.dest: getattr(action, "entry", None) for action in self._actions}
        return {name: entry for name, entry in declared.items() if entry is not None}

    def _spelling(self, name: str) -> str:
        """An option with its value, as in the help: "--output FILE"."""
        (action,) = (action for action in self._actions if action.dest == name)
        return " ".join(filter(None, (action.option_strings[-1], action.metavar)))  # type: ignore[arg-type]

    def _refuse_idle(self, args: Arguments) -> None:
        """Raise UsageError if a setting was typed without one that it needs."""
        kind = getattr(args, "kind", None)
        loose = isinstance(kind, str) and kind_of(kind).pitch is not None
        for name, entry in self.settings.items():
            if loose and entry.needs == "clearance":
                continue
            # compliant walls have impacts without clearance, too
            partners = (entry.needs, "stiffness") if entry.needs == "clearance" else (entry.needs,)
            value = getattr(args, name)
            given = value is not None and value is not False and hasattr(args, entry.needs)
            if given and all(getattr(args, partner) is None for partner in partners):
                needed = " or ".join(map(self._spelling, partners))
                raise UsageError(
                    f"{option(name)} must come with {needed}, got none; it has no effect alone"
                )

    def _hide_other_kinds(self, kind: str | None) -> None:
        """Leave out of the help what a kind of mechanism does not have."""
        of, meshed = owners(), kind_of(kind).meshed if kind else False
        for action in self._actions if kind else ():
            entry = getattr(action, "entry", None)
            if kind in of.get(action.dest, ()):
                action.help = entry.help if entry else action.help
            elif action.dest in of or (entry is not None and not entry.applies_to(meshed)):
                action.help = argparse.SUPPRESS

    def understand(self, argv: Sequence[str]) -> Arguments:
        """Parsed arguments, and as `settings` their declarations.

        SystemExit ends it where help was asked for and given.
        """
        known = self._option_string_actions
        if not {"-h", "--help"}.isdisjoint(argv):
            self._hide_other_kinds(next((word for word in argv if word in KINDS), None))
        for name in (word.partition("=")[0] for word in argv):
            # argparse would first report a missing argument, although an option was misspelt
            passes = name in known or name[:2] in known or _NEGATIVE.match(name)
            if _OPTION.match(name) and not passes:
                bare = f"-{name.lstrip('-')}"
                akin = [word for word in known if bare in word or name.startswith(f"{word}-")]
                # an option without a word in common must differ by a slip of the finger only
                least, see = 0.6 if akin else 0.82, f"see '{self.prog} --help'"
                remedy = validate.nearest(name, akin or known, see, least)
                raise UsageError(f"unknown option {name!r}; {remedy}")
        # plain argparse would take KIND for left out where an option stands before it
        args = self.parse_intermixed_args(argv)
        # whatever is wrong with a number is said in the user's units
        spoken.speak(getattr(args, "units", None) or SYSTEMS[0])
        args.settings = self.settings
        # numbers are converted when --units is known, which may stand anywhere
        for name, value in vars(args).items():
            if isinstance(value, FunctionType):
                setattr(args, name, value(args.units or SYSTEMS[0]))
        _take_motor(args)
        self._refuse_idle(args)
        return args


def _take_motor(args: Arguments) -> None:
    """Give the numbers of a motor the places of torque and no-load speed, if a command has both."""
    motor, names = getattr(args, "motor", None), ("torque", "no_load_speed")
    if motor is None or not all(hasattr(args, name) for name in names):
        return
    for name, number in zip(names, motor, strict=True):
        if (value := getattr(args, name)) is not None:
            raise UsageError(
                f"{option(name)} must not come with --motor, got {value!r}; leave it out"
            )
        setattr(args, name, number)
    args.motor = None


def understand_command(argv: Sequence[str], commands: Mapping[str, str]) -> str:
    """Name of the command; SystemExit where help or the version was asked for and given."""
    listing = "\n".join(f"  {name:<14}{summary}" for name, summary in commands.items())
    parser = Parser(
        prog="escapement",
        usage="escapement COMMAND [options]",
        description="Time-domain simulation of Geneva escapements.\n\ncommands:\n" + listing,
        epilog="'escapement COMMAND --help' explains a command.",
    )
    parser.add_argument("--version", action="version", version=f"escapement {__version__}")
    rule = one_of("COMMAND", [*commands])
    parser.add_argument("command", metavar="COMMAND", type=rule, help=argparse.SUPPRESS)
    return str(parser.understand(argv[:1]).command)


OLD_NAMES = {"drive-torque": "index"}
"""Commands that have another name now; the old one still works."""


def parser_of(name: str) -> tuple[ModuleType, Parser]:
    """The module of a command, and the parser of its arguments and of those that all have."""
    name = OLD_NAMES.get(name, name)
    command = import_module(f"escapement.cli.{name.replace('-', '_')}")
    parser = Parser(prog=f"escapement {name}", description=command.__doc__)
    command.configure(parser)
    add_common(parser, getattr(command, "UNITS", None))
    return command, parser


def add_common(parser: Parser, default_units: str | None = None) -> None:
    """Add the options of every command; `default_units` explains default units that are not SI."""
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    text = "append events to FILE as JSON lines, for job scripts"
    parser.add_argument("--log", type=Path, metavar="FILE", help=text)
    text = default_units or (
        "units of input and output (default: SI); a number may have a unit of its own: '5 mN m'"
    )
    default, rule = None if default_units else SYSTEMS[0], one_of("--units", SYSTEMS)
    shown = "|".join(SYSTEMS)
    parser.add_argument("--units", type=rule, default=default, metavar=shown, help=text)


def option(name: str) -> str:
    """Spelling of an argument on the command line."""
    return "--" + name.replace("_", "-")


@dataclass(frozen=True)
class Reader:
    """An argparse type: what was typed, checked as declared; `label` names it in messages.

    A number becomes a function of the unit system, which `Parser.understand` calls.
    """

    label: str
    entry: Setting

    def __call__(self, text: str) -> Any:
        """The value, or for a number the function that gives it."""
        if isinstance(self.entry, Quantity | Numbers):
            return lambda system: replace(self.entry, system=system).parse(self.label, text)
        try:
            return self.entry.parse(self.label, text)
        except InvalidValue as error:
            # argparse treats a ValueError as its own, and drops its message
            raise UsageError(str(error)) from None


class Several(Quantity):
    """A number of which several may be typed, with commas between them; one alone stays one."""

    def parse(self, label: str, text: str) -> Any:
        """The number, or a tuple of numbers."""
        found = tuple(super(Several, self).parse(label, word) for word in text.split(","))
        return found if len(found) > 1 else found[0]


def several(entry: Setting) -> Several:
    """The declaration of a number, of which several may be typed."""
    return Several(**vars(entry) | {"note": f"{entry.note}; several as 1,2: a table"})


@dataclass(frozen=True, kw_only=True)
class OutputFile(Setting):
    """A file to write, which `_output.check_files` checks before anything is computed.

    formats : suffixes that it may have; none for any.
    drawn : whether it replaces another without --force, since it is only a picture of data.
    """

    formats: tuple[str, ...] = ()
    drawn: bool = False

    def parse(self, label: str, text: str) -> Path:
        """The path."""
        return Path(text)


def one_of(label: str, allowed: Sequence[str]) -> Callable[[str], Any]:
    """Type of an argument with a few values."""
    return Reader(label, Choice(long_name=label, allowed=tuple(allowed)))


def add_setting(group: ArgumentGroup, entry: Setting, *also: str, **keywords: Any) -> None:
    """Add the option of a declaration, with other spellings of it; None where it is not typed."""
    keywords = {"default": None, "help": entry.help} | keywords
    if isinstance(entry, Truth):
        keywords["action"] = "store_true"
    else:
        keywords |= {"type": Reader(option(entry.name), entry), "metavar": entry.metavar}
    action = group.add_argument(*also, option(entry.name), **keywords)
    action.entry = entry  # type: ignore[attr-defined]


def add_choice(
    group: ArgumentGroup, name: str, text: str, allowed: Sequence[str], needs: str = ""
) -> None:
    """Add an option with a few values."""
    choice = Choice(name=name, long_name=text, allowed=tuple(allowed), needs=needs)
    add_setting(group, replace(choice, metavar="|".join(allowed)))


def add_number(group: ArgumentGroup, name: str, text: str, metavar: str, **rule: Any) -> None:
    """Add the option of a number; `rule` has attributes of `Quantity`."""
    add_setting(group, Quantity(name=name, long_name=text, metavar=metavar, **rule))


def add_group(parser: Parser, title: str, settings: Mapping[str, Setting]) -> None:
    """Add the options of what a class declares."""
    group = parser.add_argument_group(title)
    for entry in settings.values():
        add_setting(group, entry)
        if entry.name == "no_load_speed":
            add_setting(group, MOTOR)


def together(settings: Mapping[str, Setting]) -> dict[str, Setting]:
    """Two settings, of which each needs the other."""
    first, second = settings
    partners = {first: second, second: first}
    return {name: replace(entry, needs=partners[name]) for name, entry in settings.items()}


def typed(args: Arguments, settings: Mapping[str, Setting]) -> dict[str, Any]:
    """Typed values of some settings, or their typical ones, in SI, by the key of each."""
    return {settings[name].key: value for name, value in typed_by_name(args, settings).items()}


def typed_by_name(args: Arguments, settings: Mapping[str, Setting]) -> dict[str, Any]:
    """As `typed`, by the names of the options."""
    found = {}
    for name, entry in settings.items():
        # the classes have their own defaults for numbers that were not typed
        if (value := getattr(args, name)) is not None:
            found[name] = replace(entry, system=args.units).to_si(value)
        elif entry.typical is not None:
            found[name] = entry.typical
    return found


def read_escapement(args: Arguments) -> Any:
    """The escapement that the options of mechanism and model describe; errors are as of these."""
    from escapement.model.escapement import escapement_of, model_settings

    require(args, model_settings())
    return escapement_of(read_mechanism(args), typed_by_name(args, model_settings()))


def add_mechanism(parser: Parser, tables: bool = False) -> None:
    """Add the mechanism: its kind, and the options of every kind.

    With `tables` several numbers of slots may be typed, see `_output.tell_several`.
    """
    listing = "; ".join(f"{name}: {kind_of(name).summary}" for name in KINDS)
    text = f"mechanism (default: {DEFAULT_KIND}). {listing}"
    rule = one_of("KIND", [*KINDS])
    parser.add_argument("kind", nargs="?", type=rule, metavar="KIND", help=text)
    group = parser.add_argument_group("mechanism")
    for name, kinds in owners().items():
        entry = kind_of(kinds[0]).options()[name]  # the first of those that share it explains it
        entry = several(entry) if tables and name == SLOTS else entry
        add_setting(group, entry, help=f"{', '.join(kinds)}: {entry.help}")


def read_mechanism(args: Arguments) -> Kind:
    """The mechanism the arguments describe.

    Raises
    ------
    UsageError
        When an option was given that the kind does not have, or one is missing.
    InvalidValue
        When no such mechanism exists.
    """
    kind = args.kind or DEFAULT_KIND
    for name, kinds in owners().items():
        value = getattr(args, name)
        if value is not None and kind not in kinds:
            shown = str(value) if isinstance(value, Path | Fraction) else value
            raise UsageError(
                f"{option(name)} must not come with a {kind} mechanism, got "
                f"{shown!r}; it belongs to {' and '.join(kinds)}"
            )
    settings, sizes = kind_of(kind).options(), kind_of(kind).other_sizes()
    stated = {size.of for name, size in sizes.items() if getattr(args, name) is not None}
    lacking = {name: entry for name, entry in settings.items() if name not in stated}
    require(args, lacking, f" with {kind}")
    return kind_of(kind).from_options(**typed(args, settings))


def owners() -> dict[str, list[str]]:
    """The options of all kinds of mechanism, each with the kinds that have it."""
    found: dict[str, list[str]] = {}
    for kind in KINDS:
        for name in kind_of(kind).options():
            found.setdefault(name, []).append(kind)
    return found


def add_output(
    group: ArgumentGroup, file: str, text: str, formats: tuple[str, ...] = (), also: str = ""
) -> None:
    """Add a file to write, and whether it may replace another; `also` is another spelling."""
    entry = OutputFile(name="output", long_name=text, metavar=file, formats=formats)
    add_setting(group, entry, "-o", *filter(None, (also,)), dest="output")
    add_force(group, file, "output")


def add_force(group: ArgumentGroup, file: str, needs: str = "") -> None:
    """Add whether a file may replace another; `needs` is the option that names it."""
    entry = Truth(name="force", long_name=f"replace {file} if it exists", needs=needs)
    add_setting(group, entry, default=False)


def add_folder(parser: Parser, what: str) -> None:
    """Add a folder to fill; `_output.folder` makes it."""
    text = f"folder for {what}; it is created, and files in it are replaced"
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", help=text)


def add_plot(group: ArgumentGroup, text: str, film: str = "") -> None:
    """Add a figure to draw."""
    text += f"; {', '.join(FORMATS[:-1])} or {FORMATS[-1]}"
    if film:
        text += f"; {film}: {', '.join(FILMS)} or {PAGES[0]}"
    _add_drawn(group, "plot", text, "FILE", FORMATS + FILMS + PAGES if film else FORMATS)


def add_report(group: ArgumentGroup) -> None:
    """Add a report to write."""
    _add_drawn(group, "report", "write a report that needs no other file", "FILE.html", PAGES)


def _add_drawn(
    group: ArgumentGroup, name: str, text: str, file: str, formats: tuple[str, ...]
) -> None:
    text += "; replaced if it exists"
    entry = OutputFile(name=name, long_name=text, metavar=file, formats=formats, drawn=True)
    add_setting(group, entry)


def tell_results(parser: Parser, results: Mapping[str, Result]) -> None:
    """End the help with what the command computes, by the keys of its JSON."""
    lines = ["results, by their keys with --json:"]
    for name, result in results.items():
        unit = printed(result.kind, SYSTEMS[0])
        text = f"{name:<25} {result.long_name}{f' [{unit}]' if unit else ''}"
        lines.append(textwrap.fill(text, 79, initial_indent="  ", subsequent_indent=28 * " "))
    parser.epilog = "\n".join(lines)


def require(args: Arguments, settings: Mapping[str, Setting], where: str = "") -> None:
    """Raise UsageError if a required setting was not typed."""
    lacking = [
        option(name)
        for name, entry in settings.items()
        if entry.required and entry.typical is None and getattr(args, name) is None
    ]
    if lacking:
        raise UsageError(f"the following arguments are required{where}: {', '.join(lacking)}")
