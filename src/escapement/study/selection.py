"""Single cases of a study: one that is selected by its values, and a few of them to be shown."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from escapement.base.errors import InputFileError, InvalidValue
from escapement.base.quantity import Quantity
from escapement.base.status import Status
from escapement.base.units import SYSTEMS, ratio_of, spelt, unit_name
from escapement.study.parse import load_plan, parse_plan
from escapement.study.plan import StudyPlan, unit_kind
from escapement.study.reader import read_configuration, read_study
from escapement.study.result import index_on
from escapement.study.stored import open_hdf5
from escapement.study.table_files import is_table, read_rows

ROWS = 12
"""Greatest number of cases that are shown."""
RESULTS_SHOWN = 5
"""Greatest number of their results."""


def some_cases(
    plan: "StudyPlan", path: Path, system: str
) -> tuple[list[dict[str, Any]], list[str]]:
    """At most a dozen cases of a study file, evenly spread from the first to the last.

    Only these cases are read, and the first five of their results, so that a large file takes no
    longer. Numbers are in `system`; the unit of every column is returned as well.
    """
    along = [{name: values} | plan.varied[name] for name, values in plan.dimensions.items()]
    cases = np.unique(np.linspace(0, plan.cases - 1, ROWS).round().astype(int))
    indices = np.unravel_index(cases, plan.shape)
    columns = {n: x[i] for i, axes in zip(indices, along, strict=True) for n, x in axes.items()}
    shown = [*[name for name in plan.results if name != "status"][:RESULTS_SHOWN], "status"]
    if is_table(path):
        found = read_rows(path, cases.tolist())
    else:
        with open_hdf5(path) as hdf5:
            found = {n: np.array([hdf5[n][at] for at in zip(*indices, strict=True)]) for n in shown}
    columns |= {name: found[name] for name in shown}
    scaled = {name: in_system(unit_kind(name), plan.unit(name), system) for name in columns}
    cells = [(scaled[name][0] * column).tolist() for name, column in columns.items()]
    cells[-1] = [Status(int(number)).label for number in cells[-1]]
    units = [spelt(unit) for _, unit in scaled.values()]
    return [dict(zip(columns, row, strict=True)) for row in zip(*cells, strict=True)], units


def in_system(kind: str, unit: str, system: str) -> tuple[float, str]:
    """Factor that brings numbers of a kind from their unit into a system, and the unit there."""
    wanted = unit_name(kind, system)
    scale = 1.0 if unit == wanted else ratio_of(unit, wanted)
    return 1 if scale == 1.0 else scale, wanted  # a whole number stays whole


def load_case(path: Path, selection: str | None) -> "tuple[StudyPlan, int]":
    """The plan of a study, and the number of the case that was selected.

    Parameters
    ----------
    path : Path
        File that `escapement sweep` wrote, or its configuration, CONFIG.toml.
    selection : str, optional
        "friction=0.35,torque=0.1", in the units of the file, with "case=17" of a sample.
        An axis of one value needs no selection.

    Raises
    ------
    InvalidValue
        When the selection cannot be understood, or does not name exactly one case.
    MissingInput, InputFileError
        When the file is not a study.
    """
    written = path.suffix.lower() != ".toml"
    configuration = read_configuration(path) if written else load_plan(path).configuration
    wanted = parse_selection(selection or "", configuration.get("units", SYSTEMS[0]))
    if written and "sample" in configuration and "case" in wanted:
        if not (case := wanted.pop("case")).is_integer():
            raise InvalidValue(f"case must be a whole number, got {case:g}; cases count from 0")
        # another version of SciPy may draw other numbers: use the stored ones
        row = read_study(path).at(case=case).sampled
        drawn = {name: values.tolist() for name, values in row.items()}
        configuration["sample"] = {"method": "list"} | drawn
    try:
        plan = parse_plan(configuration) if written else load_plan(path)
    except InvalidValue as error:
        raise InputFileError(
            f"study {path} must hold a configuration this version understands, got: {error}"
        ) from None
    unknown = [name for name in wanted if name not in plan.dimensions]
    if unknown:
        raise InvalidValue(
            f"--select must name axes of {path}, got {unknown[0]!r}; "
            f"it has {', '.join(plan.dimensions)}"
        )
    index = []
    for name, values in plan.dimensions.items():
        if name not in wanted and values.size > 1:
            raise InvalidValue(
                f"--select must choose one of the {values.size} values of {name} in {path}, "
                f"got none; add {name}={values[0]:g}"
            )
        index.append(index_on(values, name, wanted[name], path) if name in wanted else 0)
    return plan, int(np.ravel_multi_index(index, plan.shape))


def parse_selection(selection: str, system: str) -> dict[str, float]:
    """Values by name from "friction=0.35,torque=0.1"; InvalidValue for any other form.

    Values without a unit are in those of `system`.
    """

    wanted = {}
    for part in filter(None, (part.strip() for part in selection.split(","))):
        name, _, text = part.partition("=")
        name = name.strip()
        if name in wanted:
            raise InvalidValue(f"--select must give {name} once, got {selection!r}; leave one out")
        if not (name and text):
            raise InvalidValue(
                f"--select must be NAME=VALUE[,NAME=VALUE...], got {part!r}; "
                "for example friction=0.35,torque=0.1"
            )
        rule: dict[str, Any] = {"remedy": "give the value of a case", "minimum": -math.inf}
        entry = Quantity(long_name=name, unit=unit_kind(name), system=system, **rule)
        wanted[name] = entry.parse(f"--select {name}", text)
    return wanted
