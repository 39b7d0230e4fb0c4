"""A Geneva wheel with the errors of its parts, as large as they are or exaggerated."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.mechanisms import Geneva
from escapement.mechanisms.wheel_checks import IMPERFECT
from escapement.outlines.curves import FloatArray


def scaled_errors(mechanism: Geneva, factor: float) -> Geneva:
    """The wheel with all errors times a factor; InvalidValue if such a wheel could not turn."""
    factor = validate.number("exaggerate", factor, remedy := "give a factor, 1 for true scale")
    if factor < 0.0:
        raise validate.fail("exaggerate", "at least 0", factor, remedy)
    if factor == 1.0 and not mechanism.misfit:
        return mechanism
    given = {name: mechanism.settings[name] for name in IMPERFECT}
    larger: dict[str, Any] = {
        name: tuple(factor * x for x in value) if isinstance(value, tuple) else factor * value
        for name, value in given.items()
    }
    found = replace(mechanism, **larger)
    if found.misfit and factor != 1.0:
        raise validate.fail("exaggerate", "small enough for pins to meet slots", factor, remedy)
    if found.misfit:
        raise InvalidValue(found.misfit)
    return found


def each(errors: Sequence[float], count: int | None) -> FloatArray:
    """Errors of pins or slots, zeros if none are given."""
    return np.array(errors or (0.0,) * (count or 1), dtype=float)
