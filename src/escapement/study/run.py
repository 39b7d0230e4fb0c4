"""Running a planned study: scenes first, then blocks, on threads or on a Dask cluster."""

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from os import PathLike
from typing import Any, Self, TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from escapement import __version__, validate
from escapement.errors import InvalidValue
from escapement.progress import Progress
from escapement.study.block import Block, Tiling, blocks_of, encode_block
from escapement.study.identity import numerics
from escapement.study.plan import StudyPlan
from escapement.study.pool import Pool, in_cluster, in_threads
from escapement.study.reader import read_study
from escapement.study.result import RESULTS, SCHEMA_VERSION, Study, count_failed
from escapement.study.scenes import (
    Columns,
    SceneFigures,
    SharedScenes,
    evaluate,
    shared_scenes,
    solve_scenes,
)
from escapement.study.writer import StudyWriter

_SLICE = 256, 16384  # fewest and most scenes solved at a time: up to 0.2 s

Report = Callable[[int, int, int], object]


class Options(TypedDict, total=False):
    """How a study is run; what each means is said in `escapement.sweep`."""

    force: bool
    resume: bool
    progress: Report | bool | None
    workers: int
    scheduler: Any


@dataclass(frozen=True)
class Tally:
    """How a study went: its cases, those without an answer, those it had already."""

    cases: int
    failed: int
    resumed: int = 0


@dataclass(frozen=True)
class Work:
    """All that is needed to solve any block of a study, wherever that is done."""

    plan: StudyPlan
    cut: Tiling
    numerics: str
    shared: SharedScenes | None = None

    def columns(self, number: int) -> Columns:
        """Results of a block."""
        if self.numerics != numerics():
            raise InvalidValue(
                f"workers must have the version of the client, numerics {self.numerics}, got "
                f"{numerics()}; install the same geneva-escapement everywhere"
            )
        return evaluate(self.plan, *self.cut.span(number), self.shared)


def solve_block(work: Work, number: int) -> Block:
    """A task: a block as files hold it."""
    return encode_block(work.cut, number, work.columns(number))


def solve_columns(work: Work, number: int) -> tuple[int, Columns]:
    """A task: the results of a block as arrays."""
    return number, work.columns(number)


def solve_slice(plan: StudyPlan, part: tuple[int, NDArray[np.int64]]) -> tuple[int, SceneFigures]:
    """A task: the scenes of some cases, and where they belong."""
    start, cases = part
    return start, solve_scenes(plan, cases)


def run_plan(
    plan: StudyPlan, path: str | PathLike[str] | None = None, **options: Unpack[Options]
) -> Study:
    """Run a planned study and return its results; arguments and errors as `escapement.sweep`."""
    if path is not None:
        write_plan(plan, path, **options)
        return read_study(path)
    if (scheduler := options.get("scheduler")) is not None:
        raise validate.fail("scheduler", "left out without a path", scheduler, "name a file")
    memory = _Memory(frame_of(plan))
    _run(plan, memory, solve_columns, options)
    return memory.study


def write_plan(plan: StudyPlan, path: str | PathLike[str], **options: Unpack[Options]) -> Tally:
    """Run a planned study into a file, in memory that does not grow with its cases.

    Arguments and errors as `escapement.sweep`.
    """
    version = numerics() + plan.fingerprint
    keep = {"force": options.get("force", False), "resume": options.get("resume", False)}
    writer = StudyWriter(path, frame_of(plan), numerics=version, **keep)
    return _run(plan, writer, solve_block, options)


class _Memory:
    """What `StudyWriter` is to a file, for results that stay in memory."""

    def __init__(self, frame: Study) -> None:
        self._frame, self.cut = frame, blocks_of(frame)
        self._results = {name: np.empty(frame.cases, r.dtype) for name, r in RESULTS.items()}
        self.missing: Iterable[int] = range(len(self.cut))
        self.resumed = self.failed = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        """There is nothing to put away."""

    def add(self, solved: tuple[int, Columns]) -> None:
        """Keep the results of a block."""
        number, columns = solved
        for name, values in self._results.items():
            values[slice(*self.cut.span(number))] = columns[name]
        self.failed += count_failed(columns["status"])

    @property
    def study(self) -> Study:
        shaped = {name: values.reshape(self._frame.shape) for name, values in self._results.items()}
        return replace(self._frame, results=shaped)


def _run(plan: StudyPlan, keeper: Any, task: Callable[..., Any], options: Options) -> Tally:
    """Solve what a keeper lacks, and give it block after block."""
    workers = validate.integer("workers", options.get("workers", 1), 1, "give a number of threads")
    plan.check_mechanism()
    with keeper:
        scheduler = options.get("scheduler") if keeper.missing else None
        pool = in_threads(workers) if scheduler is None else in_cluster(scheduler, workers)
        with pool as here, _shown(options.get("progress"), keeper.resumed) as report:
            done = keeper.resumed
            report(done, plan.cases, keeper.failed)
            if keeper.missing:
                work = Work(plan, keeper.cut, numerics(), solved_scenes(plan, here))
                for solved in here.completed(task, work, keeper.missing):
                    keeper.add(solved)
                    start, stop = keeper.cut.span(solved[0])
                    done += stop - start
                    report(done, plan.cases, keeper.failed)
    return Tally(plan.cases, keeper.failed, keeper.resumed)


def solved_scenes(plan: StudyPlan, pool: Pool) -> SharedScenes | None:
    """The scenes that blocks have in common, solved; None where each block solves its own."""
    sharing = shared_scenes(plan)
    if sharing is None:
        return None
    size = sharing.cases.size
    step = min(max(size // 64, _SLICE[0]), _SLICE[1])
    figures, status = np.empty((6, size)), np.empty(size, dtype=np.uint8)
    parts = ((start, sharing.cases[start : start + step]) for start in range(0, size, step))
    for start, (numbers, outcomes) in pool.completed(solve_slice, plan, parts):
        figures[:, start : start + step], status[start : start + step] = numbers, outcomes
    return SharedScenes(sharing, figures, status)


def frame_of(plan: StudyPlan) -> Study:
    """The study of a plan before it has results."""
    varied = (*plan.dimensions, *plan.sampled)
    units = {name: plan.unit(name) for name in varied}
    names = {name: plan.long_name(name) for name in varied}
    return Study(
        axes=plan.dimensions,
        sampled=plan.sampled,
        results={},
        units=units | {name: result.units for name, result in RESULTS.items()},
        long_names=names | {name: result.long_name for name, result in RESULTS.items()},
        configuration=plan.configuration,
        attributes={
            "title": plan.title,
            "schema_version": SCHEMA_VERSION,
            "package_version": __version__,
            "engine": plan.solver.engine,
            "rtol": plan.solver.tolerance,
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
        },
    )


def _shown(progress: Report | bool | None, before: int) -> AbstractContextManager[Report]:
    """Where progress goes: to standard error, to the caller, or nowhere."""
    if progress is True:
        return Progress(before=before)
    return nullcontext(progress or (lambda done, total, failed: None))
