"""Kinds of mechanism: which there are, and which of them the arguments describe.

A kind is one entry of `KINDS` and a module `_kind_<name>` of this package with

    OPTIONS     its arguments by name, each with what `add_argument` takes; no defaults,
                so that what was not typed is None
    QUANTITIES  which of its report's numbers are physical, by key
    read(args) -> Mechanism
    describe(mechanism) -> dict, its report by JSON key, in SI
    draw(mechanism, theta) -> Axes, to scale at a driver angle

Kinds may share an option: the first of them explains it.
"""

import argparse
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.cli._parser import Parser, UsageError, one_of, option

if TYPE_CHECKING:
    from escapement.model import Mechanism

KINDS = {
    "geneva": "wheel with radial slots, pins on a crank",
    "gear-driven": "such a wheel, pins on a planet gear (Dijksman)",
    "elliptical-planetary": "planetary drive with a pair of elliptical gears, always in mesh",
    "tabulated": "any drive that is always in mesh, from a table of its angles",
}
"""Kinds by the name that the command line gives them; the first is the default."""


def module(kind: str) -> Any:
    """The module of a kind: its options, its reader, its report."""
    return import_module(f"escapement.cli._kind_{kind.replace('-', '_')}")


def add_mechanism(parser: Parser) -> None:
    """Add the mechanism: its kind, and the options of every kind."""
    default = next(iter(KINDS))
    listing = "; ".join(f"{name}: {summary}" for name, summary in KINDS.items())
    parser.add_argument(
        "kind",
        nargs="?",
        type=one_of("KIND", tuple(KINDS)),
        metavar="KIND",
        help=f"mechanism, {default} where none is given. {listing}",
    )
    group = parser.add_argument_group("mechanism")
    for name, kinds in _owners().items():
        keywords = dict(module(kinds[0]).OPTIONS[name])
        keywords["help"] = f"{', '.join(kinds)}: {keywords['help']}"
        group.add_argument(option(name), default=None, **keywords)


def read_mechanism(args: argparse.Namespace) -> "Mechanism":
    """The mechanism the arguments describe.

    Raises
    ------
    UsageError
        When an option was given that the kind does not have.
    InvalidValue
        When no such mechanism exists.
    """
    kind = chosen(args)
    for name in given_options(args):
        owners = _owners()[name]
        if kind not in owners:
            value = getattr(args, name)
            shown = str(value) if isinstance(value, Path | Fraction) else value
            raise UsageError(
                f"{option(name)} must not come with a {kind} mechanism, got "
                f"{shown!r}; it belongs to {' and '.join(owners)}"
            )
    return module(kind).read(args)


def chosen(args: argparse.Namespace) -> str:
    """The kind that was asked for."""
    return next(iter(KINDS)) if args.kind is None else args.kind


def given_options(args: argparse.Namespace) -> list[str]:
    """The options of mechanisms that were typed."""
    return [name for name in _owners() if getattr(args, name, None) is not None]


def require(args: argparse.Namespace, *names: str) -> None:
    """Raise UsageError unless all of these options were typed."""
    missing = [option(name) for name in names if getattr(args, name) is None]
    if missing:
        raise UsageError(
            f"the following arguments are required with {chosen(args)}: {', '.join(missing)}"
        )


def _owners() -> dict[str, list[str]]:
    """The options of all kinds, each with the kinds that have it."""
    owners: dict[str, list[str]] = {}
    for kind in KINDS:
        for name in module(kind).OPTIONS:
            owners.setdefault(name, []).append(kind)
    return owners
