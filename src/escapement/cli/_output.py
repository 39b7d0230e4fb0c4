"""Output of all commands: JSON, tables, notes, and checks of the files to write.

The paths of files are checked before anything is computed.
"""

import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import escapement as esc
from escapement.base.errors import CannotCreate
from escapement.base.files import FILMS, PAGES, check_target, creating, file_format, write_file
from escapement.base.records import Record, beside
from escapement.base.spoken import speak
from escapement.base.status import MESSAGES, Status
from escapement.base.text import as_json, print_columns, words
from escapement.base.toml_file import read_toml
from escapement.base.units import SYSTEMS
from escapement.cli import _log, _waiting
from escapement.cli._arguments import SLOTS, Arguments, OutputFile, UsageError
from escapement.cli._inputs import as_record, inputs_of_command, print_inputs
from escapement.model.inputs import Input

Content = Any
"""Of a file: a text, a picture, or a function that saves it."""
_PICTURES, _FEWER, _MANY = 40, 10, 320  # pictures of an engagement in a film, fewer beyond many
_LONGEST_FILM = 50  # engagements


def tell(
    args: Arguments,
    record: Record | Mapping[str, Any],
    known: Iterable[Input] = (),
    table: Callable[[], None] | None = None,
) -> None:
    """Print what went in and what a command found, as a JSON object or as tables.

    The message of the record is shown on stderr, too, and its tables do not have it.

    Parameters
    ----------
    args : Arguments
        What was typed.
    record : Record or mapping
        What was found, in SI.
    known : iterable of Input
        Numbers that went in, with their defaults; whatever else was typed is listed, too.
    table : callable, optional
        Prints what was found, where its own tables are not what a reader needs.
    """
    _waiting.end()
    found = record if isinstance(record, Record) else Record(record)
    inputs, system = inputs_of_command(args, known), args.units or SYSTEMS[0]
    message = found.values.get("message", "")
    if args.json:
        print_json({"inputs": as_record(inputs, system)} | found.in_units(system))
    else:
        print_inputs(inputs, system)
        if table is not None:
            table()
        else:
            found.without("message").show(system)
    if message not in ("", MESSAGES[Status.OK]):
        note(message)


Found = tuple[Record, Iterable[Input], int]
"""What a command found, the numbers that went in, and its exit code."""


def tell_found(args: Arguments, find: Callable[[Arguments], Found], name: str = SLOTS) -> int:
    """Print what a command finds, as one table if several values of an option are given."""
    if isinstance(getattr(args, name), tuple):
        return tell_several(args, find, name)
    record, inputs, code = find(args)
    tell(args, record, inputs)
    return code


def tell_several(args: Arguments, find: Callable[[Arguments], Found], name: str = SLOTS) -> int:
    """Print what a command finds for each of several values of an option, as one table."""
    values, found = getattr(args, name), []
    for file in ("output", "plot", "report"):
        if getattr(args, file, None) is not None:
            rule = f"--{file} must come with one number of {words(name)}"
            raise UsageError(f"{rule}, got {len(values)}")
    for value in values:
        setattr(args, name, value)
        found.append(find(args))
    setattr(args, name, [*values])
    records, inputs = [one for one, _, _ in found], [[*known] for _, known, _ in found]
    # what follows from the option is no input of all
    known = [x for x in inputs[0] if all(x in others for others in inputs)]
    cases = [{name: n, **one.values} for n, one in zip(values, records, strict=True)]
    heads = [f"{n} {words(name)}" for n in values]
    told = Record({"cases": cases}, records[0].results)
    messages = (one.values.get("message", "") for one in records)
    notes = [
        f"{head}: {text}" for head, text in zip(heads, messages, strict=True)
        if text not in ("", MESSAGES[Status.OK])
    ]  # fmt: skip
    told = told | Record({"message": "; ".join(notes)}) if notes else told
    tell(args, told, known, partial(side_by_side, args, records, heads))
    return max(code for _, _, code in found)


def side_by_side(args: Arguments, records: Iterable[Record], heads: Iterable[str]) -> None:
    """Print the single values of several records, a column for each."""
    lines = beside([one.without("message") for one in records], args.units)
    wide = max(len(line[0]) for line in lines)
    rows = [[line[0].ljust(wide), *line[1:]] for line in lines]
    print_columns([["", *heads, ""]], rows)


