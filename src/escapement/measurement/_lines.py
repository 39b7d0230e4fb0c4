"""A text file as blocks of whole lines, every fault with its line."""

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

from escapement.errors import InputFileError

_BLOCK_BYTES = 1 << 22


class Source(NamedTuple):
    """The file, for messages."""

    path: Path

    def fault(self, line: int, rule: str, got: str, remedy: str) -> InputFileError:
        """The error for a line; a long one is cut."""
        shown = got if len(got) <= 60 else got[:57] + "..."
        return InputFileError(f"{self.path}, line {line} must {rule}, got {shown!r}; {remedy}")


class Block(NamedTuple):
    """Whole lines, and the number of the first."""

    first: int
    lines: list[str]


def blocks(source: Source, stream: BinaryIO) -> Iterator[Block]:
    """A file as blocks of whole lines."""
    line, rest = 1, b""
    while True:
        new = stream.read(_BLOCK_BYTES)
        whole, end, rest = _cut(rest + new) if new else (rest, b"", b"")
        if line == 1:
            whole = whole.removeprefix(b"\xef\xbb\xbf")
        if whole or end:
            lines = _text(source, line, whole)
            yield Block(line, lines)
            line += len(lines)
        if not new:
            return
        if len(rest) > _BLOCK_BYTES:
            remedy = "separate the samples by line ends"
            raise source.fault(line, "be a row of angles", f"{len(rest)} bytes and more", remedy)


def _cut(data: bytes) -> tuple[bytes, bytes, bytes]:
    """What is before the last line end, that, and what follows."""
    if b"\n" in data:
        return data.rpartition(b"\n")
    # the last byte may be half of a line end
    whole, end, rest = data[:-1].rpartition(b"\r")
    return whole, end, rest + data[-1:]


def _text(source: Source, first: int, data: bytes) -> list[str]:
    """Lines of text, whatever their ends; the first that is none is named."""
    remedy = "save it as CSV in UTF-8"
    data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    try:
        text = data.decode("utf-8")
        fault = text.find("\0")
        place = len(text[:fault].encode()) if fault >= 0 else -1
    except UnicodeDecodeError as error:
        place = error.start
    if place >= 0:
        line = data.count(b"\n", 0, place)
        shown = data.split(b"\n")[line][:20].decode("ascii", "backslashreplace")
        raise source.fault(first + line, "be text in UTF-8", shown, remedy)
    return text.split("\n")
