"""Filemon's question the other way round: how far a drive may go without a reversal.

The pin stays on its side of the slot as long as F = I_f omega^2/M_load does not
exceed F12 of the mechanism.
"""

import math
from bisect import bisect_left

from escapement import validate
from escapement.constant_speed import geneva
from escapement.constant_speed.case import Case, checked_number
from escapement.constant_speed.extrema import transmission_extrema
from escapement.errors import InvalidValue
from escapement.mechanisms.geneva import MOST_SLOTS
from escapement.model import Escapement, Mechanism
from escapement.quantity import check_number

LIMITS = {
    "greatest_speed": "speed",
    "greatest_follower_inertia": "inertia",
    "least_load_torque": "torque",
}
"""How far a drive may go without a pin reversal: kind of unit of each figure."""


def greatest_speed(mechanism: Mechanism, load_torque: float, follower_inertia: float) -> float:
    """Greatest driver speed without a pin reversal, sqrt(F12 M_load/I_f) [rad/s].

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    load_torque : float
        Constant torque opposing the follower [N m], >= 0.
    follower_inertia : float
        Follower and everything that turns with it [kg m^2], > 0.
    """
    load, inertia = _constant(load_torque), checked_number("follower_inertia", follower_inertia)
    return math.sqrt(_greatest_inertia_torque(mechanism, load) / inertia)


def greatest_follower_inertia(mechanism: Mechanism, speed: float, load_torque: float) -> float:
    """Greatest follower inertia without a pin reversal, F12 M_load/omega^2 [kg m^2].

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    speed : float
        Driver speed [rad/s], > 0.
    load_torque : float
        Constant torque opposing the follower [N m], >= 0.
    """
    omega, load = checked_number("speed", speed), _constant(load_torque)
    result: float = _greatest_inertia_torque(mechanism, load) / omega / omega
    return result


def least_load_torque(mechanism: Mechanism, speed: float, follower_inertia: float) -> float:
    """Least constant load without a pin reversal, I_f omega^2/F12 [N m].

    A brake on the follower that adds up to it keeps the pin from knocking.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    speed : float
        Driver speed [rad/s], > 0.
    follower_inertia : float
        Follower and everything that turns with it [kg m^2], > 0.
    """
    omega = checked_number("speed", speed)
    inertia = checked_number("follower_inertia", follower_inertia)
    result: float = inertia * omega * omega / _limit(mechanism)
    return result


def limits_without_reversal(case: Case) -> dict[str, float]:
    """`LIMITS` of a drive under a constant load, one of its numbers changed at a time, in SI."""
    mechanism, load = case.mechanism, case.load_torque
    assert not callable(load)
    limits = (
        greatest_speed(mechanism, load, case.follower_inertia),
        greatest_follower_inertia(mechanism, case.speed, load),
        least_load_torque(mechanism, case.speed, case.follower_inertia),
    )
    return dict(zip(LIMITS, limits, strict=True))


def fewest_slots(inertia_ratio: float, internal: bool = False) -> int:
    """Least number of slots of a Geneva wheel without a pin reversal at F.

    Parameters
    ----------
    inertia_ratio : float
        F = I_f omega^2/M_load [-], >= 0.
    internal : bool
        Whether the wheel is an internal one.

    Raises
    ------
    InvalidValue
        When F is below 0, or too great even for a million slots, the most that a
        `Geneva` has.
    """
    remedy = "give F = I_f omega^2/M_load"
    ratio = validate.non_negative("inertia_ratio", inertia_ratio, remedy)

    fewest = 3 + bisect_left(
        range(3, MOST_SLOTS + 1), ratio, key=lambda n: float(geneva.reversal_limits(n, internal)[0])
    )
    if fewest > MOST_SLOTS:
        raise InvalidValue(
            f"inertia_ratio must be below the limit of any wheel, of {MOST_SLOTS:,} slots at "
            f"most, got {ratio!r}; lower the speed or the inertia, or brake the follower"
        )
    return fewest


def _constant(load_torque: float) -> float:
    result: float = check_number(Escapement, "load_torque", load_torque)
    return result


def _greatest_inertia_torque(mechanism: Mechanism, load: float) -> float:
    """I_f omega^2 without a pin reversal [N m]; no load is needed where none threatens."""
    limit = _limit(mechanism)
    return limit if math.isinf(limit) else limit * load


def _limit(mechanism: Mechanism) -> float:
    return transmission_extrema(mechanism).reversal_limits[0]
