"""Pitch curves of two equal ellipses that turn about a focus each.

One is pivoted at the origin, the driver's at the other end of the line of centres,
2a away. With E the eccentric anomaly, counted from where the driving ellipse has
its far vertex on the line of centres,

    driving ellipse  radius a (1 + e cos E),  tan(alpha/2) = sqrt((1-e)/(1+e)) tan(E/2)
    driven ellipse   radius a (1 - e cos E),  tan(beta/2)  = sqrt((1+e)/(1-e)) tan(E/2)

alpha and beta being their turns from there. Both touch at one E: the radii make up
2a and the arcs from the vertices are equal, so the curves roll without slip.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement.model import FloatArray


@dataclass(frozen=True)
class PitchEllipse:
    """An ellipse that turns about one of its focuses.

    Parameters
    ----------
    semi_major_axis : float
        a [m].
    eccentricity : float
        e [-], in [0, 1).
    far : bool
        Whether angles are counted from the far vertex, as on the driving gear,
        or from the near one, as on the driven gear.
    """

    semi_major_axis: float
    eccentricity: float
    far: bool

    @property
    def _side(self) -> float:
        return 1.0 if self.far else -1.0

    @property
    def semi_minor_axis(self) -> float:
        """b = a sqrt(1 - e^2) [m]."""
        e = self.eccentricity
        return self.semi_major_axis * math.sqrt((1.0 - e) * (1.0 + e))

    def radius(self, angle: ArrayLike) -> FloatArray:
        """Distance of the curve from the pivot at angles from the vertex [m] (eq. 6)."""
        e = self._side * self.eccentricity
        return self.semi_major_axis * (1.0 - e * e) / (1.0 - e * np.cos(angle))

    def eccentric_anomaly(self, angle: ArrayLike) -> FloatArray:
        """Angle seen from the ellipse's auxiliary circle, E [rad]; any number of turns."""
        angles = np.asarray(angle, dtype=float)
        e = self._side * self.eccentricity
        turns = np.rint(angles / (2.0 * math.pi))
        half = 0.5 * angles - math.pi * turns
        stretch = math.sqrt((1.0 + e) / (1.0 - e))
        return 2.0 * (np.arctan2(stretch * np.sin(half), np.cos(half)) + math.pi * turns)

    def arc(self, angle: ArrayLike) -> FloatArray:
        """Length of the curve from the vertex to `angle` [m], an elliptic integral."""
        from scipy.special import ellipe, ellipeinc

        anomaly = self.eccentric_anomaly(angle)
        m = self.eccentricity**2
        # ellipeinc counts from the minor axis, the vertex is on the major one
        quarter = ellipe(m)
        result: FloatArray = self.semi_major_axis * (
            quarter - ellipeinc(0.5 * math.pi - anomaly, m)
        )
        return result

    def curvature(self, angle: ArrayLike) -> FloatArray:
        """Curvature of the curve at angles from the vertex [1/m]; b/a^2 at its least."""
        anomaly = self.eccentric_anomaly(angle)
        a, b = self.semi_major_axis, self.semi_minor_axis
        return a * b / ((a * np.sin(anomaly)) ** 2 + (b * np.cos(anomaly)) ** 2) ** 1.5

    def tangent_angle(self, angle: ArrayLike) -> FloatArray:
        """Angle from the radius to the tangent, pi/2 on a circle [rad]."""
        angles = np.asarray(angle, dtype=float)
        e = self._side * self.eccentricity
        result: FloatArray = 0.5 * math.pi + np.arctan2(
            e * np.sin(angles), 1.0 - e * np.cos(angles)
        )
        return result
