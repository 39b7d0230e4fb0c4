"""Understanding a command line: options by their full names, numbers, one-line errors."""

import argparse
import difflib
import math
import re
import textwrap
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, NoReturn

from escapement import __version__, validate
from escapement.errors import EscapementError, InvalidValue

_NEGATIVE = re.compile(r"-(\.?\d|inf(inity)?$|nan$)", re.IGNORECASE)
_SUBJECT = re.compile(r"[a-z_]+(?:(?: and | / )[a-z_]+)*(?= must )")
_COMPOUND = re.compile(r"(?<![^\s(])[a-z]+(?:_[a-z]+)+(?![^\s,;:)])")
_SWITCHED_ON = re.compile(r"\b([a-z_]+)=True\b")


class UsageError(EscapementError):
    """The command line cannot be understood."""


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Wraps help between words only: a name with a hyphen stays whole."""

    def _split_lines(self, text: str, width: int) -> list[str]:
        return textwrap.wrap(" ".join(text.split()), width, break_on_hyphens=False)


class Parser(argparse.ArgumentParser):
    """argparse without its surprises: no abbreviations, errors raised as one line."""

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", _Formatter)
        super().__init__(allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        """Raise what argparse found wrong, with where to read on."""
        text = re.sub(r"^argument ([^:]*):", r"\1:", message)
        raise UsageError(f"{text}; see '{self.prog} --help'")

    def understand(self, argv: Sequence[str]) -> argparse.Namespace | None:
        """Parsed arguments; None where help was asked for and given."""
        tokens = _join_negative_numbers(argv)
        self._refuse_unknown_options(tokens)
        try:
            args, extra = self.parse_known_args(tokens)
        except SystemExit:
            return None
        if extra:
            self.error(f"unexpected argument {extra[0]!r}")
        return args

    def spell(self, error: EscapementError) -> str:
        """A library's message in the words of the command line: its options with dashes."""

        def dashed(word: re.Match[str]) -> str:
            name = option(word[0])
            return name if name in self._option_string_actions else word[0]

        message = _SWITCHED_ON.sub(lambda found: option(found[1]), str(error))
        if not isinstance(error, InvalidValue):
            return message  # it names files, which may be called anything
        subject = _SUBJECT.match(message)
        end = subject.end() if subject else 0
        return re.sub("[a-z_]+", dashed, message[:end]) + _COMPOUND.sub(dashed, message[end:])

    def _refuse_unknown_options(self, tokens: Iterable[str]) -> None:
        """Before anything else: a misspelt option is not a missing one."""
        known = self._option_string_actions
        for token in tokens:
            name = token.split("=")[0]
            if token == "--":
                return
            if not token.startswith("-") or name in known or _NEGATIVE.match(token):
                continue
            if token.startswith("--") or token[:2] not in known:
                raise UsageError(f"unknown option {name!r}; {self._remedy(name, known)}")

    def _remedy(self, name: str, known: Collection[str]) -> str:
        if name == "-":
            return "a file of that name is './-'"
        bare = {spelt.lstrip("-"): spelt for spelt in known}  # dashes are alike in all
        typed = name.lstrip("-")
        close = [word for word in bare if len(typed) > 1 and word.startswith(typed)]
        close = close or difflib.get_close_matches(typed, bare, n=1, cutoff=0.6)
        return f"did you mean {bare[close[0]]!r}?" if close else f"see '{self.prog} --help'"


def understand_command(argv: Sequence[str], commands: Mapping[str, str]) -> str | None:
    """Name of the command; None where help or the version was asked for and given."""
    listing = "\n".join(f"  {name:<14}{summary}" for name, summary in commands.items())
    parser = Parser(
        prog="escapement",
        usage="escapement COMMAND [options]",
        description="Time-domain simulation of Geneva escapements.\n\ncommands:\n" + listing,
        epilog="'escapement COMMAND --help' explains a command.",
    )
    parser.add_argument("--version", action="version", version=f"escapement {__version__}")
    if not argv:
        parser.error("no command given; one of " + ", ".join(commands))
    if argv[0].startswith("-"):
        parser.understand(argv[:1])
        return None
    try:
        return validate.choice("COMMAND", argv[0], tuple(commands))
    except InvalidValue as error:
        raise UsageError(str(error)) from None


def _join_negative_numbers(argv: Sequence[str]) -> list[str]:
    """`--torque -3e-6` as `--torque=-3e-6`: argparse would take the value for a flag."""
    tokens: list[str] = []
    for token in argv:
        previous = tokens[-1] if tokens else ""
        if _NEGATIVE.match(token) and re.fullmatch(r"--[^=]+", previous):
            tokens[-1] = f"{previous}={token}"
        else:
            tokens.append(token)
    return tokens


def option(name: str) -> str:
    """Spelling of an argument on the command line."""
    return "--" + name.replace("_", "-")


def checked(check: Callable[[str], Any]) -> Callable[[str], Any]:
    """`check` as an argparse type whose own message reaches the user."""

    def convert(text: str) -> Any:
        try:
            return check(text)
        except InvalidValue as error:
            raise UsageError(str(error)) from None

    return convert


def number(name: str, rule: Callable[..., float], remedy: str) -> Callable[[str], float]:
    """Type of a real option, `rule` being one of `_validate`'s."""

    def check(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise validate.fail(name, "a finite number", text, remedy)
        return rule(name, value, remedy)

    return checked(check)


def whole(name: str, minimum: int, remedy: str) -> Callable[[str], int]:
    """Type of a whole-numbered option."""

    def check(text: str) -> int:
        try:
            value: int | str = int(text)
        except ValueError:
            value = text
        return validate.integer(name, value, minimum, remedy)

    return checked(check)


def one_of(name: str, allowed: tuple[str, ...]) -> Callable[[str], str]:
    """Type of an option with a few values."""
    return checked(lambda text: validate.choice(name, text, allowed))
