"""The results of a study, and the results that every study has."""

import json
import math
from collections import ChainMap
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.results import Result
from escapement.base.status import Status
from escapement.base.text import Shown
from escapement.base.units import spelt
from escapement.study.configuration import short_configuration
from escapement.study.stored import LAYOUT, part_of
from escapement.study.subject import subject_of

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

_AGREE = 6e-6
"""Relative difference below which a value counts as that of the axis: six figures, as shown."""


def result_names(configuration: Mapping[str, Any]) -> list[str]:
    """Names of the results of a study by its configuration, in the order of the file."""
    return [*configuration.get("results", subject_of(configuration).usual), "status"]


def kept(configuration: Mapping[str, Any]) -> dict[str, Result]:
    """The results of a study by its configuration, in the order of the file."""
    status = Result("ratio", "outcome of the case", "u1")
    figures = subject_of(configuration).figures
    return {name: figures.get(name, status) for name in result_names(configuration)}


RESULTS: Mapping[str, Result] = kept({})
"""Results that a study has by default."""


@dataclass(frozen=True, eq=False, repr=False)
class Study(Shown):
    """A study: axes, results over their grid, and their units and names.

    Attributes
    ----------
    axes : dict of ndarray, shape (n,)
        In the user's units; their order is that of the results' dimensions. The last
        axis of a sample is `case`, the numbers of its cases.
    results : dict of ndarray
        In the user's units; NaN where a case has no such figure; `status` (uint8) says why.
    units, long_names : dict of str
        For every axis, sampled parameter and result.
    configuration : dict
        The configuration of the study. For an axis with more than 64 values it has the name, the
        number of values and their checksum.
    attributes : dict
        title, Conventions, schema_version, package_version, engine, rtol and created.
    sampled : dict of ndarray, shape (n,)
        Parameters of a sample in the user's units, along `case`.
    fixed : dict of float
        Numbers that are the same in every case, in the user's units.
    """

    axes: Mapping[str, NDArray[Any]]
    results: Mapping[str, NDArray[Any]]
    units: dict[str, str]
    long_names: dict[str, str]
    configuration: dict[str, Any]
    attributes: dict[str, Any]
    sampled: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    fixed: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        # the name instead of a copy, although a file of the first version has copies
        short = short_configuration(self.configuration, self.columns)
        object.__setattr__(self, "configuration", short)

    def __getitem__(self, name: str) -> Any:
        """An axis, a result, a sampled or a fixed parameter by its name."""
        return self.columns[validate.choice("name", name, tuple(self.columns))]

    def _ipython_key_completions_(self) -> list[str]:
        return [*self.columns]

    def _shown(self) -> list[tuple[str, Any, str]]:
        failed = [("failed", self.failed, "")] if "status" in self.results else []
        varied = {**self.axes, **self.sampled}.items()
        rows = [(name, values, spelt(self.units.get(name, ""))) for name, values in varied]
        return [("cases", self.cases, ""), *failed, *rows]

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each axis."""
        return tuple(values.size for values in self.axes.values())

    @property
    def cases(self) -> int:
        """Number of cases."""
        return math.prod(self.shape)

    @property
    def columns(self) -> Mapping[str, Any]:
        """All names: axes, sampled and fixed parameters, results."""
        kinds: Any = (self.results, self.fixed, self.sampled, self.axes)  # the last come first
        return ChainMap(*kinds)

    def described(self, name: str) -> tuple[tuple[str, ...], dict[str, Any]]:
        """Dimensions and attributes of the array with this name, as in files and xarray."""
        along: dict[str, tuple[str, ...]] = {name: (name,) for name in self.axes}
        along |= dict.fromkeys(self.sampled, ("case",)) | dict.fromkeys(self.fixed, ())
        attributes: dict[str, Any] = {"units": self.units[name], "long_name": self.long_names[name]}
        if name == "status":
            numbers, labels = zip(*((member.value, member.label) for member in Status), strict=True)
            attributes["flag_values"] = np.array(numbers, "u1")
            attributes["flag_meanings"] = " ".join(labels)
        return along.get(name, tuple(self.axes)), attributes

    @property
    def root(self) -> dict[str, Any]:
        """Attributes of the study as a whole, as files and xarray have them."""
        text = json.dumps(self.configuration, allow_nan=False)
        return self.attributes | LAYOUT | {"configuration": text}

    def to_xarray(self) -> "Dataset":
        """The study as an `xarray.Dataset`; all columns of a file are read.

        Raises
        ------
        MissingPackage
            When xarray is not installed.
        """
        xarray = validate.package("xarray", "to_xarray")
        found = {}
        for name, values in self.columns.items():
            along, attributes = self.described(name)
            found[name] = xarray.Variable(along, values, attributes)
        results = {name: found.pop(name) for name in self.results}
        dataset: Dataset = xarray.Dataset(results, found, self.root)
        return dataset

    def to_dataframe(self) -> "DataFrame":
        """The study as a `pandas.DataFrame` with a row for each case and the axes as its index.

        Columns are the sampled parameters and the results; `attrs` has the units.

        Raises
        ------
        MissingPackage
            When pandas is not installed.
        """
        pandas = validate.package("pandas", "to_dataframe")
        columns = self.table(0, self.cases)
        columns |= {name: np.reshape(values, -1) for name, values in self.results.items()}
        frame = pandas.DataFrame(columns).set_index([*self.axes])
        frame.attrs = self.root | {"units": self.units}
        return frame

    def table(self, start: int, stop: int) -> dict[str, NDArray[Any]]:
        """Axes and sampled parameters of the cases start <= case < stop, shape (n,) each."""
        indices = np.unravel_index(np.arange(start, stop), self.shape)
        along = dict(zip(self.axes, indices, strict=True)) | dict.fromkeys(
            self.sampled, indices[-1]
        )
        return {name: np.asarray(self.columns[name])[index] for name, index in along.items()}

    @property
    def failed(self) -> int:
        """Number of cases that could not be computed."""
        return count_failed(self.results["status"])

    @property
    def outcomes(self) -> dict[str, int]:
        """Number of cases for each status that occurs, by its label."""
        counts = np.bincount(self.results["status"].reshape(-1), minlength=len(Status)).tolist()
        return {status.label: counts[status] for status in Status if counts[status]}

    def at(self, **values: float) -> "Study":
        """The cases at given values of some axes, which keep a length of 1.

        Parameters
        ----------
        values : float
            By name of the axis, to six figures: `study.at(slots=6)`.

        Raises
        ------
        InvalidValue
            For a name that is not an axis, or a value that is not on the axis.
        """
        kept = dict.fromkeys(self.axes, slice(None))
        for name, value in values.items():
            axis = self.axes[validate.choice("axis", name, tuple(self.axes))]
            number = validate.number(name, value, "give one of the axis")
            index = index_on(axis, name, number, "the study")
            kept[name] = slice(index, index + 1)
        grid = tuple(kept.values())
        case = kept.get("case", slice(None))
        return replace(
            self,
            axes={name: axis[kept[name]] for name, axis in self.axes.items()},
            results=part_of(self.results, grid),
            sampled=part_of(self.sampled, (case,)),
        )


def index_on(axis: NDArray[Any], name: str, value: float, owner: object) -> int:
    """Index of a value on an axis of the owner, compared to six figures.

    Raises
    ------
    InvalidValue
        When it is not there.
    """
    nearest = int(abs(axis - value).argmin())
    found = float(axis[nearest])
    if not math.isclose(found, value, rel_tol=_AGREE):
        raise InvalidValue(
            f"{name} must be a value of {owner}, got {value:g}; the nearest is {found:.10g}"
        )
    return nearest


_FAILED = np.isin(np.arange(256), [member.value for member in Status if member.failed])


def count_failed(status: NDArray[np.uint8]) -> int:
    """Number of statuses of cases that could not be computed."""
    return int(np.count_nonzero(_FAILED[status]))
