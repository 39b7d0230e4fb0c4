"""Figures of merit: what a designer reads off a motion.

The terminal figures belong to the cycle that repeats itself. Rise and settling
time compare the extrema of the motion from its start with that cycle.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from escapement.motion import Extrema, Motion
from escapement.peaks import peaks
from escapement.status import MESSAGES, Status

RISE_BAND = 0.02
"""A rise is over at the first extremum this close to its terminal value [-]."""
SETTLING_BAND = 0.01
"""A motion is settled when every later extremum is this close [-]."""
MAX_ENGAGEMENTS = 1_000_000
"""A rise or settling time beyond this many engagements is not given."""
BOUNDLESS = 1e-12
"""A gain over w below which a ratio that no loss outweighs is constant to rounding [-]."""

NAN = math.nan


@dataclass(frozen=True, eq=False)  # NaN, and what is not worked out yet, would not compare
class Figures:
    """Figures of merit of an escapement; NaN where there is none.

    What the terminal engagement's motion has to be sampled for is worked out when first
    asked for: acceleration_max to reversal_angles.

    velocity_max, velocity_min : extremes of the terminal driver speed [rad/s].
    velocity_mean : cell angle over period [rad/s].
    period : time of one terminal engagement, dwell included [s].
    rise_time : first velocity extremum within 2 % of its terminal value [s].
    settling_time : first extremum from which on every engagement's extremes
        are within 1 % [s].
    handoff_velocity : driver speed at the terminal handoff [rad/s].
    contraction : factor by which an engagement shrinks a small deviation of
        the squared handoff speed from its terminal value [-].
    acceleration_max, follower_acceleration_max : greatest magnitudes over the
        terminal cycle [rad/s^2].
    contact_moment_max : greatest magnitude of the moment on the follower [N m].
    contact_force_max : greatest magnitude of the force on the pin [N]; NaN
        without a crank radius.
    energy_residual : energy unaccounted for over the terminal cycle, of the
        work done [-].
    reversal_angles : pin reversals of the terminal cycle, from dead centre [rad].
    critical_friction : Painleve limit [-].
    motion : one engagement of the terminal cycle, None where there is none.
    status, message : outcome, and why in a sentence.
    """

    velocity_max: float = NAN
    velocity_min: float = NAN
    velocity_mean: float = NAN
    period: float = NAN
    rise_time: float = NAN
    settling_time: float = NAN
    handoff_velocity: float = NAN
    contraction: float = NAN
    critical_friction: float = NAN
    motion: Motion | None = field(default=None, repr=False)
    status: Status = Status.OK
    message: str = MESSAGES[Status.OK]

    @property
    def velocity_average_published(self) -> float:
        """(max + min)/2, the thesis' average terminal velocity [rad/s]."""
        return (self.velocity_max + self.velocity_min) / 2.0

    @cached_property
    def _peaks(self) -> list[float]:
        return [NAN] * 4 if self.motion is None else peaks(self.motion)

    @property
    def acceleration_max(self) -> float:
        """Greatest driver acceleration [rad/s^2]."""
        return self._peaks[0]

    @property
    def follower_acceleration_max(self) -> float:
        """Greatest follower acceleration [rad/s^2]."""
        return self._peaks[1]

    @property
    def contact_moment_max(self) -> float:
        """Greatest moment on the follower [N m]."""
        return self._peaks[2]

    @property
    def contact_force_max(self) -> float:
        """Greatest force on the pin [N]."""
        return self._peaks[3]

    @property
    def energy_residual(self) -> float:
        """Energy unaccounted for, of the work done [-]."""
        return NAN if self.motion is None else self.motion.ledger.residual

    @property
    def reversal_angles(self) -> tuple[float, ...]:
        """Pin reversals, from dead centre [rad]."""
        if self.motion is None:
            return ()
        turned, cell = self.motion.reversals, self.motion.escapement.mechanism.cell_angle
        return tuple((turned.theta - turned.engagement * cell).tolist())

    def as_dict(self) -> dict[str, Any]:
        """All figures by name, with the published average beside the mean."""
        return {name: getattr(self, name) for name in _NAMES}


_NAMES = (
    *("velocity_max", "velocity_min", "velocity_mean", "velocity_average_published", "period"),
    *("rise_time", "settling_time", "handoff_velocity", "contraction", "acceleration_max"),
    *("follower_acceleration_max", "contact_moment_max", "contact_force_max"),
    *("critical_friction", "energy_residual", "reversal_angles", "status", "message"),
)


def read_cycle(cycle: Motion, base: Figures) -> Figures:
    """Terminal figures from one engagement that starts at the terminal speed."""
    speeds = np.concatenate([cycle.extrema.theta_dot, cycle.at([0.0, cycle.end_time]).theta_dot])
    return replace(
        base,
        velocity_max=float(speeds.max()),
        velocity_min=float(speeds.min()),
        velocity_mean=float(cycle.escapement.mechanism.cell_angle / cycle.end_time),
        period=float(cycle.end_time),
        handoff_velocity=float(cycle.handoff_velocities[0]),
        motion=cycle,
    )


def read_transient(motion: Motion, figures: Figures) -> tuple[float, float]:
    """Rise and settling time [s] of a motion that has reached its terminal cycle.

    NaN for a time the motion is too short to show.
    """
    extrema = motion.extrema
    terminal = np.where(extrema.maximum, figures.velocity_max, figures.velocity_min)
    error = np.abs(extrema.theta_dot / terminal - 1.0)
    risen = np.nonzero(error <= RISE_BAND)[0]
    leading = _leading(extrema)
    unsettled = np.nonzero(error[leading] > SETTLING_BAND)[0]
    later = leading[unsettled[-1] + 1 :] if unsettled.size else leading
    return (
        float(extrema.time[risen[0]]) if risen.size else NAN,
        float(extrema.time[later[0]]) if later.size else NAN,
    )


def _leading(extrema: Extrema) -> np.ndarray:
    """Indices of extrema that are the greatest or least of their engagement.

    A lesser hump tends to its own limit, not to the terminal extreme. An
    extremum on a handoff belongs to the engagement that begins there.
    """
    chosen: list[int] = []
    for engagement in np.unique(extrema.engagement):
        for kind, best in ((True, np.argmax), (False, np.argmin)):
            same = np.nonzero((extrema.engagement == engagement) & (extrema.maximum == kind))[0]
            if same.size:
                chosen.append(int(same[best(extrema.theta_dot[same])]))
    return np.array(sorted(chosen), dtype=int)
