"""The planetary drive with elliptical gears: intermittent motion, always in mesh.

A carrier rolls a spur planet (radius R2) round a fixed sun (R1). On the planet's
shaft sits an ellipse, pivoted at a focus; it drives an equal ellipse, pivoted at a
focus on the carrier's axis, with the output. Where the radii of the ellipses are
as R2 to R1 the output stands still (Prikhodko 2020). With k = R1/R2 and
h = k theta/2, half the turn of the planet on its carrier,

    follower angle   phi = 2 atan(k tan h) - theta
    transmission     g   = (k^2 - 1) cos^2 h / (cos^2 h + k^2 sin^2 h)

which are the integral of the paper's eq. 9 and eq. 9 itself with e = (k-1)/(k+1),
the sense reversed: the output turns against the carrier, phi_3 = -phi.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from escapement import validate
from escapement.lazy import Lazy
from escapement.mechanisms._elliptical_gears import EllipticalGears

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike

    from escapement.mechanisms import slotted
    from escapement.model import FloatArray
    from escapement.scene import Path
else:
    np, slotted = Lazy("numpy"), Lazy("escapement.mechanisms.slotted")

TOLERANCES = (0.01, 0.1, 1.0)
"""Deviations of the output that the report takes for standing still [degrees]."""

_LENGTHS = ("centre_distance", "semi_major_axis", "semi_minor_axis", "focal_distance")
_MOST_STATIONS = 1000
_SHRINKING = 20  # halvings of the pieces towards a stop: to a millionth of a cell
_OUTSIDE = 8.0  # last digits of an angle


@dataclass(frozen=True)
class EllipticalPlanetary(EllipticalGears):
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
    def motion_ratio(self) -> float:
        """Moving share of the cell, 1: the output stands still for an instant only."""
        return 1.0

    @property
    def breaks(self) -> tuple[float, float]:
        """The stops at both ends of the cell [rad]."""
        half = math.pi / self.ratio
        return -half, half

    @property
    def ratio_max(self) -> float:
        """Greatest transmission, k^2 - 1, half-way between stops [-]."""
        # 1 taken from the rounded ratio would leave few digits of two radii nearly alike
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

        In the outer halves of the cell angles are counted from the stops while it is
        made, and its pieces shrink towards them: so g and g' keep their relative
        accuracy where both vanish. The stops lie a few roundings outside of the cell,
        lest the sign of a force that vanishes there be decided by an angle's last digit.
        """
        from escapement.mechanisms.table import chebyshev_table, read_table, table_path

        entry, exit_ = self.breaks
        away = 0.5 * exit_ * np.append(0.0, np.exp2(np.arange(-_SHRINKING, 1)))
        outside = _OUTSIDE * math.ulp(exit_)
        parts = (
            (entry, lambda x: self._from_stop(x + outside), away),
            (0.0, lambda x: self.transmission(x).g, np.array([-away[-1], away[-1]])),
            (exit_, lambda x: self._from_stop(x - outside), -away[::-1]),
        )
        tables = [
            read_table(chebyshev_table(function, edges.tolist())) for _, function, edges in parts
        ]
        starts = [zero + edges[:-1] for (zero, _, _), (edges, _) in zip(parts, tables, strict=True)]
        series = np.concatenate([series for _, series in tables])
        return table_path(np.concatenate([*starts, [exit_]]), series)

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

        Counted against the input's sense: the paper's phi_3 is its negative.
        """
        angles = np.asarray(theta, dtype=float)
        half = 0.5 * self.ratio * angles
        turns = np.rint(half / math.pi)
        near = half - math.pi * turns
        within = np.arctan2(self.ratio * np.sin(near), np.cos(near))
        result: FloatArray = 2.0 * (within + math.pi * turns) - angles
        return result

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
        # every cell turns the output by a step, its second half as the first turned back
        cells, rest = divmod(limit, self.follower_step)
        if rest > 0.5 * self.follower_step:
            cells, rest = cells + 1.0, rest - self.follower_step
        return 2.0 * (cells * self.cell_angle + math.copysign(self._way(abs(rest)), rest))

    def _way(self, limit: float) -> float:
        """Driver angle from a stop in which the output turns by up to half a step [rad]."""
        from scipy.optimize import brentq

        # about a stop the output turns by the cube of the planet's turn, further on by no less
        # than 0.6 of that: the root lies below 1.2 of the cube's
        cube = math.cbrt(12.0 * self.ratio**3 * limit / self.ratio_max)
        high = min(1.3 * cube, math.pi)
        if limit <= 0.0 or self._turned(high) <= limit:
            return high / self.ratio
        found = brentq(lambda turn: self._turned(turn) - limit, 0.05 * high, high, xtol=1e-300)
        return float(found) / self.ratio

    def _turned(self, turn: float) -> float:
        """Output angle from a stop while the planet turns by up to pi [rad].

        2 atan(a/k) - turn/k with a = tan(turn/2), of which little is left where a is small
        or k next to 1.
        """
        k, a = self.ratio, math.tan(0.5 * turn)
        share = (self.sun_radius - self.planet_radius) / self.sun_radius
        if a > 0.3:
            return turn * share - 2.0 * math.atan(share * a / (1.0 + a * a / k))
        powers = np.arange(1, 19)
        left = -np.expm1(-2.0 * powers * math.log1p(k * share))
        terms = -((-a * a) ** powers) / (2 * powers + 1) * left
        return 2.0 * a / k * float(terms.sum())

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI."""
        from escapement.mechanisms.elliptical_teeth import fewest_teeth

        turned = self.cell_report()
        rests = [(deg, self.dwell_within(math.radians(deg))) for deg in TOLERANCES]
        return {
            "stations": self.stations,
            **turned,
            "stop_interval_deg": turned["cell_angle_deg"],
            "output_per_stop_deg": -turned["follower_step_deg"],
            "eccentricity": self.eccentricity,
            "transmission_max": self.ratio_max,
            "acceleration_function_max": self.acceleration_max[0],
            **{name: getattr(self, name) for name in _LENGTHS},
            "fewest_teeth": fewest_teeth(self),
            "dwell_within": [
                {
                    "tolerance_deg": deg,
                    "dwell_deg": math.degrees(dwell),
                    "share": min(dwell / self.cell_angle, 1.0),
                }
                for deg, dwell in rests
            ],
        }

    def _half_turn(self, theta: ArrayLike) -> tuple[FloatArray, FloatArray]:
        half = 0.5 * self.ratio * np.asarray(theta, dtype=float)
        return np.sin(half), np.cos(half)
