"""The gears of a planetary drive with elliptical gears: their sizes, shapes and inertia."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

from escapement import validate
from escapement.mechanisms.kind import Kind
from escapement.quantity import quantity

if TYPE_CHECKING:
    from escapement.mechanisms._pitch_ellipses import PitchEllipse

_GREATEST_RATIO = 1e4  # of the radii: beyond it g has a peak that nobody could make


@dataclass(frozen=True)
class EllipticalGears(Kind):
    """Such a drive but for its motion; fields and errors as `EllipticalPlanetary`."""

    sun_radius: float = field(metadata=quantity(
        "pitch radius of the fixed sun gear", "length", exclusive=True,
        note=", a + c of the ellipses", remedy="give the radius R1"
    ))  # fmt: skip
    planet_radius: float = field(metadata=quantity(
        "pitch radius of the spur planet", "length", exclusive=True, note=", a - c of the ellipses",
        remedy="give the radius R2, less than the sun's"
    ))  # fmt: skip

    def __post_init__(self) -> None:
        self.check_fields()
        sun, planet = self.sun_radius, self.planet_radius
        if not sun > planet:
            raise validate.fail(
                "sun_radius", f"greater than the planet_radius, {planet!r}", sun,
                "R1 = a + c and R2 = a - c, so the sun is the greater",
            )  # fmt: skip
        if sun > _GREATEST_RATIO * planet:
            raise validate.fail(
                "sun_radius / planet_radius", f"at most {_GREATEST_RATIO:g}", sun / planet,
                "give a greater planet",
            )  # fmt: skip
        if not math.isfinite(sun + planet):
            raise validate.fail(
                "sun_radius + planet_radius", "within the range of a double", sun + planet,
                "give smaller radii",
            )  # fmt: skip

    @classmethod
    def from_ellipse(cls, semi_major_axis: float, eccentricity: float) -> Self:
        """The drive of a pair of ellipses, R1 = a (1 + e) and R2 = a (1 - e).

        Parameters
        ----------
        semi_major_axis : float
            a [m], > 0: half the centre distance.
        eccentricity : float
            e [-], between 0 and 1.
        """
        a = validate.positive("semi_major_axis", semi_major_axis, "give half the centre distance")
        e = validate.positive("eccentricity", eccentricity, "a circle never stops the output")
        if not e < 1.0:
            raise validate.fail("eccentricity", "below 1", e, "a closed ellipse has e < 1")
        return cls(a * (1.0 + e), a * (1.0 - e))

    @classmethod
    def from_stop_interval(cls, stop_interval: float, centre_distance: float) -> Self:
        """The drive that stops its output once in an angle of the input.

        Parameters
        ----------
        stop_interval : float
            Input angle from one stop to the next, 2 pi R2/R1 [rad]; less than a turn.
        centre_distance : float
            Of carrier axis and planet shaft, R1 + R2 [m].
        """
        remedy = "give the input angle between stops in rad, less than 2 pi"
        interval = validate.positive("stop_interval", stop_interval, remedy)
        if not interval < 2.0 * math.pi:
            raise validate.fail("stop_interval", "below 2 pi", interval, remedy)
        distance = validate.positive("centre_distance", centre_distance, "give R1 + R2 in m")
        planet = distance * interval / (2.0 * math.pi + interval)
        return cls(distance - planet, planet)

    @classmethod
    def from_teeth(cls, sun_teeth: int, planet_teeth: int, module: float) -> Self:
        """The drive of a pair of spur gears, R = module teeth/2.

        Parameters
        ----------
        sun_teeth, planet_teeth : int
            Teeth of the sun and, fewer, of the planet.
        module : float
            Of both [m], > 0.
        """
        sun = validate.integer("sun_teeth", sun_teeth, 1, "give the teeth of the sun")
        planet = validate.integer("planet_teeth", planet_teeth, 1, "give those of the planet")
        size = validate.positive("module", module, "give the spur gears' module in m")
        return cls(0.5 * size * sun, 0.5 * size * planet)

    @property
    def ratio(self) -> float:
        """k = R1/R2, turns of the planet on its carrier per turn of the input [-]."""
        return self.sun_radius / self.planet_radius

    @property
    def centre_distance(self) -> float:
        """Carrier axis to planet shaft, R1 + R2 = 2a [m]."""
        return self.sun_radius + self.planet_radius

    @property
    def semi_major_axis(self) -> float:
        """a = (R1 + R2)/2 of the ellipses [m]."""
        return 0.5 * self.centre_distance

    @property
    def focal_distance(self) -> float:
        """c = (R1 - R2)/2, centre to focus of the ellipses [m]."""
        return 0.5 * (self.sun_radius - self.planet_radius)

    @property
    def semi_minor_axis(self) -> float:
        """b = sqrt(R1 R2) of the ellipses [m]."""
        return math.sqrt(self.sun_radius) * math.sqrt(self.planet_radius)

    @property
    def eccentricity(self) -> float:
        """e = c/a of the ellipses [-]."""
        return self.focal_distance / self.semi_major_axis

    def planet_inertia(
        self, mass: float, moment: float, offset: float = 0.0
    ) -> tuple[float, float]:
        """What planet, satellite shaft and driving ellipse add to the driver's inertia.

        Their kinetic energy is that of a driver inertia mean - swing cos(k theta):
        the planet turns 1 + k times as fast as the carrier, and a centre of mass
        beside the shaft is now before, now behind the carrier's motion.

        Parameters
        ----------
        mass : float
            Of all that turns with the satellite shaft [kg], >= 0.
        moment : float
            Its moment of inertia about that shaft [kg m^2], >= 0.
        offset : float
            Distance of its centre of mass from the shaft, towards the ellipse's
            centre [m]; the focal distance for the bare ellipse, 0 with a
            counterweight.

        Returns
        -------
        mean, swing : float
            [kg m^2]. `Inertia.driver` takes the mean. It is constant: a swing
            that is not small against it is beyond the equation of motion.
        """
        weight = validate.non_negative("mass", mass, "give the planet's mass in kg")
        about = validate.non_negative("moment", moment, "give it about the satellite shaft")
        away = validate.number("offset", offset, "give the distance from the shaft in m")
        if weight * away * away > about * (1.0 + 1e-12):
            raise validate.fail(
                "moment", f"at least mass offset^2 = {weight * away * away:g}", about,
                "give it about the satellite shaft, not about the centre of mass",
            )  # fmt: skip
        faster = 1.0 + self.ratio
        arm = self.centre_distance
        return weight * arm * arm + about * faster * faster, 2.0 * weight * arm * away * faster

    @property
    def pitch_ellipses(self) -> tuple[PitchEllipse, PitchEllipse]:
        """Pitch curves of the driving (on the planet's shaft) and the driven ellipse.

        At driver angle theta the driving one has turned k theta on the carrier, the
        driven one theta + phi: the angles at which both touch.
        """
        from escapement.mechanisms._pitch_ellipses import PitchEllipse

        a, e = self.semi_major_axis, self.eccentricity
        return PitchEllipse(a, e, far=True), PitchEllipse(a, e, far=False)
