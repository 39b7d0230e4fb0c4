"""A study's results as a value, and the results every study has."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement import validate
from escapement.errors import InvalidValue
from escapement.merits import FIGURES, Result
from escapement.status import Status
from escapement.text import Shown
from escapement.units import spelt

SCHEMA_VERSION = 1
"""Version of the file layout: raised when an older reader would misread a newer file."""

_AGREE = 6e-6
"""Relative difference below which a value means the one of the axis: six figures, as shown."""

_NOT_SET = object()


DEFAULT = (
    *("velocity_max", "velocity_min", "velocity_mean"),
    *("period", "rise_time", "settling_time"),
)
"""Figures of merit that a study keeps where it does not choose."""


def result_names(configuration: Mapping[str, Any]) -> list[str]:
    """Names of the results of a study by its configuration, in the order of the file."""
    return [*configuration.get("results", DEFAULT), "status"]


def kept(configuration: Mapping[str, Any]) -> dict[str, Result]:
    """The results of a study by its configuration, in the order of the file."""
    status = Result("ratio", "outcome of the case", "u1")
    return {name: FIGURES.get(name, status) for name in result_names(configuration)}


RESULTS: Mapping[str, Result] = kept({})
"""Results of a study that does not choose."""


@dataclass(frozen=True, eq=False, repr=False)
class Study(Shown):
    """A study: axes, results over their grid, and what they mean.

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
        The study as it was asked for.
    attributes : dict
        title, schema_version, package_version, engine, rtol and created.
    sampled : dict of ndarray, shape (n,)
        Parameters of a sample in the user's units, along `case`.
    """

    axes: dict[str, NDArray[Any]]
    results: dict[str, NDArray[Any]]
    units: dict[str, str]
    long_names: dict[str, str]
    configuration: dict[str, Any]
    attributes: dict[str, Any]
    sampled: dict[str, NDArray[Any]] = field(default_factory=dict)

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
    def failed(self) -> int:
        """Number of cases without an answer."""
        return count_failed(self.results["status"])

    @property
    def outcomes(self) -> dict[str, int]:
        """Number of cases by the label of their status, of those that occur."""
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
            For a name that is no axis, or a value that is not on it.
        """
        kept = dict.fromkeys(self.axes, slice(None))
        for name, value in values.items():
            axis = self.axes[validate.choice("axis", name, tuple(self.axes))]
            number = validate.number(name, value, "give one of the axis")
            place = place_on(axis, name, number, "the study")
            kept[name] = slice(place, place + 1)
        grid = tuple(kept.values())
        case = kept.get("case", slice(None))
        return replace(
            self,
            axes={name: axis[kept[name]] for name, axis in self.axes.items()},
            results={name: found[grid] for name, found in self.results.items()},
            sampled={name: drawn[case] for name, drawn in self.sampled.items()},
        )


def place_on(axis: NDArray[Any], name: str, value: float, owner: object) -> int:
    """Index of a value on an axis of the owner's, told by six figures.

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


def count_failed(status: NDArray[np.uint8]) -> int:
    """How many statuses say that a case has no answer."""
    return int(np.isin(status, [member.value for member in Status if member.failed]).sum())


def difference(there: Mapping[str, Any], here: Mapping[str, Any]) -> str:
    """Where the configurations or attributes of two studies differ first; "" where they do not."""
    parts = ("configuration", "attributes")
    return next(filter(None, (_first_difference(there[part], here[part]) for part in parts)), "")


def _first_difference(there: Any, here: Any, place: str = "") -> str:
    if not (isinstance(there, dict) and isinstance(here, dict)):
        return "" if there == here else f"{place} was {_short(there)} and is {_short(here)}"
    for key in there | here:
        where = f"{place}.{key}" if place else key
        if text := _first_difference(there.get(key, _NOT_SET), here.get(key, _NOT_SET), where):
            return text
    order = f"{place or 'the study'} had the order {', '.join(there)}"
    return "" if [*there] == [*here] else order


def _short(value: Any) -> str:
    text = "not set" if value is _NOT_SET else json.dumps(value)
    return text if len(text) <= 60 else text[:40] + " ... " + text[-15:]
