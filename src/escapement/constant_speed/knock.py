"""Impacts of a pin in a slot with clearance, in a drive at constant speed, compiled.

The driver is not slowed by one, so all of it is explicit. In units of the crank radius, and of
time in which the driver's speed is one, the wall s stands at

    phi_s(theta) = Phi(theta) - s asin(q),    q = c/R

with half the clearance c and the distance R of the pin from the follower's axis. With a = asin(q)
and u = R'/R its derivatives follow from q' = -q u:

    a' = -y u,    y = q/sqrt(1 - q^2),    a'' = y (u^2/(1 - q^2) - u')

At the entry the follower stands with its slot centred, and the front wall is met where
phi_+(theta) = Phi(entry). The pin leaves the front wall where phi_+'' + load = 0, and the follower
then turns freely, slowed by its load until it rests, to where it meets a wall again.
"""

from typing import NamedTuple

import numpy as np

from escapement.mechanisms.path import HALF_RATE, RATE_SUM, Path
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.gauss import POINTS, WEIGHTS, N
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.roots import newton_in_bracket

_STEPS = 64  # between two angles, in which a first zero is looked for
_HALVINGS = 50  # of a step, until a zero is known to rounding
_FOUND = 1e-15  # rad, how exactly a zero is known
FRONT, REAR, NOWHERE = 1.0, -1.0, 0.0
"""Which wall the follower meets after its flight."""


class FlightStart(NamedTuple):
    """The follower between two walls: driver angle, angle and speed at its start, and load.

    The angle is counted from that of the slot's middle there.
    """

    start: float
    angle: float
    speed: float
    load: float


class Knock(NamedTuple):
    """Impacts of an engagement; NaN for what does not happen. Angles from dead centre [rad].

    entry_angle, entry_speed : driver angle at which the pin meets the front wall, and the speed
        phi_+' that the wall then has, times the driver's.
    entry_distance : distance of the pin from the follower's axis there, in crank radii.
    lift_off : driver angle at which the pin leaves the front wall.
    wall : `FRONT` or `REAR`, the wall that the follower meets next; `NOWHERE` until the exit.
    reversal_angle, reversal_speed, reversal_distance : driver angle, relative speed and distance
        of that impact.
    """

    entry_angle: float
    entry_speed: float
    entry_distance: float
    lift_off: float
    wall: float
    reversal_angle: float
    reversal_speed: float
    reversal_distance: float


_NAN = float("nan")
NO_KNOCK = Knock(_NAN, _NAN, _NAN, _NAN, NOWHERE, _NAN, _NAN, _NAN)
"""Of a drive whose pins fit their slots."""


@inner_jit
def _turned(path, start, end):
    """Follower angle turned over a step, for a pin in the middle of its slot."""
    half, total = 0.5 * (end - start), 0.0
    for i in range(N):
        total += WEIGHTS[i] * pose_at(path, start + half * (1.0 + POINTS[i]))[0]
    return half * total


@inner_jit
def lead_at(path, c, theta):
    """a = asin(c/R), a' and a'' at a driver angle, and g, g' and R there."""
    numbers = path.numbers
    g, u, dg, radius = pose_at(path, theta)
    q = min(c / radius, 1.0)
    cosine = np.sqrt(1.0 - q * q)
    y = q / cosine
    product = 0.25 * numbers[RATE_SUM] ** 2 - numbers[HALF_RATE] ** 2
    du = product - numbers[RATE_SUM] * g + g * g - u * u
    bend = y * (u * u / (cosine * cosine) - du)
    return np.arcsin(q), -y * u, bend, g, dg, radius


@jit
def knock(numbers, c, load, entry, exit_):
    """Impacts of a pin in a slot through the follower's axis.

    Parameters
    ----------
    numbers : `PinNumbers` of the path.
    c : half the clearance, in crank radii; > 0.
    load : load torque over I_f W^2.
    entry, exit_ : driver angles of the engagement [rad].

    Returns
    -------
    Knock
    """
    path, nan = Path(False, numbers), np.nan
    first = _entry(path, c, entry, exit_)
    if np.isnan(first):
        return landed(nan, nan, nan, nan, NOWHERE)
    _a, slope, _bend, g, _dg, radius = lead_at(path, c, first)
    speed, start = g - slope, _lift_off(path, c, load, first, exit_)
    wall, at = NOWHERE, nan
    if not np.isnan(start):
        wall, at = _landing(path, c, load, start, exit_)
    if wall == NOWHERE:
        return landed(first, speed, radius, start, NOWHERE)
    _a, slope, _bend, g, _dg, _radius = lead_at(path, c, start)
    flying = max(g - slope - load * (at - start), 0.0)
    _a, slope, _bend, g, _dg, radius_at = lead_at(path, c, at)
    met = abs(flying - (g - wall * slope))
    return landed(first, speed, radius, start, wall, reversal=(at, met, radius_at))


