"""Cases of a study file: one found by the values of its axes, and a few to be seen at once."""

import itertools
import math
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.cli._arguments import UsageError
from escapement.errors import InputFileError, InvalidValue
from escapement.status import Status
from escapement.units import SYSTEMS, factor, unit_name

if TYPE_CHECKING:
    from escapement.study.plan import StudyPlan


ROWS = 12
SHOWN = ("velocity_max", "velocity_min", "velocity_mean", "period", "rise_time")


def load_case(path: Path, selection: str | None) -> tuple["StudyPlan", int]:
    """The plan of a study file, and the number of the case that was selected.

    Parameters
    ----------
    path : Path
        File that `escapement sweep` wrote.
    selection : str, optional
        "friction=0.35,torque=0.1", in the units of the file, with "case=17" of a sample.
        An axis of one value needs no selection.

    Raises
    ------
    UsageError, InvalidValue
        When the selection cannot be understood, or names no case or more than one.
    MissingInput, InputFileError
        When the file is no study.
    """
    import numpy as np

    from escapement.study.parse import parse_plan
    from escapement.study.reader import read_configuration, read_sample_case

    wanted = parse(selection or "")
    configuration = read_configuration(path)
    if "sample" in configuration and "case" in wanted:
        case = wanted.pop("case")
        if not case.is_integer():
            raise InvalidValue(f"case must be a whole number, got {case:g}; cases count from 0")
        # another version of SciPy may draw other numbers: take those that were computed
        row = read_sample_case(path, int(case))
        configuration["sample"] = {"method": "list"} | {name: [row[name]] for name in row}
    try:
        plan = parse_plan(configuration)
    except InvalidValue as error:
        raise InputFileError(
            f"study {path} must hold a configuration this version understands, got: {error}"
        ) from None
    unknown = [name for name in wanted if name not in plan.dimensions]
    if unknown:
        raise UsageError(
            f"--select must name axes of {path}, got {unknown[0]!r}; "
            f"it has {', '.join(plan.dimensions)}"
        )
    place = [_place(path, name, values, wanted) for name, values in plan.dimensions.items()]
    return plan, int(np.ravel_multi_index(place, plan.shape))


def parse(selection: str) -> dict[str, float]:
    """Values by name of "friction=0.35,torque=0.1"; UsageError where it reads otherwise."""
    wanted = {}
    for part in filter(None, (part.strip() for part in selection.split(","))):
        name, _, text = part.partition("=")
        name = name.strip()
        if name in wanted:
            raise UsageError(f"--select must give {name} once, got {selection!r}; leave one out")
        try:
            wanted[name] = float(text)
        except ValueError:
            raise UsageError(
                f"--select must be NAME=VALUE[,NAME=VALUE...], got {part!r}; "
                "for example friction=0.35,torque=0.1"
            ) from None
    return wanted


def _place(path: Path, name: str, values: Any, wanted: dict[str, float]) -> int:
    """Index of the value that was wanted on one axis."""
    from escapement.study.result import place_on

    if name not in wanted and values.size > 1:
        raise UsageError(
            f"--select must choose one of the {values.size} values of {name} in {path}, got none; "
            f"add {name}={values[0]:g}"
        )
    try:
        return place_on(values, name, wanted[name], path) if name in wanted else 0
    except InvalidValue as error:
        # a UsageError is shown as it is: this name is no option of the command
        raise UsageError(str(error)) from None


def some_cases(
    plan: "StudyPlan", path: str | PathLike[str], units: str | None
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """At most a dozen cases of a study file, spread evenly over every dimension.

    Only those are read, however large the file. Parameters are in `units`, or in the
    study's where that is None. Returned as well: the unit of every column.
    """
    import h5py

    from escapement.study.result import RESULTS

    along = {name: {name: values} for name, values in plan.dimensions.items()}
    if plan.sampled:
        along["case"] |= plan.sampled
    names = [name for columns in along.values() for name in columns]
    scaled = {name: in_system(plan.unit(name), units) for name in names}
    with h5py.File(path, "r") as hdf5:
        cases = []
        for place in spread(plan.shape, ROWS):
            case = {
                name: values[i].item() * scaled[name][0]
                for columns, i in zip(along.values(), place, strict=True)
                for name, values in columns.items()
            }
            case |= {name: float(hdf5[name][place]) for name in SHOWN}
            cases.append(case | {"status": Status(int(hdf5["status"][place])).label})
    own = {name: unit for name, (_, unit) in scaled.items()}
    return cases, own | {name: RESULTS[name].units for name in (*SHOWN, "status")}


def in_system(unit: str, system: str | None) -> tuple[float, str]:
    """Factor that brings numbers of a unit into `system`, and the unit's name there."""
    for quantity in ("torque", "inertia", "length", "force"):
        for own in SYSTEMS:
            if system not in (None, own) and unit == unit_name(quantity, own):
                return factor(quantity, own) / factor(quantity, system), unit_name(quantity, system)
    return 1, unit  # a whole number stays whole


def spread(shape: tuple[int, ...], most: int) -> list[tuple[int, ...]]:
    """At most `most` grid places: the ends of every axis, then places between them."""
    counts = list(shape)
    while math.prod(counts) > most:
        counts[counts.index(max(counts))] -= 1
    picks = [
        [round(i * (size - 1) / (count - 1)) for i in range(count)] if count > 1 else [size // 2]
        for size, count in zip(shape, counts, strict=True)
    ]
    return list(itertools.product(*picks))
