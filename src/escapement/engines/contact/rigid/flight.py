"""Driver and follower without contact, and the first wall that the pin reaches.

Without drag and with a constant torque both move with constant acceleration, until the load has
brought the follower to rest, or the bearing the driver. Otherwise a flight is cut into parts so
short that the Taylor series of both motions give speeds and angles to rounding; their coefficients
follow one from the other. Friction never drives: a body at rest that the torque on it cannot move
is held.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.law import is_viscous
from escapement.dynamics.torque import KNOT_GAP, REST, is_undriven, last_knot, next_knot, torque_at
from escapement.dynamics.train_losses import shared
from escapement.engines.contact.rigid.free import (
    driver_rate,
    driver_sense,
    follower_rate,
    is_even,
)
from escapement.engines.contact.rigid.panel import BEND, B, W, X
from escapement.numerics.gauss import N
from escapement.numerics.jit import inner_jit
from escapement.numerics.roots import newton_in_bracket

STRIDE = 0.03
"""Driver angle between two checks of the gaps, at the speed with which a flight starts [rad]."""
PRESSING = 1e-12
"""A pin that begins a flight at a wall strikes it at once if it moves towards it faster."""
_LONGEST, _SHORTEST = 0.5, 1e-7
"""Longest and shortest part of a flight with drag, in natural units; of a slow body the longest
one is the time that it takes for so many radians, if that is more."""
_FARTHEST = np.pi
"""Greatest angle by which a follower turns before it meets the pin of a driver at rest [rad]."""
_FASTER = 0.15
"""A follower so many times faster than the driver, or more, decides how often gaps are checked."""
_LAST_TERM = 1e-16
"""The last terms of a series over the speed, at the end of its part."""
_TIE = 1e-12
"""A torque through a train that is nearer to zero counts as positive: in a flight it grows."""
# rows of the workspace for a part: coefficients of angles and speeds of driver and follower
_THETA, _SPEED, _PHI, _TURNING = B, W, X, BEND


class Flight(NamedTuple):
    """A flight, or a part of it.

    theta, speed, rate, phi, turning, slowing : angle, speed and acceleration of driver and
        follower at its start. length : how long it lasts; inf where both bodies are at rest for
        good. halt, rest : times at which driver and follower come to rest, inf if they do not.
    even : whether the accelerations are constant. If they are not, the workspace holds the series
        of a part, in which neither driver nor follower changes its sense.
    """

    theta: float
    speed: float
    rate: float
    phi: float
    turning: float
    slowing: float
    length: float
    halt: float
    rest: float
    even: bool


@inner_jit
def launch(work, scene, theta, speed, phi, turning, end):
    """The flight from a state to the driver angle `end`, or its first part."""
    if not is_even(scene):
        return _in_series(work, scene, theta, speed, phi, turning, end)
    way, sense = np.sign(turning), driver_sense(scene, theta, speed)
    rate, slowing = driver_rate(scene, theta, speed, sense), follower_rate(scene, turning, way)
    rest = -turning / slowing if slowing != 0.0 else np.inf
    length, halt = _even_length(scene, theta, speed, rate, end)
    if sense == 0.0 and turning != 0.0:
        length = min(rest, _FARTHEST / abs(turning))
    return Flight(theta, speed, rate, phi, turning, slowing, length, halt, rest, True)


@inner_jit
def _even_length(scene, theta, speed, rate, end):
    """Time to the driver angle `end` at a constant acceleration, or to where a driver that turns
    back leaves the slot or stops, and the time at which it comes to rest.
    """
    if speed < 0.0:
        room = max(theta - scene.edges[0], 0.0)
        left = speed * speed - 2.0 * rate * room
        if left > 0.0:
            return 2.0 * room / (np.sqrt(left) - speed), np.inf
        if scene.bearing > 0.0 or scene.barrel_efficiency != 1.0:
            return -speed / rate, -speed / rate
        return (np.sqrt(speed * speed + 2.0 * rate * (end - theta)) - speed) / rate, np.inf
    square = speed * speed + 2.0 * rate * (end - theta)
    if square >= 0.0:
        return 2.0 * (end - theta) / (speed + np.sqrt(square)), np.inf
    return -speed / rate, -speed / rate


@inner_jit
def _in_series(work, scene, theta, speed, phi, turning, end):
    """The next part of a flight, in Taylor series about its start."""
    way, sense = np.sign(turning), driver_sense(scene, theta, speed)
    if sense == 0.0 and turning == 0.0:
        return Flight(theta, 0.0, 0.0, phi, 0.0, 0.0, np.inf, np.inf, np.inf, True)
    # whether power flows backwards through a lossy train, and the factors e of both trains
    backs = scene.barrel_efficiency != 1.0 and sense != 0.0
    backs = backs and _through_barrel(scene, theta, speed, sense) < -_TIE
    driven = scene.load_train_efficiency != 1.0 and _through_load(scene, turning, way) < -_TIE
    barrel = shared(scene.barrel_efficiency, -sense if backs else sense)
    train = shared(scene.load_train_efficiency, 1.0 if driven else -1.0)
    # a driver that is held does not yield to the torque
    driver = scene.rho + (barrel - 1.0) * scene.barrel if sense != 0.0 else np.inf
    follower = 1.0 + (train - 1.0) * scene.load_train
    # at a knot, the torque that the driver is about to meet counts
    torque, slope = torque_at(theta + sense * KNOT_GAP, scene)
    torque, slope = barrel * torque, barrel * slope
    push = torque - slope * sense * KNOT_GAP - sense * scene.bearing
    pull = -way * train * scene.load
    angle, pace, place, turn = work[_THETA], work[_SPEED], work[_PHI], work[_TURNING]
    angle[0], pace[0], place[0], turn[0] = theta, speed, phi, turning
    for k in range(N - 1):
        air = wind = 0.0
        for i in range(k + 1):
            air += pace[i] * pace[k - i]
            wind += turn[i] * turn[k - i]
        push -= sense * scene.driver_drag * air + scene.driver_viscous * pace[k]
        pull -= way * scene.follower_drag * wind + scene.follower_viscous * turn[k]
        share = 1.0 / (k + 1)
        angle[k + 1], place[k + 1] = pace[k] * share, turn[k] * share
        pace[k + 1], turn[k + 1] = push * share / driver, pull * share / follower
        push, pull = slope * angle[k + 1], 0.0
    rate, slowing = pace[1], turn[1]
    quick = max(abs(speed), abs(turning)) + np.sqrt(max(abs(rate), abs(slowing)))
    length, halt = _LONGEST / min(quick, 1.0), np.inf
    for k in (N - 2, N - 1):
        share = max(abs(pace[k]), abs(turn[k])) / (_LAST_TERM * (1.0 + abs(speed)))
        if share * length**k > 1.0:
            length = max(share ** (-1.0 / k), _SHORTEST)
    part = Flight(theta, speed, rate, phi, turning, slowing, length, np.inf, np.inf, False)
    if sense != 0.0:
        # as long as the driver goes on in the same way, it passes an angle only once
        length = halt = _passing(work, scene, part, length, 0.0, 1)
        back = last_knot(theta, scene.edges[0], scene)
        end = next_knot(theta, end, scene) if sense > 0.0 else back
        length = _passing(work, scene, part, length, end, 0)
    if backs:
        length = _passing(work, scene, part, length, 0.0, 3)
    if driven:
        length = _passing(work, scene, part, length, 0.0, 4)
    if is_viscous(scene) and is_undriven(theta, scene):
        length = _passing(work, scene, part, length, 0.0, 5)
    rest = _passing(work, scene, part, length, 0.0, 2)
    rest = rest if rest < length else np.inf
    halt = halt if halt <= length and halt < part.length else np.inf
    return Flight(theta, speed, rate, phi, turning, slowing, min(length, rest), halt, rest, False)


@inner_jit
def _through_barrel(scene, theta, speed, sense):
    """The torque q through the barrel's train in a flight, times a positive number."""
    lost = scene.bearing + (scene.driver_drag * speed + scene.driver_viscous * sense) * speed
    own = scene.rho - scene.barrel
    return own * torque_at(theta, scene)[0] + scene.barrel * sense * lost


