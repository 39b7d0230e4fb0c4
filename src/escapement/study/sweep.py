"""A study without a configuration: axes around a nominal design."""

from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.model import Escapement, Run
from escapement.quantity import check_number
from escapement.solver import Solver, choose_solver
from escapement.study.from_escapement import plan_from
from escapement.study.result import Study
from escapement.study.run import Report, run_plan


def sweep(
    escapement: Escapement,
    *,
    sample: Mapping[str, Any] | None = None,
    engine: str | None = None,
    rtol: float | None = None,
    solver: Solver | None = None,
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
    engine, rtol, solver : optional
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
        Values [SI] of any numbers of the escapement, its inertias (`driver_inertia`,
        `follower_inertia`) and its mechanism (`slots`, `pins`); the order is that of the
        results' dimensions. A sample adds the last one, `case`.

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
        raise validate.fail("path", "the name of a file", path, "leave it out to write none")
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise validate.fail("progress", "true, false or a function", progress, "leave it out")
    start = 0.0
    if np.ndim(initial_speed) > 0:
        axes["initial_speed"] = initial_speed
    else:
        start = check_number(Run, "initial_speed", initial_speed)
    plan = plan_from(
        escapement,
        axes,
        sample=sample,
        initial_speed=start,
        **choose_solver(solver, engine, rtol).given,
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
