"""Bodies of a gear-driven Geneva wheel in radii of the fixed gear.

As for the ordinary wheel, widths are chosen here so that nothing collides.
"""

import math
from dataclasses import dataclass

import numpy as np

from escapement.mechanisms import GearDriven
from escapement.model import FloatArray
from escapement.outlines import Body, ComplexArray, Disc, circle_edge, locked_angle, slotted_edge


@dataclass(frozen=True)
class GearDrivenOutline:
    """Proportions and bodies of a gear-driven wheel.

    All lengths are in radii of the fixed gear. The common axis is the origin, and slot 0
    lies along the positive real axis when carrier and wheel are at zero.
    """

    mechanism: GearDriven

    @property
    def planet_radius(self) -> float:
        """Pitch radius of the planet."""
        return abs(1.0 / float(self.mechanism.gear_ratio))

    @property
    def mouth(self) -> float:
        """Distance of a pin from the axis where it enters."""
        return self.mechanism.entry_radius_over_fixed

    @property
    def slot_end(self) -> float:
        """Distance of a pin from the axis at dead centre."""
        return abs(self.mechanism.arms.first + self.mechanism.arms.second)

    @property
    def inward(self) -> bool:
        """Whether the slots open at the rim of a disc, else inside a ring."""
        return self.slot_end < self.mouth

    @property
    def pin_radius(self) -> float:
        """Pin radius: small beside the path, and slots must not meet."""
        narrow = min(self.mouth, self.slot_end) if self.mouth > 0.0 else self.slot_end
        between = narrow * math.pi / max(self.mechanism.slots, 3)
        return min(0.05, 0.35 * between)

    @property
    def half_slot(self) -> float:
        """Half the slot width: the pin with a little play."""
        return 1.1 * self.pin_radius

    @property
    def rim_radius(self) -> float:
        """Outer radius of the wheel."""
        if self.inward:
            return math.hypot(self.mouth, self.half_slot)
        return self.slot_end + 4.0 * self.half_slot

    @property
    def reach(self) -> float:
        """Radius of the whole drawing."""
        return max(self.rim_radius, self.mechanism.reach_over_fixed + self.pin_radius)

    def bodies(self, theta: float) -> tuple[Body, Disc, Disc, *tuple[Disc, ...]]:
        """Everything where it stands at a carrier angle: wheel, pitch circles and pins.

        "follower", "fixed-gear", "planet", and "pin-k" with k counted from 0.
        """
        carrier = complex(self.mechanism.arms.first * np.exp(1j * theta))
        pins = tuple(
            Disc(f"pin-{k}", complex(self.pin_at(theta, k)), self.pin_radius)
            for k in range(self.mechanism.pins)
        )
        return (
            Body("follower", tuple(self.wheel_edges())).turned(self.wheel_at(theta)),
            Disc("fixed-gear", 0.0, 1.0),
            Disc("planet", carrier, self.planet_radius),
            *pins,
        )

    def reliefs(self, theta: float) -> list[Body]:
        """Every "relief" at a carrier angle: where unused lobes pass through the wheel."""
        turn = self.wheel_at(theta)
        return [Body("relief", (edge,)).turned(turn) for edge in self.relief_edges()]

    def wheel_edges(self) -> list[ComplexArray]:
        """Closed edges of the wheel at zero: its body with the slots cut out."""
        slots, half = self.mechanism.slots, self.half_slot
        if self.mouth == 0.0:
            # the slots run right across the wheel, through its centre
            cap = self.slot_end + half * np.exp(1j * np.linspace(-0.5, 0.5, 19) * np.pi)
            slot = np.concatenate([cap, -cap, cap[:1]])
            turns = np.exp(2j * np.pi * np.arange(max(1, slots // 2)) / slots)
            return [circle_edge(self.rim_radius), *(slot * turn for turn in turns)]
        edge = self.rim_radius if self.inward else math.sqrt(self.mouth**2 - half**2)
        aside = math.asin(half / edge)
        arc = np.linspace(aside, 2.0 * np.pi / slots - aside, 31)[1:-1]
        body = slotted_edge(edge, self.slot_end, half, 19, edge * np.exp(1j * arc), slots)
        return [body] if self.inward else [body, circle_edge(self.rim_radius)]

    def relief_edges(self) -> list[ComplexArray]:
        """Closed edges of the room that unused lobes need in the locked wheel, at zero."""
        mechanism = self.mechanism
        theta = np.linspace(-0.6, 0.6, 61) * mechanism.alpha
        along = self.pin_at(theta, 0)
        outside = np.gradient(along)
        outside *= 1j * self.half_slot / np.abs(outside)
        deeper = outside[30].real < 0.0  # the middle point is dead centre, on the real axis
        lobe = along + (outside if deeper == self.inward else -outside)
        back = np.linspace(np.angle(lobe[-1]), np.angle(lobe[0]), 31)
        beyond = self.mouth * (1.1 if self.inward else 0.9)
        band = np.concatenate([lobe, beyond * np.exp(1j * back), lobe[:1]])
        sense = 1.0 if mechanism.turns_with_driver else -1.0
        lobe_turn = 2.0 * np.pi / (mechanism.pins * abs(float(mechanism.gear_ratio)))
        places = [
            # the wheel is locked half a step beyond dead centre while this lobe passes
            lobe * lobe_turn
            - 0.5 * sense * mechanism.follower_step
            + 2.0 * np.pi * slot / mechanism.slots
            for lobe in range(1, mechanism.unused_lobes + 1)
            for slot in range(mechanism.slots)
        ]
        return [band * np.exp(1j * place) for place in places]

    def path(self) -> ComplexArray:
        """The pin path until it closes."""
        ratio = self.mechanism.gear_ratio
        turns = ratio.denominator
        lobes = abs(ratio.numerator)
        points = 181 * max(lobes, turns)
        return self.pin_at(np.linspace(0.0, 2.0 * np.pi * turns, points), 0)

    def pin_at(self, theta: FloatArray | float, number: int) -> ComplexArray:
        """Where a pin of the planet stands at carrier angles."""
        first, _, second, rate = self.mechanism.arms
        phase = 2.0 * np.pi * number / self.mechanism.pins * np.sign(1.0 - rate)
        angles = np.asarray(theta, dtype=float)
        arm = second * np.exp(1j * (rate * angles + phase))
        place: ComplexArray = first * np.exp(1j * angles) + arm
        return place

    def wheel_at(self, theta: float) -> float:
        """Angle of the wheel at a carrier angle [rad]: locked between engagements."""
        turned = locked_angle(self.mechanism, theta)
        return turned if self.mechanism.turns_with_driver else -turned
