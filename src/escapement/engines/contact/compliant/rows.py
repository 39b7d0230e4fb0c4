"""What the steps of a march say of the times between them."""

import numpy as np

from escapement.drive import cell_of
from escapement.engines.contact.compliant.law import (
    IMPULSE,
    LOST,
    STATE,
    WALLS,
    Engagement,
    place,
    rates,
    resistance,
    slide_of,
    stored,
)
from escapement.engines.contact.compliant.march import (
    BENDS,
    CELL,
    FIRST,
    MODE,
    TIME,
    TOUCH,
)
from escapement.jit import inner_jit, jit

TABLE = 16
"""Of each time theta, phi, their speeds and accelerations, moment of the contact on the follower,
force, power lost in each of `dynamics.LOSSES`, sliding speed, speed of penetration,
and energy that the walls hold."""


@inner_jit
def between(start, end, x, h):
    """Value, slope and second derivative of the quintic through both ends, at the share x.

    Each end is a value, its slope and its second derivative.
    """
    value, slope, bend = start
    gap = end[0] - value - h * (slope + 0.5 * h * bend)
    rise = h * (end[1] - slope - h * bend)
    twist = h * h * (end[2] - bend)
    a = 10.0 * gap - 4.0 * rise + 0.5 * twist
    b = -15.0 * gap + 7.0 * rise - twist
    c = 6.0 * gap - 3.0 * rise + 0.5 * twist
    far = x * x * (3.0 * a + x * (4.0 * b + 5.0 * c * x))
    return (
        value + x * (h * (slope + 0.5 * h * bend * x) + x * x * (a + x * (b + c * x))),
        slope + h * bend * x + far / h,
        bend + x * (6.0 * a + x * (12.0 * b + 20.0 * c * x)) / (h * h),
    )


@jit(allocates=True)
def tabulate(rows, which, times, scene, joint, step, out):
    """Fill out[:TABLE] at times between rows of these indices and their next ones."""
    y, slopes = np.zeros(STATE), np.empty(STATE)
    for i in range(times.size):
        here, then = rows[which[i]], rows[which[i] + 1]
        h = then[TIME] - here[TIME]
        x = (times[i] - here[TIME]) / h
        mode = int(here[MODE])
        for k in range(2):
            start = here[FIRST + k], here[FIRST + 2 + k], here[BENDS + k]
            end = then[FIRST + k], then[FIRST + 2 + k], then[BENDS + k]
            y[k], y[2 + k], _bend = between(start, end, x, h)
        case = Engagement(scene, joint, here[CELL] * cell_of(scene), here[TOUCH])
        rates(y, mode, case, slopes)
        out[0, i] = y[0] + here[CELL] * cell_of(scene)
        out[1, i], out[2, i] = y[2], slopes[2]
        out[3, i] = y[1] + here[CELL] * step
        out[4, i], out[5, i] = y[3], slopes[3]
        touches = 1.0 if abs(mode) == 1 else 0.0
        out[6, i] = touches * (slopes[3] + resistance(y[3], scene, joint.slip))
        out[7, i] = mode * touches * slopes[IMPULSE]
        out[8:13, i] = slopes[LOST:WALLS]
        out[13, i] = slide_of(y, float(mode), scene)
        out[14, i] = mode * place(y, scene)[4]
        out[15, i] = stored(y, mode, case)
