"""States at times within the steps of a march."""

import numpy as np

from escapement.dynamics.compliance import IMPULSE, LOST, STATE
from escapement.dynamics.compliant_steps import HELD, PRESS, SLIDE
from escapement.dynamics.contact_state import ContactState, write_state
from escapement.dynamics.radau import within
from escapement.dynamics.torque import cell_of
from escapement.engines.contact.compliant.law import PinInSlot, rates, stored
from escapement.engines.contact.slot import pose, slide, to_angle, touches
from escapement.numerics.jit import jit


@jit(allocates=True)
def tabulate(rows, which, times, scene, joint, step, out):
    """Fill out[:TABLE] at times, each between the row with its index in `which` and the next."""
    y, slopes = np.zeros(STATE), np.empty(STATE)
    for i in range(times.size):
        here, then = rows[which[i]], rows[which[i] + 1]
        h, mode, on = then.time - here.time, here.mode, 1.0 if touches(here.mode) else 0.0
        within((times[i] - here.time) / h, h, here.state, then.series, y)
        driver_angle = here.engagement * cell_of(scene)
        case = PinInSlot(scene, joint, driver_angle, here.touch)
        acceleration, moment = rates(case, y, mode, slopes)
        at = pose(y, mode, scene)
        out[SLIDE, i], out[PRESS, i] = slide(at, mode, scene), mode * at.speed
        out[HELD, i] = stored(y, mode, case)
        if touches(mode):
            to_angle(y, scene)
        state = ContactState(
            theta=y[0] + driver_angle, theta_dot=y[2], theta_ddot=slopes[2],
            phi=y[1] + here.engagement * step, phi_dot=y[3], phi_ddot=acceleration,
            contact_moment=on * moment, contact_force=mode * on * slopes[IMPULSE],
            friction=slopes[LOST], driver_bearing=slopes[LOST + 1],
            follower_bearing=slopes[LOST + 2], driver_drag=slopes[LOST + 3],
            follower_drag=slopes[LOST + 4], barrel=slopes[LOST + 5], load_train=slopes[LOST + 6],
        )  # fmt: skip
        write_state(out, i, state)
