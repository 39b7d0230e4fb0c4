"""Lines of text files as loggers and spreadsheets write them, in any of their encodings."""

import codecs
import os
import re
from collections.abc import Iterator
from functools import cached_property, partial
from os import PathLike

_MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
# what spreadsheets write for a missing number begins no comment
_NO_COMMENT = re.compile(r"#(n/?a|value!|ref!|div/0!|num!)(?!\w)", re.IGNORECASE)
_HEAD, _BLOCK = 4096, 1 << 20


class BrokenLine(Exception):
    """The rule that a line breaks, and the remedy."""


class Lines:
    """Lines of a file, the line that was read last, and the lines without a row."""

    def __init__(self, path: str | PathLike[str], skip: int) -> None:
        self.path, self.skip, self.number, self.text = path, skip, 0, ""

    @cached_property
    def encoding(self) -> str:
        """Encoding of the file; that of a pipe, which cannot be read twice, must be UTF-8."""
        return encoding_of(self.path) if os.path.isfile(self.path) else "utf-8"

    def __iter__(self) -> Iterator[str]:
        """Lines that are neither skipped nor blank nor comments, from the first one on."""
        self.passed_over, self.comments = [0], list[str]()
        with open(self.path, encoding=self.encoding) as stream:
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


def encoding_of(path: str | PathLike[str]) -> str:
    """Encoding of a text file: UTF-8, UTF-16, or the code page 1252 of older Windows programs."""
    with open(path, "rb") as stream:
        head = stream.read(_HEAD)
        for mark, encoding in _MARKS.items():
            if head.startswith(mark):
                return encoding
        # without a mark, UTF-16 shows by the zero in every second byte of figures and commas
        for offset, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
            if 2.2 * head[offset::2].count(0) > len(head) > 1:
                return encoding
        stream.seek(0)
        decoder = codecs.getincrementaldecoder("utf-8")()
        try:
            for block in iter(partial(stream.read, _BLOCK), b""):
                decoder.decode(block)
            decoder.decode(b"", final=True)
        except UnicodeDecodeError:
            return "utf-8" if b"\0" in head else "cp1252"
    return "utf-8"
