"""Writing a study in bounded memory, so that finished blocks are never lost."""

import threading
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import NamedTuple

from escapement.base import files
from escapement.base.files import AnyPath
from escapement.study import table_files
from escapement.study.block import Block, Tiling, blocks_of, encode_block
from escapement.study.hdf5 import write_hdf5
from escapement.study.journal import Journal
from escapement.study.reader import failed_cases
from escapement.study.result import Study

_WRITERS = {table_files.CSV: table_files.write_csv, table_files.PARQUET: table_files.write_parquet}


def partial_path(path: AnyPath) -> Path:
    """Where the finished blocks of a study are kept until all are there."""
    target = Path(path).resolve()
    return target.with_name(target.name + ".partial")


class Unfinished(NamedTuple):
    """A study that is being written.

    cut : how its cases are cut into blocks.
    missing : numbers of the blocks still to be added.
    resumed, failed : number of cases taken from an earlier run, and of those that failed.
    add : keeps a finished block.
    """

    cut: Tiling
    missing: Sequence[int]
    resumed: int
    failed: int
    add: Callable[[Block], None]


@contextmanager
def study_writer(
    path: AnyPath, frame: Study, *, numerics: str = "", force: bool = False, resume: bool = False
) -> Iterator[Unfinished]:
    """Keep finished blocks in a journal, and make the file from them when all are there.

    Blocks may come in any order. If the `with` block is left early, the file is unchanged and the
    blocks are kept for a later `resume`.

    Parameters
    ----------
    path : path
        File to create; its suffix is one of `files.STUDIES`.
    frame : Study
        Everything except the results, of which only names and types are used.
    numerics : str
        Differs whenever a version of this package may compute other results.
    force : bool
        Replace an existing file, once the new one is complete; without `resume`,
        drop existing partial results.
    resume : bool
        Use partial results, if there are any. A complete file of the same study is not changed.

    Raises
    ------
    InvalidValue, MissingPackage
        As `table_files.check_format`.
    CannotCreate
        On entering, when the file may not be created, another process is writing
        it, or its partial results belong to another study.
    StorageError
        When the disk is full or fails.
    """
    target, cut = files.check_target(path, force or resume), blocks_of(frame)
    suffix = table_files.check_format(path)
    # a killed process leaves it, and the next process with the same output removes it
    temporary = files.temporary_path(target, f"{zlib.crc32(target.name.encode()):016x}")
    with ExitStack() as stack:
        with files.creating(path):
            journal = Journal(partial_path(target), path, force=force, resume=resume)
            stack.callback(journal.close)
            temporary.unlink(missing_ok=True)
            old = resume and not force and target.exists()
            known = table_files.failed_rows if suffix in _WRITERS else failed_cases
            complete = known(target, frame) if old else None
            # a complete CSV is computed again, because it does not contain its study
            again = old and suffix == table_files.CSV
            if complete is None:
                files.check_target(path, force or again)
                frame = journal.begin(frame, numerics)
        here = journal.failed
        storing = partial(files.storing, path, lambda: journal.path.name if here else "")

        def add(block: Block) -> None:
            with storing():
                journal.append(block)

        if complete is not None:
            yield Unfinished(cut, [], frame.cases, complete, add)
        else:
            resumed = sum(stop - start for start, stop in map(cut.span, here))
            missing = [number for number in range(len(cut)) if number not in here]
            yield Unfinished(cut, missing, resumed, sum(here.values()), add)
            if lacking := len(cut) - len(here):
                raise ValueError(f"the study lacks {lacking} blocks")
            with storing():
                journal.check()
                blocks = map(journal.block, range(len(cut)))
                if again:
                    table_files.compare_csv(frame, target, blocks)
                else:
                    write_blocks(frame, path, blocks, force, temporary)
        journal.remove()


def write_study(study: Study, path: AnyPath, *, force: bool = False) -> None:
    """Write a study as HDF5 or as a table, depending on the suffix; errors as `study_writer`."""
    cut = blocks_of(study)
    flat = {name: values.reshape(-1) for name, values in study.results.items()}

    def block(number: int) -> Block:
        span = slice(*cut.span(number))
        return encode_block(cut, number, {name: values[span] for name, values in flat.items()})

    write_blocks(study, path, map(block, range(len(cut))), force)


def write_blocks(
    frame: Study, path: AnyPath, blocks: Iterable[Block], force: bool, temporary: Path | None = None
) -> None:
    """Write all blocks of a study in their order, and put the file in place.

    It runs in a separate thread, so that Ctrl-C never interrupts HDF5; an interruption ends the
    thread before its next block.

    Raises
    ------
    CannotCreate, StorageError
        As `pending_file`.
    """
    stop, write = threading.Event(), _WRITERS.get(table_files.check_format(path), write_hdf5)

    def going() -> Iterator[Block]:
        for block in blocks:
            if stop.is_set():
                raise InterruptedError
            yield block

    with ThreadPoolExecutor(1, thread_name_prefix="escapement-store") as thread:
        work = thread.submit(write, frame, path, going(), force, temporary)
        try:
            work.result()
        except BaseException:
            stop.set()
            raise
