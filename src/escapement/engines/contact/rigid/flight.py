"""Motion without contact: how driver and follower move on their own.

`launch` gives a `Flight` from a state, as far as one formula holds. Without drag and with a
constant torque both accelerations are constant until a body comes to rest. Otherwise a Taylor
series in time about the start is used, whose coefficients follow one from the other by the
equations of motion. The flight is then only a part of the motion, which ends

- where the last terms of the series would be above rounding,
- where the law changes: at a knot of the torque, where a body comes to rest, where the power in a
  lossy train turns back, where bodies that nothing drives count as at rest,
- at the driver angle asked for.

The caller launches the next part from the end of the last one. Whether the pin reaches a wall
meanwhile, `arrival` finds out.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from escapement.dynamics.bodies import (
    drag_slope,
    driver_of,
    driver_sense,
    follower_of,
    free_driver,
    free_follower,
    shared,
)
from escapement.dynamics.law import is_drag_free, is_viscous
from escapement.dynamics.torque import (
    KNOT_GAP,
    REST,
    is_constant,
    is_undriven,
    last_knot,
    next_knot,
    torque_at,
)
from escapement.numerics.gauss import N
from escapement.numerics.jit import inner_jit
from escapement.numerics.roots import newton_in_bracket

_LONGEST, _SHORTEST = 0.5, 1e-7
"""Longest and shortest part of a flight in series, in natural units. For bodies that are slower
than 1 the longest one is the time in which they would turn by so many radians."""
_FARTHEST = np.pi
"""Greatest angle by which a follower turns before it meets the pin of a driver at rest [rad]."""
_LAST_TERM = 1e-16
"""The last terms of a series over the speed, at the end of its part."""
_TIE = 1e-12
"""A torque through a train that is nearer to zero counts as positive: in a flight it grows."""


class Flight(NamedTuple):
    """A flight, or a part of it.

    theta, speed, rate, phi, turning, turning_rate : angle, speed and acceleration of driver and
        follower at its start.
    length : how long it lasts; inf where both bodies are at rest for good.
    halt, rest : times at which driver and follower come to rest, inf if they do not.
    even : whether the accelerations are constant. If they are not, the workspace holds the series
        of the part, within which neither driver nor follower changes its sense.
    """

    theta: float
    speed: float
    rate: float
    phi: float
    turning: float
    turning_rate: float
    length: float
    halt: float
    rest: float
    even: bool


class _Watched(IntEnum):
    """What becomes zero where the series of a part no longer holds: see `_watched`."""

    ANGLE_LEFT = 0
    DRIVER_SPEED = 1
    FOLLOWER_SPEED = 2
    BARREL_TORQUE = 3
    LOAD_TORQUE = 4
    ENERGY_ABOVE_REST = 5


@inner_jit
def launch(work, scene, theta, speed, phi, turning, end):
    """The flight from a state to the driver angle `end`, or its first part."""
    if not is_even(scene):
        return _in_series(work, scene, theta, speed, phi, turning, end)
    sense, follower_sense = driver_sense(scene, theta, speed), np.sign(turning)
    rate = free_driver(scene, theta, speed, sense).rate
    turning_rate = free_follower(scene, turning, follower_sense).rate
    rest = -turning / turning_rate if turning_rate != 0.0 else np.inf
    length, halt = _even_length(scene, theta, speed, rate, end)
    if sense == 0.0 and turning != 0.0:
        length = min(rest, _FARTHEST / abs(turning))
    return Flight(
        theta=theta, speed=speed, rate=rate, phi=phi, turning=turning, turning_rate=turning_rate,
        length=length, halt=halt, rest=rest, even=True,
    )  # fmt: skip


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
    sense, follower_sense = driver_sense(scene, theta, speed), np.sign(turning)
    if sense == 0.0 and turning == 0.0:
        return Flight(
            theta=theta, speed=0.0, rate=0.0, phi=phi, turning=0.0, turning_rate=0.0,
            length=np.inf, halt=np.inf, rest=np.inf, even=True,
        )  # fmt: skip
    # whether power flows backwards through a lossy train
    backs = scene.barrel_efficiency != 1.0 and sense != 0.0
    backs = backs and free_driver(scene, theta, speed, sense).through < -_TIE
    driven = scene.load_train_efficiency != 1.0
    driven = driven and _given(scene, turning, follower_sense) < -_TIE
    _fill_series(work, scene, theta, speed, phi, turning, backs, driven)
    part = Flight(
        theta=theta, speed=speed, rate=work.driver_speed[1], phi=phi, turning=turning,
        turning_rate=work.follower_speed[1], length=_series_length(work), halt=np.inf, rest=np.inf,
        even=False,
    )  # fmt: skip
    length, halt = part.length, np.inf
    if sense != 0.0:
        # as long as the driver goes on in the same sense, it passes an angle only once
        length = halt = _passing(work, scene, part, length, 0.0, _Watched.DRIVER_SPEED)
        back = last_knot(theta, scene.edges[0], scene)
        end = next_knot(theta, end, scene) if sense > 0.0 else back
        length = _passing(work, scene, part, length, end, _Watched.ANGLE_LEFT)
    if backs:
        length = _passing(work, scene, part, length, 0.0, _Watched.BARREL_TORQUE)
    if driven:
        length = _passing(work, scene, part, length, 0.0, _Watched.LOAD_TORQUE)
    if is_viscous(scene) and is_undriven(theta, scene):
        length = _passing(work, scene, part, length, 0.0, _Watched.ENERGY_ABOVE_REST)
    rest = _passing(work, scene, part, length, 0.0, _Watched.FOLLOWER_SPEED)
    rest = rest if rest < length else np.inf
    halt = halt if halt <= length and halt < part.length else np.inf
    return Flight(
        theta=theta, speed=speed, rate=part.rate, phi=phi, turning=turning,
        turning_rate=part.turning_rate, length=min(length, rest), halt=halt, rest=rest, even=False,
    )  # fmt: skip


@inner_jit
def _fill_series(work, scene, theta, speed, phi, turning, backs, driven):
    """Fill the coefficients of angles and speeds; `backs` and `driven` say in which trains the
    power flows backwards.
    """
    sense, follower_sense = driver_sense(scene, theta, speed), np.sign(turning)
    # the factors e of both trains
    barrel = shared(scene.barrel_efficiency, -sense if backs else sense)
    train = shared(scene.load_train_efficiency, 1.0 if driven else -1.0)
    one, two = driver_of(scene), follower_of(scene)
    # a driver that is held does not yield to the torque
    driver = one.near + barrel * one.far if sense != 0.0 else np.inf
    follower = two.near + train * two.far
    # at a knot, the torque that the driver is about to meet counts
    torque, slope = torque_at(theta + sense * KNOT_GAP, scene)
    torque, slope = barrel * torque, barrel * slope
    # coefficients of the torques on both bodies, of which that of the drive is linear in theta
    push = torque - slope * sense * KNOT_GAP - sense * scene.bearing
    pull = -follower_sense * train * scene.load
    angle, pace = work.driver_angle, work.driver_speed
    follower_angle, follower_pace = work.follower_angle, work.follower_speed
    angle[0], pace[0], follower_angle[0], follower_pace[0] = theta, speed, phi, turning
    for k in range(N - 1):
        # coefficient k of the squares of both speeds
        air = wind = 0.0
        for i in range(k + 1):
            air += pace[i] * pace[k - i]
            wind += follower_pace[i] * follower_pace[k - i]
        push -= sense * scene.driver_drag * air + scene.driver_viscous * pace[k]
        pull -= (
            follower_sense * scene.follower_drag * wind + scene.follower_viscous * follower_pace[k]
        )
        share = 1.0 / (k + 1)
        angle[k + 1], follower_angle[k + 1] = pace[k] * share, follower_pace[k] * share
        pace[k + 1], follower_pace[k + 1] = push * share / driver, pull * share / follower
        push, pull = slope * angle[k + 1], 0.0


@inner_jit
def _series_length(work):
    """Time for which the series give speeds and angles to rounding."""
    pace, follower_pace = work.driver_speed, work.follower_speed
    speed, turning = abs(pace[0]), abs(follower_pace[0])
    quick = max(speed, turning) + np.sqrt(max(abs(pace[1]), abs(follower_pace[1])))
    length = _LONGEST / min(quick, 1.0)
    for k in (N - 2, N - 1):
        share = max(abs(pace[k]), abs(follower_pace[k])) / (_LAST_TERM * (1.0 + speed))
        if share * length**k > 1.0:
            length = max(share ** (-1.0 / k), _SHORTEST)
    return length


@inner_jit
def _given(scene, turning, sense):
    """The torque z through the load's train in a flight, times a positive number."""
    return -sense * free_follower(scene, turning, sense).through


