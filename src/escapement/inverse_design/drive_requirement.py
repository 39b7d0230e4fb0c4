"""A requirement for a drive or a timer: a study with ranges, bounds and objectives, not axes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from escapement.base import units, validate
from escapement.base.files import AnyPath
from escapement.base.quantity import Quantity
from escapement.base.results import Result
from escapement.base.text import Shown
from escapement.base.toml_file import read_toml
from escapement.mechanisms import DEFAULT_KIND, KINDS, kind_of
from escapement.study.plan import settings_of
from escapement.study.subject import DRIVE, ESCAPEMENT, Subject, subject_of

Range = tuple[float, float]
GREATER = (
    *("dwell_left", "greatest_speed", "greatest_follower_inertia", "torque_min"),
    *("jam_margin", "critical_friction", "velocity_min"),
)
"""Figures that should be great; all others should be small."""
_OWN = "ranges", "bounds", "objectives"
SCATTER = "scatter"
_FRICTIONS = 7
_SCATTER = Result("ratio", "half the relative change of the period over the friction range")


@dataclass(frozen=True, repr=False)
class DriveRequirement(Shown):
    """What a drive or a timer must do; numbers are in the units that `study` names.

    study : content of a study file without axes.
    subject : what it is about.
    frictions : values of a timer whose friction is uncertain, from the least to the greatest.
    figures : those that may be objectives and have bounds.
    ranges : ends between which numbers are searched, by the names of axes.
    entries : the declarations of these numbers.
    bounds : least and greatest value of figures, by names of results.
    objectives : names of the figures to improve.
    """

    study: Mapping[str, Any]
    subject: Subject
    frictions: list[float]
    figures: Mapping[str, Result]
    ranges: Mapping[str, Range]
    entries: Mapping[str, Quantity]
    bounds: Mapping[str, Range]
    objectives: tuple[str, ...]

    @property
    def system(self) -> str:
        """The units of its numbers."""
        return str(self.study.get("units", units.SYSTEMS[0]))


def drive_requirement(requirement: Mapping[str, Any] | AnyPath) -> DriveRequirement:
    """Read a requirement from its file or from the content of one; without `study` of a drive.

    Raises
    ------
    MissingInput, InputFileError
        When there is no such file, or it is not TOML.
    InvalidValue
        When a key is unknown or its value breaks a rule.
    """
    content = requirement if isinstance(requirement, Mapping) else read_toml(requirement, "wish")
    study = {name: value for name, value in content.items() if name not in _OWN}
    subject = subject_of(content) if "study" in content else DRIVE
    study["study"], figures = subject.name, dict(subject.figures)
    system = validate.choice("units", study.get("units", units.SYSTEMS[0]), units.SYSTEMS)
    ranges, bounds = (_table(content, name) for name in ("ranges", "bounds"))
    machine = _table(study, "mechanism")
    kind = kind_of(validate.choice("mechanism.kind", machine.get("kind", DEFAULT_KIND), [*KINDS]))
    found = settings_of(kind, kind.meshed, system, subject)
    entries = {name: x for name, x in found.items() if isinstance(x, Quantity) and x.axis}
    frictions: list[float] = []
    if subject is ESCAPEMENT and isinstance(study.get("friction"), list | tuple):
        low, high = _ends(entries["friction"], "friction", study.pop("friction"))
        # within the range the period of pallets may be greater than at both ends
        frictions, figures[SCATTER] = np.linspace(low, high, _FRICTIONS).tolist(), _SCATTER
    if not ranges:
        remedy = "write for example speed = [3, 9] under [ranges]"
        raise validate.fail("ranges", "a table of numbers to search", "none", remedy)
    validate.known_keys(ranges, [*entries], "in [ranges]")
    validate.known_keys(bounds, [*figures], "in [bounds]")
    usual = "torque_rms" if subject is DRIVE else SCATTER if frictions else "period"
    objectives = content.get("objectives", [usual])
    if isinstance(objectives, str) or not objectives:
        remedy = 'for example ["torque_rms"]'
        raise validate.fail("objectives", "a list of names", objectives, remedy)
    return DriveRequirement(
        study,
        subject,
        frictions,
        figures,
        {name: _ends(entries[name], name, value) for name, value in ranges.items()},
        {name: entries[name] for name in ranges},
        {name: _bound(name, figures[name].kind, value, system) for name, value in bounds.items()},
        tuple(validate.choice("objectives", x, [*figures]) for x in objectives),
    )


def _table(content: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    table = content.get(name, {})
    if not isinstance(table, Mapping):
        raise validate.fail(name, "a table", table, f"write [{name}] on a line of its own")
    return table


def _ends(entry: Quantity, name: str, given: Any) -> Range:
    """The two ends of a range, in the units of the file."""
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise validate.fail(name, "two ends, [low, high]", given, "give the least and the greatest")
    low, high = (
        x if isinstance(x, float) and math.isinf(x) else float(entry.read(name, x)) for x in given
    )
    if not low <= high:
        raise validate.fail(name, "[low, high] with low at most high", given, "swap them")
    return low, high


def _bound(name: str, kind: str, given: Any, system: str) -> Range:
    """Least and greatest value; a single number is the greatest, or the least of `GREATER`."""
    entry = Quantity(
        long_name=name, unit=kind, minimum=-math.inf, remedy="give a number",
        name=name, key=name,
    )  # fmt: skip
    entry = replace(entry, system=system)
    if isinstance(given, list | tuple):
        return _ends(entry, name, given)
    number = float(entry.read(name, given))
    return (number, math.inf) if name in GREATER else (-math.inf, number)
