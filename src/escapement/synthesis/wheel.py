"""A wheel: the motion of its follower at constant driver speed, and its gears.

On a path of two vectors (g, u) runs along a circle through (g1, 0) and (g2, 0), and
with s the sum of the two rates g' = u (s - 2 g), so that over an engagement

    g'^2 = (g1 - g)(g - g2)(s - 2 g)^2
    g''  = (s - 2 g) [(s - 2 g)(g1 + g2 - 2 g)/2 - 2 (g1 - g)(g - g2)]

are polynomials in g, which runs from 0 to its value at dead centre: every peak is at
an end or at a root of a polynomial. Gears have whole numbers of teeth, in the ratio exactly.
"""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.mechanisms import GearDriven, Geneva
from escapement.mechanisms.gear_equation import COGNATES
from escapement.mechanisms.kind import Wheel
from escapement.mechanisms.path import RATE_SUM
from escapement.mechanisms.protocol import FloatArray, checked
from escapement.mechanisms.slotted import circle

STANDARD_MODULES = (
    *(0.1, 0.12, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0),
    *(4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 32.0, 40.0, 50.0),
)
"""Modules of ISO 54, first series, and of fine-pitch gears [mm]."""
LEAST_TEETH = 17
"""A full-depth 20 degree pinion with fewer teeth is undercut."""
LEAST_DIFFERENCE = 10
"""Fewest teeth of an internal gear above its pinion's: tips clear (full depth, 20 degrees)."""
_SLOTTED = Wheel, "a slotted wheel", "give a Geneva or a GearDriven"
_GEARED = GearDriven, "gear-driven", "give for example GearDriven(12, 3)"
_POWERS = dict(velocity_max=1, acceleration_start=2, acceleration_max=2, jerk_start=3, jerk_max=3)


@dataclass(frozen=True)
class FollowerMotion:
    """Motion of the follower: arrays of one shape.

    time : in cycles, from the entry of a pin.
    angle : in steps, 0 at that entry.
    velocity, acceleration, jerk : in steps per cycle, its square and its cube. The
        impulses of jerk where the wheel starts and stops are not in it.
    """

    time: FloatArray
    angle: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    jerk: FloatArray


def follower_motion(mechanism: GearDriven | Geneva, time: ArrayLike) -> FollowerMotion:
    """Follower angle, velocity, acceleration and jerk at constant driver speed.

    Parameters
    ----------
    mechanism : GearDriven or Geneva
        The mechanism. In a dwell the follower rests.
    time : array_like
        In cycles from the entry of a pin, of any sign and size.

    Raises
    ------
    InvalidValue
        For another mechanism, or a time that is not finite.

    Notes
    -----
    A wheel in uniform motion has neither acceleration nor jerk.
    """
    _check(mechanism, *_SLOTTED)
    at = validate.numbers("time", time, "give times in cycles")
    cell, half = mechanism.cell_angle, mechanism.breaks[-1]
    step, whole = mechanism.follower_step, np.floor(at)
    # a cell begins when a pin enters, half an engagement before dead centre
    theta = (at - whole) * cell - half
    moving = theta <= half
    theta = np.minimum(theta, half)
    found = mechanism.transmission(theta)
    # at a speed of one cell a cycle each derivative by the angle brings one more cell
    rates = (found.g, found.dg, mechanism.jerk(theta))
    angle = whole + 0.5 + mechanism.follower_angle(theta) / step
    scaled = (np.where(moving, x, 0.0) * cell ** (i + 1) / step for i, x in enumerate(rates))
    return FollowerMotion(at, angle, *scaled)


@dataclass(frozen=True)
class MotionPeaks:
    """Peaks of the follower's motion at constant driver speed.

    In steps per motion time, its square and its cube, as `motion_peaks` gives them;
    `per_cycle` changes to the time of a whole cycle.

    motion_ratio : moving share of the cycle [-].
    velocity_max : greatest velocity.
    acceleration_start : acceleration with which the motion begins. It jumps to this value: the
        jerk at the start and at the end is an impulse of this size.
    acceleration_max : greatest acceleration.
    jerk_start : jerk right after the start. jerk_max : greatest size of the jerk.
    """

    motion_ratio: float
    velocity_max: float
    acceleration_start: float
    acceleration_max: float
    jerk_start: float
    jerk_max: float

    def per_cycle(self) -> "MotionPeaks":
        """The same in steps per cycle time, its square and its cube."""
        shares = {name: self.motion_ratio**power for name, power in _POWERS.items()}
        return replace(self, **{name: getattr(self, name) / shares[name] for name in shares})


