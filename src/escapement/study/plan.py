"""The plan of a study: its configuration, fixed numbers, varied numbers, and solver."""

import contextlib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from escapement.base import units
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Numbers, Quantity, Setting, declared
from escapement.base.results import Result
from escapement.base.text import Shown
from escapement.dynamics.figure_table import RUN_TIME
from escapement.engines.solver import Solver
from escapement.mechanisms import KINDS, kind_of
from escapement.mechanisms.protocol import Mechanism
from escapement.mechanisms.wheel_checks import IMPERFECT, LENGTHS
from escapement.model.checks import idle_settings, is_given
from escapement.model.escapement import Escapement, escapement_of
from escapement.model.materials import NEEDED
from escapement.model.torque_curve import TorqueCurve
from escapement.study.result import kept
from escapement.study.subject import ESCAPEMENT, SUBJECTS, Subject, subject_of

if TYPE_CHECKING:
    from escapement.constant_speed.indexing import IndexingDrive

CASE = "case"
"""Name of the dimension along which a sample varies."""


@cache
def _unit_kinds() -> dict[str, str]:
    every: dict[str, Setting] = {}
    for subject in SUBJECTS.values():
        every |= subject.settings()
    for name in KINDS:
        every |= declared(kind_of(name))
    kinds = {name: entry.unit for name, entry in every.items()}
    figures = (one.figures.items() for one in SUBJECTS.values())
    return kinds | {name: figure.kind for each in figures for name, figure in each}


def unit_kind(name: str) -> str:
    """Kind of unit, a key of `escapement.base.units`, of a parameter or a result of any study."""
    # the name of a number from a list ends with its index
    return _unit_kinds().get(name) or _unit_kinds().get(re.sub(r"_\d+$", "", name), "ratio")


@cache
def _unit(name: str, system: str) -> str:
    return units.unit_name(unit_kind(name), system)


class Settings(dict[str, Setting]):
    """Settings of a study by name, and what follows from them, which is found once."""

    @cached_property
    def axes(self) -> dict[str, Quantity]:
        """The numbers that may vary."""
        return {n: e for n, e in self.items() if isinstance(e, Quantity) and e.axis}

    @cached_property
    def names(self) -> dict[str, dict[str, str]]:
        """The name of each key, by section."""
        found: dict[str, dict[str, str]] = {}
        for name, entry in self.items():
            found.setdefault(entry.section, {})[entry.key] = name
        return found

    @cached_property
    def required(self) -> list[str]:
        """Those that a study must give or vary."""
        return [name for name, entry in self.items() if entry.required]

    @cached_property
    def defaults(self) -> dict[str, Any]:
        """What a study has where it gives nothing, in its units, and None for the others."""
        found: dict[str, Any] = dict.fromkeys(self)
        for name, entry in self.items():
            if entry.axis and entry.default is not None:
                found[name] = entry.default if entry.size == 1.0 else entry.default / entry.size
        return found


def settings_of(
    build: Any, meshed: bool, system: str = units.SYSTEMS[0], subject: Subject = ESCAPEMENT
) -> Settings:
    """All settings of the subject of a study, those of its mechanism first.

    build : the class of its mechanism, or a mechanism of the user's own, which is not changed.
    meshed : whether it has no slots, and its losses are given by an efficiency.
    system : the system of units in which they are read.
    """
    return _settings(build if isinstance(build, type) else None, meshed, system, subject.name)


@cache
def _settings(kind: type | None, meshed: bool, system: str, subject: str) -> Settings:
    entries = {} if kind is None else declared(kind)
    # settings that cannot be an axis stand first in the configuration
    found = dict(sorted(entries.items(), key=lambda item: item[1].axis))
    found |= SUBJECTS[subject].settings()
    # the scene of an escapement has the crank radius as its unit, so that no case may change it
    free = () if subject == ESCAPEMENT.name else ("crank_radius",)
    return Settings(
        (name, replace(entry, system=system, axis=entry.axis or name in free))
        for name, entry in found.items()
        if name in entries or entry.applies_to(meshed)
    )


