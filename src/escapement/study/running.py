"""Running a study: scenes first, then blocks, on threads or on a Dask cluster."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from escapement import __version__
from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.files import AnyPath
from escapement.base.progress import Progress
from escapement.engines.solver import Solver, choose_solver
from escapement.model.escapement import Escapement
from escapement.numerics.interpreted import compile_from_now_on
from escapement.study import scenes, table_files
from escapement.study.block import Block, Tiling, blocks_of, encode_block
from escapement.study.parse import plan_from
from escapement.study.plan import StudyPlan
from escapement.study.pool import Pool, in_cluster, in_threads
from escapement.study.reader import read_study
from escapement.study.result import Study, count_failed
from escapement.study.stored import LAYOUT
from escapement.study.writer import Unfinished, study_writer

_FEWEST, _MOST = 256, 16384  # scenes solved at a time: up to 0.2 s
_GOLDEN = (5.0**0.5 - 1.0) / 2.0
_ROOT = Path(__file__).parents[1]
_ROOMS = ("base", "numerics", "mechanisms", "model", "dynamics", "engines", "study")

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


class Work(NamedTuple):
    """Everything needed to solve any block of a study, in any process."""

    plan: StudyPlan
    cut: Tiling
    numerics: str
    shared: scenes.SharedScenes | None = None

    def columns(self, number: int) -> scenes.Columns:
        """Results of a block."""
        if self.numerics != numerics():
            raise InvalidValue(
                f"workers must have the version of the client, numerics {self.numerics}, got "
                f"{numerics()}; install the same geneva-escapement everywhere"
            )
        return scenes.evaluate(self.plan, *self.cut.span(number), self.shared)


def solve_block(work: Work, number: int) -> Block:
    """A task: a block in the form for files."""
    return encode_block(work.cut, number, work.columns(number))


def solve_columns(work: Work, number: int) -> Block:
    """A task: a block as arrays."""
    columns = work.columns(number)
    return Block(number, count_failed(columns["status"]), columns)


def solve_slice(plan: StudyPlan, part: tuple[int, Any]) -> tuple[int, scenes.SceneFigures]:
    """A task: the scenes of some cases, and their indices."""
    start, cases = part
    return start, scenes.solve_scenes(plan, cases)


def sweep(
    escapement: Escapement,
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
    escapement : Escapement
        The nominal design.
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
        Figures of merit to keep: names of numbers of `Figures`. Default: the velocities,
        period, rise and settling time. Figures that are not named are not computed if that saves
        time.
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
    frame = frame_of(plan)
    cut = blocks_of(frame)
    results = {name: np.empty(frame.cases, r.dtype) for name, r in plan.results.items()}

    def add(block: Block) -> None:
        for name, values in results.items():
            values[slice(*cut.span(block.number))] = block.data[name]

    _run(plan, Unfinished(cut, range(len(cut)), 0, 0, add), solve_columns, options)
    shaped = {name: values.reshape(frame.shape) for name, values in results.items()}
    return replace(frame, results=shaped)


def _read_table(plan: StudyPlan, path: AnyPath) -> Study:
    """The study of a plan, with the results of its table."""
    frame, columns = frame_of(plan), table_files.read_rows(path)
    shaped = {n: columns[n].astype(r.dtype).reshape(frame.shape) for n, r in plan.results.items()}
    return replace(frame, results=shaped)


def write_plan(plan: StudyPlan, path: AnyPath, **options: Unpack[Options]) -> Tally:
    """Run a planned study into a file, in memory that does not grow with its cases.

    Arguments and errors as `escapement.sweep`.
    """
    _check(plan, options)
    version = numerics() + plan.fingerprint
    keep = {"force": options.get("force", False), "resume": options.get("resume", False)}
    with study_writer(path, frame_of(plan), numerics=version, **keep) as study:
        return _run(plan, study, solve_block, options)


def _check(plan: StudyPlan, options: Options) -> None:
    """Refuse a study of which every case is wrong, before anything is opened or solved."""
    validate.integer("workers", options.get("workers", 1), 1, "give a number of threads")
    plan.check_mechanism()


def _run(
    plan: StudyPlan, study: Unfinished, task: Callable[[Work, int], Block], options: Options
) -> Tally:
    """Solve the missing blocks, and keep each as it is finished."""
    workers, scheduler = options.get("workers", 1), options.get("scheduler")
    here = scheduler is None or not study.missing
    pool = in_threads(workers) if here else in_cluster(scheduler, workers)
    compile_from_now_on()
    done, failed, progress = study.resumed, study.failed, options.get("progress")
    shown = nullcontext(progress) if callable(progress) else Progress(quiet=not progress)
    with pool as solvers, shown as report:
        if isinstance(report, Progress):
            report.before = done
        report(done, plan.cases, failed)
        counted = report if isinstance(report, Progress) else None
        shared = solved_scenes(plan, solvers, counted) if study.missing else None
        work = Work(plan, study.cut, numerics(), shared)
        for block in solvers.completed(task, work, _mixed(study.missing)):
            study.add(block)
            start, stop = study.cut.span(block.number)
            done, failed = done + stop - start, failed + block.failed
            report(done, plan.cases, failed)
    return Tally(plan.cases, failed, study.resumed)


def _mixed(items: Sequence[Any]) -> list[Any]:
    """The items in an order of which every beginning is spread evenly over all of them.

    The time that the first ones take then tells that of all, even if costly cases are neighbours.
    """
    return [items[i] for i in np.argsort(_GOLDEN * np.arange(len(items)) % 1.0).tolist()]


def solved_scenes(
    plan: StudyPlan, pool: Pool, progress: Progress | None = None
) -> scenes.SharedScenes | None:
    """The scenes that blocks have in common, solved; None where each block solves its own."""
    shared = scenes.shared_scenes(plan)
    if shared is None:
        return None
    size = shared.cases.size
    step = min(max(size // 64, _FEWEST), _MOST)
    figures, status = np.empty((len(plan.results) - 1, size)), np.empty(size, dtype=np.uint8)
    starts = _mixed(range(0, size, step))
    parts = ((start, shared.cases[start : start + step]) for start in starts)
    if progress is not None:
        progress.count("different cases")
    for done, (start, found) in enumerate(pool.completed(solve_slice, plan, parts), 1):
        figures[:, start : start + step], status[start : start + step] = found
        if progress is not None:
            progress(min(done * step, size), size, 0)
    if progress is not None:
        progress.count("cases")
    return shared._replace(figures=figures, status=status)


def frame_of(plan: StudyPlan) -> Study:
    """The study of a plan before it has results."""
    every = (*plan.dimensions, *plan.sampled, *plan.fixed, *plan.results)
    units = {name: plan.unit(name) for name in every}
    names = {name: plan.long_name(name) for name in every}
    # only the names and types of its results are known
    empty = {name: np.empty(0, result.dtype) for name, result in plan.results.items()}
    attributes = {
        "title": plan.configuration["title"],
        **LAYOUT,
        "package_version": __version__,
        "engine": plan.solver.engine,
        "rtol": plan.solver.tolerance,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    return Study(
        axes=plan.dimensions, results=empty, units=units, long_names=names,
        configuration=plan.configuration, attributes=attributes, sampled=plan.sampled,
        fixed=plan.fixed,
    )  # fmt: skip


def sources() -> list[Path]:
    """The files that results may depend on, in order."""
    rooms = ((_ROOT / room).rglob("*.py") for room in _ROOMS)
    return sorted(path for room in rooms for path in room)


@cache
def numerics() -> str:
    """Digest of these sources; equal digests, equal results.

    A change of a comment changes the digest too: computing a study again is better than mixing
    numbers of two versions.
    """
    digest = hashlib.sha256()
    for path in sources():
        digest.update(path.relative_to(_ROOT).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]
