"""A study as a value: what is fixed, what varies, and how it is solved."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement import units
from escapement.model import Escapement, Inertia, Mechanism
from escapement.quantity import Quantity, declared, quantities
from escapement.solver import Solver
from escapement.study.parameters import PlanKind
from escapement.study.sample import CASE, Sample


@dataclass(frozen=True, eq=False)
class StudyPlan:
    """Everything a study needs to run, and nothing it computes.

    Cases are numbered in C order over the dimensions: the axes, then the cases of the
    sample, which vary fastest. Numbers are in the user's units; `values` and `columns`
    give them in SI.

    Attributes
    ----------
    title : str
        One line for people.
    unit_system : str
        "SI" or "in-lbf-s".
    kind : PlanKind
        What the mechanism is made of.
    machine : dict
        Kind and options of the mechanism, as the [mechanism] table has them.
    fixed : dict of float
        Parameters that do not vary.
    axes : dict of ndarray, shape (n,)
        Parameters that vary on a grid, in the order of the results.
    forms : dict
        The axes as the configuration states them.
    solver : Solver
        Engine and tolerances.
    sample : Sample, optional
        Parameters that vary together.
    own_mechanism : Mechanism, optional
        A mechanism that no configuration can describe.
    """

    title: str
    unit_system: str
    kind: PlanKind
    machine: dict[str, Any]
    fixed: dict[str, float]
    axes: dict[str, NDArray[Any]]
    forms: dict[str, Any]
    solver: Solver
    sample: Sample | None = None
    own_mechanism: Mechanism | None = None

    @cached_property
    def dimensions(self) -> dict[str, NDArray[Any]]:
        """Values along each dimension of the results: of an axis, or numbers of cases."""
        if self.sample is None:
            return self.axes
        return self.axes | {CASE: np.arange(self.sample.size)}

    @property
    def varied(self) -> dict[str, dict[str, NDArray[Any]]]:
        """Values of the parameters that vary along each dimension."""
        along = {name: {name: values} for name, values in self.axes.items()}
        return along if self.sample is None else along | {CASE: self.sample.values}

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each dimension."""
        return tuple(values.size for values in self.dimensions.values())

    @property
    def cases(self) -> int:
        """Number of cases."""
        return math.prod(self.shape)

    @property
    def parameters(self) -> dict[str, Quantity]:
        """Every parameter this study may fix or vary, by name."""
        return self.kind.all_parameters

    @property
    def configuration(self) -> dict[str, Any]:
        """The study as plain JSON, of which `parse_plan` makes the same plan."""
        plain: dict[str, Any] = {"title": self.title, "units": self.unit_system}
        plain["mechanism"] = dict(self.machine)
        for name, value in self.fixed.items():
            parameter = self.parameters[name]
            home = plain.setdefault(parameter.section, {}) if parameter.section else plain
            home[parameter.key] = value
        if self.axes:
            plain["sweep"] = self.forms
        if self.sample is not None:
            plain["sample"] = self.sample.form
        return plain | {"solver": self.solver.given}

    def unit(self, name: str) -> str:
        """UDUNITS spelling of the unit of a parameter or a dimension."""
        unit = "ratio" if name == CASE else self.parameters[name].unit
        return units.unit_name(unit, self.unit_system)

    def long_name(self, name: str) -> str:
        """What a parameter or a dimension is."""
        return "number of the case" if name == CASE else self.parameters[name].long_name

    @cached_property
    def fixed_si(self) -> dict[str, Any]:
        """Fixed value of every parameter in SI; None leaves it to the mechanism."""
        given = {
            name: self.parameters[name].to_si(value, self.unit_system)
            for name, value in self.fixed.items()
        }
        return dict.fromkeys(self.parameters) | given

    @cached_property
    def _varied_si(self) -> list[dict[str, NDArray[Any]]]:
        return [
            {
                name: self.parameters[name].to_si(values, self.unit_system)
                for name, values in along.items()
            }
            for along in self.varied.values()
        ]

    def every(self, name: str) -> Any:
        """All values in SI that a parameter takes: an array, or what is fixed."""
        return next(
            (along[name] for along in self._varied_si if name in along), self.fixed_si[name]
        )

    def columns(self, cases: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
        """What varies over some cases, in SI.

        Parameters
        ----------
        cases : ndarray, shape (n,)
            Their numbers.

        Returns
        -------
        dict of ndarray, shape (n,)
            One array per parameter that varies.
        """
        places = np.unravel_index(cases, self.shape)
        return {
            name: values[place]
            for along, place in zip(self._varied_si, places, strict=True)
            for name, values in along.items()
        }

    def values(self, case: int) -> dict[str, Any]:
        """Every parameter of one case in SI; None leaves it to the mechanism."""
        columns = self.columns(np.array([case]))
        return self.fixed_si | {name: column.item() for name, column in columns.items()}

    def escapement(self, case: int) -> Escapement:
        """The escapement of one case.

        Raises
        ------
        InvalidValue
            When the parameters are legal one by one and not together, such as
            more pins than the slots allow.
        """
        values = self.values(case)
        inertias = {entry.key: values[name] for name, entry in declared(Inertia).items()}
        return Escapement(
            mechanism=self._built(values),
            inertia=Inertia(**inertias),
            **{name: values[name] for name in quantities(Escapement) if name in values},
        )

    def mechanism(self, case: int) -> Mechanism:
        """The mechanism of one case; errors as `escapement`."""
        return self._built(self.values(case))

    def check_mechanism(self) -> None:
        """Raise InvalidValue for a mechanism that no case could have."""
        varied = {*self.axes, *(self.sample.values if self.sample else ())}
        if not varied & {*self.kind.parameters}:
            _ = self.mechanism(0).path

    def _built(self, values: Mapping[str, Any]) -> Mechanism:
        if self.own_mechanism is not None:
            return self.own_mechanism
        options = {
            option: self.kind.options[option].to_si(value, self.unit_system)
            for option, value in self.machine.items()
            if option != "kind"
        }
        return self.kind.build_mechanism(values, options)
