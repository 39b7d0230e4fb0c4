"""Bodies of the planetary drive with elliptical gears: pitch curves, in millimetres."""

from dataclasses import dataclass

import numpy as np

from escapement.mechanisms import EllipticalPlanetary
from escapement.outlines import Body, ComplexArray, Disc


@dataclass(frozen=True)
class EllipticalOutline:
    """Pitch curves of the drive [mm]; the carrier's axis is the origin."""

    mechanism: EllipticalPlanetary

    def bodies(self, theta: float, carrier: float | None = None) -> tuple[Disc, Disc, Body, Body]:
        """The two spur gears and the two ellipses.

        Parameters
        ----------
        theta : float
            Driver angle from greatest output speed [rad].
        carrier : float, optional
            Direction in which the carrier is to point [rad]. Default: `theta`, its true one.

        Returns
        -------
        tuple
            "sun" and "planet", then "driven" and "driving", whose edges start and have their
            middle at the ends of the long axis.
        """
        along = theta if carrier is None else carrier
        shaft = complex(self.line_of_centres(theta)[1] * np.exp(1j * along))
        driven, driving = self._ellipses(theta)
        return (
            Disc("sun", 0.0, 1e3 * self.mechanism.sun_radius),
            Disc("planet", shaft, 1e3 * self.mechanism.planet_radius),
            Body("driven", (driven,)).turned(along),
            Body("driving", (driving,)).turned(along, shaft),
        )

    def line_of_centres(self, theta: float) -> tuple[float, float, float]:
        """Points B, C and D on the carrier, by their distances from its axis A [mm].

        The spur gears touch at B, C is the planet's axis, and the ellipses touch at D.
        """
        sun, planet = 1e3 * self.mechanism.sun_radius, 1e3 * self.mechanism.planet_radius
        turned = self.mechanism.ratio * theta
        rho = 1e3 * float(self.mechanism.pitch_ellipses[0].radius(turned))
        return sun, sun + planet, sun + planet - rho

    def _ellipses(self, theta: float) -> tuple[ComplexArray, ComplexArray]:
        """Edges of the driven and the driving ellipse, each about its own pivot.

        The carrier lies along the real axis, from the driven ellipse's pivot to the
        driving one's.
        """
        driving, driven = self.mechanism.pitch_ellipses
        sweep = np.linspace(0.0, 2.0 * np.pi, 241)
        turned = theta + float(self.mechanism.follower_angle(theta))
        inner = 1e3 * driven.radius(sweep) * np.exp(1j * (sweep - turned))
        outer = -1e3 * driving.radius(sweep) * np.exp(1j * (sweep + self.mechanism.ratio * theta))
        return inner, outer