@inner_jit
def _through_load(scene, turning, way):
    """The torque z through the load's train in a flight, times a positive number."""
    air = (scene.follower_drag * turning + scene.follower_viscous * way) * turning
    return (1.0 - scene.load_train) * scene.load - scene.load_train * air


@inner_jit
def _watched(scene, goal, which, sense, way, theta, speed, turning):
    """The value for which `_passing` finds the zero, and its slope in time."""
    if which == 0:
        return theta - goal, speed
    if which == 1:
        return speed, driver_rate(scene, theta, speed, sense)
    if which == 3:
        slope = (scene.rho - scene.barrel) * torque_at(theta, scene)[1] * speed
        lost = 2.0 * scene.driver_drag * speed + scene.driver_viscous * sense
        slope += scene.barrel * sense * lost * driver_rate(scene, theta, speed, sense)
        return _through_barrel(scene, theta, speed, sense), slope
    if which == 5:
        slope = scene.rho * speed * driver_rate(scene, theta, speed, sense)
        slope += turning * follower_rate(scene, turning, way)
        return scene.rho * (speed * speed - REST) + turning * turning, 2.0 * slope
    slowing = follower_rate(scene, turning, way)
    if which == 2:
        return turning, slowing
    air = 2.0 * scene.follower_drag * turning + scene.follower_viscous * way
    return _through_load(scene, turning, way), -scene.load_train * air * slowing


