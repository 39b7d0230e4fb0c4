"""What an engine hands over: the pieces of a motion, and its events."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from escapement.base.text import Shown
from escapement.mechanisms.protocol import FloatArray

if TYPE_CHECKING:
    from escapement.dynamics.motion import State


@dataclass(frozen=True, repr=False)
class Events(Shown):
    """Instants of one kind: arrays of one length.

    engagement : index of the engagement, from 0.
    time : [s].
    theta : cumulative driver angle from the first dead centre [rad].
    theta_dot : driver speed [rad/s].
    """

    _units: ClassVar[dict[str, str]] = {"time": "s", "theta": "rad", "theta_dot": "rad/s"}

    engagement: np.ndarray
    time: FloatArray
    theta: FloatArray
    theta_dot: FloatArray


@dataclass(frozen=True, repr=False)
class Extrema(Events):
    """Extrema of the driver speed; `maximum` tells maxima from minima."""

    maximum: np.ndarray


@dataclass(frozen=True, repr=False)
class Handoffs(Events):
    """Handoffs from pin to pin; `theta_dot` is the driver speed with which the new pin begins.

    kind : "overlap", "pick-up" (the driver turned free before it) or "strike".
    speed_before : driver speed before the impact [rad/s], elsewhere the same as `theta_dot`.
    impulse : angular impulse of the impact on the follower [N m s], 0 where there is none.
    energy : what both bodies lose in the impact [J], friction along the wall included.
    jump : by how much the follower jumps ahead from one pin to the other [rad].
    clearance_needed : by how much the slot must be wider than the pin for that [m]; NaN
        without a length.
    """

    _units: ClassVar[dict[str, str]] = {
        **Events._units,
        **{"speed_before": "rad/s", "impulse": "N m s", "energy": "J", "jump": "rad"},
        "clearance_needed": "m",
    }

    kind: np.ndarray
    speed_before: FloatArray
    impulse: FloatArray
    energy: FloatArray
    jump: FloatArray
    clearance_needed: FloatArray


@dataclass(frozen=True, repr=False)
class Impacts(Events):
    """Blows between pin and slot; `theta_dot` is the driver speed behind each.

    wall : +1 the wall that pushes the follower forward, -1 the one that holds it back; 0 where
        the follower is stopped and locked after the exit of the pin.
    speed_before : driver speed before the impact [rad/s].
    approach_speed : speed with which pin and wall approach each other [m/s].
    impulse : of the normal force [N s].
    energy : what both bodies lose in the impact [J], friction along the wall included.
    """

    _units: ClassVar[dict[str, str]] = {
        **Events._units,
        **{"speed_before": "rad/s", "approach_speed": "m/s", "impulse": "N s", "energy": "J"},
    }

    wall: FloatArray
    speed_before: FloatArray
    approach_speed: FloatArray
    impulse: FloatArray
    energy: FloatArray


class Trajectory:
    """Base of all trajectories: the pieces of a motion, its events, and the states within them.

    The first six attributes must be given, and either `state` or `states`; all others have
    defaults. Those of a follower that is free of the driver, in clearance or between walls that
    yield, give `states_at`, and the attributes that are None here.
    """

    start: Any
    """Start time of each piece [s]."""
    engagement: Any
    """Engagement of each piece."""
    sign: Any
    """+1 or -1: side of the slot that carries the force, or wall that the pin touches; 0: the
    follower is locked, or the pin in flight."""
    losses: Any
    """Work lost over each piece in each of `dynamics.law.LOSSES` [J], shape (7, n)."""
    reversals: Any
    """Every pin reversal: `Events`."""
    extrema: Any
    """Every extremum of the driver speed, corners at handoffs included: `Extrema`."""

    impacts: Any = None
    """Blows between pin and slot, `Impacts`; None where there are none but those of handoffs."""
    slide_changes: Any = None
    """`Events` at which sliding reverses; None where they follow from the pieces."""
    load_work: Any = None
    """What the load takes over each piece [J]; None where it follows from the angles."""
    elastic: Any = 0.0
    """Energy stored in walls at the end, less that at the start [J]."""
    hardest: Any = None
    """Greatest contact force [N] and its time [s]; None where samples of the motion show it."""
    peaks: Any = None
    """Greatest magnitudes over each piece of both accelerations, the contact moment and the force
    of a crank of 1 m, shape (4, n), in SI; None where states of the motion are sampled for them."""

    def state(self, piece: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angles in the cell [rad] and speeds [rad/s] at times within a piece."""
        raise NotImplementedError

    def states(self, pieces: np.ndarray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The same at times, each within a piece of its own."""
        found = np.empty((2, t.size))
        # each piece is asked once for all times within it
        order = np.argsort(pieces, kind="stable")
        firsts = np.flatnonzero(np.diff(pieces[order], prepend=-1))
        for first, last in pairwise([*firsts.tolist(), t.size]):
            chosen = order[first:last]
            found[:, chosen] = self.state(pieces[chosen[0]], t[chosen])
        return found[0], found[1]

    def states_at(self, pieces: np.ndarray, t: FloatArray) -> "State | None":
        """Whole states at times within pieces; None where they follow from `states`."""
        return None

    def around(self, t: FloatArray) -> Self:
        """A trajectory with the pieces that hold these times [s], perhaps without others."""
        return self

    def parts(self) -> Iterator[tuple[Self, slice]]:
        """Trajectories of some engagements each, one after the other, and which these are.

        A short one is its only part.
        """
        yield self, slice(None)


class NoTrajectory(Trajectory):
    """Trajectory of an escapement that has no motion: it consists of no pieces."""

    start = sign = np.empty(0)
    losses = np.empty((7, 0))
    engagement = np.empty(0, dtype=int)
    reversals = Events(engagement, start, start, start)
    extrema = Extrema(engagement, start, start, start, maximum=np.empty(0, dtype=bool))
