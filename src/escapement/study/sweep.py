"""Studies from Python: axes and a sample around a nominal design, all in SI."""

import re
import zlib
from collections.abc import Mapping
from contextlib import suppress
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.errors import InvalidValue
from escapement.mechanisms import KINDS, kind_of
from escapement.model import Escapement, Inertia, Mechanism
from escapement.quantity import declared, quantities
from escapement.solver import Solver, choose_solver
from escapement.study.parse import parse_plan
from escapement.study.plan import StudyPlan
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
    settings = choose_solver(solver, engine, rtol).given
    plan = plan_from(escapement, axes, sample=sample, initial_speed=initial_speed, **settings)
    return run_plan(
        plan,
        path,
        force=force,
        resume=resume,
        progress=progress,
        workers=workers,
        scheduler=scheduler,
    )


def plan_from(
    escapement: Escapement,
    axes: Mapping[str, ArrayLike | Mapping[str, Any]],
    *,
    sample: Mapping[str, Any] | None = None,
    initial_speed: ArrayLike = 0.0,
    title: str | None = None,
    **solver: Any,
) -> StudyPlan:
    """Plan a study of `escapement` over `axes`.

    Parameters
    ----------
    escapement : Escapement
        The nominal design; an axis replaces its value. What was left to the
        mechanism, such as the pins of `Geneva(slots=4)`, follows the axes.
    axes : Mapping
        Name of each axis and its values [SI]: numbers, or start, stop and num.
    sample : Mapping, optional
        Parameters that vary together, at every point of the grid: the [sample] table
        of a study, in SI, spread around the values of `escapement`.
    initial_speed : float or array
        Driver speed at the first pin entry [rad/s], >= 0; an array is the last axis.
    title : str, optional
        One line for people.
    **solver : optional
        Fields of `Solver`.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    machine, own = _describe(escapement.mechanism)
    axes, start = dict(axes), {"initial_speed": initial_speed}
    if np.ndim(initial_speed) > 0:
        axes, start = axes | start, {}
    inertia = {entry.key: getattr(escapement.inertia, entry.key)
               for entry in declared(Inertia).values()}  # fmt: skip
    numbers = {
        name: getattr(escapement, name)
        for name, entry in quantities(Escapement).items()
        if getattr(escapement, name) != entry.default
    }
    tables = {"mechanism": machine, "inertia": inertia, "sweep": axes, "solver": solver}
    chosen = {"title": title, "sample": sample}
    chosen = {name: value for name, value in chosen.items() if value is not None}
    return parse_plan(start | numbers | tables | chosen, mechanism=own)


def _describe(mechanism: Mechanism) -> tuple[dict[str, Any], Mechanism | None]:
    """A mechanism as a [mechanism] table, or itself where no kind fits it."""
    for name in KINDS:
        if type(mechanism) is kind_of(name):
            return {"kind": name} | _chosen(mechanism), None
    # the numbers tell apart two mechanisms whose repr is the same
    cell = (*mechanism.breaks, mechanism.cell_angle, mechanism.follower_step)
    checksum = zlib.crc32(np.concatenate([mechanism.path.numbers, cell]).tobytes())
    # an address in memory differs from process to process
    text = re.sub(r" at 0x[0-9a-fA-F]+", "", repr(mechanism))
    description = f"{text}, checksum {checksum:08x}"
    return {"kind": type(mechanism).__qualname__, "description": description}, mechanism


def _chosen(mechanism: Any) -> dict[str, Any]:
    """The settings that were given, or that the mechanism would not have chosen by itself."""
    kind = type(mechanism)
    chosen = {name: getattr(mechanism, name) for name in declared(kind)}
    for name, setting in declared(kind).items():
        if setting.required or name in getattr(mechanism, "given", ()):
            continue
        without = {key: value for key, value in chosen.items() if key != name}
        with suppress(InvalidValue):  # there may be no such mechanism without it
            if getattr(kind(**without), name) == chosen[name]:
                chosen = without
    return chosen
