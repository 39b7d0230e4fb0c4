"""What the module of a source hands to `escapement reproduce`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Reproduction:
    """A source's numbers, recomputed, and the ways to show them.

    name : of its tables, without a suffix.
    record : for JSON.
    table : rows for CSV, a header first.
    show : prints for people.
    draw : fills a folder with figures.
    """

    name: str
    record: dict[str, Any]
    table: Sequence[Sequence[Any]]
    show: Callable[[], None]
    draw: Callable[[Path], None]
