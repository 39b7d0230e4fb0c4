"""Mechanisms: each gives its transmission over a cell of driver angle.

A kind of mechanism is a class derived from `Kind`, in its own module, and one line of `KINDS`.
Modules are loaded when they are first used.

Read `protocol` first, then `geneva`.

- `protocol`, `path`, `wheel_checks`: what is asked of a mechanism, its path for kernels, checks of
  lengths
- `other_sizes`: diameters and distances in place of a mechanism's own numbers
- `kind`: the base of the kinds, with what files and the command line need
- `geneva`, `gear_driven`, `elliptical_planetary`, `tabulated`, `cam_indexer`: the kinds
- `from_functions`: a mechanism from the function of its follower angle
- `two_bodies`, `escape_wheel`, `runaway`, `clock_verge`, `drawn_bodies`: kinds whose outlines
  touch anywhere
- `alternation`: whether two pallets let one tooth after the other go by
- `chains`, `features`, `drawing_files`: outlines of lines and arcs, their files, and what a body
  touches another with
- `slotted`, `table`: kernels that evaluate a pin path, and a tabulated transmission
- `imperfect`, `pattern`: wheels with errors of their parts, and the path of every pair of pin and
  slot
- `gear_equation`, `elliptical_teeth`, `_rows`: the design equation of a gear-driven wheel, teeth of
  elliptical gears, and the function through the rows of a table
"""

from functools import cache
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from escapement.base.lazy import offered

if TYPE_CHECKING:
    from escapement.mechanisms.cam_indexer import CamIndexer as CamIndexer
    from escapement.mechanisms.clock_verge import Deadbeat as Deadbeat
    from escapement.mechanisms.clock_verge import Recoil as Recoil
    from escapement.mechanisms.drawn_bodies import Outlines as Outlines
    from escapement.mechanisms.elliptical_planetary import (
        EllipticalPlanetary as EllipticalPlanetary,
    )
    from escapement.mechanisms.gear_driven import GearDriven as GearDriven
    from escapement.mechanisms.geneva import Geneva as Geneva
    from escapement.mechanisms.kind import Kind
    from escapement.mechanisms.runaway import Runaway as Runaway
    from escapement.mechanisms.tabulated import Tabulated as Tabulated

KINDS = {
    "geneva": "geneva:Geneva",
    "gear-driven": "gear_driven:GearDriven",
    "elliptical-planetary": "elliptical_planetary:EllipticalPlanetary",
    "tabulated": "tabulated:Tabulated",
    "cam-indexer": "cam_indexer:CamIndexer",
    "runaway": "runaway:Runaway",
    "deadbeat": "clock_verge:Deadbeat",
    "recoil": "clock_verge:Recoil",
    "outlines": "drawn_bodies:Outlines",
}
"""Module and class of each kind, by the name that files and the command line give it."""
DEFAULT_KIND = "geneva"


@cache
def kind_of(name: str) -> "type[Kind]":
    """The class of a kind."""
    kind: type[Kind] = resolve_name(f"{__name__}.{KINDS[name]}")
    return kind


def __getattr__(name: str) -> Any:
    modules, classes = zip(*(home.split(":") for home in KINDS.values()), strict=True)
    return offered(__name__, classes, modules, name)
