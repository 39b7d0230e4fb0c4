"""The gears of a gear-driven wheel: whole numbers of teeth, sizes, and the planet's inertia."""

from dataclasses import dataclass

from escapement import validate
from escapement.errors import InvalidValue
from escapement.mechanisms import GearDriven
from escapement.mechanisms.gear_equation import COGNATES

STANDARD_MODULES = (
    *(0.1, 0.12, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0),
    *(4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 32.0, 40.0, 50.0),
)
"""Modules of ISO 54, first series, and of fine-pitch gears [mm]."""
LEAST_TEETH = 17
"""A full-depth 20 degree pinion with fewer teeth is undercut."""
LEAST_DIFFERENCE = 10
"""Teeth of an internal gear above its pinion's, or the tips foul (full depth, 20 degrees)."""


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
        _checked(self.mechanism)
        for name in ("fixed_teeth", "planet_teeth"):
            remedy = "a full-depth 20 degree gear with fewer is undercut"
            validate.integer(name, getattr(self, name), LEAST_TEETH, remedy)
        validate.positive("module", self.module, "give the module in m")
        ratio = abs(self.mechanism.gear_ratio)
        if self.fixed_teeth != ratio * self.planet_teeth:
            pair = f"{self.fixed_teeth}/{self.planet_teeth}"
            rule = f"in the ratio |k| = {ratio} exactly"
            raise validate.fail("teeth", rule, pair, "or the pin would miss its slots in time")
        # beside an internal gear the tips of the pinion need room, whatever its own teeth
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


def _checked(mechanism: GearDriven) -> GearDriven:
    """`mechanism`, or the error that it is not gear-driven."""
    if not isinstance(mechanism, GearDriven):
        remedy = "give for example GearDriven(12, 3)"
        raise validate.fail("mechanism", "gear-driven", mechanism, remedy)
    return mechanism


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
    limit = validate.positive("largest_radius", largest_radius, "give the radius in m")
    most = validate.integer("most_teeth", most_teeth, LEAST_TEETH, "give the most teeth")
    ratio, found = abs(_checked(mechanism).gear_ratio), []
    # teeth that have the exact ratio are multiples of the reduced fraction
    for times in range(1, most // max(ratio.numerator, ratio.denominator) + 1):
        teeth = times * ratio.numerator, times * ratio.denominator
        largest = 2.0 * limit / (mechanism.reach_over_fixed * teeth[0])
        modules = [m * 1e-3 for m in STANDARD_MODULES if m * 1e-3 <= largest * (1.0 + 1e-12)]
        if not modules:  # then none fits with more teeth either
            break
        try:
            found.append(GearPair(mechanism, *teeth, module=modules[-1]))
        except InvalidValue:
            continue
    return sorted(found, key=lambda pair: (-pair.module, -pair.fixed_teeth))


def planet_inertia(
    mechanism: GearDriven,
    fixed_radius: float,
    planet_mass: float = 0.0,
    planet_inertia: float = 0.0,
    pin_mass: float = 0.0,
    planets: int = 1,
) -> float:
    """What planets and pins add to the driver's moment of inertia [kg m^2].

    The planet's centre turns with the carrier and the planet itself at 1 - k times
    the carrier's speed, a constant factor, so that its kinetic energy is that of a
    constant inertia. So is that of two or more equally spaced pins.

    Parameters
    ----------
    mechanism : GearDriven
        With its number of pins on each planet.
    fixed_radius : float
        R0 [m], > 0.
    planet_mass : float
        Mass of a planet without its pins [kg].
    planet_inertia : float
        Its moment of inertia about its own axis [kg m^2].
    pin_mass : float
        Mass of one pin [kg].
    planets : int
        Planets alike.

    Notes
    -----
    A single pin on a planet adds 2 m R0^2 M0M MC (1 - k) cos(k theta) to the constant
    part given here; that is neglected. A counterweight opposite the pin removes it.
    The carrier's own inertia, losses of the mesh and gravity are not in it.
    """
    radius = validate.positive("fixed_radius", fixed_radius, "give the radius R0 in m")
    mass = validate.non_negative("planet_mass", planet_mass, "give the mass in kg")
    own = validate.non_negative("planet_inertia", planet_inertia, "give the inertia in kg m^2")
    pin = validate.non_negative("pin_mass", pin_mass, "give the mass in kg")
    count = validate.integer("planets", planets, 1, "give the number of planets")
    # with equally spaced pins the cross terms of both vectors cancel
    first, _, second, rate = _checked(mechanism).arms
    pins = mechanism.pins * pin * (first**2 + (rate * second) ** 2)
    return count * (radius * radius * (mass * first**2 + pins) + own * rate**2)
