"""Motion without contact: how driver and follower move on their own.

`launch` gives a `Flight` from a state, as far as one formula holds. Without drag and with a
constant torque both accelerations are constant until a body comes to rest. Otherwise angles and
speeds are Taylor series in time about the start. The equations of motion give their coefficients
one after the other. A `Flight` in series is often only a part of the whole flight. This part ends

- where the last terms of the series would exceed rounding errors,
- where the law changes: at a knot of the torque or of the load, where a body comes to rest, where
  the torque through a lossy train changes its sign, or where bodies that nothing drives count as at
  rest,
- at the driver angle asked for.

The caller launches the next part from the end of the last one. A flight takes no notice of the
walls: `arrival` finds out whether the pin reaches one meanwhile.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from escapement.dynamics.free_bodies import (
    drag_slope,
    driver_of,
    driver_sense,
    follower_of,
    follower_sense,
    free_driver,
    free_follower,
    shared,
)
from escapement.dynamics.law import is_drag_free, is_viscous
from escapement.dynamics.load import has_load_curve, is_weight, load_knot, load_over
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
"""Longest and shortest part of a flight in series, in natural units of time. For bodies that are
slower than 1 the longest part is the time in which they would turn by so many radians."""
_FARTHEST = np.pi
"""Greatest angle by which the follower turns in a flight with the driver at rest [rad]; it meets
the pin before."""
_LAST_TERM = 1e-16
"""Greatest size of the last terms of a series at the end of its part, divided by the driver speed
plus 1."""
_TIE = 1e-12
"""A torque through a train counts as negative only if it is less than minus this. Where a part ends
because a negative torque has grown to zero, rounding thus cannot make it negative again."""


class Flight(NamedTuple):
    """A flight, or a part of it.

    theta, speed, rate, phi, turning, turning_rate : angle, speed and acceleration of driver and
        follower at its start.
    length : how long it lasts; inf where both bodies are at rest for good.
    halt, rest : times at which driver and follower come to rest, inf if they do not. This ends the
        flight, except that with constant accelerations a follower comes to rest and stays so.
    even : whether the accelerations are constant. If they are not, the workspace holds the series,
        and neither driver nor follower reverses before the end of the part.
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
    """The quantities of `_watched`; the part of a flight in series ends where one becomes zero."""

    ANGLE_LEFT = 0
    DRIVER_SPEED = 1
    FOLLOWER_SPEED = 2
    BARREL_TORQUE = 3
    LOAD_TORQUE = 4
    ENERGY_ABOVE_REST = 5
    FOLLOWER_ANGLE_LEFT = 6


@inner_jit
def launch(work, scene, theta, speed, phi, turning, end):
    """The flight from a state to the driver angle `end`, or its first part."""
    if not is_even(scene):
        return _in_series(work, scene, theta, speed, phi, turning, end)
    sense = driver_sense(scene, theta, speed)
    rate = free_driver(scene, theta, speed, sense).rate
    turning_rate = free_follower(scene, phi, turning, np.sign(turning)).rate
    rest = -turning / turning_rate if turning_rate != 0.0 else np.inf
    length, halt = _even_length(scene, theta, speed, rate, end)
    # a driver that its bearing holds never comes to `end`
    if sense == 0.0 and turning != 0.0:
        length = min(rest, _FARTHEST / abs(turning))
    return Flight(
        theta=theta, speed=speed, rate=rate, phi=phi, turning=turning, turning_rate=turning_rate,
        length=length, halt=halt, rest=rest, even=True,
    )  # fmt: skip


