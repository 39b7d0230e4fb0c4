"""Errors of single slots and pins, which return whenever the part is engaged.

A slot whose angle is wrong moves the follower while a pin is in it, and in the dwell behind it. A
pin whose angle is wrong acts as an error of the input. Each part is compared with the mean of the
others.
"""

from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from escapement.base.lazy import Lazy
from escapement.measurement.normal_equations import Fitted, log_of
from escapement.measurement.readings import TURN
from escapement.mechanisms.protocol import FloatArray, Mechanism

special = Lazy("scipy.special")
_MOST = 64  # parts of a shaft


class Parts(NamedTuple):
    """Which part of a shaft is engaged at each sample: 0, 1, .. below `size`.

    engaged : which part, shape (n,).
    numbers : number of each part, counted from that of the first sample on, shape (size,).
    """

    engaged: np.ndarray
    numbers: np.ndarray

    @property
    def size(self) -> int:
        """How many parts were seen."""
        return len(self.numbers)

    def columns(self, part: slice) -> Iterator[FloatArray]:
        """Columns whose coefficients are errors that add up to zero; the last one follows."""
        index = self.engaged[part]
        last = (index == self.size - 1).astype(float)
        for number in range(self.size - 1):
            yield (index == number) - last


def parts_met(mechanism: Mechanism, driver: FloatArray) -> dict[str, Parts]:
    """The pins and slots of a mechanism that has several, by their shaft."""
    cells = np.floor((driver - mechanism.breaks[0]) / mechanism.cell_angle).astype(int)
    angles = {"input": mechanism.cell_angle, "output": abs(mechanism.follower_step)}
    found = {}
    for shaft, angle in angles.items():
        share = Fraction(angle / TURN).limit_denominator(_MOST)
        if share.numerator != 1 or abs(float(share) * TURN - angle) > 1e-9:
            continue
        since = np.mod(cells - cells[0], share.denominator)
        numbers, index = np.unique(since, return_inverse=True)
        if numbers.size > 1:
            found[shaft] = Parts(index, numbers + 1)
    return found


def worst_part(fitted: Fitted, parts: Parts) -> tuple[int, float, float, float]:
    """Number of the worst part, its size and standard error, and the logarithm of its p-value."""
    count = parts.size
    # each part less the mean of the others, from errors that add up to zero
    contrasts = np.vstack([np.eye(count - 1), -np.ones(count - 1)]) * (count / (count - 1))
    sizes = contrasts @ fitted.values
    errors = np.sqrt(np.einsum("ij,jk,ik->i", contrasts, fitted.covariance, contrasts))
    worst = int(np.argmax(np.abs(sizes) / errors))
    height = abs(sizes[worst]) / errors[worst]
    # two parts differ from each other by the same
    tried = count if count > 2 else 1
    p_value = min(1.0, 2.0 * tried * float(special.stdtr(fitted.freedom, -height)))
    alone = fitted._replace(explained=height**2 * fitted.variance)
    return (
        int(parts.numbers[worst]),
        float(sizes[worst]),
        float(errors[worst]),
        log_of(p_value, alone),
    )
