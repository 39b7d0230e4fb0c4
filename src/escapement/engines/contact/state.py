"""Conversion of states with separate motions of driver and follower from natural units to SI."""

from typing import Any

import numpy as np

from escapement.dynamics.law import LOSSES
from escapement.dynamics.motion import State
from escapement.engines.contact.state_rows import FIRST_LOSS, STATE_ROWS, StateRow
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

_NUMBERS = [row for row in StateRow if row < FIRST_LOSS]
"""Rows that are not losses."""


def state_from(escapement: Escapement, t: FloatArray, table: FloatArray) -> State:
    """A state in SI.

    Parameters
    ----------
    escapement : Escapement
        A Geneva wheel with a crank radius.
    t : ndarray
        Times [s], of any shape.
    table : ndarray, shape (STATE_ROWS, t.size)
        Its rows are `StateRow`, in natural units, with angles since the start of the motion.
    """
    clock, torque = escapement.time_unit, escapement.torque_unit
    wheel: Any = escapement.mechanism
    scale = np.full(STATE_ROWS, torque / clock)
    scale[[StateRow.THETA, StateRow.PHI]] = 1.0
    scale[[StateRow.THETA_DOT, StateRow.PHI_DOT]] = 1.0 / clock
    scale[[StateRow.THETA_DDOT, StateRow.PHI_DDOT]] = clock**-2.0
    scale[StateRow.CONTACT_MOMENT] = torque
    scale[StateRow.CONTACT_FORCE] = torque / wheel.crank_radius
    rows = (table * scale[:, None]).reshape(STATE_ROWS, *t.shape)
    reaction = np.abs(rows[StateRow.CONTACT_FORCE]) * np.hypot(1.0, escapement.scene.mu_plus)
    return State(
        t=t,
        **{row.name.lower(): rows[row] for row in _NUMBERS},
        driver_bearing_reaction=reaction,
        follower_bearing_reaction=reaction,
        power_lost=dict(zip(LOSSES, rows[FIRST_LOSS:], strict=True)),
    )
