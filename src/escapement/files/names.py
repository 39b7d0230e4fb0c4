"""Checks of names of files: inputs that HDF5 is to open, and figures to be written."""

from os import PathLike
from pathlib import Path

from escapement.errors import InputFileError, InvalidValue, MissingInput

FORMATS = (".png", ".pdf", ".svg")
"""Suffixes of figures; they are known here so that a name is checked before Matplotlib loads."""
FILMS = (".gif",)
"""Suffixes of films."""


def check_input(path: str | PathLike[str], what: str) -> None:
    """Raise MissingInput or InputFileError unless `path` is an ordinary file.

    `what` names the kind of file in the message. A pipe is refused as well, because
    reading it would wait for its writer without end.
    """
    file = Path(path)
    if not file.exists():
        raise MissingInput(f"{what} {path} does not exist; check its name")
    if not file.is_file():
        raise InputFileError(f"{what} {path} must be an ordinary file; name a file, not a folder")


def picture_format(path: str | PathLike[str], formats: tuple[str, ...] = FORMATS) -> str:
    """The suffix of a figure's name, one of `formats`; raises InvalidValue for another."""
    suffix = Path(path).suffix
    if suffix.lower() not in formats:
        raise InvalidValue(
            f"output {path} must end in {', '.join(formats)}, got {suffix!r}; change the suffix"
        )
    return suffix.lower()
