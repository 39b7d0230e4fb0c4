"""What threads and workers compute of a study: its different scenes, then its blocks."""

import hashlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.base.progress import Progress
from escapement.study import scenes
from escapement.study.block import Block, Tiling, encode_block
from escapement.study.cases import evaluate
from escapement.study.plan import StudyPlan
from escapement.study.pool import Pool
from escapement.study.result import count_failed

_FEWEST, _MOST = 256, 16384  # scenes solved at a time: up to 0.2 s
_GOLDEN = (5.0**0.5 - 1.0) / 2.0
_ROOT = Path(__file__).parents[1]
_ROOMS = (
    *("base", "numerics", "mechanisms", "model", "dynamics", "constant_speed", "engines", "study"),
)


class Work(NamedTuple):
    """Everything needed to solve any block of a study, in any process.

    encoded : whether blocks are for a file; otherwise they hold arrays.
    """

    plan: StudyPlan
    cut: Tiling
    numerics: str
    encoded: bool
    shared: scenes.SharedScenes | None = None


def solve_block(work: Work, number: int) -> Block:
    """A task: the results of a block."""
    if work.numerics != numerics():
        raise InvalidValue(
            f"workers must have the version of the client, numerics {work.numerics}, got "
            f"{numerics()}; install the same geneva-escapement everywhere"
        )
    columns = evaluate(work.plan, *work.cut.span(number), work.shared)
    if work.encoded:
        return encode_block(work.cut, number, columns)
    return Block(number, count_failed(columns["status"]), columns)


def solve_slice(plan: StudyPlan, part: tuple[int, Any]) -> tuple[int, scenes.SceneFigures]:
    """A task: the scenes of some cases, and their indices."""
    start, cases = part
    return start, scenes.solve_scenes(plan, cases)


def mixed(items: Sequence[Any]) -> list[Any]:
    """The items in an order of which every beginning is spread evenly over all of them.

    The time that the first ones take then tells that of all, even if costly cases are neighbours.
    """
    if len(items) == 1:
        return [*items]
    return [items[i] for i in np.argsort(_GOLDEN * np.arange(len(items)) % 1.0).tolist()]


def solved_scenes(
    plan: StudyPlan, pool: Pool, progress: Progress | None = None
) -> scenes.SharedScenes | None:
    """The scenes that blocks have in common, solved; None where each block solves its own."""
    given = scenes.shared_scenes(plan)
    if given is None:
        return None
    shared, size = given[0], given[0].cases.size
    step = min(max(size // 64, _FEWEST), _MOST)
    if size <= step:
        figures, status = scenes.solve_distinct(plan, given[1])
        return shared._replace(figures=figures, status=status)
    del given  # they take more memory than their figures
    figures, status = np.empty((len(plan.solved), size)), np.empty(size, dtype=np.uint8)
    starts = mixed(range(0, size, step))
    parts = ((start, shared.cases[start : start + step]) for start in starts)
    if progress is not None:
        progress.count("different cases")
    for done, (start, found) in enumerate(pool.completed(solve_slice, plan, parts), 1):
        figures[:, start : start + step], status[start : start + step] = found
        if progress is not None:
            progress(min(done * step, size), size, 0)
    if progress is not None:
        progress.count("cases")
    return shared._replace(figures=figures, status=status)


def sources() -> list[Path]:
    """The files that results may depend on, in order."""
    rooms = ((_ROOT / room).rglob("*.py") for room in _ROOMS)
    return sorted(path for room in rooms for path in room)


@cache
def numerics() -> str:
    """Digest of these sources; equal digests, equal results.

    A change of a comment changes the digest too: computing a study again is better than mixing
    numbers of two versions.
    """
    digest = hashlib.sha256()
    for path in sources():
        digest.update(path.relative_to(_ROOT).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]
