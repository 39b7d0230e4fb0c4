"""One design computed with models from simple to detailed, and their differences.

The models are the ideal mechanism, real losses, clearance with rigid impact, and compliant
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
from escapement.mechanisms.wheel_checks import IMPERFECT
from escapement.model.escapement import AIR, CONTACT, FRICTION, Escapement

ENOUGH = 1e-3
"""A model is sufficient if its period differs by less than this share from that of the next."""
_FIGURES = ("period", "velocity_max", "velocity_min", "contact_force_max")


@dataclass(frozen=True, repr=False)
class Fidelity(Shown):
    """The figures of a design with each model.

    figures : the `Figures` of each model, by its name: "ideal", "losses", "impact", "compliant";
        only those for which the design has numbers.
    changes : relative change of each figure from the model before, by model and figure.
    message : which model is enough for the period, and why figures are missing.
    """

    figures: dict[str, Figures]
    changes: dict[str, dict[str, float]]
    message: str

    def _shown(self) -> list[tuple[str, Any, str]]:
        rows = [(f"period, {name}", found.period, "s") for name, found in self.figures.items()]
        return [*rows, ("message", self.message, "")]


def compare_fidelity(escapement: Escapement) -> Fidelity:
    """Compare a design with simpler models of it.

    Parameters
    ----------
    escapement : Escapement
        The design with all known numbers. Its clearance and its stiffness belong to the upper
        models; its bearings, drags, pin radii and errors of parts belong to the second.

    Returns
    -------
    Fidelity

    Raises
    ------
    InvalidValue
        When the argument is not an escapement.
    """
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    figures = {name: terminal(model) for name, model in _models(escapement).items()}
    changes: dict[str, dict[str, float]] = {}
    for before, name in pairwise(figures):
        low, high = figures[before], figures[name]
        changes[name] = {key: getattr(high, key) / getattr(low, key) - 1.0 for key in _FIGURES}
    return Fidelity(figures, changes, _advice(figures, changes))


def _models(escapement: Escapement) -> dict[str, Escapement]:
    """The design with each model, the simplest first; a model that changes nothing is left out."""
    rigid = replace(escapement, **_defaults(CONTACT))
    without_clearance = replace(rigid, mechanism=_without(rigid.mechanism, ("clearance",)))
    # even the simplest model has the friction of the slot, or the efficiency of the mesh
    kept = {name: without_clearance.settings[name] for name in ("friction", "efficiency")}
    plain = replace(without_clearance, **_defaults(FRICTION, AIR) | kept)
    bare = ("pin_radius", "roller_radius", *IMPERFECT)
    ideal = replace(plain, mechanism=_without(plain.mechanism, bare))
    impact = replace(rigid, restitution=escapement.restitution)
    every = {"ideal": ideal, "losses": without_clearance, "impact": impact, "compliant": escapement}
    found: dict[str, Escapement] = {}
    for name, model in every.items():
        if model not in found.values() and (name != "impact" or model.contact):
            found[name] = model
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
    """Which model is enough."""
    jammed = [name for name, found in figures.items() if found.status is not Status.OK]
    names = list(figures)
    enough = names[-1]
    for name in reversed(names[1:]):
        if not abs(changes[name]["period"]) < ENOUGH:
            break
        enough = names[names.index(name) - 1]
    text = f"{enough} is enough for the period within {100.0 * ENOUGH:g} %"
    if jammed:
        text += f"; there is no cycle on {', '.join(jammed)}: {figures[jammed[0]].message}"
    return text