def motion_peaks(mechanism: GearDriven | Geneva) -> MotionPeaks:
    """Peaks of velocity, acceleration and jerk of one engagement.

    Raises
    ------
    InvalidValue
        For a mechanism without a slotted wheel, or a path through its centre.
    """
    _check(mechanism, *_SLOTTED)
    path, g = mechanism.path, Polynomial([0.0, 1.0])
    first, second = circle(path)  # u vanishes at these g, the first of which is dead centre
    slope, product = path.numbers[RATE_SUM] - 2.0 * g, (first - g) * (g - second)
    squared = product * slope**2
    jerk = slope * (slope * (first + second - 2.0 * g) / 2.0 - 2.0 * product)
    angle, step = mechanism.engagement_angle, mechanism.follower_step
    speed, rate, change = (angle**power / step for power in (1, 2, 3))
    return MotionPeaks(
        motion_ratio=mechanism.motion_ratio,
        velocity_max=first * speed,
        acceleration_start=float(np.sqrt(squared(0.0))) * rate,
        acceleration_max=float(np.sqrt(_largest(squared, first))) * rate,
        jerk_start=float(jerk(0.0)) * change,
        jerk_max=_largest(jerk, first) * change,
    )


def _check(mechanism: object, kind: type, rule: str, remedy: str) -> None:
    if not isinstance(mechanism, kind):
        raise validate.fail("mechanism", rule, mechanism, remedy)
    checked(mechanism)


def _largest(function: Polynomial, end: float) -> float:
    """Greatest size of a polynomial between 0 and `end`."""
    # rounding may give a real root a small imaginary part
    roots = function.deriv().roots()
    inside = roots[(np.abs(roots.imag) < 1e-9 * end) & (roots.real > 0.0) & (roots.real < end)]
    return float(np.abs(function(np.array([0.0, end, *inside.real]))).max())


@dataclass(frozen=True)
class GearPair:
    """Fixed gear and planet of a mechanism, with teeth.

    Parameters
    ----------
    mechanism : GearDriven
        What the gears drive.
    fixed_teeth, planet_teeth : int
        Teeth; their ratio must be |k| exactly, so that the path closes.
    module : float
        Module of the teeth [m], > 0.

    Raises
    ------
    InvalidValue
        When the teeth do not have the ratio, or would not mesh.
    """

    mechanism: GearDriven
    fixed_teeth: int
    planet_teeth: int
    module: float

    def __post_init__(self) -> None:
        _check(self.mechanism, *_GEARED)
        for name in ("fixed_teeth", "planet_teeth"):
            remedy = "a full-depth 20 degree gear with fewer is undercut"
            validate.integer(name, getattr(self, name), LEAST_TEETH, remedy)
        validate.positive("module", self.module, "give the module in m")
        ratio = abs(self.mechanism.gear_ratio)
        if self.fixed_teeth != ratio * self.planet_teeth:
            pair = f"{self.fixed_teeth}/{self.planet_teeth}"
            rule = f"in the ratio |k| = {ratio} exactly"
            raise validate.fail("teeth", rule, pair, "or the pin would miss its slots in time")
        # in an internal gear the tips of the pinion need space, independent of its own teeth
        difference = abs(self.fixed_teeth - self.planet_teeth)
        if self.internal and difference < LEAST_DIFFERENCE:
            raise InvalidValue(
                f"teeth of an internal pair must differ by at least {LEAST_DIFFERENCE} to mesh, "
                f"got {self.fixed_teeth} and {self.planet_teeth}; give more teeth, or use the "
                f"{COGNATES[self.mechanism.curve]}"
            )

    @property
    def internal(self) -> bool:
        """Whether one gear runs inside the other: all but the epicycloid."""
        return self.mechanism.gear_ratio > 0

    @property
    def fixed_radius(self) -> float:
        """Pitch radius R0 of the fixed gear [m]."""
        return 0.5 * self.module * self.fixed_teeth

    @property
    def planet_radius(self) -> float:
        """Pitch radius R of the planet [m]."""
        return 0.5 * self.module * self.planet_teeth

    @property
    def carrier_length(self) -> float:
        """Distance of the gears' axes [m]."""
        return self.mechanism.carrier_over_fixed * self.fixed_radius

    @property
    def arm_length(self) -> float:
        """Distance of the pins from the planet's axis [m]."""
        return self.mechanism.arm_over_fixed * self.fixed_radius

    @property
    def reach(self) -> float:
        """Radius that holds both gears and the pin path [m]."""
        return self.mechanism.reach_over_fixed * self.fixed_radius


