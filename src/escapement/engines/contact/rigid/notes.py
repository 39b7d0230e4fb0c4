"""The record of an engagement: the starts of its pieces, its events, and the steps it has taken."""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import Event
from escapement.dynamics.event_rows import EVENT
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit
from escapement.numerics.records import record_dtype

ROW = record_dtype(EVENT)
"""A row of the record: the start of a piece, or an event."""


class Notes(NamedTuple):
    """Record of pieces and events, and of the effort.

    rows : the record. used : number of rows in use, and of steps taken. wanted : whether any rows
    are wanted. limit : number of steps after which the engagement is given up.
    """

    rows: np.ndarray
    used: np.ndarray
    wanted: bool
    limit: int


@inner_jit
def note(notes, kind, now):
    """Write a row if there is room; the number of rows is counted in any case."""
    at = notes.used[0]
    notes.used[0] = at + 1
    if at < notes.rows.size:
        row = notes.rows[at]
        row.kind, row.wall, row.time, row.theta = kind, now.wall, now.time, now.theta
        row.speed, row.phi, row.turning = now.speed, now.phi, now.turning
        row.before = row.approach = row.impulse = row.energy = 0.0


@inner_jit
def last_row(notes):
    """The row that was written last."""
    return notes.rows[min(notes.used[0], notes.rows.size) - 1]


@inner_jit
def follow_trend(notes, now, trend):
    """The instant with the sign of theta_ddot from here on, 0 for the same as before.

    Where the sign changes, an extremum of the speed is noted.
    """
    if trend * now.trend < 0.0:
        note(notes, Event.MAXIMUM if now.trend > 0.0 else Event.MINIMUM, now)
    return altered(now, "trend", trend if trend != 0.0 else now.trend)


@inner_jit
def takes_too_many(notes):
    """Count a step; returns whether the engagement has taken more than it may."""
    notes.used[1] += 1
    return notes.used[1] > notes.limit
