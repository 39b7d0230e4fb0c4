"""Running a planned study: every case solved, into memory or into a file."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from os import PathLike
from typing import Any

import numpy as np

from escapement import __version__, validate
from escapement.progress import Progress
from escapement.study.block import Block, blocks_of, encode_block
from escapement.study.cluster import connect, in_cluster
from escapement.study.evaluate import Evaluator, in_threads
from escapement.study.identity import numerics
from escapement.study.plan import StudyPlan
from escapement.study.reader import read_study
from escapement.study.result import RESULTS, SCHEMA_VERSION, Study, count_failed
from escapement.study.writer import StudyWriter

Report = Callable[[int, int, int], object]


@dataclass(frozen=True)
class Tally:
    """How a study went: its cases, those without an answer, those it had already."""

    cases: int
    failed: int
    resumed: int = 0


def run_plan(
    plan: StudyPlan,
    path: str | PathLike[str] | None = None,
    *,
    force: bool = False,
    resume: bool = False,
    progress: Report | bool | None = None,
    workers: int = 1,
    scheduler: Any = None,
) -> Study:
    """Run a planned study and return its results; arguments and errors as `escapement.sweep`."""
    if path is not None:
        write_plan(
            plan,
            path,
            force=force,
            resume=resume,
            progress=progress,
            workers=workers,
            scheduler=scheduler,
        )
        return read_study(path)
    if scheduler is not None:
        raise validate.fail("scheduler", "left out without a path", scheduler, "name a file")
    frame, count = frame_of(plan), _count(workers)
    plan.check_mechanism()
    results = {name: np.empty(plan.cases, result.dtype) for name, result in RESULTS.items()}
    cut, evaluate = blocks_of(frame), Evaluator(plan)

    def work(number: int) -> tuple[int, int]:
        start, stop = cut.span(number)
        block = evaluate(start, stop)
        for name, values in results.items():
            values[start:stop] = block[name]
        return stop - start, count_failed(block["status"])

    done = failed = 0
    solved = in_threads(work, range(len(cut)), count, evaluate.stop)
    with _shown(progress) as report, closing(solved) as blocks:
        report(done, plan.cases, failed)
        for cases, bad in blocks:
            done, failed = done + cases, failed + bad
            report(done, plan.cases, failed)
    shaped = {name: values.reshape(plan.shape) for name, values in results.items()}
    return replace(frame, results=shaped)


def write_plan(
    plan: StudyPlan,
    path: str | PathLike[str],
    *,
    force: bool = False,
    resume: bool = False,
    progress: Report | bool | None = None,
    workers: int = 1,
    scheduler: Any = None,
) -> Tally:
    """Run a planned study into a file, in memory that does not grow with its cases.

    Arguments and errors as `escapement.sweep`.
    """
    count = _count(workers)
    plan.check_mechanism()
    version = numerics() + plan.fingerprint
    writer = StudyWriter(path, frame_of(plan), numerics=version, force=force, resume=resume)

    with (
        writer,
        _blocks(plan, writer, count, scheduler) as blocks,
        _shown(progress, writer.resumed) as report,
    ):
        done = writer.resumed
        report(done, plan.cases, writer.failed)
        for block in blocks:
            writer.add(block)
            done += block.cases
            report(done, plan.cases, writer.failed)
    return Tally(plan.cases, writer.failed, writer.resumed)


@contextmanager
def _blocks(
    plan: StudyPlan, writer: StudyWriter, workers: int, scheduler: Any
) -> Iterator[Iterable[Block]]:
    """What a study still lacks, block after block, from threads or from a cluster."""
    if scheduler is None or not writer.missing:
        evaluate = Evaluator(plan)

        def work(number: int) -> Block:
            return encode_block(writer.cut, number, evaluate(*writer.cut.span(number)))

        with closing(in_threads(work, writer.missing, workers, evaluate.stop)) as blocks:
            yield blocks
        return
    with (
        connect(scheduler, workers) as client,
        closing(in_cluster(plan, writer.cut, writer.missing, client)) as blocks,
    ):
        yield blocks


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


def _count(workers: int) -> int:
    return validate.integer("workers", workers, 1, "give the number of threads")


def _shown(progress: Report | bool | None, before: int = 0) -> AbstractContextManager[Report]:
    """Where progress goes: to standard error, to the caller, or nowhere."""
    if progress is True:
        return Progress(before=before)
    return nullcontext(progress or (lambda done, total, failed: None))
