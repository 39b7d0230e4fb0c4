"""A state of both bodies, and the rows of a table of states, which both laws of contact fill."""

from typing import Any, NamedTuple

from escapement.numerics.jit import inner_jit


class ContactState(NamedTuple):
    """A state in natural units; each field is a row of a table with a column for each time.

    Angles, speeds and accelerations of driver and follower, the moment of the contact on the
    follower, the contact force, and the power lost in each of `dynamics.law.LOSSES`, in their
    order.
    """

    theta: Any
    theta_dot: Any
    theta_ddot: Any
    phi: Any
    phi_dot: Any
    phi_ddot: Any
    contact_moment: Any
    contact_force: Any
    friction: Any
    driver_bearing: Any
    follower_bearing: Any
    driver_drag: Any
    follower_drag: Any
    barrel: Any
    load_train: Any


STATE_ROWS, FIRST_LOSS = len(ContactState._fields), ContactState._fields.index("friction")
"""Number of rows, and that of the first of `LOSSES`."""


@inner_jit
def write_state(table, column, state):
    """Write a state into a column of a table."""
    for i in range(STATE_ROWS):
        table[i, column] = state[i]
