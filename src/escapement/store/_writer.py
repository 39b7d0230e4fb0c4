"""Writing a study in bounded memory, case after case."""

from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from os import PathLike
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from escapement.errors import EscapementError
from escapement.store._chunks import tiling
from escapement.store._image import StudyImage
from escapement.store._study import RESULTS, Study
from escapement.store._target import PendingFile, storage_error


class StudyWriter:
    """Writes the results of a study in the order of its cases.

    The file appears under its name when all cases are written, and not before:
    leaving the `with` block early, for whatever reason, leaves nothing behind.
    Compressing and writing go on beside the caller, one chunk at a time.

    Parameters
    ----------
    path : path
        File to create.
    frame : Study
        Everything but the results, which are ignored.
    force : bool
        Replace an existing file, once the new one is complete.

    Raises
    ------
    CannotCreate
        On entering, when the file may not be created.
    StorageError
        When the disk is full or fails.
    """

    def __init__(self, path: str | PathLike[str], frame: Study, *, force: bool = False) -> None:
        self._path, self._frame, self._force = path, frame, force
        self._tiling = tiling(frame.shape)
        self._chunk, self._filled = 0, 0
        self._buffers = self._new_buffers()
        self._last: Future[None] | None = None
        self._image: StudyImage | None = None

    def __enter__(self) -> Self:
        self._pending = PendingFile(self._path, self._force)
        # HDF5 is entered from this one thread only, where Ctrl-C never strikes.
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="escapement-store")
        try:
            self._submit(self._create)
        except BaseException:
            self._leave()
            raise
        return self

    def append(self, block: Mapping[str, NDArray[Any]]) -> None:
        """Add the results of the next cases.

        Parameters
        ----------
        block : Mapping of ndarray, shape (n,)
            One array for each of `RESULTS`, n any number of cases.
        """
        count, done = len(block["status"]), 0
        if count > self._frame.cases - self._written:
            raise ValueError(f"{count} cases are more than the study still lacks")
        while done < count:
            start, stop = self._tiling.span(self._chunk)
            step = min(stop - start - self._filled, count - done)
            for name, buffer in self._buffers.items():
                buffer[self._filled : self._filled + step] = block[name][done : done + step]
            self._filled += step
            done += step
            if self._filled == stop - start:
                self._submit(self._store, self._chunk, self._buffers, self._filled)
                self._buffers = self._new_buffers()
                self._chunk, self._filled = self._chunk + 1, 0

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        try:
            if kind is None:
                if self._written < self._frame.cases:
                    raise ValueError(f"the study lacks {self._frame.cases - self._written} cases")
                self._submit(self._complete)
                self._wait()
        finally:
            self._leave()

    @property
    def _written(self) -> int:
        if self._chunk == len(self._tiling):
            return self._frame.cases
        return self._tiling.span(self._chunk)[0] + self._filled

    def _new_buffers(self) -> dict[str, NDArray[Any]]:
        cells = self._tiling.cells
        return {name: np.empty(cells, result.dtype) for name, result in RESULTS.items()}

    def _submit(self, work: Callable[..., None], *arguments: Any) -> None:
        """Hand work to the thread once the work before it is done, or its error told."""
        self._wait()
        self._last = self._thread.submit(self._guarded, work, *arguments)

    def _wait(self) -> None:
        if self._last is not None:
            self._last.result()

    def _guarded(self, work: Callable[..., None], *arguments: Any) -> None:
        try:
            work(*arguments)
        except EscapementError:
            raise
        except (OSError, RuntimeError) as error:  # HDF5 tells a failed device by either
            raise storage_error(self._path, error) from None

    def _create(self) -> None:
        self._image = StudyImage(self._pending.handle, self._frame, self._tiling)

    def _store(self, chunk: int, columns: dict[str, NDArray[Any]], count: int) -> None:
        assert self._image is not None
        self._image.store(chunk, columns, count)

    def _complete(self) -> None:
        assert self._image is not None
        self._image.close()
        self._pending.place()

    def _leave(self) -> None:
        """Close everything; what is not in place by now goes."""
        self._thread.submit(self._release)
        self._thread.shutdown(wait=True)

    def _release(self) -> None:
        with suppress(OSError, RuntimeError):  # told already, or given up anyway
            if self._image is not None:
                self._image.close()
        self._pending.discard()


def write_study(study: Study, path: str | PathLike[str], *, force: bool = False) -> None:
    """Write a study that is held in memory; errors as `StudyWriter`."""
    with StudyWriter(path, study, force=force) as writer:
        writer.append({name: values.reshape(-1) for name, values in study.results.items()})
