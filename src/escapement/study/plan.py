"""A study as a value: its configuration, what is fixed, what varies, and how it is solved."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement import units
from escapement.mechanisms import kind_of
from escapement.model import Escapement, Inertia, Mechanism, Run
from escapement.quantity import Quantity, Setting, declared, quantities
from escapement.solver import Solver
from escapement.study.varied import CASE


def model_numbers() -> dict[str, Quantity]:
    """Numbers of an escapement beside its mechanism that may be axes, by name."""
    every = {**quantities(Escapement), **quantities(Inertia), **quantities(Run)}
    return {name: entry for name, entry in every.items() if entry.axis}


@dataclass(frozen=True)
class PlanKind:
    """What a study may say of one kind of mechanism.

    build : the class that one of its settings makes; None for a mechanism of the user's own.
    meshed : whether it has no slot, and loses in a mesh.
    """

    build: type | None
    meshed: bool

    @classmethod
    def named(cls, name: str) -> "PlanKind":
        """The kind that a file calls so."""
        build = kind_of(name)
        return cls(build, build.meshed)

    @cached_property
    def settings(self) -> dict[str, Setting]:
        """All that its [mechanism] table may hold, what cannot be an axis first."""
        entries = {} if self.build is None else declared(self.build)
        return dict(sorted(entries.items(), key=lambda item: item[1].axis))

    @cached_property
    def parameters(self) -> dict[str, Quantity]:
        """Its numbers that may be axes."""
        return {
            name: entry
            for name, entry in self.settings.items()
            if isinstance(entry, Quantity) and entry.axis
        }

    @cached_property
    def all_parameters(self) -> dict[str, Quantity]:
        """Every number of an escapement with such a mechanism that may be an axis."""
        fitting = {
            name: entry for name, entry in model_numbers().items() if entry.fits(self.meshed)
        }
        return self.parameters | fitting


@dataclass(frozen=True, eq=False)
class StudyPlan:
    """Everything a study needs to run, and nothing it computes.

    Cases are numbered in C order over the dimensions: the axes, then the cases of the
    sample, which vary fastest.

    Attributes
    ----------
    configuration : dict
        The study as plain JSON, of which `parse_plan` makes the same plan.
    kind : PlanKind
        What the mechanism is made of.
    fixed_si : dict
        Fixed or nominal value of every setting in SI; None leaves it to the mechanism.
    varied : dict of dict of ndarray, shape (n,)
        Columns of the parameters that vary along each dimension, in the user's units.
    solver : Solver
        Engine and tolerances.
    fingerprint : str
        Of the numbers drawn for a sample; "" where nothing was drawn.
    own_mechanism : Mechanism, optional
        A mechanism that no configuration can describe.
    """

    configuration: dict[str, Any]
    kind: PlanKind
    fixed_si: dict[str, Any]
    varied: dict[str, dict[str, NDArray[Any]]]
    solver: Solver
    fingerprint: str = ""
    own_mechanism: Mechanism | None = None

    @property
    def title(self) -> str:
        """One line for people."""
        return str(self.configuration["title"])

    @property
    def unit_system(self) -> str:
        """Units of the configuration: "SI" or "in-lbf-s"."""
        return str(self.configuration["units"])

    @property
    def sampled(self) -> dict[str, NDArray[Any]]:
        """Parameters of the sample in the user's units, by name; empty on a grid."""
        return self.varied.get(CASE, {})

    @cached_property
    def dimensions(self) -> dict[str, NDArray[Any]]:
        """Values along each dimension of the results: of an axis, or numbers of cases."""
        sizes = {name: next(iter(along.values())).size for name, along in self.varied.items()}
        return {name: self.varied[name].get(name, np.arange(size)) for name, size in sizes.items()}

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

    def unit(self, name: str) -> str:
        """UDUNITS spelling of the unit of a parameter or a dimension."""
        unit = "ratio" if name == CASE else self.parameters[name].unit
        return units.unit_name(unit, self.unit_system)

    def long_name(self, name: str) -> str:
        """What a parameter or a dimension is."""
        return "number of the case" if name == CASE else self.parameters[name].long_name

    @cached_property
    def _varied_si(self) -> list[dict[str, NDArray[Any]]]:
        return [
            {name: self.parameters[name].to_si(column, self.unit_system)
             for name, column in along.items()}
            for along in self.varied.values()
        ]  # fmt: skip

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
        # parameters of one dimension, as those of a sample, share their place along it
        places = np.unravel_index(cases, self.shape)
        return {
            name: values[place]
            for along, place in zip(self._varied_si, places, strict=True)
            for name, values in along.items()
        }

    def values(self, case: int) -> dict[str, Any]:
        """Every setting of one case in SI; None leaves it to the mechanism."""
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
        # where its numbers vary, a case that cannot be built gets a status instead
        if all(self.kind.parameters.keys().isdisjoint(along) for along in self.varied.values()):
            _ = self.mechanism(0).path

    def _built(self, values: Mapping[str, Any]) -> Mechanism:
        if self.own_mechanism is not None:
            return self.own_mechanism
        assert self.kind.build is not None
        given = {name: values[name] for name in self.kind.settings if values[name] is not None}
        mechanism: Mechanism = self.kind.build(**given)
        return mechanism