@dataclass(frozen=True, eq=False, repr=False)
class StudyPlan(Shown):
    """Everything that a study needs to run, without its results.

    Cases are numbered in C order over the dimensions: the axes, then the cases of the
    sample, which vary fastest.

    Attributes
    ----------
    configuration : dict
        The study as plain JSON, from which `parse_plan` makes the same plan.
    build : type or Mechanism
        The class of the mechanism; or a mechanism that no configuration can describe.
    meshed : bool
        Whether it has no slot.
    parameters : dict of Quantity
        Every number this study may fix or vary, by name.
    fixed_si : dict
        Fixed or nominal value of every setting in SI; None leaves it to the mechanism.
    varied : dict of dict of ndarray, shape (n,)
        Columns of the parameters that vary along each dimension, in the user's units.
    solver : Solver
        Engine and tolerances.
    fingerprint : str
        Fingerprint of the numbers drawn for a sample; "" if nothing was drawn.
    curve : TorqueCurve, optional
        The torque over the driver angle in SI; `fixed_si` has its first value.
    replaced : tuple of str
        Numbers that were given a fixed value although an axis or a distribution replaces it.
    """

    configuration: dict[str, Any]
    build: Any
    meshed: bool
    parameters: dict[str, Quantity]
    fixed_si: dict[str, Any]
    varied: dict[str, dict[str, NDArray[Any]]]
    solver: Solver
    fingerprint: str = ""
    curve: TorqueCurve | None = None
    replaced: tuple[str, ...] = ()

    def _shown(self) -> list[tuple[str, Any, str]]:
        return [
            ("title", self.title, ""),
            ("dimensions", self.dimensions, ""),
            ("cases", self.cases, ""),
            ("engine", self.engine, ""),
        ]

    @property
    def subject(self) -> Subject:
        """What the study is about; not kept, since a copy in another process is another object."""
        return subject_of(self.configuration)

    @cached_property
    def settings(self) -> Settings:
        """All settings of its subject, by name."""
        return settings_of(self.build, self.meshed, subject=self.subject)

    @property
    def engine(self) -> str:
        """What solves the cases: an engine, or the closed form of an indexing drive."""
        return str(self.solver.engine) if self.subject is ESCAPEMENT else self.subject.name

    @property
    def title(self) -> str:
        """One line for people."""
        return str(self.configuration["title"])

    @property
    def sampled(self) -> dict[str, NDArray[Any]]:
        """Parameters of the sample in the user's units, by name; empty on a grid."""
        return self.varied.get(CASE, {})

    @cached_property
    def fixed(self) -> dict[str, float]:
        """Numbers that are the same in every case, in the user's units, except for idle zeros."""
        varied = {name for along in self.varied.values() for name in along}
        found = {}
        for section, names in self.settings.names.items():
            table: Any = self.configuration.get(section, {}) if section else self.configuration
            for key in names.keys() & table.keys():
                entry, value = self.settings[names[key]], table[key]
                number = isinstance(value, (int, float)) and isinstance(entry, Quantity)
                if number and names[key] not in varied and not entry.idle(value):
                    found[names[key]] = value
        return {name: found[name] for name in self.settings if name in found}

    @cached_property
    def dimensions(self) -> dict[str, NDArray[Any]]:
        """Values along each dimension of the results: of an axis, or numbers of cases."""
        sizes = {name: next(iter(along.values())).size for name, along in self.varied.items()}
        return {name: self.varied[name].get(name, np.arange(size)) for name, size in sizes.items()}

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Length of each dimension."""
        return tuple(values.size for values in self.dimensions.values())

    @cached_property
    def cases(self) -> int:
        """Number of cases."""
        return math.prod(self.shape)

    @cached_property
    def results(self) -> dict[str, Result]:
        """The results that the study keeps of every case, by name, the status last."""
        return kept(self.configuration)

    @cached_property
    def solved(self) -> list[str]:
        """Figures that are computed of every scene: the results, or what these follow from."""
        names = (NEEDED.get(name, name) for name in self.results if name != "status")
        return [*dict.fromkeys(names)]

    @cached_property
    def _named(self) -> dict[str, Setting]:
        """Every setting and parameter, by name."""
        return self.settings | self.parameters

    def unit(self, name: str) -> str:
        """UDUNITS spelling of the unit of a parameter, a dimension or a result."""
        return _unit(name, self.configuration["units"])

    def long_name(self, name: str) -> str:
        """Description of a parameter, a dimension or a result."""
        if name in self.results:
            return self.results[name].long_name
        if name == CASE:
            return "number of the case"
        return self._named[name].long_name

    @cached_property
    def _varied_si(self) -> list[dict[str, NDArray[Any]]]:
        return [
            {name: self.parameters[name].to_si(column) for name, column in along.items()}
            for along in self.varied.values()
        ]

    @cached_property
    def _every(self) -> dict[str, Any]:
        found = dict(self.fixed_si)
        for along in self._varied_si:
            found |= along
        return found

    def every(self, name: str) -> Any:
        """All values in SI of a parameter: an array, or its fixed value."""
        return self._every[name]

    def columns(self, cases: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
        """The parameters that vary over some cases, in SI.

        Parameters
        ----------
        cases : ndarray, shape (n,)
            Their numbers.

        Returns
        -------
        dict of ndarray, shape (n,)
            One array per parameter that varies.
        """
        # parameters of one dimension, as those of a sample, share their index along it
        indices = np.unravel_index(cases, self.shape)
        return {
            name: values[index]
            for along, index in zip(self._varied_si, indices, strict=True)
            for name, values in along.items()
        }

    def values(self, case: int) -> dict[str, Any]:
        """Every setting of one case in SI; None leaves it to the mechanism."""
        columns = self.columns(np.array([case]))
        return self.fixed_si | {name: column.item() for name, column in columns.items()}

    def drive(self, case: int) -> "IndexingDrive":
        """The indexing drive of one case; errors as `escapement`."""
        from escapement.constant_speed.indexing import IndexingDrive  # it loads kernels

        values = self.values(case)
        given = {name: values[name] for name in self.subject.settings() if name in values}
        numbers = {name: value for name, value in given.items() if value is not None}
        return IndexingDrive(self._machine(values), **numbers)

    def escapement(self, case: int) -> Escapement:
        """The escapement of one case.

        Raises
        ------
        InvalidValue
            When the parameters are allowed separately but not together, such as more pins than
            the slots allow.
        """
        return self.built(self.values(case))

    def built(self, values: Mapping[str, Any]) -> Escapement:
        """The escapement with these values of its settings in SI; errors as `escapement`."""
        if self.subject is not ESCAPEMENT:
            raise InvalidValue(
                "the study must be one of an escapement, got one of an indexing drive; "
                "compute its cases with escapement index, or sweep them"
            )
        values = dict(values)
        values["torque"] = self.curve or values["torque"]
        return escapement_of(self._machine(values), values)

    @cached_property
    def lengths(self) -> dict[str, float]:
        """Fixed lengths of the mechanism [m], the least crank radius, and 0 where it has none."""
        if not isinstance(self.build, type):
            lengths: dict[str, float] = self.build.lengths
            return lengths
        given = self.fixed_si
        names = ("crank_radius", "fixed_radius", "wheel_radius")
        radii = [self.every(name) for name in names if name in given]
        crank = next((float(np.min(radius)) for radius in radii if radius is not None), 0.0)
        return {name: given.get(name) or 0.0 for name in LENGTHS} | {"crank_radius": crank}

    def mechanism(self, case: int, ideal: bool = False) -> Mechanism:
        """The mechanism of one case, or the same with thin pins and perfect parts.

        Errors as `escapement`.
        """
        values = self.values(case) if self._varied_machine else self.fixed_si
        return self._machine(values, (*LENGTHS[1:], *IMPERFECT) if ideal else ())

    @cached_property
    def _varied_machine(self) -> bool:
        """Whether some cases have another mechanism than others."""
        varied = (self.parameters[name] for along in self.varied.values() for name in along)
        return any(entry.section == "mechanism" for entry in varied)

    def _machine(self, values: Mapping[str, Any], left_out: Sequence[str] = ()) -> Mechanism:
        if not isinstance(self.build, type):
            mechanism: Mechanism = self.build
            return mechanism
        given = {
            name: value
            for name, entry in declared(self.build).items()
            if name not in left_out and (value := _joined(entry, values)) is not None
        }
        return built_once(self.build, tuple(given.items()))

    @cached_property
    def perfect(self) -> bool:
        """Whether no case has errors of its parts."""
        if not isinstance(self.build, type):
            return bool(self.build.perfect)
        errors = (self.every(name) for name in self.fixed_si if name.startswith(IMPERFECT))
        return not any(np.any(given) for given in errors if is_given(given))

    @cached_property
    def contact(self) -> str:
        """The law of contact of its cases: "outlines", "any" with clearance or stiffness, or ""."""
        if self.build.pitch is not None:
            return "outlines"
        if not isinstance(self.build, type) and self.build.clearance:
            return "any"
        names = {"clearance", "stiffness"} & {*self.fixed_si}
        return "any" if any(is_given(self.every(name)) for name in names) else ""

    @property
    def unused(self) -> str:
        """Which fixed values have no effect, because an axis or a distribution replaces them."""
        lost = (f"the fixed {name} has no effect, because it varies" for name in self.replaced)
        return "; ".join(lost)

    @property
    def idle(self) -> str:
        """Which settings have no effect in any case; "" if there are none."""
        values = {name: self.every(name) for name in self.fixed_si}
        if not isinstance(self.build, type):
            values["clearance"] = self.build.clearance
        if self.contact == "outlines":
            values["clearance"] = 1.0  # there always is some
        notes = [idle_settings(self.subject.owner, values)]
        at_start = self.subject is ESCAPEMENT and RUN_TIME not in self.results
        if at_start and not self.has_cycle and (self.curve or np.any(self.every("spring_rate"))):
            named = "the torque behind the start" if self.curve else "spring_rate"
            notes.append(f"{named} has no effect on results, which are those of the first torque")
        return "; ".join(filter(None, notes))

    @cached_property
    def has_cycle(self) -> bool:
        """Whether a torque curve repeats in whole cells, so that results are those of all of it."""
        if self.curve is None or self._varied_machine:
            return self.curve is not None and (self.curve.periodic or not self.curve.angle)
        with contextlib.suppress(InvalidValue):
            return self.escapement(0).torque_cells > 0
        return False

    def check_mechanism(self) -> None:
        """Raise InvalidValue for a mechanism that no case could have."""
        # if its numbers vary, a case that cannot be built gets a status instead
        if not self._varied_machine:
            machine = self.mechanism(0)
            _ = machine.driver_features or machine.path


def built_once(build: Any, given: tuple[tuple[str, Any], ...]) -> Mechanism:
    """A mechanism, kept because its path takes longer to compute than many cases to solve."""
    if isinstance(found := _built(build, given), InvalidValue):
        raise found.with_traceback(None)
    return found


@lru_cache(64)
def _built(build: Any, given: tuple[tuple[str, Any], ...]) -> Mechanism | InvalidValue:
    """A mechanism, or why there is none: to find that out may take as long."""
    try:
        mechanism: Mechanism = build(**dict(given))
    except InvalidValue as error:
        return error
    return mechanism


def _joined(entry: Setting, values: Mapping[str, Any]) -> Any:
    """A setting of a case; a list is made from its numbers, times its factor."""
    name, found = entry.name, values.get(entry.name)
    if not isinstance(entry, Numbers):
        return found
    if f"{name}_0" in values:
        count = sum(key.startswith(f"{name}_") and key[-1].isdigit() for key in values)
        found = tuple(values[f"{name}_{i}"] for i in range(count))
    factor = values.get(f"{name}_factor", 1.0)
    return tuple(factor * number for number in found) if found and factor != 1.0 else found
