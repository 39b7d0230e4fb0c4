"""Command line: picks a command, runs it, turns every error into one line.

A command is a module of this package: its docstring is the summary in its help, and it has
`configure(parser)` and `execute(args) -> exit code`; its `UNITS`, if any, explains default units
that are not SI. Only the module of the command is imported, and it imports nothing heavy before
its arguments are parsed, so that help appears at once.

Each command is a file of its name: `run`, `rundown`, `sweep`, `compare`, `budget`, `design`,
`explore`, `plot`, `mechanism`, `export`, `index`, `measure` with its part `measure_beats`,
`reproduce`, `compile` and `bench`. Read `run` as an example.

- `_arguments`: the parser, options that several commands share, and the objects they describe
- `_inputs`, `_output`: what went in; JSON and tables, which are those of a `Record`, notes, files
- `_waiting`, `_log`: the time at work on the terminal, and the file of `--log`
"""

from __future__ import annotations

import os
import sys

from escapement.base.errors import EscapementError, InvalidValue, StorageError

# modules that take time to load are imported in `main`, which handles Ctrl-C
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any, NoReturn

COMMANDS = {
    "run": "one motion and its figures of merit",
    "rundown": "a timer whose spring runs down: rate, turns and stop",
    "sweep": "a study on a grid or a sample, to an HDF5 file",
    "compare": "several designs side by side, at one clock if asked for",
    "budget": "effects of the tolerances of a drawing, and which to tighten",
    "design": "find timers or indexing drives for a task, within bounds",
    "explore": "write a page that computes a motion while numbers are dragged",
    "plot": "draw the figures that suit a file",
    "mechanism": "geometry, transmission, motion ratio and dwell",
    "export": "write parts as DXF or SVG, after a check of the motion",
    "index": "an indexing drive: torque, power, forces, impacts, ringing of its load",
    "drive-torque": "the old name of index",
    "measure": "measured positions, motions and beats against theory, with statistics",
    "reproduce": "a source's printed numbers compared with computed ones",
    "compile": "compile the numerical code, so that all later work begins at once",
    "bench": "run time against error of all engines",
}

SOME_FAILED = 3
"""Exit code if the work is done and some cases could not be computed."""
INTERRUPTED, TERMINATED = 130, 143
"""Exit codes after Ctrl-C, and after SIGTERM, by which job schedulers end a process."""


class Terminated(KeyboardInterrupt):
    """The process was asked to end: it keeps what is finished, as after Ctrl-C."""


_STRUCK = ("interrupted", INTERRUPTED), ("terminated", TERMINATED)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments after the program's name. Default: those of the process.

    Returns
    -------
    int
        Exit code: 0 done; 2 wrong usage or invalid value; 3 done, some cases
        failed; 65 unreadable input file; 66 missing input; 73 cannot create
        output; 74 input/output error; 130 interrupted; 143 terminated.
    """
    code = _answer(sys.argv[1:] if argv is None else argv)
    _end_log(code)
    return code


def _answer(argv: Sequence[str]) -> int:
    """Run one command; every error becomes one line and an exit code."""
    try:
        import warnings

        if hasattr(sys.stdout, "reconfigure"):
            # a letter that the terminal's encoding lacks is shown by its number
            sys.stdout.reconfigure(errors="backslashreplace")
        with warnings.catch_warnings():
            warnings.showwarning = _warn
            code = _dispatch(argv)
            sys.stdout.flush()
            return code
    except EscapementError as error:
        return _complain(str(error), error.exit_code)
    except KeyboardInterrupt as error:
        return _complain(*_STRUCK[isinstance(error, Terminated)])
    except BrokenPipeError:
        _drop_output()
        return 0  # the reader has seen enough, as in `escapement ... | head`
    except OSError as error:
        _drop_output()
        message = f"input or output failed: {error.strerror or error}; free space, or use another"
        return _complain(f"{message} disk", StorageError.exit_code)
    except MemoryError:
        message = "not enough memory; ask for a shorter motion or fewer cases"
        return _complain(message, StorageError.exit_code)
    except ArithmeticError as error:
        message = f"a number leaves the range of a double ({error}); choose less extreme values"
        return _complain(message, InvalidValue.exit_code)


def program() -> NoReturn:
    """The command line as a process of its own."""
    struck = []

    def strike(number: int, _: object) -> None:
        struck.append(number == signal.SIGTERM)
        raise Terminated if struck[-1] else KeyboardInterrupt

    try:
        import signal

        # a background job of a shell ignores Ctrl-C, and must continue to do so
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, strike)
        if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
            signal.signal(signal.SIGTERM, strike)
        code = main()
    except BaseException:
        # libraries that are being loaded turn Ctrl-C into their own errors
        if not struck:
            raise
        code = _complain(*_STRUCK[struck[-1]])
        _end_log(code)
    if code in (INTERRUPTED, TERMINATED):
        # an orderly exit would wait for threads that are no longer needed; all files are closed
        os._exit(code)
    sys.exit(code)


def _dispatch(argv: Sequence[str]) -> int:
    """Understand the command and its arguments, then run the module that has it."""
    from escapement.base import spoken
    from escapement.base.units import SYSTEMS
    from escapement.cli import _log, _output, _waiting
    from escapement.cli._arguments import OLD_NAMES, parser_of, understand_command

    try:
        name = understand_command(argv, COMMANDS)
        command, parser = parser_of(name)
        args = parser.understand(argv[1:])
        _output.check_files(args)
        if args.log is not None:
            _log.start(args.log, argv)
        with _waiting.shown(argv[0], quiet=getattr(args, "quiet", False)):
            code: int = command.execute(args)
        if name in OLD_NAMES:
            _output.note(f"{name} is the old name of {OLD_NAMES[name]}")
    except SystemExit:  # argparse ends so after help, or the version
        return 0
    finally:
        spoken.speak(SYSTEMS[0])
    return code


def _warn(message: Warning | str, *_: Any, **__: Any) -> None:
    """A library's warning as one line, without its place in the source."""
    _tell("warning", str(message))


def _complain(message: str, code: int) -> int:
    """One line on stderr, whatever line breaks the message has."""
    import contextlib

    with contextlib.suppress(OSError):  # the reader may have left: `escapement ... 2>&1 | head`
        _tell("error", message)
    return code


def _tell(event: str, message: str) -> None:
    """One line on stderr, and in the log."""
    from escapement.cli import _log

    line = " ".join(message.split())
    _log.record(event, message=line)
    print(f"escapement: {event}: {line}", file=sys.stderr)


def _end_log(code: int) -> None:
    from escapement.cli import _log

    _log.end(code)


def _drop_output() -> None:
    """Drop what cannot be written: the interpreter would try again, and complain, at exit."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
