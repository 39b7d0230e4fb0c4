"""Running a study into memory or into a file, on threads or on a Dask cluster."""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from datetime import UTC, datetime
from typing import Any, NamedTuple, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from escapement import __version__
from escapement.base import validate
from escapement.base.files import AnyPath
from escapement.base.progress import Progress
from escapement.constant_speed.index_case import IndexCase
from escapement.engines.solver import Solver, choose_solver
from escapement.model.escapement import Escapement
from escapement.numerics.interpreted import compile_from_now_on, interprets
from escapement.study import table_files
from escapement.study.block import Block, blocks_of
from escapement.study.parse import plan_from
from escapement.study.plan import StudyPlan
from escapement.study.pool import Pool, in_cluster, in_threads
from escapement.study.reader import read_study
from escapement.study.result import Study
from escapement.study.scenes import scene_shape, together
from escapement.study.solving import Work, mixed, numerics, solve_block, solved_scenes
from escapement.study.stored import LAYOUT
from escapement.study.writer import Unfinished, study_writer

FEW = 64
"""So many different scenes take less time in plain Python than compiling does."""

Report = Callable[[int, int, int], object]


class Options(TypedDict, total=False):
    """Options of a run; `sweep` explains each."""

    force: bool
    resume: bool
    progress: Report | bool | None
    workers: int
    scheduler: Any


class Tally(NamedTuple):
    """Summary of a run: numbers of cases, of failed ones, and of those from an earlier run."""

    cases: int
    failed: int
    resumed: int = 0


