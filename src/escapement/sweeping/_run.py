"""Running a study: every case of a grid or a sample, into memory or into a file."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement import __version__, _validate
from escapement.configuration import StudyPlan, plan_from
from escapement.model import Escapement
from escapement.progress import Progress
from escapement.solver import DEFAULT_ENGINE
from escapement.store import (
    RESULTS,
    SCHEMA_VERSION,
    Block,
    Study,
    StudyWriter,
    blocks_of,
    count_failed,
    encode_block,
    read_study,
)
from escapement.sweeping._blocks import in_threads
from escapement.sweeping._cluster import connect, in_cluster
from escapement.sweeping._evaluate import Evaluator
from escapement.sweeping._numerics import numerics

Report = Callable[[int, int, int], object]


@dataclass(frozen=True)
class Tally:
    """How a study went: its cases, those without an answer, those it had already."""

    cases: int
    failed: int
    resumed: int = 0


def sweep(
    escapement: Escapement,
    *,
    sample: Mapping[str, Any] | None = None,
    engine: str = DEFAULT_ENGINE,
    rtol: float | None = None,
    initial_speed: ArrayLike = 0.0,
    path: str | PathLike[str] | None = None,
    force: bool = False,
    resume: bool = False,
    progress: Report | bool | None = None,
    workers: int = 1,
    scheduler: Any = None,
    **axes: ArrayLike,
) -> Study:
    """Figures of merit over a grid of parameters, or a sample of them.

    Parameters
    ----------
    escapement : Escapement
        The nominal design.
    sample : Mapping, optional
        Parameters that vary together, at every point of the grid: `method`
        ("latin-hypercube", "sobol" or "list"), `size`, `seed` (default 0), and a
        distribution [SI] of each parameter, such as {"relative_tolerance": 0.05} or
        {"low": 0.2, "high": 0.3}; with "list" its values, case by case.
    engine, rtol : optional
        As for `terminal`.
    initial_speed : float or array
        Driver speed at the first pin entry [rad/s]; an array is the last axis.
    path : path, optional
        HDF5 file to write as well.
    force : bool
        Replace an existing file; without `resume`, drop what was kept of an
        unfinished run.
    resume : bool
        Compute only what an unfinished run of the same study did not finish.
    progress : bool or callable, optional
        True shows it on standard error; a callable gets (done, total, failed).
    workers : int
        Threads that compute; with a local cluster, processes.
    scheduler : str or distributed.Client, optional
        A Dask cluster to compute on, needs `path`: "local", an address, or a client.
    **axes : array
        Values [SI] of any of friction or efficiency, torque, load_torque, driver_inertia,
        follower_inertia and the numbers of the mechanism (slots, pins); the
        order is that of the results' dimensions. A sample adds the last one, `case`.

    Returns
    -------
    Study
        A case that has no answer holds NaN, and a status that says why.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    CannotCreate, StorageError
        As `StudyWriter`.
    """
    if not (path is None or isinstance(path, str | PathLike)):
        raise _validate.fail("path", "the name of a file", path, "leave it out to write none")
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise _validate.fail("progress", "true, false or a function", progress, "leave it out")
    if np.ndim(initial_speed) > 0:
        axes["initial_speed"], initial_speed = initial_speed, 0.0
    else:
        remedy = "give the driver speed in rad/s"
        initial_speed = _validate.non_negative("initial_speed", initial_speed, remedy)
    plan = plan_from(
        escapement,
        axes,
        sample=sample,
        initial_speed=initial_speed,
        engine=engine,
        rtol=rtol,
    )
    return run_plan(
        plan,
        path,
        force=force,
        resume=resume,
        progress=progress,
        workers=workers,
        scheduler=scheduler,
    )


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
    """Run a planned study and return its results; arguments and errors as `sweep`."""
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
        raise _validate.fail("scheduler", "left out without a path", scheduler, "name a file")
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

    Arguments and errors as `sweep`.
    """
    count = _count(workers)
    plan.check_mechanism()
    version = numerics() + ("" if plan.sample is None else plan.sample.fingerprint)
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
    sampled = {} if plan.sample is None else plan.sample.values
    varied = (*plan.dimensions, *sampled)
    units = {name: plan.unit(name) for name in varied}
    names = {name: plan.long_name(name) for name in varied}
    return Study(
        axes=plan.dimensions,
        sampled=sampled,
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
    return _validate.integer("workers", workers, 1, "give the number of threads")


def _shown(progress: Report | bool | None, before: int = 0) -> AbstractContextManager[Report]:
    """Where progress goes: to standard error, to the caller, or nowhere."""
    if progress is True:
        return Progress(before=before)
    return nullcontext(progress or (lambda done, total, failed: None))
