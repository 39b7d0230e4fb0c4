"""Two bodies with outlines for tests: features from numbers, and marches over them."""

import math

import numpy as np

from escapement.engines.two_bodies import march as marching
from escapement.engines.two_bodies.law import Law
from escapement.engines.two_bodies.pairs import joints_of, pairs_of
from escapement.mechanisms.features import CONVEX, LINE, Features


def features(rows, fold=1):
    """Features from rows of their numbers."""
    columns = np.array(rows, float).T
    return Features(columns[0].astype(np.int64), *columns[1:], fold=fold)


def geneva(slots, half_clearance, pin=0.0):
    """Driver, follower and distance of a Geneva wheel; theta is 0 at the entry of a pin."""
    centre = 1.0 / math.sin(math.pi / slots)
    outer, entry = math.sqrt(centre**2 - 1.0), math.pi / slots - 0.5 * math.pi
    pins = 2 * slots // (slots - 2) if 2 * slots % (slots - 2) == 0 else 1
    driver = features([(CONVEX, math.cos(entry), math.sin(entry), 0.0, math.pi, pin)], pins)
    along = np.exp(1j * entry) - centre
    along /= abs(along)
    wall, end = half_clearance + pin, math.sqrt(outer**2 - half_clearance**2)
    first = max(centre - 1.2, 0.05)
    low, high = first * along + 1j * wall * along, end * along - 1j * wall * along
    rows = [
        (LINE, low.real, low.imag, np.angle(along), end - first, 0.0),
        (LINE, high.real, high.imag, np.angle(-along), end - first, 0.0),
    ]
    return driver, features(rows, slots), centre


def followed(driver, follower, centre, inertias, count, start=(0.0, 0.0), rows=0, **numbers):
    """Follow engagements with a torque of 1; returns times, states at handoffs, the ending, rows.

    The unit of time is sqrt(I_1/torque), and times and speeds are returned for I = `inertias`.
    """
    unit = math.sqrt(inertias[1])
    given = dict.fromkeys(Law._fields, 0.0) | {"plain": True, "gain": 1.0, **numbers}
    given |= {"rho": inertias[0] / inertias[1], "centre": centre, "begin": start[0]}
    law = Law(**given | {"torque": np.array([0.0, 0.0, 1.0])})
    begins, used = np.zeros((count + 1, marching.BEGIN)), np.zeros(2, np.int64)
    begins[0, [marching.THETA, marching.PHI, marching.PAIR]] = *start, marching.UNKNOWN
    table = np.zeros(rows, marching.ROW)
    pairs, joints = pairs_of(driver, follower), (joints_of(driver), joints_of(follower))
    pitches = 2.0 * math.pi / driver.fold, 2.0 * math.pi / follower.fold
    done, ending = 0, 15
    while ending == 15:
        inputs = law, pairs, joints, pitches, math.inf, done, begins[done:], table, used
        ending, more, _theta, _time = marching.march(*inputs)
        done, used[1] = done + more, 0
    begins[:, marching.TIME] *= unit
    begins[:, [marching.SPEED, marching.TURNING]] /= unit
    return begins[: done + 1], ending, table[: used[0]]