@inner_jit
def landed(first, speed, radius, start, wall, reversal=(np.nan, np.nan, np.nan)):
    """The impacts, of which the last ones may not happen."""
    at, met, radius_at = reversal
    return Knock(
        entry_angle=first, entry_speed=speed, entry_distance=radius, lift_off=start, wall=wall,
        reversal_angle=at, reversal_speed=met, reversal_distance=radius_at,
    )  # fmt: skip


@inner_jit
def _entry(path, c, entry, exit_):
    """Driver angle at which the front wall meets the follower at rest; NaN if it never does."""
    turned = 0.0
    for i in range(_STEPS):
        # without clearance they meet at the entry, so the steps grow from there
        low = entry + (exit_ - entry) * (i / _STEPS) ** 2
        high = entry + (exit_ - entry) * ((i + 1) / _STEPS) ** 2
        after = turned + _turned(path, low, high)
        if after >= lead_at(path, c, high)[0]:
            start, theta = low, high
            for _ in range(_HALVINGS):
                lead, slope, _bend, g, _dg, _radius = lead_at(path, c, theta)
                value = turned + _turned(path, start, theta) - lead
                guess, low, high = newton_in_bracket(theta, value, g - slope, low, high, True)
                step = abs(guess - theta)
                theta = guess
                if step <= _FOUND:
                    break
            return theta
        turned = after
    return np.nan


@inner_jit
def _lift_off(path, c, load, start, exit_):
    """Driver angle at which the front wall is left: phi_+'' + load becomes negative."""
    step = (exit_ - start) / _STEPS
    for i in range(_STEPS + 1):
        _a, _slope, bend, _g, dg, _radius = lead_at(path, c, start + i * step)
        if dg - bend + load < 0.0:
            low, high = start + max(i - 1, 0) * step, start + i * step
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                _a, _slope, bend, _g, dg, _radius = lead_at(path, c, middle)
                if dg - bend + load < 0.0:
                    high = middle
                else:
                    low = middle
            return high
    return np.nan


@inner_jit
def _landing(path, c, load, start, exit_):
    """The wall that the follower meets first after it has left the front wall, and where."""
    a, slope, _bend, g, _dg, _radius = lead_at(path, c, start)
    flight = FlightStart(start, -a, g - slope, load)
    turned = 0.0
    for i in range(_STEPS):
        # the flight is short if the clearance is small, so the steps grow from its beginning
        low = start + (exit_ - start) * (i / _STEPS) ** 3
        high = start + (exit_ - start) * ((i + 1) / _STEPS) ** 3
        after = turned + _turned(path, low, high)
        for wall in (REAR, FRONT):
            # the gap to the front wall opens from zero: rounding there is no impact
            hidden = wall == FRONT and i < _STEPS // 8
            if hidden or _gap(path, c, high, after, flight, wall) > 0.0:
                continue
            begin, theta = low, high
            for _ in range(_HALVINGS):
                there = turned + _turned(path, begin, theta)
                value = _gap(path, c, theta, there, flight, wall)
                slope = _closing(path, c, theta, flight, wall)
                guess, low, high = newton_in_bracket(theta, value, slope, low, high, False)
                step = abs(guess - theta)
                theta = guess
                if step <= _FOUND:
                    break
            return wall, theta
        turned = after
    return NOWHERE, np.nan


@inner_jit
def _gap(path, c, theta, turned, flight, wall):
    """Distance in angle from a wall to the follower in flight, which ends where it is zero.

    turned : angle by which the slot's middle has turned since the beginning of the flight.
    """
    time = theta - flight.start
    # the load stops the follower, and then holds it
    time = min(time, flight.speed / flight.load) if flight.load > 0.0 else time
    follower = flight.angle + (flight.speed - 0.5 * flight.load * time) * time
    return wall * (follower - turned + wall * lead_at(path, c, theta)[0])


@inner_jit
def _closing(path, c, theta, flight, wall):
    """Derivative of `_gap` by the driver angle."""
    _a, slope, _bend, g, _dg, _radius = lead_at(path, c, theta)
    speed = max(flight.speed - flight.load * (theta - flight.start), 0.0)
    return wall * (speed - g) + slope
