"""Figures of merit: what a designer reads off a motion.

The terminal figures belong to the cycle that repeats itself. Rise and settling
time compare the extrema of the motion from its start with that cycle.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from escapement.motion import Extrema, Motion
from escapement.status import MESSAGES, Status

RISE_BAND = 0.02
"""A rise is over at the first extremum this close to its terminal value [-]."""
SETTLING_BAND = 0.01
"""A motion is settled when every later extremum is this close [-]."""
MAX_ENGAGEMENTS = 1_000_000
"""A rise or settling time beyond this many engagements is not given."""
BOUNDLESS = 1e-12
"""A gain over w below which a ratio that no loss outweighs is constant to rounding [-]."""
_NEAREST = 1e-9  # of a piece: how close to its ends a peak is looked for

NAN = math.nan


@dataclass(frozen=True)
class Figures:
    """Figures of merit of an escapement; NaN where there is none.

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
    critical_friction : Painleve limit [-].
    energy_residual : energy unaccounted for over the terminal cycle, of the
        work done [-].
    reversal_angles : pin reversals of the terminal cycle, from dead centre [rad].
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
    acceleration_max: float = NAN
    follower_acceleration_max: float = NAN
    contact_moment_max: float = NAN
    contact_force_max: float = NAN
    critical_friction: float = NAN
    energy_residual: float = NAN
    reversal_angles: tuple[float, ...] = ()
    status: Status = Status.OK
    message: str = MESSAGES[Status.OK]

    @property
    def velocity_average_published(self) -> float:
        """(max + min)/2, the thesis' average terminal velocity [rad/s]."""
        return (self.velocity_max + self.velocity_min) / 2.0

    def as_dict(self) -> dict[str, Any]:
        """Fields by name, with the published average beside the mean."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return values | {"velocity_average_published": self.velocity_average_published}


def read_cycle(cycle: Motion, base: Figures) -> Figures:
    """Terminal figures from one engagement that starts at the terminal speed."""
    speeds = np.concatenate([cycle.extrema.theta_dot, cycle.at([0.0, cycle.end_time]).theta_dot])
    mechanism = cycle.escapement.mechanism
    cell = mechanism.cell_angle
    names = ["theta_ddot", "phi_ddot", "contact_moment"]
    if getattr(mechanism, "crank_radius", None) is not None:
        names.append("contact_force")
    acceleration, follower_acceleration, moment, *force = _peaks(cycle, names)
    turned = cycle.reversals.theta - cycle.reversals.engagement * cell
    return replace(
        base,
        velocity_max=float(speeds.max()),
        velocity_min=float(speeds.min()),
        velocity_mean=float(cell / cycle.end_time),
        period=float(cycle.end_time),
        handoff_velocity=float(cycle.handoff_velocities[0]),
        acceleration_max=acceleration,
        follower_acceleration_max=follower_acceleration,
        contact_moment_max=moment,
        contact_force_max=force[0] if force else NAN,
        energy_residual=cycle.ledger.residual,
        reversal_angles=tuple(turned.tolist()),
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


def _peaks(motion: Motion, names: Sequence[str]) -> list[float]:
    """Greatest magnitudes of quantities over all pieces, one-sided at boundaries.

    Each grid zooms in on the best point of the one before; a parabola through the
    last three, some 1e-6 of a piece apart, gives what lies between them.
    """
    bounds = np.append(motion.trajectory.start, motion.end_time)
    pieces = np.arange(bounds.size - 1)[:, None]
    # a row for all quantities at first, then one for each
    grid = _looks(motion, pieces, bounds)[None]
    for size in (33, 33, 33, 0):
        state = motion.within(pieces, grid)
        columns = [getattr(state, name) for name in names]
        values = np.abs([column[min(row, grid.shape[0] - 1)] for row, column in enumerate(columns)])
        best = values.argmax(axis=-1, keepdims=True)
        grid = np.broadcast_to(grid, values.shape)
        low = np.take_along_axis(grid, np.maximum(best - 1, 0), axis=-1)[..., 0]
        high = np.take_along_axis(grid, np.minimum(best + 1, grid.shape[-1] - 1), axis=-1)[..., 0]
        if size:
            grid = np.linspace(low, high, size, axis=-1)
    return [
        max(_summit(line[max(i - 1, 0) : i + 2]) for line, (i,) in zip(lines, places, strict=True))
        for lines, places in zip(values, best, strict=True)
    ]


def _looks(motion: Motion, pieces: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Times within each piece at which no peak is overlooked, a row a piece.

    Next to the ends of a piece a light driver's acceleration peaks within an angle of
    sqrt(rho), and a slow one passes much of the angle in little of the time: so they
    are even in time as well as in angle, and ever closer towards both ends.
    """
    ends = np.geomspace(_NEAREST, 0.25, 48)
    shares = np.unique(np.concatenate([np.linspace(0.0, 1.0, 129), ends, 1.0 - ends]))
    low, high = bounds[:-1, None], bounds[1:, None]
    by_time = low + (high - low) * shares
    theta = motion.within(pieces, by_time).theta
    angles = theta[:, :1] + (theta[:, -1:] - theta[:, :1]) * shares
    by_angle = np.array(list(map(np.interp, angles, theta, by_time)))
    return np.sort(np.concatenate([by_time, by_angle], axis=1), axis=1)


def _summit(values: np.ndarray) -> float:
    """Top of the parabola through three even samples, the middle one the greatest."""
    top = float(values.max())
    if values.size < 3:
        return top
    bend = 2.0 * values[1] - values[0] - values[2]
    return top + float((values[2] - values[0]) ** 2 / (8.0 * bend)) if bend > 0.0 else top