def gear_pairs(
    mechanism: GearDriven, largest_radius: float, most_teeth: int = 250
) -> list[GearPair]:
    """Gear pairs of standard module that fit a space, strongest teeth first.

    Parameters
    ----------
    mechanism : GearDriven
        What the gears drive.
    largest_radius : float
        Radius of the space around the common axis [m], for gears and pin path.
    most_teeth : int
        Most teeth of either gear.

    Returns
    -------
    list of GearPair
        For each number of teeth the largest standard module; empty where no pair
        of at least `LEAST_TEETH` fits.
    """
    _check(mechanism, *_GEARED)
    limit = validate.positive("largest_radius", largest_radius, "give the radius in m")
    most = validate.integer("most_teeth", most_teeth, LEAST_TEETH, "give the most teeth")
    ratio, found = abs(mechanism.gear_ratio), []
    # teeth that have the exact ratio are multiples of the reduced fraction
    for times in range(1, most // max(ratio.numerator, ratio.denominator) + 1):
        teeth = times * ratio.numerator, times * ratio.denominator
        largest = 2.0 * limit / (mechanism.reach_over_fixed * teeth[0])
        modules = [m * 1e-3 for m in STANDARD_MODULES if m * 1e-3 <= largest * (1.0 + 1e-12)]
        if not modules:  # then none fits with more teeth either
            break
        with suppress(InvalidValue):  # too few teeth, or their tips would foul
            found.append(GearPair(mechanism, *teeth, module=modules[-1]))
    return sorted(found, key=lambda pair: (-pair.module, -pair.fixed_teeth))


def planet_inertia(
    mechanism: GearDriven,
    fixed_radius: float,
    planet_mass: float = 0.0,
    planet_inertia: float = 0.0,
    pin_mass: float = 0.0,
    planets: int = 1,
) -> float:
    """Contribution of planets and pins to the driver's moment of inertia [kg m^2].

    The planet's centre turns with the carrier and the planet itself at 1 - k times
    the carrier's speed, a constant factor, so that its kinetic energy is that of a
    constant inertia. So is that of two or more equally spaced pins.

    Parameters
    ----------
    mechanism : GearDriven
        The wheel, with the number of pins on each planet.
    fixed_radius : float
        R0 [m], > 0.
    planet_mass : float
        Mass of a planet without its pins [kg].
    planet_inertia : float
        Its moment of inertia about its own axis [kg m^2].
    pin_mass : float
        Mass of one pin [kg].
    planets : int
        Number of equal planets.

    Notes
    -----
    A single pin on a planet adds 2 m R0^2 M0M MC (1 - k) cos(k theta) to the constant
    part given here; that is neglected. A counterweight opposite the pin removes it.
    The carrier's own inertia, losses of the mesh and gravity are not in it.
    """
    _check(mechanism, *_GEARED)
    radius = validate.positive("fixed_radius", fixed_radius, "give the radius R0 in m")
    mass = validate.non_negative("planet_mass", planet_mass, "give the mass in kg")
    own_inertia = validate.non_negative(
        "planet_inertia", planet_inertia, "give the inertia in kg m²"
    )
    pin = validate.non_negative("pin_mass", pin_mass, "give the mass in kg")
    count = validate.integer("planets", planets, 1, "give the number of planets")
    # with equally spaced pins the cross terms of both vectors cancel
    first, _, second, rate = mechanism.arms
    pins = mechanism.pins * pin * (first**2 + (rate * second) ** 2)
    return count * (radius * radius * (mass * first**2 + pins) + own_inertia * rate**2)
