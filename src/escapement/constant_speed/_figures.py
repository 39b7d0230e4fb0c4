"""Reversals, extremes and mean of the torque, as roots and integrals over the angle."""

import math
from itertools import pairwise

import numpy as np

from escapement.constant_speed._chebyshev import extremes, interpolate, zeros
from escapement.constant_speed.case import Case
from escapement.constant_speed.contact import table
from escapement.constant_speed.extrema import edges, rounding_of_acceleration
from escapement.constant_speed.kernels import tabulate_ratio
from escapement.model import FloatArray

_PIECES = 512  # to begin with, of a load of any shape: a row in 5000 of a table is seen
_ROUNDING = 64.0 * np.finfo(float).eps  # of the load: the moment carries that of the angle too


def find_reversals(case: Case) -> tuple[FloatArray, int]:
    """Angles where the contact moment changes sign, and Filemon's zone."""
    points = _places(case, edges(case.mechanism))
    found = zeros(lambda theta: table(case, theta)[2][1], points)
    places = np.unique(np.concatenate([[points[0]], found, [points[-1]]]))
    sides = [_side(case, low, high) for low, high in pairwise(places)]
    reversals, side = [], 0.0
    for place, following in zip(places[:-1], sides, strict=True):
        if following * side < 0.0:
            reversals.append(place)
        side = following or side
    if not reversals:
        return np.empty(0), 1
    return np.array(reversals), 3 if side < 0.0 else 2


def _places(case: Case, points: list[float]) -> list[float]:
    """`points`, and between them more where a load may hide something narrow."""
    if not case.load_varies:
        return points
    width = (points[-1] - points[0]) / _PIECES
    spans = [
        np.linspace(low, high, math.ceil((high - low) / width), endpoint=False)
        for low, high in pairwise(points)
    ]
    return [*np.concatenate(spans).tolist(), points[-1]]


def _side(case: Case, low: float, high: float) -> float:
    """Sign of the contact moment between two of its zeros; 0 where it is rounding."""
    middle = np.array([0.5 * (low + high)])
    _, load, (ratio, moment, _) = table(case, middle)
    rounding = _ROUNDING * abs(load[0]) + case.inertial * rounding_of_acceleration(ratio[0])
    return float(np.sign(moment[0]) if abs(moment[0]) > rounding else 0.0)


def torque_figures(case: Case, reversals: FloatArray) -> dict[str, float]:
    """Extremes and mean of the torque, between the points where it has kinks."""
    points, half = edges(case.mechanism), case.half
    kinks = {*points, half, *reversals.tolist(), *_idle(case, reversals)}

    def torque(theta: FloatArray) -> FloatArray:
        return table(case, theta)[2][2]

    pieces = interpolate(torque, _places(case, sorted(kinks)))
    first = [piece for piece in pieces if piece.high <= half]
    mean = sum(piece.integral() for piece in first) / (half - points[0])
    top, top_at, bottom, bottom_at = extremes(torque, pieces)
    return {
        "torque_max": top,
        "torque_max_angle": top_at,
        "torque_min": bottom,
        "torque_min_angle": bottom_at,
        "torque_mean": float(mean),
    }


def _idle(case: Case, reversals: FloatArray) -> list[float]:
    """Where friction holds what the follower drives, p = 0: the power turns round there."""
    if case.friction == 0.0 or case.efficiency == 1.0 or len(reversals) == 0:
        return []

    def ratio(theta: FloatArray) -> FloatArray:
        out = np.empty_like(theta)
        tabulate_ratio(case.mechanism.path, theta, -1.0, case.friction, out)
        return out

    return zeros(ratio, edges(case.mechanism)).tolist()
