"""Lines of text files as loggers and spreadsheets write them, in any of their encodings."""

import codecs
import os
import re
from collections.abc import Iterator
from os import PathLike
from typing import TextIO

# what spreadsheets write for a missing number begins no comment
_NO_COMMENT = re.compile(r"#(n/?a|value!|ref!|div/0!|num!)(?!\w)", re.IGNORECASE)
_MARKS = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE


class BrokenLine(Exception):
    """The rule that a line breaks, and the remedy."""


class Lines:
    """Lines of a file, the line that was read last, and the lines without a row."""

    def __init__(self, path: str | PathLike[str], skip: int) -> None:
        self.path, self.skip, self.number, self.text = path, skip, 0, ""

    def __iter__(self) -> Iterator[str]:
        """Lines that are neither skipped nor blank nor comments, from the first one on."""
        self.passed_over, self.comments = [0], list[str]()
        with open_text(self.path) as stream:
            for self.number, self.text in enumerate(stream, 1):
                # a byte order mark stands at the beginning of each file that was appended
                if self.text[0] == "\ufeff":
                    self.text = self.text[1:] or "\n"
                comment = self.text[0] == "#" and not _NO_COMMENT.match(self.text)
                if self.number <= self.skip or self.text.isspace() or comment:
                    self.passed_over.append(self.number)
                    self.comments.append(self.text)
                # `loadtxt` would take the lines after an open quote for one field
                elif '"' in self.text and self.text.count('"') % 2:
                    raise BrokenLine("close its quotes", "correct it")
                else:
                    yield self.text


def _as_windows(error: UnicodeError) -> tuple[str, int]:
    """Bytes that are no UTF-8 as the code page 1252 of older Windows programs has them."""
    if isinstance(error, UnicodeDecodeError):
        text = error.object[error.start : error.end].decode("cp1252", errors="replace")
        return text, error.end
    raise error


codecs.register_error("escapement.windows", _as_windows)


def open_text(path: str | PathLike[str]) -> TextIO:
    """A text file in UTF-8, UTF-16 with its mark, or code page 1252, open for reading."""
    encoding = "utf-8"
    if os.path.isfile(path):  # a pipe cannot be read twice
        with open(path, "rb") as stream:
            encoding = "utf-16" if stream.read(2) in _MARKS else "utf-8"
    return open(path, encoding=encoding, errors="escapement.windows")
