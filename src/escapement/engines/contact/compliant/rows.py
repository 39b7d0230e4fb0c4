"""States at times within the steps of a march."""

import numpy as np

from escapement.dynamics.torque import cell_of
from escapement.engines.contact.compliant.law import (
    IMPULSE,
    LOST,
    STATE,
    WALLS,
    PinInSlot,
    rates,
    resistance,
    stored,
)
from escapement.engines.contact.compliant.march import CELL, FIRST, MODE, SERIES, TIME, TOUCH
from escapement.engines.contact.compliant.radau import within
from escapement.engines.contact.compliant.slot import pose, slide, to_angle, touches
from escapement.numerics.jit import jit

TABLE = 18
"""Numbers at each time: theta, phi, their speeds and accelerations, moment of the contact on the
follower, force, power lost in each of `dynamics.law.LOSSES`, sliding speed, speed of penetration,
and energy stored in the walls."""


@jit(allocates=True)
def tabulate(rows, which, times, scene, joint, step, out):
    """Fill out[:TABLE] at times, each between the row with its index in `which` and the next."""
    y, slopes = np.zeros(STATE), np.empty(STATE)
    for i in range(times.size):
        here, then = rows[which[i]], rows[which[i] + 1]
        h, mode = then[TIME] - here[TIME], int(here[MODE])
        within((times[i] - here[TIME]) / h, h, here[FIRST:], then[SERIES:], y)
        driver_angle = here[CELL] * cell_of(scene)
        case = PinInSlot(scene, joint, driver_angle, here[TOUCH])
        acceleration, at = rates(y, mode, case, slopes), pose(y, mode, scene)
        on = 1.0 if touches(mode) else 0.0
        out[15, i] = slide(at, mode, scene)
        out[16, i] = mode * at.speed
        out[17, i] = stored(y, mode, case)
        if touches(mode):
            to_angle(y, scene)
        out[0, i], out[1, i], out[2, i] = y[0] + driver_angle, y[2], slopes[2]
        out[3, i], out[4, i], out[5, i] = y[1] + here[CELL] * step, y[3], acceleration
        out[6, i] = on * (acceleration + resistance(y[3], acceleration, scene, joint.slip))
        out[7, i] = mode * on * slopes[IMPULSE]
        out[8:15, i] = slopes[LOST:WALLS]