@inner_jit
def _passing(work, scene, part, length, goal, which):
    """Time within a part at which its driver angle (0) reaches a goal, one of the speeds (1 of the
    driver, 2 of the follower) or one of the torques through trains (3 of the barrel, 4 of the
    load) changes its sign, or both bodies count as at rest (5); `length` where they do not.
    """
    # the senses of a part, also beyond its end, where it is smooth
    sense, way = driver_sense(scene, part.theta, part.speed), np.sign(part.turning)
    inputs = scene, goal, which, sense, way
    at_start = _watched(*inputs, part.theta, part.speed, part.turning)[0]
    low, high, t = 0.0, length, length
    for _ in range(80):
        theta, speed, _phi, turning = place_at(work, part, t)
        value, slope = _watched(*inputs, theta, speed, turning)
        if t == length and not value * at_start < 0.0:
            return length
        guess, low, high = newton_in_bracket(t, value, slope, low, high, at_start < 0.0)
        step, t = abs(guess - t), guess
        if step <= 1e-15 * length:
            break
    return t


@inner_jit
def place_at(work, flight, t):
    """theta, theta_dot, phi and phi_dot after a time within a flight."""
    if not flight.even:
        theta = speed = phi = turning = 0.0
        for i in range(N):
            k = N - 1 - i
            theta, speed = theta * t + work[_THETA][k], speed * t + work[_SPEED][k]
            phi, turning = phi * t + work[_PHI][k], turning * t + work[_TURNING][k]
        return theta, speed, phi, turning
    theta = flight.theta + (flight.speed + 0.5 * flight.rate * t) * t
    speed, moved = flight.speed + flight.rate * t, min(t, flight.rest)
    phi = flight.phi + (flight.turning + 0.5 * flight.slowing * moved) * moved
    return theta, speed, phi, flight.turning + flight.slowing * moved if t < flight.rest else 0.0


@inner_jit
def state_after(work, flight, t):
    """As `place_at`; a body that has come to rest by then is at rest to the last digit."""
    theta, speed, phi, turning = place_at(work, flight, t)
    return (
        theta, 0.0 if t >= flight.halt else speed, phi, 0.0 if t >= flight.rest else turning,
    )  # fmt: skip


@inner_jit
def ahead(case, theta, speed, phi, turning):
    """D, the distance by which the pin's centre is ahead of the slot's line, and its rate."""
    sine, cosine = np.sin(theta), np.cos(theta)
    across, along = np.sin(phi), np.cos(phi)
    x = case.centre + case.crank * cosine
    moved = cosine * along + case.crank * sine * across
    return sine * along - x * across, speed * moved - turning * (x * along + sine * across)