@inner_jit
def _watched(scene, goal, what, sense, follower_sense, theta, speed, turning):
    """A value whose zero `_passing` finds, and its slope in time; `goal` is a driver angle."""
    driver = free_driver(scene, theta, speed, sense)
    follower = free_follower(scene, turning, follower_sense)
    if what == _Watched.ANGLE_LEFT:
        return theta - goal, speed
    if what == _Watched.DRIVER_SPEED:
        return speed, driver.rate
    if what == _Watched.FOLLOWER_SPEED:
        return turning, follower.rate
    if what == _Watched.ENERGY_ABOVE_REST:
        slope = scene.rho * speed * driver.rate + turning * follower.rate
        return scene.rho * (speed * speed - REST) + turning * turning, 2.0 * slope
    if what == _Watched.BARREL_TORQUE:
        body = driver_of(scene)
        slope = body.near * torque_at(theta, scene)[1] * speed
        return driver.through, slope + body.far * drag_slope(body, speed) * driver.rate
    body = follower_of(scene)
    slope = body.far * drag_slope(body, turning) * follower.rate
    return _given(scene, turning, follower_sense), -follower_sense * slope


@inner_jit
def _passing(work, scene, part, length, goal, what):
    """Time within a part at which what is watched changes its sign; `length` where it does not.

    `goal` is the driver angle from which the angle left is counted.
    """
    # the senses of a part, also beyond its end, where it is smooth
    sense, follower_sense = driver_sense(scene, part.theta, part.speed), np.sign(part.turning)
    inputs = scene, goal, what, sense, follower_sense
    at_start = _watched(*inputs, part.theta, part.speed, part.turning)[0]
    low, high, t = 0.0, length, length
    for _ in range(80):
        theta, speed, _phi, turning = state_at(work, part, t)
        value, slope = _watched(*inputs, theta, speed, turning)
        if t == length and not value * at_start < 0.0:
            return length
        guess, low, high = newton_in_bracket(t, value, slope, low, high, at_start < 0.0)
        step, t = abs(guess - t), guess
        if step <= 1e-15 * length:
            break
    return t


