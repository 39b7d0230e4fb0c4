"""The states of a motion at given times, from the steps that hold them."""

import numpy as np

from escapement.engines.two_bodies.law import MOTION, STATE, Mode, pushed, rates, torques, touching
from escapement.engines.two_bodies.step import advance, memory_for
from escapement.numerics.altered import altered
from escapement.numerics.jit import jit

MORE = 10
"""Rows of a table of states behind those of the state: both accelerations, the moment and the force
of the contact, and the powers that are lost."""


@jit(allocates=True)
def trace(law, pairs, pitch, steps, which, since, table):
    """Fill a table with states, shape (STATE + MORE, n).

    Parameters
    ----------
    law, pairs : as of `march.march`. pitch : of the driver.
    steps : rows of the record that begin a step.
    which, since : for each state the number of its step, and the time since its start.
    """
    y, out, more, memory = np.empty(STATE), np.empty(STATE), np.empty(STATE), memory_for(STATE)
    for k in range(len(which)):
        step = steps[which[k]]
        for i in range(STATE):
            y[i] = step.y[i]
        mode = Mode(
            pair=step.pair, nose=step.nose, track=step.track, sigma=step.sigma,
            driver_sense=step.driver_sense, follower_sense=step.follower_sense,
        )  # fmt: skip
        here = altered(law, "begin", law.begin - step.engagement * pitch)
        if since[k] > 0.0:
            advance(here, pairs, mode, y, since[k], out, memory)
        else:
            out[:] = y
        rates(here, pairs, mode, out, more)
        for i in range(STATE):
            table[i, k] = out[i]
        table[STATE, k], table[STATE + 1, k] = more[2], more[3]
        for i in range(MOTION, STATE):
            table[STATE + i, k] = more[i]
        table[STATE + 2, k] = table[STATE + 3, k] = 0.0
        if mode.pair >= 0:
            push = pushed(here, mode, touching(here, pairs, mode, out), out)
            # what the contact gives the follower is all but its own torques
            own = torques(here, out)[1] - mode.follower_sense * here.load
            table[STATE + 2, k], table[STATE + 3, k] = push.follower - own, push.force
