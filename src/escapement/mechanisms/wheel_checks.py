"""Lengths and errors of parts that a mechanism may have, and whether they fit it."""

from collections.abc import Mapping
from typing import Any

from escapement.base import validate

LENGTHS = ("crank_radius", "pin_radius", "roller_radius", "clearance")
"""Lengths that a slotted mechanism may have [m]; the first is the unit of its path."""

_ERRORS = ("centre_distance_error", "crank_radius_errors", "slot_offsets")
"""Lengths of imperfect parts."""

IMPERFECT = (*_ERRORS, "pin_angle_errors", "slot_angle_errors")
"""All errors of imperfect parts."""


_RADII = (*LENGTHS[1:], *_ERRORS, "stiffness", "driver_bearing_radius", "follower_bearing_radius")
_CHECKED = ("driver_bearing_friction", *_RADII)

MEASURED = frozenset((*_CHECKED, *IMPERFECT))
"""All errors, and the numbers that `check_lengths` looks at."""


def check_lengths(values: Mapping[str, Any], length: float | None, plain_crank: bool) -> None:
    """Refuse radii for a mechanism without a length, and a journal that it cannot have.

    Parameters
    ----------
    values : Mapping
        What is given of the radii and of the friction of bearings, by name [SI].
    length : float or None
        Unit of the mechanism's path [m].
    plain_crank : bool
        Whether the driver's bearing carries the force of the contact and no other.
    """
    for name in _CHECKED:
        value = values.get(name)
        if not value:
            continue
        if name.startswith("driver") and not plain_crank:
            rule = "0 for a gear-driven wheel, whose driver's bearing also carries the mesh"
            raise validate.fail(name, rule, value, "give driver_bearing_torque instead")
        if name in _RADII and not length:
            rule = "left out for a mechanism without a length"
            remedy = "give the mechanism its crank_radius or fixed_radius"
            raise validate.fail(name, rule, value, remedy)
