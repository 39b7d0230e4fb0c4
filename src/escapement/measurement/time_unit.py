"""Doubts about the unit of measured times, from the times that a design takes."""

import math

from escapement.base import spoken
from escapement.base.errors import InvalidValue

_DOUBTFUL = 10.0  # a ratio of times beyond this means a torque that is wrong a hundred times
_CLOSE = 4.0  # a ratio within this factor of that of a unit may come from the unit
_READ_AS_S = {"ns": 1e9, "us": 1e6, "ms": 1e3, "minutes": 1.0 / 60.0, "hours": 1.0 / 3600.0}
"""Units of time, and by how much times in them are too long if they are read as seconds."""


def check_unit(name: str, ratio: float, text: str, torque: float | None = None) -> None:
    """Raise InvalidValue where measured times are far from those of a design.

    Parameters
    ----------
    name : str
        Argument that holds the measured times.
    ratio : float
        Measured time divided by the time of the design, above 0 [-].
    text : str
        Both times in words.
    torque : float, optional
        The design's torque [N m]; the message says with which torque the times would be right.
    """
    if 1.0 / _DOUBTFUL <= ratio <= _DOUBTFUL:
        return
    unit = min(_READ_AS_S, key=lambda one: abs(math.log(ratio / _READ_AS_S[one])))
    guess = ""
    if abs(math.log(ratio / _READ_AS_S[unit])) < math.log(_CLOSE):
        guess = f", which may be {unit} taken as s"
    right = "correct the numbers of the escapement"
    if torque is not None:
        needed = spoken.as_spoken(torque / ratio**2, "torque", 2)
        right = f"give the escapement a torque of about {needed}"
    raise InvalidValue(
        f"{name} must be of the order of the design's, got {text}; check the unit of the "
        f"times{guess}, or, if it is right, {right}"
    )
