"""Running a study: every case of a grid, into memory or into a file."""

from collections.abc import Callable, Generator
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from escapement import __version__, _validate, simulation
from escapement.configuration import StudyPlan, plan_from
from escapement.model import Escapement
from escapement.progress import Progress
from escapement.store import RESULTS, SCHEMA_VERSION, Study, StudyWriter, count_failed, read_study
from escapement.sweeping._blocks import Columns, evaluate_blocks

Report = Callable[[int, int, int], None]


@dataclass(frozen=True)
class Tally:
    """How a study went: cases run, and those of them without an answer."""

    cases: int
    failed: int


def sweep(
    escapement: Escapement,
    *,
    engine: str = simulation.DEFAULT_ENGINE,
    rtol: float | None = None,
    initial_speed: ArrayLike = 0.0,
    path: str | PathLike[str] | None = None,
    force: bool = False,
    progress: Report | bool | None = None,
    workers: int = 1,
    **axes: ArrayLike,
) -> Study:
    """Figures of merit over a grid of parameters.

    Parameters
    ----------
    escapement : Escapement
        The nominal design.
    engine, rtol : optional
        As for `terminal`.
    initial_speed : float or array
        Driver speed at the first pin entry [rad/s]; an array is the last axis.
    path : path, optional
        HDF5 file to write as well.
    force : bool
        Replace an existing file.
    progress : bool or callable, optional
        True shows it on standard error; a callable gets (done, total, failed).
    workers : int
        Threads that compute.
    **axes : array
        Values [SI] of any of friction, torque, load_torque, driver_inertia,
        follower_inertia and the numbers of the mechanism (slots, pins); the
        order is that of the results' dimensions.

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
    if np.ndim(initial_speed) > 0:
        axes["initial_speed"], initial_speed = initial_speed, 0.0
    plan = plan_from(escapement, axes, initial_speed=initial_speed, engine=engine, rtol=rtol)  # type: ignore[arg-type]
    return run_plan(plan, path, force=force, progress=progress, workers=workers)


def run_plan(
    plan: StudyPlan,
    path: str | PathLike[str] | None = None,
    *,
    force: bool = False,
    progress: Report | bool | None = None,
    workers: int = 1,
) -> Study:
    """Run a planned study and return its results; arguments and errors as `sweep`."""
    if path is not None:
        write_plan(plan, path, force=force, progress=progress, workers=workers)
        return read_study(path)
    results = {name: np.empty(plan.cases, result.dtype) for name, result in RESULTS.items()}
    start = 0
    with closing(_reported(plan, progress, workers)) as blocks:
        for block in blocks:
            stop = start + len(block["status"])
            for name, values in results.items():
                values[start:stop] = block[name]
            start = stop
    shaped = {name: values.reshape(plan.shape) for name, values in results.items()}
    return replace(frame_of(plan), results=shaped)


def write_plan(
    plan: StudyPlan,
    path: str | PathLike[str],
    *,
    force: bool = False,
    progress: Report | bool | None = None,
    workers: int = 1,
) -> Tally:
    """Run a planned study into a file, in memory that does not grow with its cases.

    Arguments and errors as `sweep`.
    """
    failed = 0
    with (
        StudyWriter(path, frame_of(plan), force=force) as writer,
        closing(_reported(plan, progress, workers)) as blocks,
    ):
        for block in blocks:
            writer.append(block)
            failed += count_failed(block["status"])
    return Tally(plan.cases, failed)


def frame_of(plan: StudyPlan) -> Study:
    """The study of a plan before it has results."""
    units = {name: plan.unit(name) for name in plan.axes}
    names = {name: plan.parameters[name].long_name for name in plan.axes}
    rtol = plan.solver.rtol
    return Study(
        axes=plan.axes,
        results={},
        units=units | {name: result.units for name, result in RESULTS.items()},
        long_names=names | {name: result.long_name for name, result in RESULTS.items()},
        configuration=plan.configuration,
        attributes={
            "title": plan.title,
            "schema_version": SCHEMA_VERSION,
            "package_version": __version__,
            "engine": plan.solver.engine,
            "rtol": simulation.DEFAULT_RTOL[plan.solver.engine] if rtol is None else rtol,
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
        },
    )


def _reported(
    plan: StudyPlan, progress: Report | bool | None, workers: int
) -> Generator[Columns, None, None]:
    """The blocks of a plan in order, each reported when it is done."""
    workers = _validate.integer("workers", workers, 1, "give the number of threads")
    shown: AbstractContextManager[Report | None] = nullcontext()
    if progress is True:
        shown = Progress()
    elif progress:
        shown = nullcontext(progress)
    done = failed = 0
    with shown as report, closing(evaluate_blocks(plan, workers)) as blocks:
        if report is not None:
            report(done, plan.cases, failed)
        for block in blocks:
            yield block
            done += len(block["status"])
            failed += count_failed(block["status"])
            if report is not None:
                report(done, plan.cases, failed)
