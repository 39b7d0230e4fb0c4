"""Teeth of the elliptical gears: their module, and how few there may be.

Teeth have one pitch all along the curve, so a whole number of them fixes the module.
A rack of pressure angle alpha and addendum h m cuts into flanks that it has made where
the radius of curvature of the pitch curve is less than h m/sin^2(alpha); on an ellipse
it is least at the ends of the long axis, a (1 - e^2).

Source: F. L. Litvin and A. Fuentes, Gear Geometry and Applied Theory (2004), chapters
6 and 12: a non-circular gear is cut as its circle of curvature would be.
"""

import math

from escapement import validate
from escapement.mechanisms.elliptical_planetary import EllipticalPlanetary

PRESSURE_ANGLE = math.radians(20.0)
ADDENDUM = 1.0


def perimeter(mechanism: EllipticalPlanetary) -> float:
    """Length of the pitch ellipses [m], 4 a E(e)."""
    return float(mechanism.pitch_ellipses[0].arc(2.0 * math.pi))


def tooth_module(mechanism: EllipticalPlanetary, teeth: int) -> float:
    """Module of the elliptical gears [m]: pitch over pi.

    Parameters
    ----------
    mechanism : EllipticalPlanetary
        The drive.
    teeth : int
        Of each elliptical gear, >= 3. With an odd number both gears are alike and
        symmetrical about their long axes: a tooth at one end, a gap at the other.
    """
    count = validate.integer("teeth", teeth, 3, "give the teeth of one elliptical gear")
    return perimeter(mechanism) / (math.pi * count)


def fewest_teeth(
    mechanism: EllipticalPlanetary,
    pressure_angle: float = PRESSURE_ANGLE,
    addendum: float = ADDENDUM,
) -> int:
    """Fewest teeth of the elliptical gears that a rack does not undercut.

    Parameters
    ----------
    mechanism : EllipticalPlanetary
        The drive; its eccentricity alone matters.
    pressure_angle : float
        Of the rack [rad], between 0 and pi/4.
    addendum : float
        How far the rack's straight flanks reach beyond its pitch line, in modules, > 0.

    Returns
    -------
    int
        18 for a circle, pressure angle 20 degrees and addendum 1; more for an ellipse.
    """
    angle = validate.positive("pressure_angle", pressure_angle, "0.349 rad are 20 degrees")
    if not angle < 0.25 * math.pi:
        raise validate.fail("pressure_angle", "below pi/4", angle, "0.349 rad are 20 degrees")
    reach = validate.positive("addendum", addendum, "1 is usual")
    from scipy.special import ellipe

    # both in semi-major axes, whatever the unit of the radii: 4 E(e), and 1 - e^2
    around = 4.0 * float(ellipe(mechanism.eccentricity**2))
    sharpest = 4.0 * mechanism.ratio / (mechanism.ratio + 1.0) ** 2
    limit = around * reach / (math.pi * sharpest * math.sin(angle) ** 2)
    return math.ceil(limit * (1.0 - 1e-12))
