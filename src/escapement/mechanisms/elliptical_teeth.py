"""Elliptical gears: pitch curves, the module of their teeth, and the fewest teeth.

The two equal ellipses turn about a focus each, one at the origin, the driver's at the
other end of the line of centres, 2a away. With E the eccentric anomaly, counted from where
the driving ellipse has its far vertex on the line of centres,

    driving ellipse  radius a (1 + e cos E),  tan(alpha/2) = sqrt((1-e)/(1+e)) tan(E/2)
    driven ellipse   radius a (1 - e cos E),  tan(beta/2)  = sqrt((1+e)/(1-e)) tan(E/2)

where alpha and beta are their rotations from there. Both touch at the same E: the radii add up to
2a and the arcs from the vertices are equal, so the curves roll without slip.

The pitch of the teeth is the same along the whole curve, so their number determines the module. A
rack of pressure angle alpha and addendum h m undercuts the flanks where the radius of curvature
of the pitch curve is less than h m/sin^2(alpha); on an ellipse it is least at the ends of the
long axis, a (1 - e^2).

Source: F. L. Litvin and A. Fuentes, Gear Geometry and Applied Theory (2004), chapters
6 and 12: a non-circular gear is cut like its circle of curvature.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.mechanisms.elliptical_planetary import EllipticalPlanetary, between_0_and
from escapement.mechanisms.protocol import FloatArray

PRESSURE_ANGLE = math.radians(20.0)
ADDENDUM = 1.0


def stretched(angle: ArrayLike, stretch: float) -> FloatArray:
    """2 atan(stretch tan(angle/2)), continued over any number of turns [rad]."""
    angles = np.asarray(angle, dtype=float)
    turns = np.rint(angles / (2.0 * math.pi))
    half = 0.5 * angles - math.pi * turns
    return 2.0 * (np.arctan2(stretch * np.sin(half), np.cos(half)) + math.pi * turns)


@dataclass(frozen=True)
class PitchEllipse:
    """An ellipse that turns about one of its focuses.

    Parameters
    ----------
    semi_major_axis : float
        a [m].
    eccentricity : float
        e [-], between -1 and 1: positive where angles are counted from the far vertex, as on
        the driving gear, negative where they are counted from the near one.
    """

    semi_major_axis: float
    eccentricity: float

    def radius(self, angle: ArrayLike) -> FloatArray:
        """Distance of the curve from the pivot at angles from the vertex [m] (eq. 6)."""
        e = self.eccentricity
        return self.semi_major_axis * (1.0 - e * e) / (1.0 - e * np.cos(angle))

    def arc(self, angle: ArrayLike) -> FloatArray:
        """Length of the curve from the vertex to `angle` [m], an elliptic integral."""
        from scipy.special import ellipe, ellipeinc

        e = self.eccentricity
        anomaly = stretched(angle, math.sqrt((1.0 + e) / (1.0 - e)))
        # ellipeinc counts from the minor axis, the vertex is on the major one
        away = ellipe(e * e) - ellipeinc(0.5 * math.pi - anomaly, e * e)
        return np.asarray(self.semi_major_axis * away)

    def curvature(self, angle: ArrayLike) -> FloatArray:
        """Curvature of the curve at angles from the vertex [1/m]; b/a^2 at its least."""
        e = self.eccentricity
        parameter = self.semi_major_axis * (1.0 - e) * (1.0 + e)
        return np.asarray(np.sin(self.tangent_angle(angle)) ** 3 / parameter)

    def tangent_angle(self, angle: ArrayLike) -> FloatArray:
        """Angle from the radius to the tangent, pi/2 on a circle [rad]."""
        e = self.eccentricity
        return np.asarray(0.5 * math.pi + np.arctan2(e * np.sin(angle), 1.0 - e * np.cos(angle)))


def tooth_module(mechanism: EllipticalPlanetary, teeth: int) -> float:
    """Module of the elliptical gears [m]: pitch over pi.

    Parameters
    ----------
    mechanism : EllipticalPlanetary
        The drive.
    teeth : int
        Teeth of each elliptical gear, >= 3. With an odd number both gears are equal and
        symmetrical about their long axes: a tooth at one end, a gap at the other.
    """
    count = validate.integer("teeth", teeth, 3, "give the teeth of one elliptical gear")
    return float(mechanism.pitch_ellipses[0].arc(2.0 * math.pi)) / (math.pi * count)


def fewest_teeth(
    mechanism: EllipticalPlanetary,
    pressure_angle: float = PRESSURE_ANGLE,
    addendum: float = ADDENDUM,
) -> int:
    """Fewest teeth of the elliptical gears that a rack does not undercut.

    Parameters
    ----------
    mechanism : EllipticalPlanetary
        The drive; only its eccentricity matters.
    pressure_angle : float
        Pressure angle of the rack [rad], between 0 and pi/4.
    addendum : float
        How far the rack's straight flanks reach beyond its pitch line, in modules, > 0.

    Returns
    -------
    int
        18 for a circle, pressure angle 20 degrees and addendum 1; more for an ellipse.
    """
    remedy = "give less than pi/4, 0.349 rad are 20 degrees"
    angle = between_0_and(0.25 * math.pi, "pressure_angle", pressure_angle, remedy)
    reach = validate.positive("addendum", addendum, "1 is usual")
    from scipy.special import ellipe

    # both in semi-major axes, independent of the unit of the radii: 4 E(e), and 1 - e^2
    around = 4.0 * float(ellipe(mechanism.eccentricity**2))
    sharpest = 4.0 * mechanism.ratio / (mechanism.ratio + 1.0) ** 2
    limit = around * reach / (math.pi * sharpest * math.sin(angle) ** 2)
    return math.ceil(limit * (1.0 - 1e-12))
