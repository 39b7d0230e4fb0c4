"""The parser of all commands, options that several share, and the objects they describe.

Options of numbers follow from their declarations, see `escapement.quantity`. Values are
checked as typed, in the user's units, so that a message shows what the user wrote; the
conversion to SI follows.
"""

import argparse
import contextlib
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from escapement import __version__, validate
from escapement.errors import EscapementError, InvalidValue
from escapement.files import FORMATS
from escapement.mechanisms import DEFAULT_KIND, KINDS, kind_of
from escapement.model import Escapement, Inertia
from escapement.quantity import Setting, Truth, declared
from escapement.units import SYSTEMS

if TYPE_CHECKING:
    from escapement.mechanisms.kind import Kind

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
        raise UsageError(f"{message}; see '{self.prog} --help'")

    def understand(self, argv: Sequence[str]) -> argparse.Namespace:
        """Parsed arguments; SystemExit where help was asked for and given."""
        known = self._option_string_actions
        for name in (word.partition("=")[0] for word in argv):
            # argparse would first tell of what is missing, which a misspelt option is not
            passes = name in known or name[:2] in known or _NEGATIVE.match(name)
            if _OPTION.match(name) and not passes:
                longer = [word for word in known if word.startswith(name)] or known
                remedy = validate.nearest(name, longer, f"see '{self.prog} --help'")
                raise UsageError(f"unknown option {name!r}; {remedy}")
        return self.parse_args(argv)


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
    rule = one_of("COMMAND", tuple(commands))
    parser.add_argument("command", metavar="COMMAND", type=rule, help=argparse.SUPPRESS)
    name: str = parser.understand(argv[:1]).command
    return name


def option(name: str) -> str:
    """Spelling of an argument on the command line."""
    return "--" + name.replace("_", "-")


def checked(check: Callable[[Any], Any], convert: type = str) -> Callable[[str], Any]:
    """An argparse type: `check` of what was typed, converted where that is possible."""

    def read(text: str) -> Any:
        value: Any = text
        with contextlib.suppress(ValueError):
            value = convert(text)
        try:
            return check(value)
        except InvalidValue as error:
            raise UsageError(str(error)) from None

    return read


def number(name: str, rule: Callable[..., float], remedy: str) -> Callable[[str], float]:
    """Type of a real option, `rule` being one of `escapement.validate`."""
    return checked(lambda value: rule(name, value, remedy), float)


def whole(name: str, minimum: int, remedy: str) -> Callable[[str], int]:
    """Type of a whole-numbered option."""
    return checked(lambda value: validate.integer(name, value, minimum, remedy), int)


def one_of(name: str, allowed: tuple[str, ...]) -> Callable[[str], str]:
    """Type of an option with a few values."""
    return checked(lambda text: validate.choice(name, text, allowed))


def add_setting(group: argparse._ActionsContainer, entry: Setting, **keywords: Any) -> None:
    """Add the option of something declared; what is not typed is None."""
    keywords.setdefault("help", entry.help)
    if isinstance(entry, Truth):
        keywords["action"] = "store_true"
    else:
        spelt = option(entry.name)
        keywords["type"] = checked(lambda text: entry.parse(spelt, text))
        keywords["metavar"] = entry.metavar
    group.add_argument(option(entry.name), default=None, **keywords)


def add_group(parser: Parser, title: str, settings: Mapping[str, Setting]) -> None:
    """Add the options of what a class declares."""
    group = parser.add_argument_group(title)
    for entry in settings.values():
        add_setting(group, entry)


def typed(args: argparse.Namespace, settings: Mapping[str, Setting]) -> dict[str, Any]:
    """What was typed of some settings, in SI, by the key of each."""
    return {
        entry.key: entry.to_si(getattr(args, name), args.units)
        for name, entry in settings.items()
        if getattr(args, name) is not None
    }


