"""A design in Python and what varies of it, as the content of a study file, planned."""

import re
import zlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Setting, declared
from escapement.base.units import DEGREE
from escapement.constant_speed.index_case import IndexCase
from escapement.mechanisms import KINDS, kind_of
from escapement.mechanisms.protocol import Mechanism
from escapement.model.escapement import Escapement
from escapement.study.parse.configuration import parse_plan
from escapement.study.plan import StudyPlan, built_once
from escapement.study.subject import DRIVE

_KEY = "study.design"


def plan_from(
    escapement: Escapement | IndexCase,
    axes: Mapping[str, ArrayLike | Mapping[str, Any]],
    *,
    sample: Mapping[str, Any] | None = None,
    initial_speed: ArrayLike = 0.0,
    turns: float | None = None,
    results: Sequence[str] | None = None,
    title: str | None = None,
    **solver: Any,
) -> StudyPlan:
    """Plan a study of `escapement` over `axes`.

    Parameters
    ----------
    escapement : Escapement
        The nominal design; an axis replaces its value. Settings that the mechanism chose, such as
        the pins of `Geneva(slots=4)`, are chosen again in each case.
    axes : Mapping
        Name of each axis and its values [SI]: numbers, or start, stop and num.
    sample : Mapping, optional
        Parameters that vary together, at every point of the grid: the [sample] table
        of a study, in SI, spread around the values of `escapement`.
    initial_speed : float or array
        Driver speed at the first pin entry [rad/s], >= 0; an array is the last axis.
    turns : float, optional
        Driver turns to run, of which `run_time` is the time.
    results : sequence of str, optional
        Figures of merit to keep. Default: those that its subject has by default.
    title : str, optional
        One line for people.
    **solver : optional
        Fields of `Solver`.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    if not isinstance(escapement, Escapement | IndexCase):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    kept, axes = escapement.kept if isinstance(escapement, Escapement) else {}, dict(axes)
    if _KEY not in kept:
        kept[_KEY] = _design(escapement)
    design, described = kept[_KEY]
    numbers: dict[str, Any] = {}
    if isinstance(escapement, Escapement):
        numbers["initial_speed"] = initial_speed
        if np.ndim(initial_speed) > 0:
            axes, numbers = axes | numbers, {}
    elif np.any(initial_speed):
        rule, remedy = "0 for an indexing drive, whose speed is constant", "leave it out"
        raise validate.fail("initial_speed", rule, initial_speed, remedy)
    chosen: dict[str, Any] = {"title": title, "results": results, "sample": sample}
    chosen |= {"solver": solver, "turns": turns}
    chosen = {name: value for name, value in chosen.items() if value is not None}
    return parse_plan(design | numbers | {"sweep": axes} | chosen, mechanism=described)


def _design(escapement: Escapement | IndexCase) -> tuple[dict[str, Any], Mechanism | None]:
    """The numbers and tables of a design, and its mechanism if it is of no known kind."""
    machine, described = _describe(escapement.mechanism)
    entries, given = declared(type(escapement)), escapement.settings.items()
    found: dict[str, Any] = {"mechanism": machine}
    found |= {n: _as_read(entries[n], x) for n, x in given if x != entries[n].default}
    if isinstance(escapement, Escapement):
        parts = {"inertia": escapement.inertia, **escapement.trains}
        return found | {name: part.by_key for name, part in parts.items()}, described
    return found | {"study": DRIVE.name}, described


def _describe(mechanism: Mechanism) -> tuple[dict[str, Any], Mechanism | None]:
    """A mechanism as a [mechanism] table, or the mechanism itself if it is of no known kind."""
    for name in KINDS:
        if type(mechanism) is kind_of(name):
            entries, chosen = declared(kind_of(name)), _chosen(mechanism)
            return {"kind": name} | {n: _as_read(entries[n], x) for n, x in chosen.items()}, None
    # the numbers distinguish two mechanisms with the same repr
    cell = (*mechanism.breaks, mechanism.cell_angle, mechanism.follower_step)
    checksum = zlib.crc32(np.concatenate([mechanism.path.numbers, cell]).tobytes())
    # an address in memory differs from process to process
    text = re.sub(r" at 0x[0-9a-fA-F]+", "", repr(mechanism))
    description = f"{text}, checksum {checksum:08x}"
    return {"kind": type(mechanism).__qualname__, "description": description}, mechanism


def _as_read(entry: Setting, value: Any) -> Any:
    """A value in SI as a study file has it, which tells some angles in degrees."""
    return value / DEGREE if entry.unit == "degrees" and value is not None else value


def _chosen(mechanism: Any) -> dict[str, Any]:
    """The settings that were given, or that the mechanism would not have chosen by itself."""
    kind: Any = type(mechanism)
    chosen = dict(mechanism.settings)
    entries = declared(kind).items()
    needed = {name for name, entry in entries if entry.required or name in mechanism.given}
    others = [name for name, _ in entries if name not in needed]
    # mostly it would choose all the others again; if not, each is tried by itself
    for left_out in [others, *([name] for name in others)]:
        without = {key: value for key, value in chosen.items() if key not in left_out}
        with suppress(InvalidValue, TypeError):  # there may be no such mechanism
            settings = built_once(kind, tuple(without.items())).settings
            if all(settings[name] == chosen[name] for name in left_out):
                chosen = without
        if not chosen.keys() - needed:
            break
    return chosen
