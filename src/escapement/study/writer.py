"""Writing a study in bounded memory, so that nothing that was finished is ever lost."""

import json
import threading
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from escapement import files
from escapement.files import AnyPath
from escapement.status import Status
from escapement.study.block import CELLS, Block, Tiling, blocks_of, encode_block
from escapement.study.journal import Journal
from escapement.study.reader import failed_cases
from escapement.study.result import Study

_FILTERS: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}


def partial_path(path: AnyPath) -> Path:
    """Where the finished blocks of a study are kept until all are there."""
    target = Path(path).resolve()
    return target.with_name(target.name + ".partial")


class Unfinished(NamedTuple):
    """A study that is being written.

    cut : how its cases are cut into blocks.
    missing : numbers of the blocks still to be added.
    resumed, failed : cases taken over; those of them without an answer.
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
    """Keep finished blocks in a journal, and make the file of them when all are there.

    Blocks may come in any order. Leaving the `with` block early, for whatever reason,
    leaves the file as it was and the blocks for a later `resume`.

    Parameters
    ----------
    path : path
        File to create.
    frame : Study
        Everything but the results, of which names and types count.
    numerics : str
        Differs whenever a version of this package may compute other results.
    force : bool
        Replace an existing file, once the new one is complete; without `resume`,
        drop existing partial results.
    resume : bool
        Take over what partial results there are. A complete file of the same study
        is left alone.

    Raises
    ------
    CannotCreate
        On entering, when the file may not be created, another process is writing
        it, or its partial results belong to another study.
    StorageError
        When the disk is full or fails.
    """
    target, cut = files.check_target(path, force or resume), blocks_of(frame)
    # killed processes leave it behind, and the next one of the same output removes it
    temporary = files.temporary_path(target, f"{zlib.crc32(target.name.encode()):016x}")
    with ExitStack() as stack:
        with files.creating(path):
            journal = Journal(partial_path(target), path, force=force, resume=resume)
            stack.callback(journal.close)
            temporary.unlink(missing_ok=True)
            old = resume and not force and target.exists()
            complete = failed_cases(target, frame) if old else None
            if complete is None:
                files.check_target(path, force)
                frame = journal.begin(frame, numerics, len(cut))
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
                write_blocks(frame, path, blocks, force, temporary)
        journal.remove()


def write_study(study: Study, path: AnyPath, *, force: bool = False) -> None:
    """Write a study that is held in memory; errors as `study_writer`."""
    cut = blocks_of(study)
    flat = {name: values.reshape(-1) for name, values in study.results.items()}

    def block(number: int) -> Block:
        span = slice(*cut.span(number))
        return encode_block(cut, number, {name: values[span] for name, values in flat.items()})

    write_blocks(study, path, map(block, range(len(cut))), force)


def write_blocks(
    frame: Study, path: AnyPath, blocks: Iterable[Block], force: bool, temporary: Path | None = None
) -> None:
    """Write all blocks of a study, and put the file in place.

    It runs in a thread of its own, where Ctrl-C never strikes HDF5; an interruption ends the
    thread before its next block.

    Raises
    ------
    CannotCreate, StorageError
        As `pending_file`.
    """
    stop, cut = threading.Event(), blocks_of(frame)

    def write() -> None:
        with files.pending_hdf5(path, force, temporary) as (hdf5, disk):
            results = _create_datasets(hdf5, frame, cut.tile)
            for block in blocks:
                if stop.is_set():
                    raise InterruptedError
                if disk.error is not None:
                    break
                for dataset, data in zip(results, block.chunks, strict=True):
                    dataset.id.write_direct_chunk(cut.offset(block.number), data)

    with ThreadPoolExecutor(1, thread_name_prefix="escapement-store") as thread:
        work = thread.submit(write)
        try:
            work.result()
        except BaseException:
            stop.set()
            raise


def _create_datasets(hdf5: Any, frame: Study, tile: tuple[int, ...]) -> list[Any]:
    """Everything but results; returns their datasets, which are empty."""
    import h5py

    hdf5.attrs.update(frame.attributes)
    text = json.dumps(frame.configuration, allow_nan=False)
    dataset = hdf5.create_dataset("configuration", data=text, dtype=h5py.string_dtype())
    dataset.attrs.update(units="1", long_name="configuration of the study, JSON")
    for name, values in (frame.axes | frame.sampled).items():
        kind = "<i8" if values.dtype.kind == "i" else "<f8"
        chunks = (min(values.size, CELLS),)
        line = _create(hdf5, frame, name, data=values, dtype=kind, chunks=chunks)
        if name in frame.axes:
            line.make_scale(name)
        else:
            line.dims[0].attach_scale(hdf5[[*frame.axes][-1]])
    results = {
        name: _create(hdf5, frame, name, shape=frame.shape, dtype=values.dtype, chunks=tile)
        for name, values in frame.results.items()
    }
    for dataset in results.values():
        if frame.sampled:
            dataset.attrs["coordinates"] = " ".join(frame.sampled)  # as the CF conventions have it
        for dimension, axis in zip(dataset.dims, frame.axes, strict=True):
            dimension.attach_scale(hdf5[axis])
    numbers, labels = zip(*((member.value, member.label) for member in Status), strict=True)
    flags = {"flag_values": np.array(numbers, "u1"), "flag_meanings": " ".join(labels)}
    results["status"].attrs.update(flags)
    return [*results.values()]


def _create(hdf5: Any, frame: Study, name: str, **options: Any) -> Any:
    dataset = hdf5.create_dataset(name, **options, **_FILTERS)
    dataset.attrs.update(units=frame.units[name], long_name=frame.long_names[name])
    return dataset
