"""Another way to read the angles that would make them those of the mechanism."""

import math
from typing import Any

import numpy as np

from escapement.measurement.fit import fit_zeros
from escapement.measurement.readings import TURN

_UNITS = {"turns": 360.0, "radians": 180.0 / math.pi}
"""Degrees in a unit that angles may be in when they are taken for degrees."""
_OPTIONS = {"turns": "turn", "radians": "rad"}


def other_reading(result: Any, cells: float, small: float) -> str:
    """What to try where the angles would fit this mechanism if read otherwise, else "".

    Tried are other units, and the columns exchanged.

    Parameters
    ----------
    result : Measurement
        Readings that do not fit as they were read.
    cells : float
        Cells that both shafts would have to move through.
    small : float
        Greatest standard deviation of the errors, as a share of a follower step.
    """
    tries = [
        (name, factor * result.input, factor * result.output) for name, factor in _UNITS.items()
    ]
    tries.append(("", result.output, result.input))
    step = abs(result.mechanism.follower_step)
    least = cells * result.mechanism.cell_angle * (result.errors.size - 1) / result.errors.size
    for name, angle, output in tries:
        if np.ptp(angle) < 0.999 * least or np.ptp(output) < 0.5 * min(cells * step, TURN):
            continue
        error = float(fit_zeros(result.mechanism, angle, output).errors.std())
        if error < small * step:
            agreement = f"within {math.degrees(error):.3g} degrees"
            if not name:
                return f"With input and output exchanged, they fit this mechanism {agreement}."
            unit = _OPTIONS[name]
            return (
                f"Read as {name}, the angles fit this mechanism {agreement}: give --angle-unit "
                f"{unit}, "
                f"in Python angle_unit={unit!r}."
            )
    return ""