@inner_jit
def _even_length(scene, theta, speed, rate, end):
    """The length of a flight with constant accelerations, and the time at which the driver comes to
    rest in it, inf if it does not.

    The flight ends at the driver angle `end`, or where the driver comes to rest before. A driver
    that turns back may also leave the slot at the entry, or turn forwards again within the flight.
    """
    if speed < 0.0:
        room = max(theta - scene.edges[0], 0.0)
        left = speed * speed - 2.0 * rate * room
        if left > 0.0:
            return 2.0 * room / (np.sqrt(left) - speed), np.inf
        # with friction in the bearing or a lossy train the acceleration is another one once the
        # driver turns forwards, so the flight ends where it comes to rest
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
    sense, turns = driver_sense(scene, theta, speed), follower_sense(scene, phi, turning)
    # behind the exit the follower is locked
    turns = turns if end <= scene.edges[-1] else 0.0
    if sense == 0.0 and turns == 0.0:
        return Flight(
            theta=theta, speed=0.0, rate=0.0, phi=phi, turning=0.0, turning_rate=0.0,
            length=np.inf, halt=np.inf, rest=np.inf, even=True,
        )  # fmt: skip
    # Whether the torque through a lossy train is negative. `backs` is for the barrel's train, as
    # where the inertia of the barrel drives a driver that turns back; `driven` is for the load's
    # train, where the inertia of the last shaft drives the follower.
    backs = scene.barrel_efficiency != 1.0 and sense != 0.0
    backs = backs and free_driver(scene, theta, speed, sense).through < -_TIE
    driven = scene.load_train_efficiency != 1.0
    if driven:
        given = scene, 0.0, _Watched.LOAD_TORQUE, sense, turns, theta, speed, phi, turning
        value, slope = _watched(*given)
        driven = value < -_TIE or (value <= _TIE and slope < 0.0)
    _fill_series(work, scene, theta, speed, phi, turning, turns, backs, driven)
    part = Flight(
        theta=theta, speed=speed, rate=work.driver_speed[1], phi=phi, turning=turning,
        turning_rate=work.follower_speed[1], length=_series_length(work), halt=np.inf, rest=np.inf,
        even=False,
    )  # fmt: skip
    length, halt = part.length, np.inf
    if sense != 0.0:
        # up to where the driver comes to rest it turns in one sense, and passes an angle only once
        length = halt = _passing(work, scene, part, length, 0.0, _Watched.DRIVER_SPEED)
        back = last_knot(theta, scene.edges[0], scene)
        end = next_knot(theta, end, scene) if sense > 0.0 else back
        length = _passing(work, scene, part, length, end, _Watched.ANGLE_LEFT)
    if has_load_curve(scene) and turns != 0.0 and not is_weight(scene):
        knot = load_knot(phi, turns, scene.driver_angle, scene)
        length = _passing(work, scene, part, length, knot, _Watched.FOLLOWER_ANGLE_LEFT)
    if backs:
        length = _passing(work, scene, part, length, 0.0, _Watched.BARREL_TORQUE)
    if driven or (has_load_curve(scene) and scene.load_train_efficiency != 1.0):
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
def _fill_series(work, scene, theta, speed, phi, turning, turns, backs, driven):
    """Fill the coefficients of angles and speeds.

    `turns` is the sense of the follower, 0 where it is held. `backs` and `driven` tell whether the
    torques through the trains of barrel and load are negative, see `_in_series`.
    """
    sense, loaded = driver_sense(scene, theta, speed), has_load_curve(scene) and turns != 0.0
    # the factors e of both trains, see `dynamics.free_bodies`; power flows to the driver where the
    # torque through its train has the sign of its speed
    barrel = shared(scene.barrel_efficiency, -sense if backs else sense)
    train = shared(scene.load_train_efficiency, 1.0 if driven else -1.0)
    one, two = driver_of(scene), follower_of(scene)
    # a driver that its bearing holds stays at rest, as if its inertia were infinite
    driver = one.near + barrel * one.far if sense != 0.0 else np.inf
    follower = two.near + train * two.far
    # at a knot the torque ahead of the driver counts, so it is taken a little farther on
    torque, slope = torque_at(theta + sense * KNOT_GAP, scene)
    torque, slope = barrel * torque, barrel * slope
    # `push` and `pull` are the coefficients k of the torques on driver and follower as series in
    # time. For k = 0 the torque of the drive is that at theta; for k > 0 it is the slope times the
    # coefficient of the angle.
    push = torque - slope * sense * KNOT_GAP - sense * scene.bearing
    pull = -turns * train * scene.load
    if loaded:
        here = load_over(phi, turns, scene.driver_angle, scene)
        work.load[0], work.load_slope[0] = here
        pull -= here[0]
    viscous = one.viscous + barrel * one.motor
    angle, pace = work.driver_angle, work.driver_speed
    follower_angle, follower_pace = work.follower_angle, work.follower_speed
    angle[0], pace[0], follower_angle[0], follower_pace[0] = theta, speed, phi, turning
    for k in range(N - 1):
        # coefficient k of the squares of both speeds
        air = wind = 0.0
        for i in range(k + 1):
            air += pace[i] * pace[k - i]
            wind += follower_pace[i] * follower_pace[k - i]
        push -= sense * scene.driver_drag * air + viscous * pace[k]
        pull -= turns * scene.follower_drag * wind + scene.follower_viscous * follower_pace[k]
        share = 1.0 / (k + 1)
        angle[k + 1], follower_angle[k + 1] = pace[k] * share, follower_pace[k] * share
        pace[k + 1], follower_pace[k + 1] = push * share / driver, pull * share / follower
        push, pull = slope * angle[k + 1], 0.0
        if loaded:
            _extend_load(work, k, is_weight(scene))
            pull = -work.load[k + 1]


