"""Driver and follower without contact, and the first wall that the pin reaches.

Without drag and with a constant torque both move with constant acceleration, the follower until
its load has brought it to rest. Otherwise a flight is cut into parts so short that values at the
Gauss points determine angles and speeds.
"""

from typing import NamedTuple

import numpy as np

from escapement.drive import is_constant, torque_at
from escapement.dynamics import is_drag_free
from escapement.engines.contact.rigid.panel import BEND, PLACES, B, G, U, W, X
from escapement.gauss import BARYCENTRIC, POINTS, N, cumulate, tail_of
from escapement.jit import inner_jit
from escapement.power_flow import passed_on
from escapement.roots import newton_in_bracket

STRIDE = 0.03
"""Greatest driver angle between two checks of the gaps [rad]."""
PRESSING = 1e-12
"""A pin that begins a flight at a wall strikes it at once if it moves towards it faster."""
_LONGEST = 0.25
"""Longest part of a flight with drag, in natural units."""
_SHORTEST = 1e-7
# rows of the workspace for a part: angles and speeds of driver and follower
_THETA, _SPEED, _PHI, _TURNING = B, W, X, BEND


class Flight(NamedTuple):
    """A flight, or a part of it in which neither driver nor follower changes its sense.

    theta, speed, rate, phi, turning, slowing : angle, speed and acceleration of driver and
        follower at its start. length : how long it lasts.
    rest : time at which the follower comes to rest.
    half : half the length of a part with drag; 0 if the accelerations are constant.
    """

    theta: float
    speed: float
    rate: float
    phi: float
    turning: float
    slowing: float
    length: float
    rest: float
    half: float


@inner_jit
def driver_rate(scene, theta, speed, way):
    """theta_ddot of a driver without contact that turns in the sense `way`, +1 or -1."""
    torque = torque_at(theta, scene)[0]
    lost = scene.bearing + scene.driver_drag * speed * speed
    # way times speed, not its magnitude: the law stays smooth if a trial passes a reversal
    lost = way * (lost + scene.driver_viscous * way * speed)
    if scene.barrel_efficiency == 1.0:
        return (torque - lost) / scene.rho
    own = scene.rho - scene.barrel
    return passed_on(own, scene.barrel, torque, -lost, scene.barrel_efficiency, way)[0]


@inner_jit
def follower_rate(scene, turning, way):
    """phi_ddot of a follower without contact that turns in the sense `way`, 0 at rest."""
    air = scene.follower_drag * turning * turning + scene.follower_viscous * way * turning
    if scene.load_train_efficiency == 1.0 or way == 0.0:
        return -way * (scene.load + air)
    own, efficiency = 1.0 - scene.load_train, scene.load_train_efficiency
    return passed_on(own, scene.load_train, -way * scene.load, -way * air, efficiency, way)[0]


@inner_jit
def is_even(scene):
    """Whether a free driver has constant acceleration."""
    return is_constant(scene) and is_drag_free(scene)


@inner_jit
def launch(work, scene, theta, speed, phi, turning, end, count):
    """The flight from a state, or its first part; `end` is the driver angle at which it ends."""
    way, sense = np.sign(turning), 1.0 if speed >= 0.0 else -1.0
    rate, slowing = driver_rate(scene, theta, speed, sense), follower_rate(scene, turning, way)
    if not is_even(scene):
        return _in_series(work, scene, theta, speed, phi, turning, end, count)
    rest = -turning / slowing if slowing != 0.0 else np.inf
    length, square = np.inf, speed * speed + 2.0 * rate * (end - theta)
    if speed < 0.0 and (scene.bearing > 0.0 or scene.barrel_efficiency != 1.0):
        length = -speed / rate
    elif square >= 0.0 and speed >= 0.0:
        length = 2.0 * (end - theta) / (speed + np.sqrt(square))
    elif square >= 0.0:
        length = (np.sqrt(square) - speed) / rate
    elif rate < 0.0:
        length = -speed / rate
    return Flight(theta, speed, rate, phi, turning, slowing, length, rest, 0.0)


@inner_jit
def _in_series(work, scene, theta, speed, phi, turning, end, count):
    """The next part of a flight, by Picard's iteration on the Gauss points."""
    way, sense = np.sign(turning), 1.0 if speed >= 0.0 else -1.0
    rate, slowing = driver_rate(scene, theta, speed, sense), follower_rate(scene, turning, way)
    angle, pace, place, turn = work[_THETA], work[_SPEED], work[_PHI], work[_TURNING]
    one, two, half = work[G], work[U], _LONGEST
    while True:
        for i in range(N):
            t = half * (1.0 + work[PLACES][i])
            pace[i], angle[i] = speed + rate * t, theta + (speed + 0.5 * rate * t) * t
            turn[i] = turning + slowing * t
        change = 1.0
        for _ in range(30):
            if change <= 1e-15 * (1.0 + abs(speed)):
                break
            change = 0.0
            for i in range(N):
                one[i] = half * driver_rate(scene, angle[i], pace[i], sense)
                two[i] = half * follower_rate(scene, turn[i], way)
            cumulate(one, angle)
            cumulate(two, place)
            for i in range(N):
                change = max(change, abs(speed + angle[i] - pace[i]))
                change = max(change, abs(turning + place[i] - turn[i]))
                pace[i], turn[i] = speed + angle[i], turning + place[i]
                one[i], two[i] = half * pace[i], half * turn[i]
            cumulate(one, angle)
            cumulate(two, place)
            for i in range(N):
                angle[i], place[i] = theta + angle[i], phi + place[i]
        tails = tail_of(pace, count) + tail_of(turn, count) + change
        if half <= _SHORTEST or tails <= 1e-13 * (1.0 + abs(speed)):
            break
        half *= 0.5
    part = Flight(theta, speed, rate, phi, turning, slowing, 2.0 * half, np.inf, half)
    length = _passing(work, scene, part, part.length, end, 0)
    length = _passing(work, scene, part, length, 0.0, 1)
    rest = _passing(work, scene, part, length, 0.0, 2)
    rest = rest if rest < length else np.inf
    return Flight(theta, speed, rate, phi, turning, slowing, min(length, rest), rest, half)


