"""TOML files that people write: read in the usual encodings, with the mended line after a slip."""

import re
import tomllib
from pathlib import Path
from typing import Any

from escapement.base.errors import InputFileError
from escapement.base.files import AnyPath, check_input

# Usual slips: what TOML asks for, the slip, and what stands in its place. They are tried in turn.
_SLIPS = (
    ("a hyphen as the minus sign", "−", "-"),
    ("straight quotes", "[“”„]", '"'),
    ("an equals sign between key and value", r"^(\s*[\w.-]+)(?:\s*:\s*|\s+)(?![=\s])", r"\1 = "),
    ("a decimal point", r"(=\s*[-+]?\d*),(\d+)", r"\1.\2"),
    ("a digit before the decimal point", r"(?<![\w.\"'])([-+]?)\.(\d)", r"\g<1>0.\2"),
    ("a digit after the decimal point", r"(\d)\.(?![\d\w\"'])", r"\1.0"),
    ("true or false in small letters", r"\b(True|False)\b", lambda found: found[1].lower()),
    (
        "quotes around a number with its unit",
        r"=\s*([-+]?[\d.]+(?:e[-+]?\d+)? ?[^\d\s\"'#\]\[,][^\"'#\]\[,]*?)\s*(#|$)",
        r'= "\1" \2',
    ),
    ("quotes around a word", r"=\s*([A-Za-z][\w./-]*)\s*(#|$)", r'= "\1" \2'),
    ("single quotes around a path with backslashes", r'=\s*"([^"\']*\\[^"\']*)"', r"= '\1'"),
)
_LINE = re.compile(r"\(at line (\d+), column \d+\)")
_MARK = "\ufeff"  # byte order mark: editors on Windows begin a file with it


def read_toml(path: AnyPath, what: str) -> dict[str, Any]:
    """The content of a TOML file.

    Besides UTF-8, as TOML asks, a file may be UTF-16 with its byte order mark; byte order marks
    at the beginning of lines, which files that were joined have, are left out.

    Parameters
    ----------
    path : path
        The file.
    what : str
        Kind of the file, for messages.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it cannot be read or is not TOML; the message has the line, and the mended line if the
        slip is a usual one.
    """
    check_input(path, what)
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise InputFileError(f"{what} {path} must be readable, got: {error.strerror}") from None
    try:
        return parse_toml(_text(data))
    except ValueError as error:
        raise InputFileError(f"{what} {path} must be valid TOML, {error}") from None


def parse_toml(text: str) -> dict[str, Any]:
    """The content of a text in TOML; ValueError with the line, what is wrong and the remedy."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("got tables that are nested too deeply; write fewer brackets") from None
    except ValueError as error:
        if (found := _LINE.search(reason := str(error))) is None:
            raise ValueError(f"got: {reason}; correct it there") from None
        number = int(found[1])
        line = text.splitlines()[number - 1].strip()
        remedy = _remedy(text, number) or f"correct it there ({_LINE.sub('', reason).strip()})"
        raise ValueError(f"got in line {number}: {line}; {remedy}") from None


def _text(data: bytes) -> str:
    """A file's text; ValueError with the line that is not UTF-8."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        try:
            return data.decode("utf-16")
        except UnicodeDecodeError:
            raise ValueError(
                "which is UTF-8, got another encoding; save the file as UTF-8"
            ) from None
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        number = data.count(b"\n", 0, error.start) + 1
        line = data.splitlines()[number - 1].decode("cp1252", errors="replace").strip()
        raise ValueError(
            f"which is UTF-8, got another encoding in line {number}: {line}; save the file as UTF-8"
        ) from None
    return "\n".join(line.removeprefix(_MARK) for line in text.splitlines())


def _remedy(text: str, number: int) -> str:
    """What to write in a line that is no TOML; nothing if no usual slip explains the error."""
    lines = text.splitlines()
    line = lines[number - 1]
    wrong: list[str] = []
    for rule, slip, mended in _SLIPS:
        changed = re.sub(slip, mended, line).rstrip()
        if changed == line.rstrip():
            continue
        line, wrong = changed, [*wrong, rule]
        if _first_error("\n".join([*lines[: number - 1], line, *lines[number:]])) > number:
            return f"TOML asks for {' and '.join(wrong)}: write {line.strip()}"
    return ""


def _first_error(text: str) -> float:
    """Number of the line in which a text stops to be TOML; infinity if it is TOML."""
    try:
        tomllib.loads(text)
    except ValueError as error:
        found = _LINE.search(str(error))
        return int(found[1]) if found else 0.0
    return float("inf")
