"""An input that HDF5 is to open, looked at before it does."""

from os import PathLike
from pathlib import Path

from escapement.errors import InputFileError, MissingInput


def check_input(path: str | PathLike[str], what: str) -> None:
    """Raise MissingInput or InputFileError unless there is an ordinary file, called `what`.

    A pipe would have to wait for its writer, for ever.
    """
    file = Path(path)
    if not file.exists():
        raise MissingInput(f"{what} {path} does not exist; check its name")
    if not file.is_file():
        raise InputFileError(f"{what} {path} must be an ordinary file; name a file, not a folder")
