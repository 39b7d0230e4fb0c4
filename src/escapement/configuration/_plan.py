"""A study as a value: what is fixed, what varies, and how it is solved."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement import units
from escapement.configuration._kinds import Kind
from escapement.configuration._parameters import Parameter
from escapement.configuration._solver import Solver
from escapement.model import Escapement, Inertia, Mechanism


@dataclass(frozen=True, eq=False)
class StudyPlan:
    """Everything a study needs to run, and nothing it computes.

    Cases are numbered in C order over the axes: the last axis varies fastest.
    Numbers are in the user's units; `values` and `columns` give them in SI.

    Attributes
    ----------
    title : str
        One line for people.
    unit_system : str
        "SI" or "in-lbf-s".
    kind : Kind
        What the mechanism is made of.
    machine : dict
        Kind and options of the mechanism, as the [mechanism] table has them.
    fixed : dict of float
        Parameters that do not vary.
    axes : dict of ndarray, shape (n,)
        Parameters that vary, in the order of the results.
    forms : dict
        The axes as the configuration states them.
    solver : Solver
        Engine and tolerances.
    own_mechanism : Mechanism, optional
        A mechanism that no configuration can describe.
    """

    title: str
    unit_system: str
    kind: Kind
    machine: dict[str, Any]
    fixed: dict[str, float]
    axes: dict[str, NDArray[Any]]
    forms: dict[str, Any]
    solver: Solver
    own_mechanism: Mechanism | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each axis."""
        return tuple(values.size for values in self.axes.values())

    @property
    def cases(self) -> int:
        """Number of grid points."""
        return math.prod(self.shape)

    @property
    def parameters(self) -> dict[str, Parameter]:
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
        return plain | {"sweep": self.forms, "solver": self.solver.given}

    def unit(self, axis: str) -> str:
        """UDUNITS spelling of the unit of an axis."""
        return units.unit_name(self.parameters[axis].quantity, self.unit_system)

    @cached_property
    def _fixed_si(self) -> dict[str, float | None]:
        given = {
            name: self.parameters[name].to_si(value, self.unit_system)
            for name, value in self.fixed.items()
        }
        return dict.fromkeys(self.parameters) | given

    @cached_property
    def _axes_si(self) -> list[NDArray[Any]]:
        return [
            self.parameters[name].to_si(values, self.unit_system)
            for name, values in self.axes.items()
        ]

    def columns(self, start: int, stop: int) -> dict[str, NDArray[Any]]:
        """What varies over the cases start <= case < stop, in SI.

        Returns
        -------
        dict of ndarray, shape (stop - start,)
            One array per axis.
        """
        places = np.unravel_index(np.arange(start, stop), self.shape)
        columns = (axis[place] for axis, place in zip(self._axes_si, places, strict=True))
        return dict(zip(self.axes, columns, strict=True))

    def values(self, case: int) -> dict[str, Any]:
        """Every parameter of one case in SI; None leaves it to the mechanism."""
        varying = {name: column.item() for name, column in self.columns(case, case + 1).items()}
        return self._fixed_si | varying

    def escapement(self, case: int) -> Escapement:
        """The escapement of one case.

        Raises
        ------
        InvalidValue
            When the parameters are legal one by one and not together, such as
            more pins than the slots allow.
        """
        values = self.values(case)
        return Escapement(
            mechanism=self._build_mechanism(values),
            inertia=Inertia(values["driver_inertia"], values["follower_inertia"]),
            torque=values["torque"],
            friction=values.get("friction", 0.0),
            load_torque=values["load_torque"],
            efficiency=values.get("efficiency", 1.0),
        )

    def _build_mechanism(self, values: Mapping[str, Any]) -> Mechanism:
        if self.own_mechanism is not None:
            return self.own_mechanism
        module, _, name = self.kind.factory.partition(":")
        build = getattr(import_module(module), name)
        options = {
            option: self.kind.options[option].to_si(value, self.unit_system)
            for option, value in self.machine.items()
            if option != "kind"
        }
        return build(**{name: values[name] for name in self.kind.parameters}, **options)
