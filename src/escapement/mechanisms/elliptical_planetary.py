"""The planetary drive with elliptical gears: intermittent motion, always in mesh.

A carrier rolls a spur planet (radius R2) round a fixed sun (R1). On the planet's
shaft sits an ellipse, pivoted at a focus; it drives an equal ellipse, pivoted at a
focus on the carrier's axis, with the output. Where the radii of the ellipses have the ratio R2 to
R1 the output stands still (Prikhodko 2020). With k = R1/R2 and h = k theta/2, half the turn of
the planet on its carrier,

    follower angle   phi = 2 atan(k tan h) - theta
    transmission     g   = (k^2 - 1) cos^2 h / (cos^2 h + k^2 sin^2 h)

which are the integral of the paper's eq. 9 and eq. 9 itself with e = (k-1)/(k+1) and the opposite
sign: the output turns against the carrier, phi_3 = -phi.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self

from escapement.base import validate
from escapement.base.lazy import Lazy
from escapement.base.quantity import Quantity, quantity
from escapement.mechanisms.kind import CELL, ArrayLike, Kind, np, slotted, table
from escapement.mechanisms.path import Path
from escapement.mechanisms.protocol import FloatArray

if TYPE_CHECKING:
    from escapement.mechanisms import elliptical_teeth as teeth
else:
    teeth = Lazy("escapement.mechanisms.elliptical_teeth")

TOLERANCES = (0.01, 0.1, 1.0)
"""Deviations of the output within which the report counts it as standing still [degrees]."""

_LENGTHS = ("centre_distance", "semi_major_axis", "semi_minor_axis", "focal_distance")
_GREATEST_RATIO = 1e4  # greatest ratio of the radii; above it no gear could have the peak of g
_MOST_STATIONS = 1000
_SHRINKING = 20  # halvings of the pieces towards a stop: to a millionth of a cell
_OUTSIDE = 8.0  # last digits of an angle


@dataclass(frozen=True, repr=False)
class EllipticalPlanetary(Kind):
    """Planetary drive with a pair of elliptical gears.

    Parameters
    ----------
    sun_radius : float
        Pitch radius R1 of the fixed sun gear [m].
    planet_radius : float
        Pitch radius R2 of the spur planet [m], 0 < R2 < R1. The ellipses follow:
        semi-major axis (R1 + R2)/2, focal distance (R1 - R2)/2.

    Raises
    ------
    InvalidValue
        When a radius breaks its rule, or R1/R2 exceeds 10,000.

    Notes
    -----
    Driver angles are counted from greatest output speed, the paper's phi_1. A cell
    runs from one stop to the next. Only R1/R2 matters for the motion.

    Source: Prikhodko (2020), eqs. 1 to 9.
    """

    kind = "elliptical-planetary"
    summary = "planetary drive with a pair of elliptical gears, always in mesh"
    meshed = True
    report_units: ClassVar[dict[str, str]] = dict.fromkeys(_LENGTHS, "length")
    reported = ("stations", *CELL)

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
            rule = f"greater than the planet_radius, {planet!r}"
            remedy = "R1 = a + c and R2 = a - c, so the sun is the greater"
            raise validate.fail("sun_radius", rule, sun, remedy)
        if sun > _GREATEST_RATIO * planet:
            name, rule = "sun_radius / planet_radius", f"at most {_GREATEST_RATIO:g}"
            raise validate.fail(name, rule, sun / planet, "give a greater planet")

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
        e = between_0_and(1.0, "eccentricity", eccentricity, "a circle never stops the output")
        return cls(a * (1.0 + e), a * (1.0 - e))

    @classmethod
    def from_stop_interval(cls, stop_interval: float, centre_distance: float) -> Self:
        """The drive that stops its output once in an angle of the input.

        Parameters
        ----------
        stop_interval : float
            Input angle from one stop to the next, 2 pi R2/R1 [rad]; less than a turn.
        centre_distance : float
            Distance of the carrier's axis from the planet's shaft, R1 + R2 [m].
        """
        remedy = "give the input angle between stops in rad, less than 2 pi"
        interval = between_0_and(2.0 * math.pi, "stop_interval", stop_interval, remedy)
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
            Module of both gears [m], > 0.
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
        """Contribution of planet, satellite shaft and driving ellipse to the driver's inertia.

        Their kinetic energy is that of a driver inertia mean - swing cos(k theta):
        the planet turns 1 + k times as fast as the carrier, and a centre of mass off the shaft
        moves alternately faster and slower than the shaft.

        Parameters
        ----------
        mass : float
            Mass of everything that turns with the satellite shaft [kg], >= 0.
        moment : float
            Its moment of inertia about that shaft [kg m^2], >= 0.
        offset : float
            Distance of its centre of mass from the shaft, towards the ellipse's
            centre [m]; the focal distance for the bare ellipse, 0 with a
            counterweight.

        Returns
        -------
        mean, swing : float
            [kg m^2]. `Inertia.driver` takes the mean. The equation of motion has a constant
            inertia, so the swing must be small compared with the driver's inertia.
        """
        weight = validate.non_negative("mass", mass, "give the planet's mass in kg")
        about = validate.non_negative("moment", moment, "give it about the satellite shaft")
        away = validate.number("offset", offset, "give the distance from the shaft in m")
        if weight * away * away > about * (1.0 + 1e-12):
            rule = f"at least mass offset^2 = {weight * away * away:g}"
            remedy = "give it about the satellite shaft, not about the centre of mass"
            raise validate.fail("moment", rule, about, remedy)
        faster, arm = 1.0 + self.ratio, self.centre_distance
        return weight * arm * arm + about * faster * faster, 2.0 * weight * arm * away * faster

    @property
    def pitch_ellipses(self) -> tuple[teeth.PitchEllipse, teeth.PitchEllipse]:
        """Pitch curves of the driving (on the planet's shaft) and the driven ellipse.

        At driver angle theta the driving one has turned k theta on the carrier, the
        driven one theta + phi: the angles at which both touch.
        """
        a, e = self.semi_major_axis, self.eccentricity
        return teeth.PitchEllipse(a, e), teeth.PitchEllipse(a, -e)

    @property
    def cell_angle(self) -> float:
        """Driver angle from stop to stop, 2 pi R2/R1 [rad]."""
        return 2.0 * math.pi / self.ratio

    @property
    def follower_step(self) -> float:
        """Output angle from stop to stop, 2 pi (1 - R2/R1), against the input [rad]."""
        return 2.0 * math.pi * self.focal_distance * 2.0 / self.sun_radius

    @property
    def stations(self) -> int | None:
        """Directions in which the output stops; None where they never repeat.

        The denominator of R2/R1 in lowest terms; more than 1000 count as never.
        """
        share = 1.0 / self.ratio
        whole = Fraction(share).limit_denominator(_MOST_STATIONS)
        return whole.denominator if whole < 1 and abs(share - whole) < 1e-12 else None

    @property
    def breaks(self) -> tuple[float, float]:
        """The stops at both ends of the cell [rad]."""
        half = math.pi / self.ratio
        return -half, half

    @property
    def ratio_max(self) -> float:
        """Greatest transmission, k^2 - 1, half-way between stops [-]."""
        # subtracting 1 from the rounded ratio would lose digits if the two radii are nearly equal
        return (self.sun_radius - self.planet_radius) / self.planet_radius * (self.ratio + 1.0)

    @property
    def acceleration_max(self) -> tuple[float, float]:
        """Greatest g' [-] and the driver angle that has it [rad]; the least mirrors it.

        There 2 e cos^2 p + (1 + e^2) cos p = 4 e, p the planet's turn.
        """
        e = self.eccentricity
        total = 1.0 + e * e
        cosine = 8.0 * e / (total + math.sqrt(total * total + 32.0 * e * e))
        angle = -math.acos(cosine) / self.ratio
        return float(self.transmission(angle).dg), angle

    @cached_property
    def path(self) -> Path:
        """A table of the transmission, as kernels evaluate it.

        In the outer halves of the cell angles are counted from the stops while the table is made,
        and its pieces shrink towards them, so that g and g' keep their relative accuracy where
        both vanish. The stops lie a few roundings outside the cell, so that the last digit of an
        angle does not decide the sign of a force that vanishes there.
        """
        entry, exit_ = self.breaks
        away = 0.5 * exit_ * np.append(0.0, np.exp2(np.arange(-_SHRINKING, 1)))
        outside = _OUTSIDE * math.ulp(exit_)
        parts = (
            (entry, table.resolved(lambda x: self._from_stop(x + outside), away)),
            (0.0, table.resolved(lambda x: self.transmission(x).g, away[[-1, -1]] * [-1.0, 1.0])),
            (exit_, table.resolved(lambda x: self._from_stop(x - outside), -away[::-1])),
        )
        starts = [zero + series.edges[:-1] for zero, series in parts]
        rows = [series.rows for _zero, series in parts]
        return table.table_path(np.concatenate([*starts, [exit_]]), np.concatenate(rows))

    def _from_stop(self, angle: FloatArray) -> FloatArray:
        """Transmission at driver angles from a stop."""
        sine, cosine = self._half_turn(angle)
        return self.ratio_max * sine * sine / (sine * sine + (self.ratio * cosine) ** 2)

    def transmission(self, theta: ArrayLike) -> slotted.Transmission:
        """Transmission at driver angles of any size [rad]; u is 0, nothing slides."""
        sine, cosine = self._half_turn(theta)
        length = cosine * cosine + (self.ratio * sine) ** 2
        g = self.ratio_max * cosine * cosine / length
        dg = -(self.ratio**3) * self.ratio_max * sine * cosine / (length * length)
        return slotted.Transmission(g, np.zeros_like(g), dg)

    def jerk(self, theta: ArrayLike) -> FloatArray:
        """g'' at driver angles of any size [rad]."""
        sine, cosine = self._half_turn(theta)
        k, gain = self.ratio, self.ratio_max
        length = cosine * cosine + (k * sine) ** 2
        bent = (cosine - sine) * (cosine + sine) * length - 4.0 * gain * (sine * cosine) ** 2
        return -0.5 * k**4 * gain * bent / length**3

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Output angle at driver angles of any size [rad], zero at theta = 0.

        It is counted against the direction of the input: the paper's phi_3 is its negative.
        """
        angles = np.asarray(theta, dtype=float)
        return np.asarray(teeth.stretched(self.ratio * angles, self.ratio) - angles)

    def dwell_below(self, ratio: float) -> float:
        """Driver angle about a stop within which g is at most `ratio` [rad].

        Parameters
        ----------
        ratio : float
            Tolerated output speed over input speed [-], >= 0.
        """
        limit = validate.non_negative("ratio", ratio, "give output over input speed, 0.01 say")
        left = self.ratio_max - limit
        if left <= 0.0:
            return self.cell_angle
        # g is the limit where cot^2 h = k^2 limit/(k^2 - 1 - limit)
        return 4.0 * math.atan(self.ratio * math.sqrt(limit / left)) / self.ratio

    def dwell_within(self, angle: float) -> float:
        """Driver angle about a stop in which the output stays within +-angle [rad].

        Parameters
        ----------
        angle : float
            Tolerated deviation of the output from where it stops [rad], > 0; from half
            a step on the angle reaches beyond the cell.
        """
        limit = validate.positive("angle", angle, "give the tolerated deviation in rad")
        # every cell turns the output by a step, and its second half mirrors the first
        rest = math.remainder(limit, self.follower_step)
        cells = round((limit - rest) / self.follower_step)
        return 2.0 * (cells * self.cell_angle + math.copysign(self._angle_turning(abs(rest)), rest))

    def _angle_turning(self, limit: float) -> float:
        """Driver angle from a stop in which the output turns by up to half a step [rad]."""
        from scipy.integrate import quad
        from scipy.optimize import brentq

        def left(angle: float) -> float:
            # the integral keeps its digits where the position function is small
            output = quad(self._from_stop, 0.0, angle, epsabs=0.0, epsrel=1e-13)[0]
            return float(output - limit)

        # near a stop the output turns by the cube of the planet's rotation, further on by at
        # least 0.6 of that: the root lies below 1.2 times that of the cube
        cube = math.cbrt(12.0 * self.ratio**3 * limit / self.ratio_max)
        high = min(1.3 * cube, math.pi) / self.ratio
        if left(high) <= 0.0:
            return high
        return float(brentq(left, 0.05 * high, high, xtol=1e-300))

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI."""
        dwells = [(deg, self.dwell_within(math.radians(deg))) for deg in TOLERANCES]
        record, cell = super().report(), self.cell_angle
        return record | {
            "stop_interval_deg": record["cell_angle_deg"],
            "output_per_stop_deg": -record["follower_step_deg"],
            "eccentricity": self.eccentricity,
            "transmission_max": self.ratio_max,
            "acceleration_function_max": self.acceleration_max[0],
            **{name: getattr(self, name) for name in _LENGTHS},
            "fewest_teeth": teeth.fewest_teeth(self),
            "dwell_within": [
                {"tolerance_deg": deg, "dwell_deg": math.degrees(x), "share": min(x / cell, 1.0)}
                for deg, x in dwells
            ],
        }

    def _half_turn(self, theta: ArrayLike) -> tuple[FloatArray, FloatArray]:
        half = 0.5 * self.ratio * np.asarray(theta, dtype=float)
        return np.sin(half), np.cos(half)


def between_0_and(limit: float, name: str, value: float, remedy: str) -> float:
    """`value` as a finite number above 0 and below the limit."""
    rule = Quantity(long_name=name, exclusive=True, maximum=limit, below=True, remedy=remedy)
    return float(rule.check(name, value))
