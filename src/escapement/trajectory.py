"""What an engine hands over: the pieces of a motion, and its events."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from escapement.model import FloatArray


@dataclass(frozen=True)
class Events:
    """Instants of one kind: arrays of one length.

    engagement : index of the engagement, from 0.
    time : [s].
    theta : cumulative driver angle from the first dead centre [rad].
    theta_dot : driver speed [rad/s].
    """

    engagement: np.ndarray
    time: FloatArray
    theta: FloatArray
    theta_dot: FloatArray


@dataclass(frozen=True)
class Extrema(Events):
    """Extrema of the driver speed; `maximum` tells the two kinds apart."""

    maximum: np.ndarray


class Trajectory(Protocol):
    """What an engine hands over: pieces, and the state within a piece."""

    @property
    def start(self) -> FloatArray:
        """Start time of each piece [s]."""

    @property
    def engagement(self) -> np.ndarray:
        """Engagement of each piece."""

    @property
    def sign(self) -> FloatArray:
        """+1 or -1: side of the slot that carries the force; 0: follower locked."""

    @property
    def friction_loss(self) -> FloatArray:
        """Work lost in friction over each piece [J]."""

    @property
    def reversals(self) -> Events:
        """Every pin reversal."""

    @property
    def extrema(self) -> Extrema:
        """Every extremum of the driver speed, corners at handoffs included."""

    def state(self, piece: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angle in the cell [rad] and speed [rad/s] at times within a piece."""


class Nothing:
    """Trajectory of a scene that has no motion."""

    _none = np.empty(0)
    start = sign = friction_loss = _none
    engagement = _none.astype(int)
    reversals = Events(engagement, _none, _none, _none)
    extrema = Extrema(engagement, _none, _none, _none, maximum=_none.astype(bool))

    def state(self, piece: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Never asked for: there is no piece."""
        raise IndexError(piece)
