"""The first wall that the pin reaches in a flight, and when.

The pin touches a wall where D, the distance by which its centre is ahead of the slot's centre line,
is c or -c. `arrival` looks at D and its rate at times between which the driver, or a fast follower,
turns by a small angle. Between two looks the pin reaches a wall if it is beyond it at the second,
or if D has a summit in between that is beyond it; Newton's method finds the time.

The wall that the pin has just left is a root of D = s c at the start. It counts again once a look
has found the gap open.
"""

from typing import NamedTuple

import numpy as np

from escapement.engines.contact.rigid.flight import state_at
from escapement.engines.contact.slot import free_pose
from escapement.numerics.jit import inner_jit
from escapement.numerics.roots import newton_in_bracket

STRIDE = 0.03
"""Driver angle between two looks at D, at the speed with which a flight starts [rad]."""
PRESSING = 1e-12
"""A pin that begins a flight at a wall strikes it at once if it moves towards it faster."""
_FASTER = 0.15
"""The share of the follower's speed that counts where it is so fast that it, and not the driver,
decides how often D is looked at."""


class _Look(NamedTuple):
    """D at a time of a flight, and its rate."""

    time: float
    distance: float
    pace: float


@inner_jit
def pin_offset(frame, theta, speed, phi, turning):
    """D, the distance by which the pin's centre is ahead of the slot's line, and its rate."""
    at = free_pose(frame, theta, speed, phi, turning)
    return at.across, at.speed


@inner_jit
def _first_look(frame, flight, wall, pace, stride):
    """Time at which to check first whether the gap at the wall that the pin left has opened.

    `pace` is the rate of D at the start. A pin that rebounds returns to that wall after twice its
    speed over its deceleration; the check comes well before.
    """
    step = 1e-3 * stride
    speed_then = flight.speed + flight.rate * step
    theta = flight.theta + (flight.speed + 0.5 * flight.rate * step) * step
    turning_then = flight.turning + flight.turning_rate * step
    phi = flight.phi + (flight.turning + 0.5 * flight.turning_rate * step) * step
    opening = -wall * pace
    then = -wall * pin_offset(frame, theta, speed_then, phi, turning_then)[1]
    closing = (opening - then) / step
    return min(stride, 0.8 * opening / closing) if opening > 0.0 and closing > 0.0 else stride


@inner_jit
def _look(frame, work, flight, t):
    distance, pace = pin_offset(frame, *state_at(work, flight, t))
    return _Look(time=t, distance=distance, pace=pace)


@inner_jit
def arrival(work, frame, half_clearance, flight, wall):
    """Time at which the pin first reaches a wall, and that wall, 0 if none within the flight.

    `wall` is the one that the pin leaves, or 0. It counts again once its gap has opened. A pin that
    still moves towards it, or whose gap does not open in the shortest step, strikes it at once.
    Without an arrival the time is the length of the flight.
    """
    length = flight.length
    # D changes its slope over an angle whose cube is about the clearance
    stride = min(STRIDE, 0.5 * np.cbrt(half_clearance))
    quick = max(abs(flight.speed), np.sqrt(stride * abs(flight.rate)))
    stride /= max(quick, _FASTER * abs(flight.turning))
    here = _look(frame, work, flight, 0.0)
    if wall * here.pace > PRESSING:
        return 0.0, wall
    first = stride
    if wall != 0.0:
        first = _first_look(frame, flight, wall, here.pace, stride)
    step, opened, shortest = min(length, first), wall == 0.0, 1e-6 * stride
    while here.time < length:
        then = _look(frame, work, flight, min(here.time + step, length))
        if not opened and not wall * then.distance < half_clearance:
            if then.time <= shortest:
                return then.time, wall
            # look again, sooner
            step *= 0.25
            continue
        leaves, opened = (0.0 if opened else wall), True
        found, struck = np.inf, 0.0
        for side in (1.0, -1.0):
            if side != leaves:
                time = _reached(work, frame, half_clearance, flight, side, here, then)
                if time < found:
                    found, struck = time, side
        if struck != 0.0:
            return found, struck
        here = then
        step = min(stride, 1.7 * step)
    return length, 0.0


@inner_jit
def _reached(work, frame, half_clearance, flight, side, here, then):
    """Time between two looks at which the pin first reaches a wall, inf if it does not."""
    beyond = then
    if side * then.distance < half_clearance:
        if not (side * here.pace > 0.0 and side * then.pace < 0.0):
            return np.inf
        # between two looks the pin may have gone to the wall and back: it stays below the point
        # at which the tangents of both meet
        meet = side * (then.distance - here.distance) - side * then.pace * (then.time - here.time)
        meet /= side * (here.pace - then.pace)
        if side * (here.distance + here.pace * meet) < half_clearance:
            return np.inf
        summit = _summit(work, frame, flight, side, here.time, then.time)
        beyond = _look(frame, work, flight, summit)
        if side * beyond.distance < half_clearance:
            return np.inf
    return _touching(work, frame, half_clearance, flight, side, here.time, beyond)


@inner_jit
def _summit(work, frame, flight, side, low, high):
    """Time between two looks at which D is greatest towards a side, by bisection."""
    for _ in range(50):
        middle = 0.5 * (low + high)
        if side * pin_offset(frame, *state_at(work, flight, middle))[1] > 0.0:
            low = middle
        else:
            high = middle
    return low


@inner_jit
def _touching(work, frame, half_clearance, flight, side, low, beyond):
    """Time at which D = s c, between a time `low` and a look at a pin beyond the wall."""
    high, distance, pace = beyond.time, beyond.distance, beyond.pace
    t, before, slope_before = high, 0.0, 0.0
    for _ in range(80):
        value, slope = side * distance - half_clearance, side * pace
        guess, low, high = newton_in_bracket(t, value, slope, low, high, True)
        step, t = abs(guess - t), guess
        # how far the next step of Newton's method would go, by the bend of D
        bent = abs(slope - slope_before) * step * step
        if bent < 2e-16 * (1.0 + t) * abs(slope) * before or step <= 1e-15 * (1.0 + t):
            break
        before, slope_before = step, slope
        distance, pace = pin_offset(frame, *state_at(work, flight, t))
    return t
