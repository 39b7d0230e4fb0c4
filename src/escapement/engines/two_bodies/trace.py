"""The states of a motion at given times, from the steps that hold them."""

import numpy as np

from escapement.dynamics.contact_state import ContactState, write_state
from escapement.engines.two_bodies.law import MOTION, STATE, Mode, losses, push_at
from escapement.engines.two_bodies.step import advance, path_for, state_at
from escapement.numerics.altered import altered
from escapement.numerics.jit import jit


@jit(allocates=True)
def trace(law, pairs, pitch, rows, which, since, table, lost):
    """Fill a table with the rows of a `ContactState`, and another one with the work lost so far.

    Parameters
    ----------
    law, pairs : as of `march.march`. pitch : of the driver.
    rows : those of the record that begin a step.
    which, since : for each state the number of its row, and the time since then.
    """
    y, at, rate, path, last = np.empty(STATE), np.empty(STATE), np.empty(6), path_for(STATE), -1
    for k in range(len(which)):
        row = rows[which[k]]
        signs = row.sigma, row.driver_sense, row.follower_sense
        mode = Mode(row.pair, row.nose, row.track, signs[0], signs[1], signs[2])
        here = altered(law, "begin", law.begin - row.engagement * pitch)
        if which[k] != last:
            y[0], y[1], y[2], y[3] = row.theta, row.phi, row.speed, row.turning
            # assigning to a slice would take longer to compile, because of its error messages
            for i in range(MOTION, STATE):
                y[i] = row.lost[i - MOTION]
            push, path.span[1] = push_at(here, pairs, mode, y), 0.0
            advance(here, pairs, mode, y, push, row.length, 1.0, path)
            last = which[k]
        state_at(path, y, row.length, since[k], at)
        push = push_at(here, pairs, mode, at)
        losses(here, mode, push, at, rate)
        state = ContactState(
            theta=at[0], theta_dot=at[2], theta_ddot=push.driver,
            phi=at[1], phi_dot=at[3], phi_ddot=push.follower,
            contact_moment=push.moment, contact_force=push.force,
            friction=rate[0], driver_bearing=rate[1], follower_bearing=rate[2],
            driver_drag=rate[3], follower_drag=rate[4], barrel=0.0, load_train=0.0,
        )  # fmt: skip
        write_state(table, k, state)
        for i in range(MOTION, STATE):
            lost[i - MOTION, k] = at[i]
