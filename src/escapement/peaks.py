"""Greatest accelerations, moment and force of a motion, however narrow their peaks."""

import math

import numpy as np

from escapement.motion import Motion

_NEAREST = 1e-9  # of a piece: how close to its ends a peak is looked for


def peaks(motion: Motion) -> list[float]:
    """Greatest accelerations of driver and follower, contact moment and force of a motion.

    Magnitudes over all pieces, one-sided at boundaries; the force is NaN without a crank
    radius.

    Each grid zooms in on the best point of the one before; a parabola through the
    last three, some 1e-6 of a piece apart, gives what lies between them.
    """
    names = ["theta_ddot", "phi_ddot", "contact_moment"]
    if getattr(motion.escapement.mechanism, "crank_radius", None) is not None:
        names.append("contact_force")
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
    tops = [
        max(_summit(line[max(i - 1, 0) : i + 2]) for line, (i,) in zip(lines, places, strict=True))
        for lines, places in zip(values, best, strict=True)
    ]
    return tops if len(tops) == 4 else [*tops, math.nan]


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
    rise = values[2] - values[0]  # not squared: a force may be too great for that
    return top + float(rise * (rise / (8.0 * bend))) if bend > 0.0 else top
