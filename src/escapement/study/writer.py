"""Writing a study in bounded memory, so that nothing that was finished is ever lost."""

from collections.abc import Iterator
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Self

from escapement.errors import CannotCreate, EscapementError, StorageError
from escapement.files.atomic import check_target, creation_error, storage_error
from escapement.study.block import Block, blocks_of, encode_block
from escapement.study.identity import check_same, journal_head
from escapement.study.image import Assembly
from escapement.study.journal import Journal
from escapement.study.reader import failed_cases
from escapement.study.result import Study


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
        try:
            self._journal = Journal(partial_path(target))
        except OSError as error:
            raise self._not_begun(error) from None
        try:
            self._begin(target)
        except OSError as error:
            self._journal.close()
            raise self._not_begun(error) from None
        except BaseException:
            self._journal.close()
            raise
        return self

    def add(self, block: Block) -> None:
        """Keep a finished block."""
        try:
            self._journal.append(block)
            self.failed += block.failed
            self._assembly.look()
        except CannotCreate:
            raise
        except OSError as error:
            raise self._kept(error) from None

    def __exit__(self, kind: type[BaseException] | None, *error: object) -> None:
        try:
            if kind is None:
                if not self._done:
                    self._complete()
                self._journal.remove()
        finally:
            if not self._done:
                self._assembly.close()
            self._journal.close()

    def _begin(self, target: Path) -> None:
        """Find out what is there already, and what is still missing."""
        self._journal.sign()
        failed = None
        if self._resume and not self._force and target.exists():
            failed = failed_cases(target, self._frame)
            if failed is None:
                check_target(self._path)
        self._done = failed is not None
        if failed is None:
            self._open_journal()
            self.missing = self._journal.missing.tolist()
            failed = self._journal.failed
        lacking = sum(stop - start for start, stop in map(self.cut.span, self.missing))
        self.failed, self.resumed = failed, self._frame.cases - lacking
        if not self._done:
            self._assembly = Assembly(
                *(self._frame, self._path, self._force, self._journal.temporary),
                *(len(self.cut), self._journal.block),
            )

    def _open_journal(self) -> None:
        journal, head = self._journal, journal_head(self._frame, self._numerics)
        if self._resume:
            if journal.head is not None:
                check_same(self._path, journal.head, head)
                attributes = self._frame.attributes | journal.head["fixed"]
                self._frame = replace(self._frame, attributes=attributes)
            journal.find(head, self.cut)
            # blocks of this very study survive a damaged head
            if journal.head is not None or journal.missing.size < len(self.cut):
                journal.carry_on()
                return
        if not journal.ours:
            raise CannotCreate(
                f"output {self._path} must have {journal.path.name} to itself, got a file that "
                "is no partial result; move it away"
            )
        if not self._force and not self._resume and journal.holds_blocks:
            raise CannotCreate(
                f"output {self._path} must not have partial results yet, got {journal.path.name}; "
                "continue with resume=True or start over with force=True"
            )
        journal.start(head, self.cut)

    def _complete(self) -> None:
        if self._journal.missing.size:
            raise ValueError(f"the study lacks {self._journal.missing.size} blocks")
        try:
            self._journal.sync()
            self._assembly.finish()
        except CannotCreate:
            raise
        except OSError as error:
            raise self._kept(error) from None

    def _not_begun(self, error: OSError) -> EscapementError:
        if isinstance(error, EscapementError):
            return error
        return creation_error(self._path, error)

    def _kept(self, error: OSError) -> StorageError:
        if not self._journal.blocks:
            return storage_error(self._path, error)
        reason = getattr(error, "strerror", None) or error
        return StorageError(
            f"writing {self._path} failed: {reason}; what was finished is kept in "
            f"{self._journal.path.name}: free space, then continue with resume=True"
        )


def write_study(study: Study, path: str | PathLike[str], *, force: bool = False) -> None:
    """Write a study that is held in memory; errors as `StudyWriter`."""
    cut = blocks_of(study)
    flat = {name: values.reshape(-1) for name, values in study.results.items()}

    def blocks() -> Iterator[Block]:
        for number in range(len(cut)):
            span = slice(*cut.span(number))
            yield encode_block(cut, number, {name: values[span] for name, values in flat.items()})

    ready = blocks()
    assembly = Assembly(study, path, force, None, len(cut), lambda _: next(ready))
    try:
        assembly.finish()
    except EscapementError:
        raise
    except OSError as error:
        raise storage_error(path, error) from None
    finally:
        assembly.close()
