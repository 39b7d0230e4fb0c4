"""Options that several commands share, and the objects they describe.

Options of numbers follow from their declarations, see `escapement.quantity`. Values are
checked as typed, in the user's units, so that a message shows what the user wrote; the
conversion to SI follows.
"""

import argparse
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.cli._parser import Parser, UsageError, checked, one_of, option
from escapement.files import FORMATS
from escapement.mechanisms import DEFAULT_KIND, KINDS, kind_of
from escapement.model import Escapement, Inertia
from escapement.quantity import Setting, Truth, declared
from escapement.units import SYSTEMS

if TYPE_CHECKING:
    from escapement.mechanisms.kind import Kind


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
    given = {entry.key: entry.typical for entry in settings.values() if entry.typical is not None}
    given |= typed(args, settings)
    missing = [
        option(name)
        for name, entry in settings.items()
        if entry.required and entry.key not in given
    ]
    if missing:
        raise UsageError(f"the following arguments are required with {kind}: {', '.join(missing)}")
    return kind_of(kind).from_options(**given)


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


def read_inertia(args: argparse.Namespace) -> Inertia | None:
    """Both inertias, or None where neither is given."""
    settings = declared(Inertia)
    given = typed(args, settings)
    if len(given) == len(settings):
        return Inertia(**given)
    if not given:
        return None
    (there,) = (option(name) for name, entry in settings.items() if entry.key in given)
    (missing,) = (option(name) for name, entry in settings.items() if entry.key not in given)
    raise UsageError(f"{missing} must be given beside {there}, got that alone; give both or none")


def read_escapement(args: argparse.Namespace) -> Escapement:
    """The escapement the arguments describe."""
    return Escapement(
        mechanism=read_mechanism(args),
        inertia=Inertia(**typed(args, declared(Inertia))),
        **typed(args, declared(Escapement)),
    )
