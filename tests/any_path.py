"""Geneva wheels, and mechanisms with the same pin paths that are not of a registered kind."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import quad

import escapement as esc
from escapement.mechanisms.protocol import Mechanism
from escapement.mechanisms.slotted import transmission


@dataclass(frozen=True)
class Plain(Mechanism):
    """Any path at all: nothing tells the package that it is a Geneva wheel."""

    path: np.ndarray
    half: float

    cell_angle = 2.0 * math.pi
    follower_step = 1.0

    @property
    def breaks(self):
        return -self.half, 0.0, self.half

    def follower_angle(self, theta):
        rates = [quad(lambda x: transmission(self.path, x).g, 0.0, t)[0] for t in np.ravel(theta)]
        return np.reshape(rates, np.shape(theta))


def series_of(path):
    """Edges and coefficients of a table, as it was made from them."""
    pieces, order = (int(x) for x in path.numbers[:2])
    return path.numbers[2 : 3 + pieces], path.numbers[
        3 + pieces : 3 + pieces * (1 + order)
    ].reshape(pieces, order)


def plain(wheel):
    return Plain(wheel.path, wheel.breaks[-1])


def name_of(wheel):
    return f"{wheel.slots}{'-internal' if wheel.internal else ''}"


each_wheel = pytest.mark.parametrize(
    "wheel",
    [esc.Geneva(n, pins=1, internal=k) for n in (3, 4, 5, 8, 40) for k in (False, True)],
    ids=name_of,
)
