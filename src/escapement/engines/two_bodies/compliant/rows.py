"""States at times within the steps of a march."""

import numpy as np

from escapement.dynamics.compliance import IMPULSE, LOST, STATE
from escapement.dynamics.compliant_steps import HELD, PRESS, SLIDE
from escapement.dynamics.contact_state import ContactState, write_state
from escapement.dynamics.radau import within
from escapement.engines.two_bodies.compliant.law import (
    CONTACT,
    MOST,
    Yielding,
    pressed,
    rates,
    stored,
)
from escapement.engines.two_bodies.law import energy
from escapement.numerics.altered import altered
from escapement.numerics.jit import jit


@jit(allocates=True)
def tabulate(rows, which, times, bodies, pitches, out):
    """Fill rows of `out` at times, each between the row with its index in `which` and the next."""
    law, pairs, joints, joint = bodies
    y, slopes, held = np.zeros(STATE), np.empty(STATE), np.zeros(MOST, CONTACT)
    for i in range(times.size):
        here, then = rows[which[i]], rows[which[i] + 1]
        h, count = then.time - here.time, here.count
        for k in range(count):
            one = held[k]
            one.pair, one.nose, one.track = here.places[k, 0], here.places[k, 1], here.places[k, 2]
            one.active, one.touch = here.places[k, 3], here.touches[k]
        before = here.engagement * pitches[0]
        turned = altered(law, "begin", law.begin - before)
        case = Yielding(turned, pairs, joints, joint, held, held)
        within((times[i] - here.time) / h, h, here.state, then.series, y)
        moment = rates(case, y, count, slopes)
        out[SLIDE, i] = out[PRESS, i] = 0.0
        if count > 0:
            at = pressed(case, held[count - 1], y)
            out[SLIDE, i], out[PRESS, i] = at.slip, at.rate
        out[HELD, i] = stored(case, y, count) + energy(law, y)[1]
        state = ContactState(
            theta=y[0] + before, theta_dot=y[2], theta_ddot=slopes[2],
            phi=y[1] + here.turned * pitches[1], phi_dot=y[3], phi_ddot=slopes[3],
            contact_moment=moment, contact_force=slopes[IMPULSE],
            friction=slopes[LOST], driver_bearing=slopes[LOST + 1],
            follower_bearing=slopes[LOST + 2], driver_drag=slopes[LOST + 3],
            follower_drag=slopes[LOST + 4], barrel=0.0, load_train=0.0,
        )  # fmt: skip
        write_state(out, i, state)