@inner_jit
def _ahead_after(case, work, flight, t):
    return ahead(case, *place_at(work, flight, t))


@inner_jit
def _first_look(case, flight, wall, pace, stride):
    """Time at which to check first whether the gap at the wall that the pin left has opened.

    `pace` is the speed of D at the start. A pin that rebounds returns to that wall after twice its
    speed over its deceleration; the check comes well before.
    """
    step = 1e-3 * stride
    speed_then = flight.speed + flight.rate * step
    theta = flight.theta + (flight.speed + 0.5 * flight.rate * step) * step
    phi = flight.phi + (flight.turning + 0.5 * flight.slowing * step) * step
    opening = -wall * pace
    then = -wall * ahead(case, theta, speed_then, phi, flight.turning + flight.slowing * step)[1]
    closing = (opening - then) / step
    return min(stride, 0.8 * opening / closing) if opening > 0.0 and closing > 0.0 else stride


@inner_jit
def arrival(work, case, flight, wall):
    """Time at which the pin first reaches a wall, and that wall, 0 if none within the flight.

    `wall` is the one that the pin leaves, or 0. It counts again once its gap has opened. A pin that
    still moves towards it, or whose gap does not open in the shortest step, strikes it at once.
    Without an arrival the time is the length of the flight.
    """
    length, play = flight.length, case.play
    # D changes its slope over an angle whose cube is about the play
    stride = min(STRIDE, 0.5 * np.cbrt(play))
    quick = max(abs(flight.speed), np.sqrt(stride * abs(flight.rate)))
    stride /= max(quick, _FASTER * abs(flight.turning))
    place, pace = _ahead_after(case, work, flight, 0.0)
    if wall * pace > PRESSING:
        return 0.0, wall
    step = min(length, _first_look(case, flight, wall, pace, stride) if wall != 0.0 else stride)
    t, opened, least = 0.0, wall == 0.0, 1e-6 * stride
    while t < length:
        after = min(t + step, length)
        there, then = _ahead_after(case, work, flight, after)
        if not opened and not wall * there < play:
            if after <= least:
                return after, wall
            step *= 0.25
            continue
        leaves, opened = (0.0 if opened else wall), True
        found, struck = np.inf, 0.0
        for side in (1.0, -1.0):
            time, high = after, (there, then)
            if side == leaves:
                continue
            if side * there < play:
                if not (side * pace > 0.0 and side * then < 0.0):
                    continue
                # between two checks the pin may have gone to the wall and back: it stays below
                # the point at which the tangents of both checks meet
                meet = (side * (there - place) - side * then * (after - t)) / (side * (pace - then))
                if side * (place + pace * meet) < play:
                    continue
                time = _summit(work, case, flight, side, t, after)
                high = _ahead_after(case, work, flight, time)
                if side * high[0] < play:
                    continue
            time = _touching(work, case, flight, side, t, time, high[0], high[1])
            if time < found:
                found, struck = time, side
        if struck != 0.0:
            return found, struck
        t, place, pace = after, there, then
        step = min(stride, 1.7 * step)
    return length, 0.0


@inner_jit
def _summit(work, case, flight, side, low, high):
    """Time between two checks at which D is greatest towards a side, by bisection."""
    for _ in range(50):
        middle = 0.5 * (low + high)
        if side * _ahead_after(case, work, flight, middle)[1] > 0.0:
            low = middle
        else:
            high = middle
    return low


@inner_jit
def _touching(work, case, flight, side, low, high, place, pace):
    """Time between two checks at which D = s c; `place` and `pace`: D and its speed at `high`."""
    t, before, slope_before = high, 0.0, 0.0
    for _ in range(80):
        value, slope = side * place - case.play, side * pace
        guess, low, high = newton_in_bracket(t, value, slope, low, high, True)
        step, t = abs(guess - t), guess
        # how far the next step of Newton's method would go, by the bend of D
        bent = abs(slope - slope_before) * step * step
        if bent <= 2e-16 * (1.0 + t) * abs(slope) * before or step <= 1e-15 * (1.0 + t):
            break
        before, slope_before = step, slope
        place, pace = _ahead_after(case, work, flight, t)
    return t
