"""A mechanism of no kind that the package knows: any pin path at all."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad

from escapement.mechanisms._slotted import transmission


@dataclass(frozen=True)
class Plain:
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


def plain(wheel):
    return Plain(wheel.path, wheel.breaks[-1])
