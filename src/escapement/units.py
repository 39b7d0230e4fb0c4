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

_FACTORS = {"torque": INCH_POUND, "inertia": INCH_POUND, "length": INCH, "force": POUND_FORCE}
_FACTORS["power"] = INCH_POUND
_NAMES = {
    "SI": {"torque": "N m", "inertia": "kg m2", "length": "m", "force": "N", "power": "W"},
    "in-lbf-s": {
        "torque": "in lbf",
        "inertia": "in lbf s2",
        "length": "in",
        "force": "lbf",
        "power": "in lbf s-1",
    },
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
        "torque", "power", "inertia", "length", "force", "speed", "acceleration", "time",
        "angle", "degrees" or "ratio".
    system : str
        "SI" or "in-lbf-s".
    """
    if quantity == "degrees":
        return DEGREE
    return _FACTORS.get(quantity, 1.0) if system == "in-lbf-s" else 1.0


def unit_name(quantity: str, system: str) -> str:
    """UDUNITS spelling of the unit of `quantity` in `system`."""
    return _COMMON.get(quantity) or _NAMES[system][quantity]


def printed(quantity: str, system: str) -> str:
    """The unit as help and messages write it: "kg m^2", "in-lbf-s^2", "rad/s"; "" for a ratio."""
    above: list[str] = []
    below: list[str] = []
    for part in unit_name(quantity, system).split():
        symbol, sign, power = re.fullmatch(r"([a-z]+|1)(-?)(\d*)", part, re.IGNORECASE).groups()  # type: ignore[union-attr]
        raised = symbol + (f"^{power}" if power not in ("", "1") else "")
        (below if sign else above).append("" if raised == "1" else raised)
    joint = "-" if system != "SI" else " "
    return "/".join([joint.join(above), *below])


def degrees(angle: float) -> float:
    """An angle in degrees to twelve decimals: sixty should read as sixty."""
    return round(math.degrees(angle), 12)
