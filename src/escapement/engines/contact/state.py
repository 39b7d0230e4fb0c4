"""Conversion of states with separate motions of driver and follower from natural units to SI."""

from typing import Any

import numpy as np

from escapement.dynamics.law import LOSSES
from escapement.dynamics.motion import State
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

COLUMNS = (
    *("theta", "theta_dot", "theta_ddot", "phi", "phi_dot", "phi_ddot"),
    *("contact_moment", "contact_force"),
)
"""Columns of a state, which the power lost in each of `LOSSES` follows."""


def state_from(escapement: Escapement, t: FloatArray, table: FloatArray) -> State:
    """A state in SI.

    Parameters
    ----------
    escapement : Escapement
        A Geneva wheel with a crank radius.
    t : ndarray
        Times [s], of any shape.
    table : ndarray, shape (len(COLUMNS) + len(LOSSES), t.size)
        `COLUMNS`, angles since the start of the motion, and the power lost in each of `LOSSES`,
        in natural units.
    """
    clock, torque = escapement.time_unit, escapement.torque_unit
    wheel: Any = escapement.mechanism
    rates, force = (1.0, 1.0 / clock, clock**-2.0), torque / wheel.crank_radius
    scale = np.array([*rates, *rates, torque, force, *(torque / clock,) * len(LOSSES)])
    rows = (table * scale[:, None]).reshape(len(scale), *t.shape)
    reaction = np.abs(rows[7]) * np.hypot(1.0, escapement.scene.mu_plus)
    return State(
        t=t,
        **dict(zip(COLUMNS, rows, strict=False)),
        driver_bearing_reaction=reaction,
        follower_bearing_reaction=reaction,
        power_lost=dict(zip(LOSSES, rows[len(COLUMNS) :], strict=True)),
    )