def add_mechanism(parser: Parser) -> None:
    """Add the mechanism: its kind, and the options of every kind."""
    listing = "; ".join(f"{name}: {kind_of(name).summary}" for name in KINDS)
    parser.add_argument(
        "kind",
        nargs="?",
        type=one_of("KIND", tuple(KINDS)),
        metavar="KIND",
        help=f"mechanism, {DEFAULT_KIND} where none is given. {listing}",
    )
    group = parser.add_argument_group("mechanism")
    for name, kinds in _owners().items():
        entry = kind_of(kinds[0]).options()[name]  # the first of those that share it explains it
        add_setting(group, entry, help=f"{', '.join(kinds)}: {entry.help}")


def read_mechanism(args: argparse.Namespace) -> "Kind":
    """The mechanism the arguments describe.

    Raises
    ------
    UsageError
        When an option was given that the kind does not have, or one is missing.
    InvalidValue
        When no such mechanism exists.
    """
    kind = DEFAULT_KIND if args.kind is None else args.kind
    owners = _owners()
    for name in mechanism_options(args):
        if kind not in owners[name]:
            value = getattr(args, name)
            shown = str(value) if isinstance(value, Path | Fraction) else value
            raise UsageError(
                f"{option(name)} must not come with a {kind} mechanism, got "
                f"{shown!r}; it belongs to {' and '.join(owners[name])}"
            )
    settings = kind_of(kind).options()
    require(args, settings, f" with {kind}")
    given = {entry.key: entry.typical for entry in settings.values() if entry.typical is not None}
    return kind_of(kind).from_options(**given | typed(args, settings))


def mechanism_options(args: argparse.Namespace) -> list[str]:
    """The options of mechanisms that were typed."""
    return [name for name in _owners() if getattr(args, name, None) is not None]


def _owners() -> dict[str, list[str]]:
    """The options of all kinds, each with the kinds that have it."""
    owners: dict[str, list[str]] = {}
    for kind in KINDS:
        for name in kind_of(kind).options():
            owners.setdefault(name, []).append(kind)
    return owners


def add_output(group: argparse._ActionsContainer, file: str, text: str) -> None:
    """Add a file to write, never over another unless it may: `_output.check_wanted` looks."""
    group.add_argument("-o", "--output", type=Path, metavar=file, help=text)
    group.add_argument("--force", action="store_true", help=f"replace {file} where it exists")


def add_folder(parser: Parser, what: str, otherwise: str = "") -> None:
    """Add a folder to fill; `_output.folder` makes it."""
    text = f"folder for {what}; created, files in it replaced{otherwise}"
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", help=text)


def add_plot(group: argparse._ActionsContainer, text: str) -> None:
    """Add a figure to draw; `_output.check_wanted` looks at its place."""
    names = f"{', '.join(FORMATS[:-1])} or {FORMATS[-1]}"
    group.add_argument(
        "--plot", type=Path, metavar="FILE", help=f"{text}; {names}, replaced where it exists"
    )


def add_common(
    parser: Parser,
    *,
    units: str | None = SYSTEMS[0],
    text: str = "units of what goes in and what comes out (default: SI)",
) -> None:
    """Add what every command takes."""
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    parser.add_argument(
        "--units",
        type=one_of("--units", SYSTEMS),
        default=units,
        metavar="|".join(SYSTEMS),
        help=text,
    )


def require(args: argparse.Namespace, settings: Mapping[str, Setting], where: str = "") -> None:
    """Raise UsageError where a setting that is required was not typed."""
    lacking = [
        option(name)
        for name, entry in settings.items()
        if entry.required and entry.typical is None and getattr(args, name) is None
    ]
    if lacking:
        raise UsageError(f"the following arguments are required{where}: {', '.join(lacking)}")


def read_escapement(args: argparse.Namespace) -> Escapement:
    """The escapement the arguments describe."""
    require(args, declared(Escapement) | declared(Inertia))
    return Escapement(
        mechanism=read_mechanism(args),
        inertia=Inertia(**typed(args, declared(Inertia))),
        **typed(args, declared(Escapement)),
    )
