"""One design computed with models from simple to detailed, called rungs, and their differences.

The rungs are the ideal mechanism, real losses, clearance with rigid impact, and compliant
contact. Each includes more of the real mechanism and takes longer to compute.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from escapement.base import validate
from escapement.base.quantity import Declared, declared
from escapement.base.status import Status
from escapement.base.text import Shown
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines.simulate import terminal
from escapement.mechanisms.checks import IMPERFECT
from escapement.model.escapement import AIR, CONTACT, FRICTION, Escapement

ENOUGH = 1e-3
"""A rung is sufficient if its period differs by less than this share from that of the next."""
_FIGURES = ("period", "velocity_max", "velocity_min", "contact_force_max")


@dataclass(frozen=True, repr=False)
class Rungs(Shown):
    """The figures of a design on each rung.

    figures : the `Figures` of each rung, by its name: "ideal", "losses", "impact", "compliant";
        only those for which the design has numbers.
    changes : relative change of each figure from the rung before, by rung and figure.
    message : which rung is enough for the period, and why figures are missing.
    """

    figures: dict[str, Figures]
    changes: dict[str, dict[str, float]]
    message: str

    def _shown(self) -> list[tuple[str, Any, str]]:
        rows = [(f"period, {name}", found.period, "s") for name, found in self.figures.items()]
        return [*rows, ("message", self.message, "")]


def compare_rungs(escapement: Escapement) -> Rungs:
    """Compare a design with simpler models of it.

    Parameters
    ----------
    escapement : Escapement
        The design with all known numbers. Its clearance and its stiffness belong to the upper
        rungs; its bearings, drags, pin radii and errors of parts belong to the second.

    Returns
    -------
    Rungs

    Raises
    ------
    InvalidValue
        When the argument is not an escapement.
    """
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    figures = {name: terminal(rung) for name, rung in _rungs(escapement).items()}
    changes: dict[str, dict[str, float]] = {}
    for before, name in pairwise(figures):
        low, high = figures[before], figures[name]
        changes[name] = {key: getattr(high, key) / getattr(low, key) - 1.0 for key in _FIGURES}
    return Rungs(figures, changes, _advice(figures, changes))


def _rungs(escapement: Escapement) -> dict[str, Escapement]:
    """The design on each rung, the simplest first; a rung that changes nothing is left out."""
    rigid = replace(escapement, **_defaults(CONTACT))
    fitting = replace(rigid, mechanism=_without(rigid.mechanism, ("clearance",)))
    # even the simplest model has the friction of the slot, or the efficiency of the mesh
    kept = {name: fitting.settings[name] for name in ("friction", "efficiency")}
    plain = replace(fitting, **_defaults(FRICTION, AIR) | kept)
    bare = ("pin_radius", "roller_radius", *IMPERFECT)
    ideal = replace(plain, mechanism=_without(plain.mechanism, bare))
    impact = replace(rigid, restitution=escapement.restitution)
    every = {"ideal": ideal, "losses": fitting, "impact": impact, "compliant": escapement}
    found: dict[str, Escapement] = {}
    for name, rung in every.items():
        if rung not in found.values() and (name != "impact" or rung.contact):
            found[name] = rung
    return found


def _defaults(*groups: str) -> dict[str, Any]:
    """Defaults of the numbers of an escapement in these groups, by name."""
    entries = declared(Escapement).items()
    return {name: entry.default for name, entry in entries if entry.group in groups}


def _without(mechanism: Any, names: tuple[str, ...]) -> Any:
    """A mechanism without some of its numbers."""
    known = declared(type(mechanism)) if isinstance(mechanism, Declared) else {}
    given = {name: known[name].default for name in names if name in known}
    return replace(mechanism, **given) if given else mechanism


def _advice(figures: dict[str, Figures], changes: dict[str, dict[str, float]]) -> str:
    """Which rung is enough."""
    jammed = [name for name, found in figures.items() if found.status is not Status.OK]
    names = list(figures)
    enough = names[-1]
    for name in reversed(names[1:]):
        if not abs(changes[name]["period"]) < ENOUGH:
            break
        enough = names[names.index(name) - 1]
    told = f"{enough} is enough for the period within {100.0 * ENOUGH:g} %"
    if jammed:
        told += f"; there is no cycle on {', '.join(jammed)}: {figures[jammed[0]].message}"
    return told
