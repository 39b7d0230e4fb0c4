"""Reading a study file."""

import re
import tomllib
from os import PathLike
from pathlib import Path
from typing import Any

from escapement.errors import InputFileError, InvalidValue, MissingInput
from escapement.study.parse import parse_plan
from escapement.study.plan import StudyPlan

_BARE_POINT = re.compile(r"(?<![\w.])[+-]?(\.\d+|\d+\.)(?![\w.])")


def load_plan(path: str | PathLike[str]) -> StudyPlan:
    """Read and check a study configuration (TOML).

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it cannot be read or is not TOML; the message has the line.
    InvalidValue
        When a key is unknown, missing, or its value breaks a rule.
    """
    content = _toml(Path(path))
    try:
        return parse_plan(content)
    except InvalidValue as error:
        raise InvalidValue(f"{path}: {error}") from None


def _toml(path: Path) -> dict[str, Any]:
    try:
        data = path.read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        raise MissingInput(f"study file {path} does not exist; check its name") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputFileError(
            f"study file {path} must be a readable file, got: {reason}; name a TOML file"
        ) from None
    try:
        return tomllib.loads(data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        reason = f"a byte that is not UTF-8 (at line {line})"
    except RecursionError:
        reason = "values nested too deeply"
    except ValueError as error:
        reason = str(error)
    remedy = _bare_point(data, reason) or "correct that line"
    raise InputFileError(f"study file {path} must be valid TOML, got: {reason}; {remedy}")


def _bare_point(data: bytes, reason: str) -> str:
    """What to write for a number with nothing before or after its point; empty for no such."""
    line = re.search(r"at line (\d+)", reason)
    if line is None:
        return ""
    text = data.splitlines()[int(line[1]) - 1].decode(errors="replace").partition("#")[0]
    found = _BARE_POINT.search(text)
    if found is None:
        return ""
    number = found[1]
    return f"write {number + '0' if number.endswith('.') else '0' + number}, not {number}"