def sweep(
    escapement: Escapement | IndexCase,
    *,
    sample: Mapping[str, Any] | None = None,
    engine: str | None = None,
    rtol: float | None = None,
    solver: Solver | None = None,
    initial_speed: ArrayLike = 0.0,
    results: Sequence[str] | None = None,
    path: AnyPath | None = None,
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
    escapement : Escapement or IndexingDrive
        The nominal design; of what `index` returns the figures are those of an indexing drive.
    sample : Mapping, optional
        Parameters that vary together, at every point of the grid: `method`
        ("latin-hypercube", "sobol" or "list"), `size`, `seed` (default 0), and a
        distribution [SI] of each parameter, such as {"relative_tolerance": 0.05} or
        {"low": 0.2, "high": 0.3}; with "list" its values, case by case.
    engine, rtol, solver : optional
        As for `terminal`.
    initial_speed : float or array
        Driver speed at the first pin entry [rad/s]; an array is the last axis.
    results : sequence of str, optional
        Figures of merit to keep: names of numbers of `Figures`, or of `IndexingDrive`. Default:
        the velocities, period, rise and settling time; of a drive torque, power and forces.
        Figures that are not named are not computed if that saves time.
    path : path, optional
        File to write as well: HDF5 where its name ends in .h5, .hdf5 or .nc, a table where it
        ends in .csv or .parquet.
    force : bool
        Replace an existing file; without `resume`, delete the partial results of an unfinished
        run.
    resume : bool
        Compute only the blocks that an unfinished run of the same study did not finish.
    progress : bool or callable, optional
        True shows it on standard error; a callable gets (done, total, failed).
    workers : int
        Threads that compute; with a local cluster, processes.
    scheduler : str or distributed.Client, optional
        A Dask cluster to compute on, needs `path`: "local", an address, or a client.
    **axes : array
        Values [SI] of any numbers of the escapement, its inertias (`driver_inertia`,
        `follower_inertia`) and its mechanism (`slots`, `pins`); the order is that of the
        results' dimensions. A sample adds the last one, `case`.

    Returns
    -------
    Study
        A case that could not be computed has NaN, and a status that says why.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    CannotCreate, StorageError, MissingPackage
        As `study_writer`.
    """
    settings = choose_solver(solver, engine, rtol).given
    plan = plan_from(
        escapement, axes, sample=sample, initial_speed=initial_speed, results=results, **settings
    )
    options: Options = {"force": force, "resume": resume, "progress": progress}
    options |= {"workers": workers, "scheduler": scheduler}
    return run_plan(plan, path, **options)


def run_plan(plan: StudyPlan, path: AnyPath | None = None, **options: Unpack[Options]) -> Study:
    """Run a planned study and return its results; arguments and errors as `escapement.sweep`."""
    if path is not None:
        write_plan(plan, path, **options)
        return _read_table(plan, path) if table_files.is_table(path) else read_study(path)
    if (scheduler := options.get("scheduler")) is not None:
        raise validate.fail("scheduler", "left out without a path", scheduler, "name a file")
    _check(plan, options)
    results = {name: np.empty(plan.cases, r.dtype) for name, r in plan.results.items()}
    # the study has views of these arrays
    study = frame_of(plan, {name: values.reshape(plan.shape) for name, values in results.items()})
    cut = blocks_of(study)

    def add(block: Block) -> None:
        span = slice(*cut.span(block.number))
        for name, values in results.items():
            values[span] = block.data[name]

    workers = options.get("workers", 1)
    # starting a thread takes as long as solving many cases
    alone = _in_python(plan) or workers == 1
    pool = nullcontext(Pool()) if alone else in_threads(workers)
    _run(plan, Unfinished(cut, range(len(cut)), 0, 0, add), pool, options, encoded=False)
    return study


def _read_table(plan: StudyPlan, path: AnyPath) -> Study:
    """The study of a plan, with the results of its table."""
    columns, shape = table_files.read_rows(path), plan.shape
    return frame_of(
        plan, {n: columns[n].astype(r.dtype).reshape(shape) for n, r in plan.results.items()}
    )


def write_plan(plan: StudyPlan, path: AnyPath, **options: Unpack[Options]) -> Tally:
    """Run a planned study into a file, in memory that does not grow with its cases.

    Arguments and errors as `escapement.sweep`.
    """
    _check(plan, options)
    version = numerics() + plan.fingerprint
    keep = {"force": options.get("force", False), "resume": options.get("resume", False)}
    workers, scheduler = options.get("workers", 1), options.get("scheduler")
    with study_writer(path, frame_of(plan), numerics=version, **keep) as study:
        here = scheduler is None or not study.missing
        pool: AbstractContextManager[Pool] = nullcontext(Pool())
        if not here:
            pool = in_cluster(scheduler, workers)
        elif not _in_python(plan):
            pool = in_threads(workers)
        return _run(plan, study, pool, options, encoded=True)


def _in_python(plan: StudyPlan) -> bool:
    """Whether a plan has so few scenes that plain Python solves them, in one thread.

    Otherwise kernels are compiled from now on, which must not happen while several threads run.
    """
    few = interprets() and together(plan) and math.prod(scene_shape(plan)) <= FEW
    if not few:
        compile_from_now_on()
    return few


def _check(plan: StudyPlan, options: Options) -> None:
    """Refuse a study of which every case is wrong, before anything is opened or solved."""
    validate.integer("workers", options.get("workers", 1), 1, "give a number of threads")
    plan.check_mechanism()


def _run(
    plan: StudyPlan,
    study: Unfinished,
    pool: AbstractContextManager[Pool],
    options: Options,
    encoded: bool,
) -> Tally:
    """Solve the missing blocks, and keep each as it is finished."""
    done, failed, progress = study.resumed, study.failed, options.get("progress")
    report = progress if callable(progress) else None if progress else (lambda *_: None)
    shown = Progress() if report is None else nullcontext(report)
    with pool as solvers, shown as report:
        if isinstance(report, Progress):
            report.before = done
        report(done, plan.cases, failed)
        counted = report if isinstance(report, Progress) else None
        shared = solved_scenes(plan, solvers, counted) if study.missing else None
        work = Work(plan, study.cut, numerics(), encoded, shared)
        for block in solvers.completed(solve_block, work, mixed(study.missing)):
            study.add(block)
            start, stop = study.cut.span(block.number)
            done, failed = done + stop - start, failed + block.failed
            report(done, plan.cases, failed)
    return Tally(plan.cases, failed, study.resumed)


def frame_of(plan: StudyPlan, results: Mapping[str, NDArray[Any]] | None = None) -> Study:
    """The study of a plan with these results, by default before it has any."""
    every = (*plan.dimensions, *plan.sampled, *plan.fixed, *plan.results)
    units = {name: plan.unit(name) for name in every}
    names = {name: plan.long_name(name) for name in every}
    if results is None:  # only their names and types are known
        results = {name: np.empty(0, result.dtype) for name, result in plan.results.items()}
    attributes = {
        "title": plan.configuration["title"],
        **LAYOUT,
        "package_version": __version__,
        "engine": plan.engine,
        "rtol": plan.solver.tolerance,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    return Study(
        axes=plan.dimensions, results=results, units=units, long_names=names,
        configuration=plan.configuration, attributes=attributes, sampled=plan.sampled,
        fixed=plan.fixed,
    )  # fmt: skip
