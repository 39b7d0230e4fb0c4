"""The codes of events, and of the ways in which a part of a motion ends, for all engines.

Kernels keep them as integers in records, and return them as members.
"""

from enum import IntEnum

from escapement.numerics.jit import inner_jit


class Event(IntEnum):
    """Kinds of events in an engagement.

    REVERSAL: the other wall of the slot takes over the force. MINIMUM and MAXIMUM: extrema of the
    driver speed. BREAK: the sliding speed has a kink. ENTRY and EXIT: of the pin.

    With clearance: IMPACT, the pin strikes a wall, or the follower is stopped at the exit.
    LIFT_OFF: the pin leaves a wall. SLIDE_CHANGE: its sliding along the wall turns round. At
    FLIGHT, CONTACT and DWELL a piece of the motion begins in which the pin flies, touches a wall,
    or has left the slot while the follower is locked.
    """

    REVERSAL = 0
    MINIMUM = 1
    MAXIMUM = 2
    BREAK = 3
    ENTRY = 4
    EXIT = 5
    IMPACT = 6
    LIFT_OFF = 7
    SLIDE_CHANGE = 8
    FLIGHT = 9
    CONTACT = 10
    DWELL = 11


EXTREMA = Event.MINIMUM, Event.MAXIMUM
"""Extrema of the driver speed."""
PIECES = Event.FLIGHT, Event.CONTACT, Event.DWELL
"""Events at which a piece of a motion with clearance begins."""


class Ending(IntEnum):
    """How an engagement, a piece or a panel of it ends, or the march that follows it.

    The engagement ends with DONE: at the handoff. OVER: the time asked for has passed. STALL: the
    drive cannot go on. SPENT: the spring is spent. JAM: at the Painleve limit. BACKS_OUT: the
    driver turns back out of the slot, and the drive would turn it forwards again. UNDRIVEN: it does
    so without a drive. RESTLESS: there are too many pieces. TOO_LONG: there are too many steps.
    ARRIVED: the goal of a march is reached. STANDS: nothing moves. OVERLAPS: bodies are within each
    other. SINKS: a body is pressed in too deep.

    A piece ends, and the engagement goes on, with LIFTED: the pin lifts off. TURNED: a driver that
    turns back comes to rest. STRUCK: the pin strikes a wall. REVERSED: the other wall of a slot
    without clearance takes over the force. With TOUCHES a contact goes on, and with RUNNING a
    march.

    A panel of contact ends besides with BARREL_TURNED and LOAD_TURNED: power in the train of the
    barrel or of the load turns back. RESTED: bodies that nothing drives count as at rest. STOPPED:
    the driver stops.
    """

    DONE = 0
    OVER = 1
    STALL = 2
    SPENT = 3
    JAM = 4
    BACKS_OUT = 5
    UNDRIVEN = 6
    RESTLESS = 7
    TOO_LONG = 8
    ARRIVED = 9
    STANDS = 10
    LIFTED = 11
    TURNED = 12
    STRUCK = 13
    TOUCHES = 14
    RUNNING = 15
    BARREL_TURNED = 16
    LOAD_TURNED = 17
    RESTED = 18
    STOPPED = 19
    REVERSED = 20
    OVERLAPS = 21
    SINKS = 22


GOES_ON = Ending.LIFTED, Ending.TURNED, Ending.STRUCK, Ending.TOUCHES, Ending.RUNNING
"""Endings of a piece behind which its engagement goes on."""


@inner_jit
def has_ended(ending: int) -> bool:
    """Whether an engagement has ended with a piece that ends so."""
    return ending not in GOES_ON


@inner_jit
def is_extremum(event: int) -> bool:
    """Whether an `Event` is an extremum of the driver speed."""
    return event in EXTREMA
