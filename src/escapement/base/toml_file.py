"""TOML files that people write: read in the usual encodings, with the line of a slip."""

import re
import tomllib
from typing import Any

from escapement.base.errors import InputFileError
from escapement.base.files import AnyPath, check_input
from escapement.base.lines import open_text

_LINE = re.compile(r"\(at line (\d+), column \d+\)")
_MARK = "\ufeff"  # byte order mark: editors on Windows begin a file with it
_RULES = (
    "TOML asks for KEY = VALUE, with digits on both sides of a decimal point, quotes around words "
    "and numbers with a unit, and true or false in small letters"
)


def read_toml(path: AnyPath, what: str) -> dict[str, Any]:
    """The content of a TOML file, in any encoding that `open_text` reads.

    Parameters
    ----------
    path : path
        The file. Byte order marks at the beginning of lines, which files that were joined have,
        are left out.
    what : str
        Kind of the file, for messages.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it cannot be read or is not TOML; the message has the line.
    """
    check_input(path, what)
    try:
        with open_text(path) as stream:
            return parse_toml("".join(line.removeprefix(_MARK) for line in stream))
    except OSError as error:
        raise InputFileError(f"{what} {path} must be readable, got: {error.strerror}") from None
    except ValueError as error:
        raise InputFileError(f"{what} {path} must be valid TOML, {error}") from None


def parse_toml(text: str) -> dict[str, Any]:
    """The content of a text in TOML; ValueError with the line, what is wrong and the rules."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("got tables that are nested too deeply; write fewer brackets") from None
    except ValueError as error:
        found, where = _LINE.search(str(error)), ""
        if found is not None:
            number = int(found[1])
            where = f" in line {number}: {text.splitlines()[number - 1].strip()}"
        reason = _LINE.sub("", str(error)).strip()
        raise ValueError(f"got{where} ({reason}); {_RULES}") from None
