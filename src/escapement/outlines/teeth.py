"""Teeth along a pitch curve, as a rack with straight flanks cuts them while it rolls along it.

Where the rack's pitch line touches the pitch curve at P, the gear's edge has the points of the
rack's edge whose normals run through P. In the frame of tangent T and outward normal N there, on
the side of a tooth that is met first when one runs along T (the signs in brackets: on the other)

    flank     P - (+) q cot(alpha) T + q N,   q the height, q/(sin cos alpha) before (behind) P
    fillet    P + (-) (H cot(psi) + r cos(psi)) T - (H + r sin(psi)) N,   cut by the round tip
    root      P - 1.25 m N
    tip       P + m N

with the module m, the pressure angle alpha, the radius r of the rack's tip, and H = 1.25 m - r.
One rack cuts both gears of a pair, so their flanks touch while the pitch curves roll. On a circle
the flank is an involute; on an ellipse it is locally that of the circle of curvature.

Source: F. L. Litvin and A. Fuentes, Gear Geometry and Applied Theory (2004), chapters 6 and 12.
"""

import math

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.base.spoken import spoken_length
from escapement.mechanisms.elliptical_teeth import ADDENDUM, PRESSURE_ANGLE, PitchEllipse
from escapement.mechanisms.protocol import FloatArray
from escapement.outlines.curves import ComplexArray, Curve, biarcs

_DEDENDUM = 1.25  # depth of the root below the pitch curve [modules]
_SINE, _COSINE = math.sin(PRESSURE_ANGLE), math.cos(PRESSURE_ANGLE)
# the rack's flank is straight down to one addendum, where its round tip begins
_ROUND = (_DEDENDUM - ADDENDUM) / (1.0 - _SINE)
_DEEP = _DEDENDUM - _ROUND
_BESIDE = _DEEP * _SINE / _COSINE + _ROUND / _COSINE
_HALVINGS = 50
_FINE = 2e-7  # distance of arcs from the flanks that they stand for [m]
_SPREAD = 1e-4  # the same of flanks of seven points, in modules; it shrinks with their cube


def rack_cut(pitch: PitchEllipse, teeth: int, centred: bool, backlash: float = 0.0) -> Curve:
    """The edge of a gear about the pivot of its pitch curve [m].

    Parameters
    ----------
    pitch : PitchEllipse
        The pitch curve; a circle has the eccentricity 0.
    teeth : int
        Number of teeth, at least as many as a rack does not undercut.
    centred : bool
        Whether a tooth is centred at the vertex from which angles are counted, else a gap.
    backlash : float
        Backlash of a pair of gears along the pitch curve [m]; half of it is taken from each.

    Returns
    -------
    Curve
        Counter-clockwise, as many arcs for each tooth, from the root before it on. They
        deviate from the flanks by up to 0.2 um.

    Raises
    ------
    InvalidValue
        If the backlash leaves no tip.
    """
    rolled = _Rolled(pitch)
    step = rolled.length / teeth
    module, half = step / math.pi, 0.25 * (step - backlash)
    points = 1 + max(3, math.ceil(6.0 * math.cbrt(_SPREAD * module / _FINE)))
    positions = np.arange(teeth)[:, None] + (0.0 if centred else 0.5)
    middle = np.asarray(step * positions, dtype=float)
    (first, up), (last, down) = (
        _side(rolled, middle + side * half, side, module, points) for side in (-1.0, 1.0)
    )
    # the tip of a tooth from its one corner over its middle to the other
    ends = rolled.foot(np.column_stack([first[:, -1], last[:, -1]]), middle)
    if backlash < 0.0 or not np.all(ends[:, 0] < ends[:, 1]):
        raise InvalidValue(
            "clearance of toothed gears must be at least 0 and leave tips, got "
            f"{spoken_length(backlash)} at a module of {spoken_length(module)}; "
            "give less"
        )
    anomalies = np.column_stack([ends[:, 0], ends.mean(axis=1), ends[:, 1]])
    point, along = rolled.at(anomalies)
    top = (point - 1j * module * ADDENDUM * along)[:, 1:2]
    corners = np.hstack([first, top, last[:, ::-1]])
    # directions in which the edge comes to each point and goes on from it
    comes = np.hstack([up, along[:, 1:], -down[:, -2::-1]])
    goes = np.hstack([up[:, :-1], along[:, :2], -down[:, ::-1]])
    return biarcs(corners.ravel(), goes.ravel(), comes.ravel())