@inner_jit
def _extend_load(work, k, swings):
    """Fill coefficient k + 1 of the load over the follower angle, and of its slope by the angle.

    The slope is constant up to the next knot; that of a weight falls by the load per radian.
    """
    load = slope = 0.0
    for i in range(k + 1):
        load += work.load_slope[i] * work.follower_speed[k - i]
        slope -= work.load[i] * work.follower_speed[k - i]
    work.load[k + 1], work.load_slope[k + 1] = load / (k + 1), 0.0
    if swings:
        work.load_slope[k + 1] = slope / (k + 1)


@inner_jit
def _series_length(work):
    """Time up to which the last two terms of the series of both speeds are below `_LAST_TERM`, or
    `_SHORTEST` if that is longer."""
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
def _given(scene, phi, turning, sense):
    """z, the torque that the follower supplies through the load's train in a flight, times a
    positive number."""
    return -sense * free_follower(scene, phi, turning, sense).through


@inner_jit
def _watched(scene, goal, what, sense, turns, theta, speed, phi, turning):
    """The value of the quantity `what` at a state, and its derivative by time.

    `_passing` finds the zero of this value. `goal` is the angle of driver or follower from which
    the angle left is counted.
    """
    driver = free_driver(scene, theta, speed, sense)
    follower = free_follower(scene, phi, turning, turns)
    if what == _Watched.ANGLE_LEFT:
        return theta - goal, speed
    if what == _Watched.FOLLOWER_ANGLE_LEFT:
        return phi - goal, turning
    if what == _Watched.DRIVER_SPEED:
        return speed, driver.rate
    if what == _Watched.FOLLOWER_SPEED:
        return turning, follower.rate
    if what == _Watched.ENERGY_ABOVE_REST:
        slope = scene.rho * speed * driver.rate + turning * follower.rate
        return scene.rho * (speed * speed - REST) + turning * turning, 2.0 * slope
    if what == _Watched.BARREL_TORQUE:
        body = driver_of(scene)
        slope = body.near * (torque_at(theta, scene)[1] * speed - body.motor * driver.rate)
        return driver.through, slope + body.far * drag_slope(body, speed) * driver.rate
    body = follower_of(scene)
    slope = body.far * drag_slope(body, turning) * follower.rate
    if has_load_curve(scene):
        slope += body.far * load_over(phi, turns, scene.driver_angle, scene)[1] * turning
    return _given(scene, phi, turning, turns), -turns * slope


@inner_jit
def _passing(work, scene, part, length, goal, what):
    """Time within a part at which the quantity `what` changes its sign; `length` if it does not.

    `goal` is the angle from which an angle left is counted.
    """
    # the senses at the start count for all times that are tried, even if a body has reversed by
    # then, so that the value is a smooth function of time
    sense = driver_sense(scene, part.theta, part.speed)
    turns = follower_sense(scene, part.phi, part.turning)
    inputs = scene, goal, what, sense, turns
    at_start, slope = _watched(*inputs, part.theta, part.speed, part.phi, part.turning)
    # a value that is zero at the start has the sign to which it goes
    if abs(at_start) <= (_TIE if what == _Watched.LOAD_TORQUE else 0.0):
        at_start = slope
    low, high, t = 0.0, length, length
    for _ in range(80):
        value, slope = _watched(*inputs, *state_at(work, part, t))
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
    """Whether nothing drives the bodies, drag is viscous, and both count as at rest.

    `law.rest_speed` gives the reason.
    """
    if not (is_viscous(scene) and is_undriven(theta, scene)):
        return False
    return scene.rho * speed * speed + turning * turning <= (1.0 + 1e-9) * scene.rho * REST


@inner_jit
def is_even(scene):
    """Whether driver and follower have constant accelerations without contact."""
    return is_constant(scene) and is_drag_free(scene) and not has_load_curve(scene)
