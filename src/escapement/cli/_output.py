"""What commands have in common on the way out: JSON, units, notes, and the places of files.

Places are looked at before anything is computed for them.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from escapement.cli._arguments import UsageError
from escapement.errors import CannotCreate
from escapement.files import cannot_create, check_replaceable, check_target, picture_format
from escapement.text import as_json, plain, print_columns, print_values, words
from escapement.units import factor, unit_name

_INPUTS = ("data", "study", "table")
_NO_LIMIT = "no finite value makes the pin reverse"
_REASONS = {
    "stations": "R2/R1 is no fraction with a denominator of at most 1000, so the output never "
    "stops in the same direction again",
    "critical_friction": "a mesh has no Painleve limit",
    "inertia_ratio": "there is no F without a load",
    "reversal_limits": "the follower's deceleration ends at zero, so no inertia ratio lets it "
    "drive up to the end",
    "torque_max_over_mean": "the mean torque is not above zero",
    "greatest_speed": _NO_LIMIT,
    "greatest_follower_inertia": _NO_LIMIT,
    "least_load_torque": _NO_LIMIT,
}
"""Why a number is missing, of those for which there is but one reason."""


def report(
    args: argparse.Namespace,
    record: Mapping[str, Any],
    quantities: Mapping[str, str],
    labels: Mapping[str, str] | None = None,
    warning: str = "",
) -> None:
    """Print what a command found, in the user's units, as JSON or as a table.

    A `message` is added, and shown on stderr too, where there is a warning or a number is missing.

    Parameters
    ----------
    args : Namespace
        With `_arguments.add_common`.
    record : Mapping
        Numbers in SI, texts and lists by JSON key.
    quantities : Mapping
        Kind of unit of those numbers that have one, see `escapement.units`.
    labels : Mapping, optional
        What the table calls a key, where that is not the key in words.
    warning : str
        What the user should know of the numbers.
    """
    shown = {
        key: in_units(value, quantities.get(key, "ratio"), args.units)
        for key, value in record.items()
    }
    message = "; ".join([*filter(None, [warning]), *not_given(record)])
    if args.json:
        print_json(shown | ({"message": message} if message else {}))
    else:
        _print_table(shown, quantities, args.units, labels or {})
    if message:
        note(message)


def _print_table(
    record: Mapping[str, Any], quantities: Mapping[str, str], system: str, labels: Mapping[str, str]
) -> None:
    """Name, value and unit of each; a list of objects follows as a table of its own."""
    units = {key: "deg" for key in record if key.endswith("_deg")}
    units |= {key: unit_name(quantity, system) for key, quantity in quantities.items()}
    tables = {
        key: value
        for key, value in record.items()
        if isinstance(value, list) and value and isinstance(value[0], dict)
    }
    print_values(
        # an empty list is shown as a word
        (labels.get(key, words(key)), value, "" if value == [] else units.get(key, ""))
        for key, value in record.items()
        if key not in tables
    )
    for key, rows in tables.items():
        # a single row repeats what stands above
        if len(rows) > 1:
            print(f"\n{words(key)}")
            header = [words(name) + " (deg)" * name.endswith("_deg") for name in rows[0]]
            print_columns([header], [row.values() for row in rows])


def print_json(record: Mapping[str, Any]) -> None:
    """One object on stdout."""
    print(as_json(record), end="")


def not_given(record: Mapping[str, Any]) -> list[str]:
    """Why numbers are missing from what a command found."""
    # what is not a number or not finite becomes None, as in JSON
    found = {key: plain(value) for key, value in record.items() if key in _REASONS}
    return [
        f"{key} is not given: {_REASONS[key]}"
        for key, value in found.items()
        if value is None or (isinstance(value, list) and None in value)
    ]


def in_units(value: Any, quantity: str, system: str) -> Any:
    """An SI value in the user's units; what has no unit, or is None, stays as it is."""
    scale = factor(quantity, system)
    return value if scale == 1.0 or value is None else value / scale


def note(message: str) -> None:
    """A line on stderr."""
    print(f"escapement: {message}", file=sys.stderr)


def check_wanted(args: argparse.Namespace, file: str = "FILE") -> None:
    """Look at the places that --output with --force, and --plot name, where they do.

    None of them may be an input of the command.

    Parameters
    ----------
    args : Namespace
        With `_arguments.add_plot`, and `_arguments.add_output` or without it.
    file : str
        What the command's help calls its output.

    Raises
    ------
    UsageError
        When there is nothing that --force could replace.
    InvalidValue
        When the plot's suffix is that of no picture.
    CannotCreate
        When a file cannot be put there, or is an input or the other output.
    """
    output, plot = getattr(args, "output", None), args.plot
    inputs = [path for name in _INPUTS if (path := getattr(args, name, None)) is not None]
    if output is not None:
        check_output(output, *inputs, force=args.force)
        inputs.append(output)
    elif getattr(args, "force", False):
        raise UsageError(f"--force must come with --output {file}, got none; leave it out")
    if plot is not None:
        check_picture(plot, *inputs)


def check_output(path: Path, *others: Path, force: bool = False) -> None:
    """Raise CannotCreate unless a file can be put at `path`.

    Parameters
    ----------
    path : Path
        Where the file is to be.
    *others : Path
        Inputs and other outputs, which it must not be.
    force : bool
        Whether an existing file may be replaced.
    """
    folder = check_target(path, force).parent
    for other in others:
        # links are followed, or a result would replace what it is computed from
        if os.path.realpath(path) == os.path.realpath(other):
            raise CannotCreate(f"output {path} must not be {other} too; give it a name of its own")
    _try_writing(path, folder)


def check_picture(path: Path, *others: Path) -> None:
    """As `check_output`. Pictures are made from data: one that is not read-only is replaced.

    Raises InvalidValue for a suffix that no picture has.
    """
    picture_format(path)
    check_output(path, *others, force=True)
    check_replaceable(path)


def make_folder(path: Path) -> None:
    """Create the folder `path` where it is not there; its parent must be."""
    try:
        path.mkdir(exist_ok=True)
    except OSError as error:
        raise cannot_create(path, error) from None
    _try_writing(path, path)


@contextmanager
def folder(path: Path | None) -> Iterator[None]:
    """A folder to fill, where one was asked for; a new one that stays empty is removed."""
    new = path is not None and not path.exists()
    try:
        if path is not None:
            make_folder(path)
        yield
    finally:
        if path is not None and new:
            with suppress(OSError):  # the folder is not empty
                path.rmdir()


def _try_writing(path: Path, folder: Path) -> None:
    """A file without a name in `folder`: leaves nothing behind, whatever happens."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise cannot_create(path, error) from None
