"""Formats that a figure can be written in, known without loading a plotting library."""

from os import PathLike
from pathlib import Path

from escapement.errors import InvalidValue

FORMATS = (".png", ".pdf", ".svg")
"""What a figure's name may end in."""


def picture_format(path: str | PathLike[str]) -> str:
    """The suffix of a figure's name, one of `FORMATS`; raises InvalidValue for another."""
    suffix = Path(path).suffix
    if suffix.lower() not in FORMATS:
        raise InvalidValue(
            f"output {path} must end in {', '.join(FORMATS)}, got {suffix!r}; change the suffix"
        )
    return suffix.lower()
