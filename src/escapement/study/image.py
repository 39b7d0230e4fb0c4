"""The HDF5 file of a study: its layout, and the thread that makes it of finished blocks."""

import errno
import json
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from itertools import takewhile
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from escapement.files.atomic import PendingFile
from escapement.files.deferred_errors import DeferredErrorFile
from escapement.status import Status
from escapement.study.block import CELLS, Block, Tiling, blocks_of
from escapement.study.result import RESULTS, Study

_FILTERS: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}


class StudyImage:
    """A study file under construction on an open, empty file.

    Every method raises OSError as soon as the disk has failed; closing never
    leaves HDF5 in a state it cannot leave.

    Parameters
    ----------
    handle : binary file
        Where the bytes go.
    frame : Study
        Everything but the results.
    tiling : Tiling
        How the results are cut into chunks.
    """

    def __init__(self, handle: BinaryIO, frame: Study, tiling: Tiling) -> None:
        import h5py

        self._tiling = tiling
        self._target = DeferredErrorFile(handle)
        self._hdf5 = h5py.File(self._target, "w")
        try:
            _write_root(self._hdf5, frame)
            for name, values in frame.axes.items():
                _write_line(self._hdf5, frame, name, values).make_scale(name)
            for name, values in frame.sampled.items():
                line = _write_line(self._hdf5, frame, name, values)
                line.dims[0].attach_scale(self._hdf5[[*frame.axes][-1]])
            self._results = [
                _create_result(self._hdf5, frame, name, tiling.tile) for name in RESULTS
            ]
            self._check()
        except BaseException:
            self._hdf5.close()
            raise

    def store(self, block: Block) -> None:
        """Write one chunk of every result."""
        offset = self._tiling.offset(block.number)
        for dataset, data in zip(self._results, block.chunks, strict=True):
            dataset.id.write_direct_chunk(offset, data)
        self._check()

    def close(self) -> None:
        """Complete the file."""
        self._hdf5.close()
        self._check()

    def _check(self) -> None:
        if self._target.error is not None:
            raise self._target.error


def write_blocks(
    frame: Study,
    path: str | PathLike[str],
    blocks: Iterator[Block],
    force: bool,
    stop: threading.Event,
    temporary: Path | None,
) -> None:
    """Write all blocks of a study, in order, and put the file in place.

    Run it in a thread of its own, where Ctrl-C never strikes HDF5; once `stop` is
    set it ends without putting anything in place.

    Raises
    ------
    CannotCreate, StorageError
        As `PendingFile`.
    OSError
        When a block cannot be read or written.
    """
    pending = PendingFile(path, force, temporary)
    try:
        _write_image(pending.handle, frame, takewhile(lambda _: not stop.is_set(), blocks))
        if not stop.is_set():
            pending.place()
    except RuntimeError as error:  # HDF5 tells a failed device by it
        raise OSError(errno.EIO, str(error)) from None
    finally:
        pending.discard()


def _write_image(handle: BinaryIO, frame: Study, blocks: Iterator[Block]) -> None:
    image = StudyImage(handle, frame, blocks_of(frame))
    try:
        for block in blocks:
            image.store(block)
    except BaseException:
        with suppress(OSError):  # told already
            image.close()
        raise
    image.close()


def _write_root(hdf5: Any, frame: Study) -> None:
    import h5py

    for name, value in frame.attributes.items():
        hdf5.attrs[name] = value
    text = json.dumps(frame.configuration, allow_nan=False)
    dataset = hdf5.create_dataset("configuration", data=text, dtype=h5py.string_dtype())
    dataset.attrs["units"] = "1"
    dataset.attrs["long_name"] = "configuration of the study, JSON"


def _write_line(hdf5: Any, frame: Study, name: str, values: NDArray[Any]) -> Any:
    """A dataset over one dimension: values of an axis, or of a sampled parameter."""
    chunks = (min(values.size, CELLS),)
    kind = "<i8" if values.dtype.kind == "i" else "<f8"
    line = hdf5.create_dataset(name, data=values, dtype=kind, chunks=chunks, **_FILTERS)
    line.attrs["units"] = frame.units[name]
    line.attrs["long_name"] = frame.long_names[name]
    return line


def _create_result(hdf5: Any, frame: Study, name: str, tile: tuple[int, ...]) -> Any:
    result = RESULTS[name]
    dataset = hdf5.create_dataset(name, frame.shape, result.dtype, chunks=tile, **_FILTERS)
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


class Assembly:
    """A thread that writes blocks in order, each as soon as it is there.

    Parameters
    ----------
    frame, path, force, temporary :
        As for `write_blocks`.
    count : int
        Blocks of the study.
    fetch : callable
        A block by its number, None where it is not there yet.
    """

    def __init__(
        self,
        frame: Study,
        path: str | PathLike[str],
        force: bool,
        temporary: Path | None,
        count: int,
        fetch: Callable[[int], Block | None],
    ) -> None:
        self._count, self._fetch = count, fetch
        self._stop, self._news = threading.Event(), threading.Condition()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="escapement-store")
        self._work = self._thread.submit(
            write_blocks, frame, path, self._in_order(), force, self._stop, temporary
        )

    def look(self) -> None:
        """Tell that another block is there; raises what stopped the thread, if it did."""
        with self._news:
            self._news.notify()
        if self._work.done():
            self._work.result()

    def finish(self) -> None:
        """Wait for the file to be in place; all blocks must be there."""
        self.look()
        self._work.result()

    def close(self) -> None:
        """End the thread, wherever it is: what is not in place by now never will be."""
        self._stop.set()
        with self._news:
            self._news.notify()
        self._thread.shutdown(wait=True)

    def _in_order(self) -> Iterator[Block]:
        for number in range(self._count):
            with self._news:
                while (block := self._fetch(number)) is None and not self._stop.is_set():
                    self._news.wait()
            if block is None:
                return
            yield block
