"""Cases of a study file: one found by the values of its axes, and a few to be seen at once."""

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.cli._arguments import UsageError
from escapement.errors import InputFileError, InvalidValue
from escapement.status import Status
from escapement.units import factor

if TYPE_CHECKING:
    from escapement.study.plan import StudyPlan


ROWS = 12
RESULTS = ("velocity_max", "velocity_min", "velocity_mean", "period", "rise_time")


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
        # as it was drawn and computed, not drawn again
        row = read_sample_case(path, _whole(wanted.pop("case")))
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


def _whole(case: float) -> int:
    if not case.is_integer():
        raise InvalidValue(f"case must be a whole number, got {case:g}; cases count from 0")
    return round(case)


def _place(path: Path, name: str, values: Any, wanted: dict[str, float]) -> int:
    """Index of the value that was wanted on one axis."""
    if name not in wanted:
        if values.size == 1:
            return 0
        raise UsageError(
            f"--select must choose one of the {values.size} values of {name} in {path}, got none; "
            f"add {name}={values[0]:g}"
        )
    from escapement.study.result import place_on

    try:
        return place_on(values, name, wanted[name], path)
    except InvalidValue as error:
        # as it stands: the name is one of the file's axes, not an option
        raise UsageError(str(error)) from None


def some_cases(
    plan: "StudyPlan", path: str | PathLike[str], units: str | None
) -> list[dict[str, Any]]:
    """At most a dozen cases of a study file, spread evenly over every dimension.

    Only those are read, however large the file. Parameters are in `units`, or in the
    study's where that is None.
    """
    import h5py

    places = spread(plan.shape, ROWS)
    numbers = {name: {name: values} for name, values in plan.dimensions.items()}
    if plan.sample is not None:
        numbers[[*numbers][-1]] |= plan.sample.values
    with h5py.File(path, "r") as hdf5:
        cases = []
        for place in places:
            case = {
                name: values[i].item() * _scale(plan, name, units)
                for along, i in zip(numbers.values(), place, strict=True)
                for name, values in along.items()
            }
            case |= {name: float(hdf5[name][place]) for name in RESULTS}
            cases.append(case | {"status": Status(int(hdf5["status"][place])).label})
    return cases


def _scale(plan: "StudyPlan", name: str, units: str | None) -> float:
    """Factor from the study's units of a parameter to `units`."""
    if units in (None, plan.unit_system) or name not in plan.parameters:
        return 1  # a whole number stays whole
    unit = plan.parameters[name].unit
    return factor(unit, plan.unit_system) / factor(unit, units)


def spread(shape: tuple[int, ...], most: int) -> list[tuple[int, ...]]:
    """At most `most` grid places: the ends of every axis, then places between them."""
    import itertools
    import math

    counts = list(shape)
    while math.prod(counts) > most:
        counts[counts.index(max(counts))] -= 1
    picks = [_evenly(size, count) for size, count in zip(shape, counts, strict=True)]
    return list(itertools.product(*picks))


def _evenly(size: int, count: int) -> list[int]:
    """`count` of the indices of an axis, both ends among them; of one, the middle."""
    if count == 1:
        return [size // 2]
    return [round(i * (size - 1) / (count - 1)) for i in range(count)]
