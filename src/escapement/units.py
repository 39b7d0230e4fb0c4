"""Exact factors between SI and the inch-pound units of the sources.

The inch (0.0254 m), the pound (0.45359237 kg) and standard gravity
(9.80665 m/s^2) are exact by definition, so every factor below is exact too.
"""

import math
import re

INCH = 0.0254
"""One inch [m]."""
POUND_FORCE = 0.45359237 * 9.80665
"""One pound-force [N]."""
INCH_POUND = INCH * POUND_FORCE
"""One in-lbf [N m]; also one in-lbf-s^2 [kg m^2], the inertia unit of Meyer (1973)."""
DEGREE = math.pi / 180.0
"""One degree [rad]."""

SYSTEMS = ("SI", "in-lbf-s")
"""Unit systems a user may choose: SI, or inch, pound-force and second."""

# kind of unit: its names in the systems, and the SI value of one of the inch-pound system
_UNITS = {
    "torque": ("N m", "in lbf", INCH_POUND),
    "inertia": ("kg m2", "in lbf s2", INCH_POUND),
    "length": ("m", "in", INCH),
    "force": ("N", "lbf", POUND_FORCE),
    "power": ("W", "in lbf s-1", INCH_POUND),
    "drag": ("N m s2", "in lbf s2", INCH_POUND),
    "viscous": ("N m s", "in lbf s", INCH_POUND),
    "rate": ("N m rad-1", "in lbf rad-1", INCH_POUND),
}
_COMMON = {
    "speed": "rad s-1", "acceleration": "rad s-2", "time": "s", "angle": "rad",
    "degrees": "degree", "energy": "J", "ratio": "1",
}  # fmt: skip


def factor(quantity: str, system: str) -> float:
    """SI value of one unit of `quantity` in `system`.

    Parameters
    ----------
    quantity : str
        "torque", "power", "inertia", "length", "force", "drag", "viscous", "speed",
        "acceleration", "time", "angle", "degrees" or "ratio".
    system : str
        "SI" or "in-lbf-s".
    """
    if quantity == "degrees":
        return DEGREE
    return _UNITS[quantity][2] if system != "SI" and quantity in _UNITS else 1.0


def unit_name(quantity: str, system: str) -> str:
    """UDUNITS spelling of the unit of `quantity` in `system`."""
    return _COMMON.get(quantity) or _UNITS[quantity][SYSTEMS.index(system)]  # type: ignore[return-value]


def printed(quantity: str, system: str) -> str:
    """The unit as help and messages write it: "kg m^2", "in-lbf-s^2", "rad/s"; "" for a ratio."""
    # "rad s-2" is to be rad/s^2, and "kg m2" kg m^2
    name = re.sub(r" (\w+)-(\d)", r"/\1\2", unit_name(quantity, system))
    name = re.sub(r"(?<=[a-z])(\d)", r"^\1", name).removesuffix("^1").removeprefix("1")
    return name if system == "SI" else name.replace(" ", "-")


def degrees(angle: float) -> float:
    """An angle in degrees to twelve decimals: sixty should read as sixty."""
    return round(math.degrees(angle), 12)
