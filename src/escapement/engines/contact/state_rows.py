"""The rows of a table of states, which the kernels of both laws of contact fill."""

from enum import IntEnum


class StateRow(IntEnum):
    """Rows of a table of states in natural units, with a column for each time.

    Angles, speeds and accelerations of driver and follower, the moment of the contact on the
    follower, the contact force, and the power lost in each of `dynamics.law.LOSSES`, in their
    order.
    """

    THETA = 0
    THETA_DOT = 1
    THETA_DDOT = 2
    PHI = 3
    PHI_DOT = 4
    PHI_DDOT = 5
    CONTACT_MOMENT = 6
    CONTACT_FORCE = 7
    FRICTION = 8
    DRIVER_BEARING = 9
    FOLLOWER_BEARING = 10
    DRIVER_DRAG = 11
    FOLLOWER_DRAG = 12
    BARREL = 13
    LOAD_TRAIN = 14


FIRST_LOSS, STATE_ROWS = int(StateRow.FRICTION), len(StateRow)
"""Row of the first of `LOSSES`, and number of rows."""
