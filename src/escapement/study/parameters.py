"""What a study may say of an escapement: from the declarations of the classes that it builds."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

from escapement.mechanisms import KINDS, kind_of
from escapement.model import Escapement, Inertia, Mechanism, Run
from escapement.quantity import Quantity, Setting, declared, quantities


@cache
def model_numbers() -> dict[str, Quantity]:
    """Numbers of an escapement beside its mechanism, by the name of their axis."""
    every = {**quantities(Escapement), **quantities(Inertia), **quantities(Run)}
    return {name: entry for name, entry in every.items() if entry.axis}


@dataclass(frozen=True)
class PlanKind:
    """What a study may say of one kind of mechanism.

    build : who makes one of its settings; None for a mechanism of the user's own.
    meshed : whether it has no slot, and loses in a mesh.
    """

    build: type | None
    meshed: bool

    @classmethod
    def named(cls, name: str) -> "PlanKind":
        """The kind that a file calls so."""
        build = kind_of(name)
        return cls(build, build.meshed)

    @classmethod
    def of(cls, mechanism: Mechanism) -> "PlanKind":
        """The kind of a mechanism that no file can describe."""
        return cls(None, mechanism.path.table)

    @cached_property
    def settings(self) -> dict[str, Setting]:
        """All that its [mechanism] table may hold."""
        return {} if self.build is None else declared(self.build)

    @cached_property
    def parameters(self) -> dict[str, Quantity]:
        """Its numbers that may be axes."""
        return {
            name: entry
            for name, entry in self.settings.items()
            if isinstance(entry, Quantity) and entry.axis
        }

    @cached_property
    def options(self) -> dict[str, Setting]:
        """Its settings that cannot be axes."""
        return {name: entry for name, entry in self.settings.items() if not entry.axis}

    @cached_property
    def all_parameters(self) -> dict[str, Quantity]:
        """Every number of an escapement with such a mechanism that may be an axis."""
        model = model_numbers()
        return self.parameters | {
            name: entry for name, entry in model.items() if entry.fits(self.meshed)
        }

    @property
    def loss(self) -> str:
        """Name of the loss that such a mechanism has."""
        return next(name for name, entry in self.all_parameters.items() if entry.instead)

    def build_mechanism(self, numbers: Mapping[str, Any], options: Mapping[str, Any]) -> Mechanism:
        """The mechanism of numbers in SI, by the names of all parameters, and of options."""
        assert self.build is not None
        built: Mechanism = self.build(
            **{name: numbers[name] for name in self.parameters}, **options
        )
        return built


def homes(kind: PlanKind) -> dict[str, str]:
    """Where keys belong that stand in the wrong place, or are of another kind of mechanism."""
    found = _of_other_kinds(kind)
    for name, entry in model_numbers().items():
        if not entry.fits(kind.meshed):
            slot = "with" if kind.meshed else "without"
            found[name] = f"a study of a mechanism {slot} a slot"
    return found | dict.fromkeys(["kind", *kind.options], "[mechanism]")


def _of_other_kinds(kind: PlanKind) -> dict[str, str]:
    owners: dict[str, list[str]] = {}
    for name in KINDS:
        for key in PlanKind.named(name).settings:
            owners.setdefault(key, []).append(name)
    return {
        key: "[mechanism] of kind " + " or ".join(map(repr, kinds))
        for key, kinds in owners.items()
        if key not in kind.settings
    }
