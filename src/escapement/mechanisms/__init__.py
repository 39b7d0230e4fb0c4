"""Mechanisms: each gives its transmission over a cell of driver angle.

A kind of mechanism is a class derived from `Kind`, in its own module, and one line of `KINDS`.
Modules are loaded when they are first used.
"""

from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from escapement.lazy import offered

if TYPE_CHECKING:
    from escapement.mechanisms.elliptical_planetary import EllipticalPlanetary
    from escapement.mechanisms.gear_driven import GearDriven
    from escapement.mechanisms.geneva import Geneva
    from escapement.mechanisms.kind import Kind
    from escapement.mechanisms.tabulated import Tabulated

__all__ = ["EllipticalPlanetary", "GearDriven", "Geneva", "Tabulated"]

KINDS = {
    "geneva": "geneva:Geneva",
    "gear-driven": "gear_driven:GearDriven",
    "elliptical-planetary": "elliptical_planetary:EllipticalPlanetary",
    "tabulated": "tabulated:Tabulated",
}
"""Module and class of each kind, by the name that files and the command line give it."""
DEFAULT_KIND = "geneva"


def kind_of(name: str) -> "type[Kind]":
    """The class of a kind."""
    kind: type[Kind] = resolve_name(f"{__name__}.{KINDS[name]}")
    return kind


def __getattr__(name: str) -> Any:
    return offered(__name__, __all__, (home.partition(":")[0] for home in KINDS.values()), name)
