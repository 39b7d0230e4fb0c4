"""A plan from an escapement and the axes to vary it over: all in SI."""

import re
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.errors import InvalidValue
from escapement.mechanisms import KINDS, kind_of
from escapement.model import Escapement, Inertia, Mechanism
from escapement.quantity import declared, quantities
from escapement.solver import DEFAULT_ENGINE
from escapement.study.parameters import PlanKind
from escapement.study.parse import parse_plan
from escapement.study.plan import StudyPlan


def plan_from(
    escapement: Escapement,
    axes: Mapping[str, ArrayLike | Mapping[str, Any]],
    *,
    sample: Mapping[str, Any] | None = None,
    initial_speed: float = 0.0,
    engine: str = DEFAULT_ENGINE,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    max_step: float | None = None,
    title: str | None = None,
) -> StudyPlan:
    """Plan a study of `escapement` over `axes`.

    Parameters
    ----------
    escapement : Escapement
        The nominal design; an axis replaces its value. What was left to the
        mechanism, such as the pins of `Geneva(slots=4)`, follows the axes.
    axes : Mapping
        Name of each axis and its values [SI]: numbers, or start, stop and num.
    sample : Mapping, optional
        Parameters that vary together, at every point of the grid: the [sample] table
        of a study, in SI, spread around the values of `escapement`.
    initial_speed : float
        Driver speed at the first pin entry [rad/s], >= 0.
    engine, rtol, atol, method, max_step : optional
        As for `simulate`.
    title : str, optional
        One line for people.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    machine, own = _describe(escapement.mechanism)
    kind = PlanKind.of(escapement.mechanism) if own is not None else PlanKind.named(machine["kind"])
    inertia = escapement.inertia
    solver = {"engine": engine, "rtol": rtol, "atol": atol, "method": method, "max_step": max_step}
    configuration = {
        "mechanism": machine,
        "inertia": {entry.key: getattr(inertia, entry.key) for entry in declared(Inertia).values()},
        "initial_speed": initial_speed,
        "sweep": axes,
        "solver": solver,
    }
    numbers = {
        name: getattr(escapement, name)
        for name, entry in quantities(Escapement).items()
        if entry.fits(kind.meshed)
    }
    chosen = {**numbers, "sample": sample, "title": title}
    configuration |= {name: value for name, value in chosen.items() if value is not None}
    return parse_plan(configuration, mechanism=own)


def _describe(mechanism: Mechanism) -> tuple[dict[str, Any], Mechanism | None]:
    """A mechanism as a [mechanism] table, or itself where no kind fits it."""
    for name in KINDS:
        if type(mechanism) is kind_of(name):
            return {"kind": name} | _chosen(mechanism), None
    # two that look alike may differ in what their repr leaves out
    cell = (*mechanism.breaks, mechanism.cell_angle, mechanism.follower_step)
    checksum = zlib.crc32(np.concatenate([mechanism.path.numbers, cell]).tobytes())
    # where it is in memory is another place in each process
    text = re.sub(r" at 0x[0-9a-fA-F]+", "", repr(mechanism))
    description = f"{text}, checksum {checksum:08x}"
    return {"kind": type(mechanism).__qualname__, "description": description}, mechanism


def _chosen(mechanism: Any) -> dict[str, Any]:
    """The settings that were given, or that the mechanism would not have chosen by itself."""
    settings = declared(type(mechanism))
    chosen = {name: getattr(mechanism, name) for name in settings}
    given = getattr(mechanism, "given", ())
    for name, setting in settings.items():
        if setting.required or name in given:
            continue
        without = {key: value for key, value in chosen.items() if key != name}
        try:
            own_choice = getattr(type(mechanism)(**without), name)
        except InvalidValue:  # there is no such mechanism without it
            continue
        if own_choice == chosen[name]:
            chosen = without
    return chosen
