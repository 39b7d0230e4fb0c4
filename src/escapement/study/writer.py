"""Writing a study in bounded memory, so that nothing that was finished is ever lost."""

import errno
import json
import threading
import zlib
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from escapement.errors import CannotCreate, EscapementError, StorageError
from escapement.files import (
    DeferredErrorFile,
    PendingFile,
    check_target,
    creation_error,
    storage_error,
    temporary_path,
)
from escapement.status import Status
from escapement.study.block import CELLS, Block, blocks_of, encode_block
from escapement.study.identity import journal_head
from escapement.study.journal import Journal
from escapement.study.reader import failed_cases
from escapement.study.result import RESULTS, Study

_FILTERS: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}


def partial_path(path: str | PathLike[str]) -> Path:
    """Where the finished blocks of a study are kept until all are there."""
    target = Path(path).resolve()
    return target.with_name(target.name + ".partial")


class StudyWriter:
    """Keeps finished blocks in a journal, and makes the file of them when all are there.

    Blocks may come in any order. Leaving the `with` block early, for whatever reason,
    leaves the file as it was and the blocks for a later `resume`.

    Parameters
    ----------
    path : path
        File to create.
    frame : Study
        Everything but the results, which are ignored.
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

    Attributes
    ----------
    missing : list of int
        Numbers of the blocks still to be added.
    resumed, failed : int
        Cases taken over on entering; cases without an answer so far.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        frame: Study,
        *,
        numerics: str = "",
        force: bool = False,
        resume: bool = False,
    ) -> None:
        self._path, self._frame, self._numerics = path, frame, numerics
        self._force, self._resume = force, resume
        self.cut = blocks_of(frame)
        self.missing: list[int] = []
        self.resumed = self.failed = 0

    def __enter__(self) -> Self:
        target = check_target(self._path, self._force or self._resume)
        # killed processes leave it behind, and the next one of the same output removes it
        self._temporary = temporary_path(target, f"{zlib.crc32(target.name.encode()):016x}")
        try:
            self._journal = Journal(
                partial_path(target), self._path, force=self._force, resume=self._resume
            )
            try:
                self._temporary.unlink(missing_ok=True)
                self._begin(target)
            except BaseException:
                self._journal.close()
                raise
        except OSError as error:
            raise creation_error(self._path, error) from None
        return self

    def add(self, block: Block) -> None:
        """Keep a finished block."""
        try:
            self._journal.append(block)
        except OSError as error:
            raise self._kept(error) from None
        self.failed += block.failed

    def __exit__(self, kind: type[BaseException] | None, *error: object) -> None:
        try:
            if kind is None:
                if not self._done:
                    self._complete()
                self._journal.remove()
        finally:
            self._journal.close()

    def _begin(self, target: Path) -> None:
        """Find out what is there already, and what is still missing."""
        failed = None
        if self._resume and not self._force and target.exists():
            failed = failed_cases(target, self._frame)
            if failed is None:
                check_target(self._path)
        self._done = failed is not None
        if failed is None:
            fixed = self._journal.begin(journal_head(self._frame, self._numerics), self.cut)
            self._frame = replace(self._frame, attributes=self._frame.attributes | fixed)
            self.missing = self._journal.missing
            failed = sum(self._journal.failed.values())
        lacking = sum(stop - start for start, stop in map(self.cut.span, self.missing))
        self.failed, self.resumed = failed, self._frame.cases - lacking

    def _complete(self) -> None:
        if lacking := len(self._journal.missing):
            raise ValueError(f"the study lacks {lacking} blocks")
        blocks = map(self._journal.block, range(len(self.cut)))
        try:
            self._journal.check()
            write_blocks(self._frame, self._path, blocks, self._force, self._temporary)
        except CannotCreate:
            raise
        except OSError as error:
            raise self._kept(error) from None

    def _kept(self, error: OSError) -> StorageError:
        if not self._journal.failed:
            return storage_error(self._path, error)
        reason = getattr(error, "strerror", None) or error
        return StorageError(
            f"writing {self._path} failed: {reason}; what was finished is kept in "
            f"{self._journal.path.name}: free space, then continue with resume=True (--resume)"
        )


def write_study(study: Study, path: str | PathLike[str], *, force: bool = False) -> None:
    """Write a study that is held in memory; errors as `StudyWriter`."""
    cut = blocks_of(study)
    flat = {name: values.reshape(-1) for name, values in study.results.items()}
    spans = (slice(*cut.span(number)) for number in range(len(cut)))
    blocks = (
        encode_block(cut, number, {name: values[span] for name, values in flat.items()})
        for number, span in enumerate(spans)
    )
    try:
        write_blocks(study, path, blocks, force)
    except EscapementError:
        raise
    except OSError as error:
        raise storage_error(path, error) from None


def write_blocks(
    frame: Study,
    path: str | PathLike[str],
    blocks: Iterable[Block],
    force: bool,
    temporary: Path | None = None,
) -> None:
    """Write all blocks of a study, and put the file in place.

    It runs in a thread of its own, where Ctrl-C never strikes HDF5; an interruption ends the
    thread before its next block.

    Raises
    ------
    CannotCreate, StorageError
        As `PendingFile`.
    OSError
        When a block cannot be read or written.
    """
    stop = threading.Event()
    with ThreadPoolExecutor(1, thread_name_prefix="escapement-store") as thread:
        work = thread.submit(_write_file, frame, path, blocks, force, temporary, stop)
        try:
            work.result()
        except BaseException:
            stop.set()
            raise


def _write_file(
    frame: Study,
    path: str | PathLike[str],
    blocks: Iterable[Block],
    force: bool,
    temporary: Path | None,
    stop: threading.Event,
) -> None:
    pending = PendingFile(path, force, temporary)
    try:
        _write_image(DeferredErrorFile(pending.handle), frame, blocks, stop)
        if not stop.is_set():
            pending.place()
    except RuntimeError as error:  # HDF5 tells a failed device by it
        raise OSError(errno.EIO, str(error)) from None
    finally:
        pending.discard()


def _write_image(
    target: DeferredErrorFile, frame: Study, blocks: Iterable[Block], stop: threading.Event
) -> None:
    """The bytes of a study file; raises OSError soon after the disk has failed."""
    import h5py

    cut = blocks_of(frame)
    with h5py.File(target, "w") as hdf5:
        results = _create_datasets(hdf5, frame, cut.tile)
        for block in blocks:
            if target.error is not None or stop.is_set():
                break
            for dataset, data in zip(results, block.chunks, strict=True):
                dataset.id.write_direct_chunk(cut.offset(block.number), data)
    if target.error is not None:
        raise target.error


def _create_datasets(hdf5: Any, frame: Study, tile: tuple[int, ...]) -> list[Any]:
    """Everything but results; returns their datasets, which are empty."""
    import h5py

    hdf5.attrs.update(frame.attributes)
    text = json.dumps(frame.configuration, allow_nan=False)
    dataset = hdf5.create_dataset("configuration", data=text, dtype=h5py.string_dtype())
    dataset.attrs.update(units="1", long_name="configuration of the study, JSON")
    for name, values in frame.axes.items():
        _create_line(hdf5, frame, name, values).make_scale(name)
    for name, values in frame.sampled.items():
        line = _create_line(hdf5, frame, name, values)
        line.dims[0].attach_scale(hdf5[[*frame.axes][-1]])
    return [_create_result(hdf5, frame, name, tile) for name in RESULTS]


def _create_line(hdf5: Any, frame: Study, name: str, values: NDArray[Any]) -> Any:
    """A dataset over one dimension: values of an axis, or of a sampled parameter."""
    chunks = (min(values.size, CELLS),)
    kind = "<i8" if values.dtype.kind == "i" else "<f8"
    line = hdf5.create_dataset(name, data=values, dtype=kind, chunks=chunks, **_FILTERS)
    line.attrs["units"] = frame.units[name]
    line.attrs["long_name"] = frame.long_names[name]
    return line


def _create_result(hdf5: Any, frame: Study, name: str, tile: tuple[int, ...]) -> Any:
    kind = RESULTS[name].dtype
    dataset = hdf5.create_dataset(name, frame.shape, kind, chunks=tile, **_FILTERS)
    dataset.attrs["units"] = frame.units[name]
    dataset.attrs["long_name"] = frame.long_names[name]
    if frame.sampled:
        dataset.attrs["coordinates"] = " ".join(frame.sampled)  # as the CF conventions have it
    if name == "status":
        dataset.attrs["flag_values"] = np.array([member.value for member in Status], "u1")
        dataset.attrs["flag_meanings"] = " ".join(member.label for member in Status)
    for dimension, axis in zip(dataset.dims, frame.axes, strict=True):
        dimension.attach_scale(hdf5[axis])
    return dataset
