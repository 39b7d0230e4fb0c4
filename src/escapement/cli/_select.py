"""One case of a study file: found by its axes, and simulated again as a full motion."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.cli._parser import UsageError
from escapement.errors import InputFileError, InvalidValue

if TYPE_CHECKING:
    from escapement.configuration import StudyPlan

_AGREE = 6e-6
"""Relative difference below which a value means the one of the axis: six figures, as shown."""


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

    from escapement.configuration import parse_plan
    from escapement.store import read_configuration, read_sample_case

    wanted = _parse(selection or "")
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


def _parse(selection: str) -> dict[str, float]:
    wanted = {}
    for part in filter(None, (part.strip() for part in selection.split(","))):
        name, _, text = part.partition("=")
        try:
            wanted[name.strip()] = float(text)
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
    value = wanted[name]
    nearest = int(abs(values - value).argmin())
    found = float(values[nearest])
    if not abs(found - value) <= _AGREE * max(abs(found), abs(value)):
        raise UsageError(
            f"{name} must be a value of {path}, got {value:g}; the nearest is {found:.10g}"
        )
    return nearest
