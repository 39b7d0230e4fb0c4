"""Output of all commands: JSON, tables, notes, and checks of the files to write.

The paths of files are checked before anything is computed.
"""

import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import escapement as esc
from escapement.base.errors import CannotCreate
from escapement.base.files import (
    FILMS,
    FORMATS,
    REPORTS,
    check_target,
    creating,
    file_format,
    write_file,
)
from escapement.base.spoken import speak
from escapement.base.text import as_json, plain, print_columns, print_values, words
from escapement.base.toml_file import read_toml
from escapement.base.units import SYSTEMS, factor, printed
from escapement.cli import _log, _waiting
from escapement.cli._arguments import Arguments, UsageError
from escapement.cli._inputs import as_record, inputs_of_command, print_inputs
from escapement.model.inputs import Input

Record = Mapping[str, Any]
"""What a command found, by JSON key."""
Save = Callable[[], None]
"""Saves a file whose content is complete: a command makes every file before it saves the first,
so that a number that is refused leaves nothing on disk."""
Kinds = Mapping[str, str]
"""Kind of unit, see `escapement.base.units`, of those that have one, by JSON key."""

_INPUTS = ("data", "study", "table", "log")
_PICTURES, _FEWER, _MANY = 40, 10, 320  # pictures of an engagement in a film, fewer beyond many
_LONGEST_FILM = 50  # engagements
_LABELS = {
    "inertia_ratio": "inertia ratio F",
    "reversal_limits": "reversal limits F12, F23",
    "torque_max_deg": "torque max at",
    "torque_mean": "torque mean to dead centre",
    "greatest_speed": "greatest speed without reversal",
    "greatest_follower_inertia": "greatest follower inertia without reversal",
    "least_load_torque": "least load torque without reversal",
}
"""Names of keys in tables, where a name is not the key in words."""
_NO_LIMIT = "no finite value makes the pin reverse"
_REASONS = {
    "stations": "R2/R1 is not a fraction with a denominator of at most 1000, so the output never "
    "stops in the same direction again",
    "critical_friction": "no friction in slots can jam it",
    "last_reversal_angle": "the pin does not reverse",
    "inertia_ratio": "F is not defined without a load",
    "reversal_limits": "the follower's deceleration ends at zero, so no inertia ratio lets it "
    "drive up to the end",
    "torque_max_over_mean": "the mean torque is not above zero",
    "greatest_speed": _NO_LIMIT,
    "greatest_follower_inertia": _NO_LIMIT,
    "least_load_torque": _NO_LIMIT,
}
"""Why a number is missing, for numbers with only one possible reason."""


def tell(
    args: Arguments,
    record: Record,
    table: Callable[[], None],
    message: str = "",
    known: Iterable[Input] = (),
) -> None:
    """Print what went in and what a command found, and what to know of it on stderr.

    The output is a JSON object, or a table. `known` are the numbers that went in, with their
    defaults; whatever else was typed is listed, too.
    """
    _waiting.end()
    inputs, system = inputs_of_command(args, known), args.units or SYSTEMS[0]
    if args.json:
        print_json({"inputs": as_record(inputs, system)} | {**record})
    else:
        print_inputs(inputs, system)
        table()
    if message:
        note(message)


def speak_as(args: Arguments, path: Path, what: str) -> None:
    """Speak the units that a TOML file names, unless the user chose others."""
    if args.units is None:
        named = read_toml(path, what).get("units")
        args.units = named if named in SYSTEMS else SYSTEMS[0]
        speak(args.units)


def print_json(record: Record) -> None:
    """One object on stdout."""
    print(as_json(record), end="")


def report(
    args: Arguments,
    record: Record,
    kinds: Kinds,
    warning: str = "",
    known: Iterable[Input] = (),
) -> None:
    """Print numbers in SI in the user's units; a list of objects becomes a table of its own.

    If there is a warning about the numbers, or a number is missing, a `message` is added, which
    is also shown on stderr. `known` is as of `tell`.
    """
    shown = _shown(record, kinds, args.units)
    message = "; ".join([*filter(None, [warning]), *not_given(record)])

    def table() -> None:
        several = [key for key, x in shown.items() if isinstance(x, list) and dict in map(type, x)]
        single = {key: value for key, value in shown.items() if key not in several}
        print_values(rows(single, kinds, args.units))
        for key in several:
            # a single row repeats what stands above
            if len(shown[key]) > 1:
                print(f"\n{words(key)}")
                columns = rows(dict.fromkeys(shown[key][0]), kinds, args.units)
                header = [
                    name + f" ({unit})" * (unit not in ("", "1")) for name, _, unit in columns
                ]
                print_columns([header], [line.values() for line in shown[key]])

    tell(args, shown | ({"message": message} if message else {}), table, message, known)


def rows(record: Record, kinds: Kinds, system: str) -> list[tuple[str, Any, str]]:
    """Name, value and unit for a table of numbers in the user's units, angles in degrees."""

    def unit(key: str) -> str:
        kind = "degrees" if key.endswith("_deg") else kinds.get(key, "ratio")
        return printed(kind, system)

    return [(_LABELS.get(key, words(key)), value, unit(key)) for key, value in record.items()]


def _shown(record: Record, kinds: Kinds, system: str) -> dict[str, Any]:
    """Numbers in SI in the user's units, those of objects in a list too."""
    return {
        key: [_shown(line, kinds, system) for line in value]
        if isinstance(value, list) and dict in map(type, value)
        else in_units(value, kinds.get(key, "ratio"), system)
        for key, value in record.items()
    }


