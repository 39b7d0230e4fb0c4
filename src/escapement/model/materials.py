"""Elastic constants of materials, and the stresses of a pin that presses on a flat wall."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from escapement.base import validate
from escapement.base.lazy import np
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


def given(value: Any) -> Any:
    """A number, or NaN in its place if it is 0; or an array of these."""
    if isinstance(value, float | int):
        return value or math.nan
    return np.where(value != 0.0, value, math.nan)


def first_given(*values: Any) -> Any:
    """The first that is not 0, NaN if there is none; of arrays element by element."""
    found: Any = math.nan
    for value in reversed(values):
        plain = isinstance(value, float | int) and isinstance(found, float)
        found = value or found if plain else np.where(value != 0.0, value, found)
    return found


def pin_stresses(force: Any, rubbing: Any, numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Stresses of a pin in its slot, by the names of figures of merit [SI].

    Parameters
    ----------
    force : float or ndarray
        Greatest force on it [N].
    rubbing : float or ndarray
        Greatest product of the force and the sliding speed [W].
    numbers : Mapping
        `pin_length` to `wheel_material` as of an `Escapement`, and the radii of its mechanism:
        numbers, or arrays of those of many designs.

    Returns
    -------
    dict
        NaN without a length or a radius of the pin. The pressure that is multiplied by the speed
        is that on the projected area of the pin, 2 r L, as usual for plain bearings; a roller
        does not slide in its slot.
    """
    pin, roller = numbers["pin_radius"], numbers["roller_radius"]
    own, length = numbers["pressure_pin_radius"], given(numbers["pin_length"])
    outer, inner = first_given(own, roller, pin), first_given(pin, own)
    slides = np.where(np.asarray(roller) > 0.0, math.nan, 1.0)[()]
    modulus = contact_modulus(*(material(numbers[f"{x}_material"]) for x in ("pin", "wheel")))
    return {
        "pressure_max": hertz_pressure(force, modulus, length, outer),
        "pin_bending_max": pin_bending(force, length, numbers["pin_gap"], inner),
        "pin_shear_max": pin_shear(force, inner) + 0.0 * length,
        "pressure_speed_max": slides * rubbing / (2.0 * outer * length),
    }


NEEDED = {
    **dict.fromkeys(("pressure_max", "pin_bending_max", "pin_shear_max"), "contact_force_max"),
    "pressure_speed_max": "rubbing_max",
}
"""The figure from which each of these follows."""
