"""A design in the served page's form: its numbers by name, and a study of one case in TOML."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from escapement.base.quantity import Setting, declared
from escapement.model.escapement import Escapement, Run
from escapement.model.torque_curve import TorqueCurve
from escapement.study.parse import plan_from


def numbers_of(escapement: Escapement) -> dict[str, Any]:
    """Numbers, words and truth values of an escapement by the names of studies, in SI."""
    found: dict[str, Any] = {}
    for owner in (escapement.mechanism, escapement.inertia, escapement):
        for name, value in owner.settings.items():
            if isinstance(value, TorqueCurve):
                value = value.torque[0]
            if value is None or isinstance(value, int | float | str):
                found[name] = value
            elif hasattr(value, "numerator"):  # a fraction
                found[name] = float(value)
    return found


def text_of(escapement: Escapement, initial_speed: float = 0.0) -> str:
    """The design as a study of one case in TOML."""
    axis = "load_torque" if isinstance(escapement.torque, TorqueCurve) else "torque"
    axes = {axis: [escapement.settings[axis]]}
    found = plan_from(escapement, axes, initial_speed=initial_speed).configuration
    # the engine is not written: it follows from the design, also after a change
    plain = _as_shown(
        found | {"title": "a design of the explorer"}, declared(Escapement) | declared(Run)
    )
    plain["mechanism"] = _as_shown(plain["mechanism"], declared(type(escapement.mechanism)))
    return "\n".join(_lines(plain)) + "\n"


def _as_shown(table: Mapping[str, Any], entries: Mapping[str, Setting]) -> dict[str, Any]:
    """The entries of a table that differ from their defaults."""
    idle = {entry.key: entry.default for entry in entries.values() if not entry.required}
    return {k: v for k, v in table.items() if k != "solver" and not (k in idle and v == idle[k])}


def _lines(table: Mapping[str, Any]) -> list[str]:
    """A table and those within it as lines of TOML."""
    numbers = {name: value for name, value in table.items() if not isinstance(value, Mapping)}
    lines = [f"{name} = {_value(value)}" for name, value in numbers.items() if value is not None]
    for name, value in table.items():
        if isinstance(value, Mapping):
            inner = [f"{key} = {_value(item)}" for key, item in value.items() if item is not None]
            lines += ["", f"[{name}]", *inner]
    return lines


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(map(_value, value)) + "]"
    return json.dumps(value, ensure_ascii=False)
