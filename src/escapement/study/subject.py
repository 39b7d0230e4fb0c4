"""What a study is about: an escapement, or an indexing drive at constant speed."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, NamedTuple

from escapement.base import validate
from escapement.base.quantity import Quantity, Setting, declared, quantities
from escapement.base.results import Result
from escapement.constant_speed.index_case import IndexCase
from escapement.constant_speed.index_record import INDEX
from escapement.dynamics.figure_table import FIGURES
from escapement.model.escapement import Escapement, Inertia, Run
from escapement.model.train import train_numbers


class Subject(NamedTuple):
    """A model of which a study varies the numbers.

    name : as a study file has it.
    noun : as titles have it.
    owner : the class that declares most of its settings.
    settings : function that gives all of them by name, besides those of its mechanism.
    figures : the results that it can have.
    usual : those that a study keeps by default.
    """

    name: str
    noun: str
    owner: type
    settings: Callable[[], Mapping[str, Setting]]
    figures: Mapping[str, Result]
    usual: tuple[str, ...]


@cache
def model_numbers() -> dict[str, Quantity]:
    """Numbers of an escapement, besides those of its mechanism, that may be axes, by name."""
    every = {**quantities(Escapement), **quantities(Inertia), **train_numbers(), **quantities(Run)}
    return {name: entry for name, entry in every.items() if entry.axis}


def _of_escapement() -> Mapping[str, Setting]:
    others = {n: e for n, e in declared(Escapement).items() if not isinstance(e, Quantity)}
    return others | model_numbers()


ESCAPEMENT = Subject(
    "escapement", "escapement", Escapement, _of_escapement, FIGURES,
    (
        *("velocity_max", "velocity_min", "velocity_mean"),
        *("period", "rise_time", "settling_time"),
    ),
)  # fmt: skip
_LISTS = "reversal_limits", "reversals_deg"
DRIVE = Subject(
    "index", "drive", IndexCase, lambda: declared(IndexCase),
    {name: result for name, result in INDEX.items() if name not in _LISTS},
    (
        *("torque_max", "torque_min", "torque_rms", "power_max", "power_mean"),
        *("contact_moment_max", "contact_force_max"),
    ),
)  # fmt: skip
"""An indexing drive, as `escapement.index` computes it."""
SUBJECTS = {one.name: one for one in (ESCAPEMENT, DRIVE)}


def subject_of(content: Mapping[str, Any]) -> Subject:
    """The subject of a study by its file or configuration; InvalidValue for an unknown one."""
    if "study" not in content:
        return ESCAPEMENT
    return SUBJECTS[validate.choice("study", content["study"], tuple(SUBJECTS))]
