"""Bodies of the drives with gears: a Geneva wheel that gears drive, and elliptical gears."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from escapement.mechanisms import EllipticalPlanetary, GearDriven
from escapement.mechanisms.elliptical_teeth import PitchEllipse
from escapement.mechanisms.protocol import FloatArray
from escapement.outlines.bodies import Body, Disc, arc, pins_and_rollers, slotted_edge
from escapement.outlines.curves import ComplexArray, Curve, biarcs, chain

_TURN = 2.0 * np.pi
_NEAR = 2  # teeth on both sides of the line of centres that bodies have
_FINE = 2e-4  # distance of arcs from the ellipse that they stand for [mm]


class GearDrivenOutline:
    """Proportions and bodies of a gear-driven wheel.

    All lengths are in radii of the fixed gear. The common axis is the origin, and slot 0 lies
    along the positive real axis when carrier and wheel are at zero. As in the ordinary wheel,
    widths are chosen so that nothing collides.

    Parameters
    ----------
    mechanism : GearDriven
        What to draw.
    clearance : float
        Slot width minus pin diameter [m], if the pins have a radius.

    Attributes
    ----------
    planet_radius : float
        Pitch radius of the planet.
    mouth, slot_end : float
        Distance of a pin from the axis where it enters, and at dead centre.
    inward : bool
        Whether the slots open at the rim of a disc, else inside a ring.
    pin_radius, half_slot : float
        As in a `GenevaOutline`. A radius that was not given is small compared with the path, and
        so small that slots do not meet.
    rim_radius, reach : float
        Outer radius of the wheel, and radius of the whole drawing.
    plane : tuple
        The follower, and the bodies that move in its plane.
    """

    plane = "follower", ("pin", "roller")
    meshing = False

    def __init__(self, mechanism: GearDriven, clearance: float = 0.0) -> None:
        self.mechanism = mechanism
        self.planet_radius = abs(1.0 / float(mechanism.gear_ratio))
        self.mouth = mechanism.entry_radius_over_fixed
        self.slot_end = abs(mechanism.arms.first + mechanism.arms.second)
        self.inward = self.slot_end < self.mouth
        narrow = min(self.mouth or self.slot_end, self.slot_end)
        chosen = min(0.05, 0.35 * narrow * math.pi / max(mechanism.slots, 3))
        self.pin_radius = mechanism.contact_radius or chosen
        gap = clearance / mechanism.crank_radius if mechanism.crank_radius else 0.0
        given = mechanism.contact_radius
        self.half_slot = given + 0.5 * gap if given else 1.1 * chosen
        ring = self.slot_end + 4.0 * self.half_slot
        self.rim_radius = math.hypot(self.mouth, self.half_slot) if self.inward else ring
        self.reach = max(self.rim_radius, mechanism.reach_over_fixed + self.pin_radius)

    def bodies(self, theta: float) -> tuple[Body, Disc, Disc, *tuple[Disc, ...]]:
        """All bodies in their positions at a carrier angle: wheel, pitch circles and pins.

        "follower", "fixed-gear", "planet", "pin-k" with k counted from 0, and "roller-k" where
        pins have rollers.
        """
        carrier = complex(self.mechanism.arms.first * np.exp(1j * theta))
        centres = [complex(self.pin_at(theta, k)) for k in range(self.mechanism.pins)]
        return (
            Body("follower", tuple(self.wheel_edges())).rotated(self.wheel_at(theta)),
            Disc("fixed-gear", 0.0, 1.0),
            Disc("planet", carrier, self.planet_radius),
            *pins_and_rollers(self.mechanism, centres, self.pin_radius),
        )

    def reliefs(self, theta: float) -> list[Body]:
        """Every "relief" at a carrier angle: the space for unused lobes in the locked wheel."""
        mechanism, turn = self.mechanism, self.wheel_at(theta)
        along = self.pin_at(np.linspace(-0.6, 0.6, 61) * mechanism.alpha, 0)
        outside = np.gradient(along)
        outside *= 1j * self.half_slot / np.abs(outside)
        deeper = outside[30].real < 0.0  # the middle point is dead centre, on the real axis
        lobe = along + (outside if deeper == self.inward else -outside)
        beyond = self.mouth * (1.1 if self.inward else 0.9)
        back = arc(beyond, float(np.angle(lobe[-1])), float(np.angle(lobe[0])), 31)
        band = chain(points := np.concatenate([lobe, back]), np.zeros(points.size))
        # the wheel is locked half a step beyond dead centre while a lobe passes
        locked = 0.5 * mechanism.follower_step * (1.0 if mechanism.turns_with_driver else -1.0)
        lobe_turn = _TURN / (mechanism.pins * abs(float(mechanism.gear_ratio)))
        passing = lobe_turn * np.arange(1, mechanism.unused_lobes + 1) - locked
        slots = _TURN * np.arange(mechanism.slots) / mechanism.slots
        angles = np.add.outer(passing, slots).ravel()
        return [Body("relief", (band,)).rotated(turn + angle) for angle in angles]

    def wheel_edges(self) -> list[Curve]:
        """Edges of the wheel at zero: its body with the slots cut out."""
        slots, half = self.mechanism.slots, self.half_slot
        if self.mouth == 0.0:
            # the slots run right across the wheel, through its centre, where their walls meet
            arms = slots if slots % 2 == 0 else 2 * slots
            rim, ends = half / math.sin(math.pi / arms), -_TURN * np.arange(arms) / arms
            inner = slotted_edge(rim, self.slot_end, half, None, ends) if arms > 2 else None
            cap = complex(self.slot_end, half)
            slot = chain([-cap.conjugate(), cap, cap.conjugate(), -cap], [0, -math.pi] * 2)
            return [inner or slot, Curve.circle(self.rim_radius)]
        edge = math.hypot(self.mouth, half)
        body = slotted_edge(edge, self.slot_end, half, ([], []), -_TURN * np.arange(slots) / slots)
        return [body] if self.inward else [body, Curve.circle(self.rim_radius)]

    def path(self) -> ComplexArray:
        """The pin path until it closes."""
        ratio = self.mechanism.gear_ratio
        points = 181 * max(abs(ratio.numerator), ratio.denominator)
        return self.pin_at(np.linspace(0.0, _TURN * ratio.denominator, points), 0)

    def pin_at(self, theta: FloatArray | float, number: int) -> ComplexArray:
        """Position of a pin of the planet at carrier angles."""
        first, _, second, rate = self.mechanism.arms
        phase = _TURN * number / self.mechanism.pins * np.sign(1.0 - rate)
        turn = 1j * np.asarray(theta, dtype=float)
        return np.asarray(first * np.exp(turn) + second * np.exp(rate * turn + 1j * phase))

    def wheel_at(self, theta: float) -> float:
        """Angle of the wheel at a carrier angle [rad]: locked between engagements."""
        angle = float(self.mechanism.follower_angle(theta))
        return angle if self.mechanism.turns_with_driver else -angle


@dataclass(frozen=True)
class EllipticalOutline:
    """Gears of the planetary drive [mm]; the carrier's axis is the origin.

    Parameters
    ----------
    mechanism : EllipticalPlanetary
        The drive.
    cut : tuple of Curve, optional
        Edges of the driven and the driving gear with their teeth [m], as `meshed.toothed_gears`
        gives them. The bodies then are what lies near the line of centres. Default: pitch curves.
    teeth : int
        Teeth of each.
    """

    mechanism: EllipticalPlanetary
    cut: tuple[Curve, Curve] | None = None
    teeth: int = 0
    plane = "driven", ("driving",)

    @property
    def meshing(self) -> bool:
        """Whether the gears have their teeth."""
        return self.cut is not None

    def bodies(self, theta: float, carrier: float | None = None) -> tuple[Disc, Disc, Body, Body]:
        """The two spur gears and the two ellipses.

        Parameters
        ----------
        theta : float
            Driver angle from greatest output speed [rad].
        carrier : float, optional
            Direction of the carrier in the drawing [rad]. Default: `theta`, its true one.

        Returns
        -------
        tuple
            "sun" and "planet", then "driven" and "driving", whose edges start and have their
            middle at the ends of the long axis.
        """
        along = theta if carrier is None else carrier
        shaft = complex(self.line_of_centres(theta)[1] * np.exp(1j * along))
        driving, driven = self.mechanism.pitch_ellipses
        # the ellipses about their own pivots while the carrier lies along the real axis
        angle = theta + float(self.mechanism.follower_angle(theta))
        outer_angle = self.mechanism.ratio * theta
        inner = self._edge(0, driven, angle).moved(np.exp(-1j * angle))
        outer = self._edge(1, driving, -outer_angle).moved(-np.exp(1j * outer_angle))
        return (
            Disc("sun", 0.0, 1e3 * self.mechanism.sun_radius),
            Disc("planet", shaft, 1e3 * self.mechanism.planet_radius),
            Body("driven", (inner,)).rotated(along),
            Body("driving", (outer,)).rotated(along, shaft),
        )

    def _edge(self, number: int, pitch: PitchEllipse, angle: float) -> Curve:
        """A gear about its pivot: its pitch curve, or the teeth near an angle from its vertex."""
        if self.cut is None:
            return pitch_curve(1e3 * pitch.semi_major_axis, pitch.eccentricity)
        edge = self.cut[number].moved(1e3)
        whole = edge.corners.size
        each = whole // self.teeth
        tooth = math.floor(float(pitch.arc(angle) / pitch.arc(_TURN)) * self.teeth)
        rows = np.arange((tooth - _NEAR) * each, (tooth + _NEAR + 1) * each) % whole
        # a line closes what is cut out of the gear
        corners = np.append(edge.corners[rows], edge.ends[rows[-1]])
        return Curve(corners, np.append(edge.bulges[rows], 0.0))

    def line_of_centres(self, theta: float) -> tuple[float, float, float]:
        """Points B, C and D on the carrier, by their distances from its axis A [mm].

        The spur gears touch at B, C is the planet's axis, and the ellipses touch at D.
        """
        sun, planet = 1e3 * self.mechanism.sun_radius, 1e3 * self.mechanism.planet_radius
        angle = self.mechanism.ratio * theta
        rho = 1e3 * float(self.mechanism.pitch_ellipses[0].radius(angle))
        return sun, sun + planet, sun + planet - rho


@lru_cache(maxsize=32)
def pitch_curve(semi_major_axis: float, eccentricity: float) -> Curve:
    """An ellipse about a focus as arcs that deviate from it by less than 0.2 um.

    Parameters
    ----------
    semi_major_axis : float
        a [mm].
    eccentricity : float
        As in `PitchEllipse`: if it is > 0, the far vertex is on the positive real axis.
    """
    a, count = semi_major_axis, 8
    focus = 2.0 * eccentricity * a
    while True:
        turn = np.exp(2j * np.pi * np.arange(count) / count)
        minor = a * math.sqrt(1.0 - eccentricity**2)
        along = -a * turn.imag + 1j * minor * turn.real
        points = 0.5 * focus + a * turn.real + 1j * minor * turn.imag
        curve = biarcs(points, along / np.abs(along))
        found = curve.at(np.linspace(0.0, 1.0, 9))
        # the distances from the focuses add up to 2a; a first-order step leads back to the
        # ellipse
        one, two = np.abs(found), np.abs(found - focus)
        slope = np.abs(found / one + (found - focus) / two)
        if np.abs((one + two - 2.0 * a) / slope).max() < _FINE:
            return curve
        count *= 2
