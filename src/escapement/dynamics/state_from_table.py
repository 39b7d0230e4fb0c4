"""Conversion of states with separate motions of driver and follower from natural units to SI."""

from typing import Any

import numpy as np

from escapement.dynamics.contact_state import FIRST_LOSS, STATE_ROWS, ContactState
from escapement.dynamics.law import LOSSES
from escapement.dynamics.motion import State
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement


def state_from(escapement: Escapement, t: FloatArray, table: FloatArray) -> State:
    """A state in SI.

    Parameters
    ----------
    escapement : Escapement
        A Geneva wheel with a crank radius.
    t : ndarray
        Times [s], of any shape.
    table : ndarray, shape (STATE_ROWS, t.size)
        The rows of a `ContactState`, with angles since the start of the motion.
    """
    clock, torque = escapement.time_unit, escapement.torque_unit
    wheel: Any = escapement.mechanism
    speed, acceleration = 1.0 / clock, clock**-2.0
    scale = ContactState(
        1.0, speed, acceleration, 1.0, speed, acceleration, torque, torque / wheel.crank_radius,
        *[torque / clock] * len(LOSSES),
    )  # fmt: skip
    rows = (table * np.array(scale)[:, None]).reshape(STATE_ROWS, *t.shape)
    numbers = dict(zip(ContactState._fields, rows[:FIRST_LOSS], strict=False))
    reaction = np.abs(numbers["contact_force"]) * np.hypot(1.0, escapement.scene.mu_plus)
    return State(
        t=t,
        **numbers,
        driver_bearing_reaction=reaction,
        follower_bearing_reaction=reaction,
        power_lost=dict(zip(LOSSES, rows[FIRST_LOSS:], strict=True)),
    )