def speak_as(args: Arguments, path: Path, what: str) -> None:
    """Speak the units that a TOML file names, unless the user chose others."""
    if args.units is None:
        named = read_toml(path, what).get("units")
        args.units = named if named in SYSTEMS else SYSTEMS[0]
        speak(args.units)


def print_json(record: Mapping[str, Any]) -> None:
    """One object on stdout."""
    print(as_json(record), end="")


def with_reasons(record: Record, warning: str = "") -> Record:
    """A record with a message, if there is a warning or a number is missing."""
    message = "; ".join([*filter(None, [warning]), *record.reasons()])
    return replace(record, values={**record.values, "message": message}) if message else record


def note(message: str) -> None:
    """A line on stderr, and in the log."""
    _log.record("note", message=message)
    print(f"escapement: {message}", file=sys.stderr)


def save(
    args: Arguments,
    output: Callable[[], Content] | None = None,
    plot: Callable[[Any], Content] | None = None,
    report: Callable[[], Content] | None = None,
) -> None:
    """Make all files that were asked for, then save them.

    A number that is refused while one of them is made leaves nothing on disk.

    Parameters
    ----------
    args : Arguments
        With the paths of the files.
    output, report : callable, optional
        Make the content of --output and of --report.
    plot : callable, optional
        Makes that of --plot, with `escapement.plots`.
    """
    makers = {"output": output, "plot": plot and partial(picture, plot), "report": report}
    asked = {n: x for n, x in makers.items() if x and getattr(args, n, None) is not None}
    for name, content in {name: make() for name, make in asked.items()}.items():
        save_as(getattr(args, name), content, force=name != "output" or args.force)


def save_as(path: Path, content: Content, force: bool = True) -> None:
    """Save content, of which a picture is saved by Matplotlib, and a function saves itself."""
    if isinstance(content, str):
        write_file(path, [content.encode()], force)
    elif callable(content):
        content()
    else:
        esc.plots.save(content, path)
    _log.record("saved", file=str(path))


def picture(plot: Callable[[Any], Content]) -> Content:
    """What `plot` makes; the plotting library is loaded only for that."""
    return plot(esc.plots)


def page_of(escapement: Any, budget: Any = None, **how: Any) -> str:
    """A report of a design; `how` has the other arguments of `reports.page`."""
    from escapement.reports import page

    return page(escapement, budget, **how)


def moving(path: Path | None, motion: Any, still: Callable[[Any], Content]) -> Any:
    """What makes a film of a motion, or a page that plays it, or a picture, by the suffix.

    still : makes the picture, with `escapement.plots`.
    """
    suffix = "" if path is None else path.suffix.lower()
    if suffix not in FILMS + PAGES:
        return still
    if suffix in PAGES:
        from escapement.explorer import player

        return lambda _: player(motion)
    engagements = max(1, motion.handoff_times.size)
    if engagements > _LONGEST_FILM:
        raise UsageError(
            f"a film must show at most {_LONGEST_FILM} engagements, got {engagements}; run fewer, "
            "as with --engagements 3"
        )
    frames = max(min(_PICTURES * engagements, _MANY), _FEWER * engagements)
    return lambda plots: plots.animate(motion, frames=frames)


def check_files(args: Arguments) -> None:
    """Check the paths of all files to write; none of them may be an input of the command.

    Raises
    ------
    InvalidValue, CannotCreate
        When the suffix is unknown, or as `check_output`.
    """
    files = {n: x for n, x in args.settings.items() if isinstance(x, OutputFile)}
    known = [x for name, x in vars(args).items() if isinstance(x, Path) and name not in files]
    for name, entry in files.items():
        if (path := getattr(args, name)) is not None:
            if entry.formats:
                file_format(path, entry.formats)
            check_output(path, *known, force=getattr(args, "force", False), drawn=entry.drawn)
            known.append(path)


def check_output(path: Path, *others: Path, force: bool = False, drawn: bool = False) -> None:
    """Look whether a file can be put at `path`.

    Parameters
    ----------
    path : Path
        Where the file is to be.
    *others : Path
        Inputs and other outputs, which it must not be.
    force : bool
        Whether an existing file may be replaced.
    drawn : bool
        Whether it is made from data, as a picture: one that is not read-only is replaced without
        asking.

    Raises
    ------
    CannotCreate
        When it cannot be written there.
    """
    folder = check_target(path, force or drawn, writable=drawn).parent
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