def _side(
    rolled: "_Rolled", crossing: FloatArray, side: float, module: float, points: int
) -> tuple[ComplexArray, ComplexArray]:
    """Points of one side of every tooth from root to tip, and the directions of the edge there.

    crossing : arcs at which the flanks cross the pitch curve, shape (teeth, 1).
    side : -1 for the side that is met first, 1 for the other.
    """
    psi = np.linspace(0.5 * math.pi, PRESSURE_ANGLE, points)
    out = module * _DEEP * np.cos(psi) / np.sin(psi)
    point, along = rolled.at(rolled.anomaly(crossing + side * (module * _BESIDE + out)))
    across = out + module * _ROUND * np.cos(psi)
    deep = module * (_DEEP + _ROUND * np.sin(psi))
    fillet = point + along * (1j * deep - side * across)
    rounded = along * (-side * np.sin(psi) - 1j * np.cos(psi))
    low = np.full(crossing.shape, -module * ADDENDUM)
    # a flank bends most at its root
    share = np.linspace(0.0, 1.0, points)[1:] ** 1.3
    height = low + (_height(rolled, crossing, side, module) - low) * share
    flank, along = _flank(rolled, crossing, side, height)
    straight = along * (-side * _SINE - 1j * _COSINE)
    return np.hstack([fillet, flank]), np.hstack([rounded, straight])


def _flank(
    rolled: "_Rolled", crossing: FloatArray, side: float, height: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Points of flanks at heights above the tangent where they are cut, and its direction."""
    arc = crossing - side * height / (_SINE * _COSINE)
    point, along = rolled.at(rolled.anomaly(arc))
    return point + along * height * (side * _COSINE / _SINE - 1j), along


def _height(rolled: "_Rolled", crossing: FloatArray, side: float, module: float) -> FloatArray:
    """Height at which a flank is one addendum away from the pitch curve."""
    low, high = np.zeros(crossing.shape), np.full(crossing.shape, module * ADDENDUM)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        point, _along = _flank(rolled, crossing, side, middle)
        reached, _along = rolled.at(rolled.foot(point, crossing))
        beyond = np.abs(point - reached) > module * ADDENDUM
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return low


class _Rolled:
    """A pitch curve by its eccentric anomaly, which is the angle itself on a circle."""

    def __init__(self, pitch: PitchEllipse) -> None:
        self.major, self.eccentricity = pitch.semi_major_axis, pitch.eccentricity
        self.minor = self.major * math.sqrt(1.0 - self.eccentricity**2)
        self.length = float(pitch.arc(2.0 * math.pi))

    def at(self, anomaly: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Points, and unit tangents counter-clockwise."""
        cosine, sine = np.cos(anomaly), np.sin(anomaly)
        along = -self.major * sine + 1j * self.minor * cosine
        centre = self.eccentricity * self.major
        return centre + self.major * cosine + 1j * self.minor * sine, along / np.abs(along)

    def anomaly(self, arc: FloatArray) -> FloatArray:
        """Anomalies at arcs from the vertex, by Newton's method."""
        from scipy.special import ellipe, ellipeinc

        square = self.eccentricity**2
        found = 2.0 * math.pi * arc / self.length
        for _ in range(20):
            # ellipeinc counts from the minor axis
            gone = ellipe(square) - ellipeinc(0.5 * math.pi - found, square)
            step = (arc / self.major - gone) / np.sqrt(1.0 - square * np.cos(found) ** 2)
            found = found + step
            if np.abs(step).max() < 1e-14:
                break
        return found

    def foot(self, points: ComplexArray, arc: FloatArray) -> FloatArray:
        """Anomalies of the points of the curve that are nearest to given ones, by Newton's method.

        arc : from where to start, less than a tooth away.
        """
        found = np.broadcast_to(self.anomaly(arc), points.shape)
        for _ in range(20):
            cosine, sine = np.cos(found), np.sin(found)
            speed = -self.major * sine + 1j * self.minor * cosine
            second_derivative = -self.major * cosine - 1j * self.minor * sine
            away = points - (self.eccentricity * self.major - second_derivative)
            slope = np.real(away * second_derivative.conj()) - np.abs(speed) ** 2
            step = -np.real(away * speed.conj()) / slope
            found = found + step
            if np.abs(step).max() < 1e-13:
                break
        return found
