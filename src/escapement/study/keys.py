"""Unknown keys: said where they stand, with the nearest key that is known there."""

import difflib
from collections.abc import Iterable, Mapping
from typing import Any

from escapement import validate
from escapement.errors import InvalidValue


def check_keys(
    table: Mapping[str, Any],
    known: Iterable[str],
    where: str,
    elsewhere: Mapping[str, str] | None = None,
) -> None:
    """Raise InvalidValue for the first key of `table` that is not `known`.

    Parameters
    ----------
    table : Mapping
        What the user wrote.
    known : iterable of str
        The keys this place has.
    where : str
        The place, as the message names it: "in [solver]".
    elsewhere : Mapping, optional
        Keys of other places and how to write them there.
    """
    allowed = tuple(known)
    for key in table:
        if key not in allowed:
            remedy = _remedy(str(key), allowed, elsewhere or {})
            raise InvalidValue(f"unknown key {str(key)!r} {where}; {remedy}")


def _remedy(key: str, allowed: tuple[str, ...], elsewhere: Mapping[str, str]) -> str:
    if key in elsewhere:
        return f"it belongs in {elsewhere[key]}"
    close = difflib.get_close_matches(key, allowed, n=1, cutoff=0.5)
    return f"did you mean {close[0]!r}?" if close else f"known are {', '.join(allowed)}"


def table(configuration: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """The sub-table `name`, empty where it is absent."""
    value = configuration.get(name, {})
    if not isinstance(value, Mapping):
        raise validate.fail(name, "a table", value, f"write [{name}] on a line of its own")
    return value