def not_given(record: Mapping[str, Any]) -> list[str]:
    """Why numbers are missing from what a command found."""
    # values that are not finite numbers become None, as in JSON
    found = {key: plain(value) for key, value in record.items() if key in _REASONS}
    return [
        f"{key} is not given: {_REASONS[key]}"
        for key, value in found.items()
        if value is None or (isinstance(value, list) and None in value)
    ]


def in_units(value: Any, quantity: str, system: str) -> Any:
    """An SI value in the user's units; a value without a unit, or None, stays as it is."""
    scale = factor(quantity, system)
    if isinstance(value, list):
        return [in_units(one, quantity, system) for one in value]
    return value if scale == 1.0 or value is None else value / scale


def note(message: str) -> None:
    """A line on stderr, and in the log."""
    _waiting.clear()
    _log.record("note", message=message)
    print(f"escapement: {message}", file=sys.stderr)


def draw(path: Path | None, plot: Callable[[Any], Any]) -> None:
    """Save a figure, which `plot` makes with `escapement.plots`, where one was asked for."""
    drawn(path, plot)()


def drawn(path: Path | None, plot: Callable[[Any], Any]) -> Save:
    """As `draw`, but the figure is only made; the result saves it."""
    if path is None:
        return _nothing
    # the plotting library is loaded only for a figure
    return partial(_save_picture, path, plot(esc.plots))


def drawn_motion(path: Path | None, motion: Any, plot: Callable[[Any], Any]) -> Save:
    """Make a page that plays a motion, a film of it, or what `plot` makes, by the suffix."""
    if path is None or path.suffix.lower() not in FILMS:
        return drawn(path, plot)
    if path.suffix.lower() == ".html":
        from escapement.explorer import player

        return partial(_save_text, path, player(motion))
    engagements = max(1, motion.handoff_times.size)
    if engagements > _LONGEST_FILM:
        raise UsageError(
            f"a film must show at most {_LONGEST_FILM} engagements, got {engagements}; run fewer, "
            "as with --engagements 3"
        )
    frames = max(min(_PICTURES * engagements, _MANY), _FEWER * engagements)
    return drawn(path, lambda plots: plots.animate(motion, frames=frames))


def reported(args: Arguments, escapement: Any, budget: Any = None, speed: float = 0.0) -> Save:
    """Make a report of a design where one was asked for; the result saves it.

    `speed` is that of the driver at the first pin entry [rad/s].
    """
    if args.report is None:
        return _nothing
    from escapement.reports import page

    return partial(_save_text, args.report, page(escapement, budget, "", speed))


def _save_picture(path: Path, picture: Any) -> None:
    esc.plots.save(picture, path)
    _log.record("saved", file=str(path))


def _save_text(path: Path, text: str) -> None:
    write_file(path, [text.encode()], force=True)
    _log.record("saved", file=str(path))


def _nothing() -> None:
    """No file was asked for."""


def check_wanted(
    args: Arguments,
    file: str = "FILE",
    formats: tuple[str, ...] | None = None,
    pictures: tuple[str, ...] = FORMATS,
) -> None:
    """Check the paths that --output with --force, and --plot, name.

    None of them may be an input of the command.

    Parameters
    ----------
    args : Arguments
        With `_arguments.add_plot`, and `_arguments.add_output` or without it.
    file : str
        What the command's help calls its output.
    formats : tuple of str, optional
        Suffixes that the output may have.
    pictures : tuple of str
        Suffixes that the figure may have.

    Raises
    ------
    UsageError
        When there is nothing that --force could replace.
    InvalidValue, CannotCreate
        As `check_output`.
    """
    given = vars(args)
    inputs = [given[name] for name in _INPUTS if given.get(name) is not None]
    if given.get("output") is not None:
        if formats:
            file_format(args.output, formats)
        check_output(args.output, *inputs, force=args.force)
        inputs.append(args.output)
    elif given.get("force"):
        raise UsageError(f"--force must come with --output {file}, got none; leave it out")
    if args.plot is not None:
        check_output(args.plot, *inputs, pictures=pictures)
    if given.get("report") is not None:
        file_format(args.report, REPORTS)
        check_output(args.report, *inputs, force=True)


def check_output(
    path: Path, *others: Path, force: bool = False, pictures: tuple[str, ...] = ()
) -> None:
    """Look whether a file can be put at `path`.

    Parameters
    ----------
    path : Path
        Where the file is to be.
    *others : Path
        Inputs and other outputs, which it must not be.
    force : bool
        Whether an existing file may be replaced.
    pictures : tuple of str
        Suffixes that a picture may have, where it is one. Pictures are made from data: one that
        is not read-only is replaced without asking.

    Raises
    ------
    CannotCreate
        When it cannot be written there.
    InvalidValue
        When the suffix is not that of a picture.
    """
    if pictures:
        file_format(path, pictures)
    folder = check_target(path, force or bool(pictures), writable=bool(pictures)).parent
    for other in others:
        # links are followed; otherwise a result could replace its own input
        if os.path.realpath(path) == os.path.realpath(other):
            raise CannotCreate(f"output {path} must not be {other} too; give it a name of its own")
    _try_writing(path, folder)


@contextmanager
def folder(path: Path | None) -> Iterator[None]:
    """A folder to fill, where one was asked for; a new one that stays empty is removed."""
    new = path is not None and not path.exists()
    try:
        if path is not None:
            _try_writing(path, path)
        yield
    finally:
        if path is not None and new:
            with suppress(OSError):  # the folder is not empty
                path.rmdir()


def _try_writing(path: Path, folder: Path) -> None:
    """Make `folder` if it is missing, and test it with a temporary file, which is removed."""
    with creating(path):
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