@inner_jit
def state_at(work, flight, t):
    """theta, theta_dot, phi and phi_dot after a time within a flight."""
    if not flight.even:
        theta = speed = phi = turning = 0.0
        for i in range(N):
            k = N - 1 - i
            theta, speed = theta * t + work.driver_angle[k], speed * t + work.driver_speed[k]
            phi, turning = phi * t + work.follower_angle[k], turning * t + work.follower_speed[k]
        return theta, speed, phi, turning
    theta = flight.theta + (flight.speed + 0.5 * flight.rate * t) * t
    speed, moved = flight.speed + flight.rate * t, min(t, flight.rest)
    phi = flight.phi + (flight.turning + 0.5 * flight.turning_rate * moved) * moved
    turning = flight.turning + flight.turning_rate * moved if t < flight.rest else 0.0
    return theta, speed, phi, turning


@inner_jit
def state_after(work, flight, t):
    """As `state_at`; a body that has come to rest by then is at rest to the last digit."""
    theta, speed, phi, turning = state_at(work, flight, t)
    speed = 0.0 if t >= flight.halt else speed
    return theta, speed, phi, 0.0 if t >= flight.rest else turning


@inner_jit
def is_calm(scene, theta, speed, turning):
    """Whether only viscous drag acts and both bodies count as at rest: `law.rest_speed`."""
    if not (is_viscous(scene) and is_undriven(theta, scene)):
        return False
    return scene.rho * speed * speed + turning * turning <= (1.0 + 1e-9) * scene.rho * REST


@inner_jit
def is_even(scene):
    """Whether driver and follower have constant accelerations without contact."""
    return is_constant(scene) and is_drag_free(scene)
