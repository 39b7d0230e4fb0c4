"""Elastic constants of materials, and the stresses of a pin that presses on a flat wall."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from escapement.base import validate
from escapement.base.quantity import Setting


class Material(NamedTuple):
    """An elastic material.

    modulus : Young's modulus [Pa].
    poisson : Poisson's ratio [-].
    """

    modulus: float
    poisson: float


MATERIALS = {
    "steel": Material(206e9, 0.30),
    "stainless-steel": Material(190e9, 0.305),
    "cast-iron": Material(100e9, 0.211),
    "brass": Material(106e9, 0.324),
    "bronze": Material(111e9, 0.349),
    "aluminium": Material(71.7e9, 0.333),
    "acetal": Material(3.1e9, 0.35),
}
"""Elastic constants by name: metals as tabulated in Budynas and Nisbett, *Shigley's Mechanical
Engineering Design*, table A-5 (bronze is phosphor bronze; steel with the usual rounded 206 GPa and
0.30), and acetal homopolymer at 23 °C as in DuPont's design guide for Delrin."""


@dataclass(frozen=True, kw_only=True)
class MaterialSetting(Setting):
    """A material: one of `MATERIALS` by name, or its modulus [Pa] and Poisson's ratio."""

    def check(self, label: str, value: Any) -> Any:
        """`value` as a name or a `Material`."""
        if isinstance(value, str):
            return validate.choice(label, value, tuple(MATERIALS))
        rule = "a name, or a modulus in Pa above 0 and a Poisson's ratio from 0 to 0.5"
        try:
            modulus, poisson = (float(number) for number in value)
        except (TypeError, ValueError):
            raise validate.fail(label, rule, value, self.remedy) from None
        if not (0.0 < modulus < math.inf and 0.0 <= poisson <= 0.5):
            raise validate.fail(label, rule, value, self.remedy)
        return Material(modulus, poisson)

    def parse(self, label: str, text: str) -> Any:
        """As `check`, of a name or of two numbers with a comma between them."""
        return self.check(label, text.split(",") if "," in text else text)


def material(value: str | Material) -> Material:
    """The material that a checked setting names."""
    return MATERIALS[value] if isinstance(value, str) else value


def contact_modulus(one: Material, other: Material) -> float:
    """E* of two materials in contact, 1/E* = sum of (1 - nu^2)/E [Pa]."""
    return 1.0 / sum((1.0 - body.poisson**2) / body.modulus for body in (one, other))


def hertz_pressure(force: float, modulus: float, length: float, radius: float) -> float:
    """Greatest pressure of a cylinder on a flat wall [Pa].

    Parameters
    ----------
    force : float
        On the length of contact [N].
    modulus : float
        E* of both materials, see `contact_modulus` [Pa].
    length, radius : float
        Length of the contact and radius of the cylinder [m].

    Source: Hertz's line contact, p_max = sqrt(N E*/(pi L r)); Johnson, *Contact Mechanics*,
    eq. 4.45 with N/L for his P.
    """
    root: float = (force * modulus / (math.pi * length * radius)) ** 0.5
    return root


def radius_for(force: float, modulus: float, length: float, pressure: float) -> float:
    """Radius of a cylinder whose greatest pressure on a flat wall is `pressure` [m]."""
    return force * modulus / (math.pi * length * pressure**2)


def pin_bending(force: float, length: float, gap: float, radius: float) -> float:
    """Bending stress of a round cantilever, with the force at the middle of `length` behind a gap.

    32 N (e + L/2)/(pi d^3) [Pa].
    """
    return 32.0 * force * (gap + 0.5 * length) / (math.pi * (2.0 * radius) ** 3)


def pin_shear(force: float, radius: float) -> float:
    """Mean shear stress of a round pin, 4 N/(pi d^2) [Pa]."""
    return force / (math.pi * radius**2)
