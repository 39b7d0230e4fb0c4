"""What every contestant solves, and how wrong its answer is.

Four slots, four pins and Meyer's inertias (1973, Appendix E) under 0.10 in-lbf, twenty
engagements from rest. The answer is the time and the driver speed at each handoff; the
error is the largest relative difference from a reference of twenty digits.
"""

import json
import math
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files

import numpy as np

from escapement.mechanisms import Geneva
from escapement.model import Escapement, FloatArray, Inertia
from escapement.units import INCH_POUND

REFERENCE = "reference.json"
"""Data file of this package, written by `benchmarks/make_reference.py`."""


@dataclass(frozen=True)
class Problem:
    """A motion from rest with a known answer.

    Parameters
    ----------
    name, title : str
        In files, and in figures.
    friction : float
        Coefficient of friction [-].
    slots : int
        Slots of an external wheel in continuous engagement.
    driver_inertia, follower_inertia : float
        Moments of inertia [kg m^2].
    torque : float
        Driving torque [N m].
    engagements : int
        Handoffs that are compared.
    """

    name: str
    title: str
    friction: float
    slots: int = 4
    driver_inertia: float = 3e-6 * INCH_POUND
    follower_inertia: float = 50e-6 * INCH_POUND
    torque: float = 0.10 * INCH_POUND
    engagements: int = 20

    @cached_property
    def escapement(self) -> Escapement:
        """The problem as the package states it."""
        return Escapement(
            mechanism=Geneva(slots=self.slots),
            inertia=Inertia(driver=self.driver_inertia, follower=self.follower_inertia),
            friction=self.friction,
            torque=self.torque,
        )

    @cached_property
    def numbers(self) -> tuple[float, float, float, float]:
        """Centre distance, inertia ratio, friction and half the engagement angle [rad].

        All a solver needs to know when the follower's inertia, the torque and
        `clock` are its units.
        """
        turn = math.pi / self.slots
        ratio = self.driver_inertia / self.follower_inertia
        return 1.0 / math.sin(turn), ratio, self.friction, math.pi / 2.0 - turn

    @property
    def clock(self) -> float:
        """Unit of time of `numbers`, sqrt(I_f / torque) [s]."""
        return math.sqrt(self.follower_inertia / self.torque)

    @cached_property
    def reference(self) -> tuple[FloatArray, FloatArray]:
        """Handoff times [s] and speeds [rad/s], correctly rounded."""
        text = files(__package__).joinpath(REFERENCE).read_text(encoding="utf-8")
        record = json.loads(text)[self.name]
        times, speeds = record["handoff_times"], record["handoff_velocities"]
        return np.array([float(x) for x in times]), np.array([float(x) for x in speeds])

    def error(self, times: FloatArray, speeds: FloatArray) -> float:
        """Largest relative error of handoff times and speeds [-]; NaN where one is missing."""
        if len(times) != self.engagements:
            return math.nan
        found, expected = np.array([times, speeds]), np.array(self.reference)
        return float(np.abs(found / expected - 1.0).max())


PROBLEMS = (
    Problem("meyer", r"four slots, $\mu$ = 0.35", 0.35),
    # the Painleve limit is 0.406079: the reduced inertia falls to a hundredth
    Problem("near-limit", r"$\mu$ = 0.402, 99 % of the Painlevé limit", 0.402),
)