@inner_jit
def _passing(work, scene, part, length, goal, which):
    """Time within a part at which the driver angle reaches a goal (which = 0), or the speed of
    driver (1) or follower (2) changes its sign; `length` if this does not happen.
    """
    at_start = part.theta - goal if which == 0 else (part.speed if which == 1 else part.turning)
    low, high, t = 0.0, length, length
    for _ in range(80):
        theta, speed, _phi, turning = place_at(work, part, t)
        value = theta - goal if which == 0 else (speed if which == 1 else turning)
        if t == length and not value * at_start < 0.0:
            return length
        slope = speed if which == 0 else driver_rate(scene, theta, speed, np.sign(part.speed))
        if which == 2:
            slope = follower_rate(scene, turning, np.sign(part.turning))
        guess, low, high = newton_in_bracket(t, value, slope, low, high, at_start < 0.0)
        step, t = abs(guess - t), guess
        if step <= 1e-15 * length:
            break
    return t


@inner_jit
def place_at(work, flight, t):
    """theta, theta_dot, phi and phi_dot after a time within a flight."""
    if flight.half > 0.0:
        x = t / flight.half - 1.0
        above = below = speed = phi = turning = 0.0
        for i in range(N):
            apart = x - POINTS[i]
            # exactly at a Gauss point, a tiny distance gives that point all the weight
            weight = BARYCENTRIC[i] / (apart if apart != 0.0 else 1e-30)
            below += weight
            above += weight * work[_THETA][i]
            speed += weight * work[_SPEED][i]
            phi += weight * work[_PHI][i]
            turning += weight * work[_TURNING][i]
        return above / below, speed / below, phi / below, turning / below
    theta = flight.theta + (flight.speed + 0.5 * flight.rate * t) * t
    speed, moved = flight.speed + flight.rate * t, min(t, flight.rest)
    phi = flight.phi + (flight.turning + 0.5 * flight.slowing * moved) * moved
    return theta, speed, phi, flight.turning + flight.slowing * moved if t < flight.rest else 0.0


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
def _first_look(case, flight, wall, stride):
    """Time at which to check first whether the gap at the wall that the pin left has opened.

    A pin that rebounds returns to that wall after twice its speed over its deceleration.
    """
    step = 1e-3 * stride
    speed, speed_then = flight.speed, flight.speed + flight.rate * step
    theta = flight.theta + (speed + 0.5 * flight.rate * step) * step
    phi = flight.phi + (flight.turning + 0.5 * flight.slowing * step) * step
    opening = -wall * ahead(case, flight.theta, speed, flight.phi, flight.turning)[1]
    then = -wall * ahead(case, theta, speed_then, phi, flight.turning + flight.slowing * step)[1]
    closing = (opening - then) / step
    return min(stride, 0.8 * opening / closing) if opening > 0.0 and closing > 0.0 else stride


@inner_jit
def arrival(work, case, flight, wall):
    """Time at which the pin first reaches a wall, and that wall, 0 if none within the flight.

    `wall` is the one that the pin leaves, or 0. Its gap must have opened before it counts.
    """
    length, play = flight.length, case.play
    # D changes its slope over an angle whose cube is about the play
    stride = min(STRIDE, 0.5 * np.cbrt(play))
    stride /= max(abs(flight.speed), np.sqrt(stride * abs(flight.rate)))
    step = min(length, _first_look(case, flight, wall, stride) if wall != 0.0 else stride)
    t, opened, least = 0.0, wall == 0.0, 1e-6 * stride
    place, pace = _ahead_after(case, work, flight, 0.0)
    if wall * pace > PRESSING:
        return 0.0, wall
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
            time = after
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
                if side * _ahead_after(case, work, flight, time)[0] < play:
                    continue
            time = _touching(work, case, flight, side, t, time)
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
def _touching(work, case, flight, side, low, high):
    """Time between two checks at which D = s c."""
    t = high
    for _ in range(80):
        value, slope = _ahead_after(case, work, flight, t)
        guess, low, high = newton_in_bracket(
            t, side * value - case.play, side * slope, low, high, True
        )
        step, t = abs(guess - t), guess
        if step <= 1e-15 * (1.0 + t):
            break
    return t
