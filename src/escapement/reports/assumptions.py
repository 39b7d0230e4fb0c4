"""What the model of a design leaves out, and roughly what that would change."""

from collections.abc import Iterable

from escapement.mechanisms.wheel_checks import IMPERFECT
from escapement.model.escapement import Escapement

ALWAYS = (
    ("friction that depends on speed, load or time", "each coefficient is the same at all speeds"),
    ("side loads on bearings, such as weight", "they add to the constant torque of the bearing"),
    ("friction of the locking disc", "in a dwell the driver turns without touching the follower"),
    ("bending of shafts and discs", "parts are rigid, except for compliant walls of slots"),
)
"""Effects that no design includes, and the assumption instead."""


def left_out(escapement: Escapement, varied: Iterable[str] = ()) -> list[tuple[str, str]]:
    """Effects without numbers in this design, and the change that they usually cause.

    Numbers that are `varied` about the design are among those that it has.

    The sizes are those of docs/effects.md and docs/tolerances.md, for Geneva wheels at
    frictions from 0.20 to 0.35.
    """
    real, wheel = escapement, escapement.mechanism
    given = real.settings | wheel.lengths | dict.fromkeys(varied, True)

    def lacks(*names: str) -> bool:
        return not any(given[name] for name in names)

    found = []
    if lacks("pin_radius"):
        text = "a pin of a twentieth of the crank radius makes the period 3 to 4 % shorter"
        found.append(("width of the pins", text))
    if lacks("clearance") and not real.contact:
        text = "each thousandth of the crank radius makes the period 0.3 to 0.7 % longer"
        found.append(("clearance between pin and slot", text))
    if lacks("driver_bearing_radius", "follower_bearing_radius", "driver_bearing_torque"):
        text = "a journal of a twentieth of the crank radius adds 0.3 to 2 % to the period"
        found.append(("friction of the bearings", text))
    if lacks("driver_drag", "follower_drag"):
        found.append(("air", "it changes the period of plain wheels by at most 0.2 %"))
    if lacks("driver_viscous", "follower_viscous"):
        text = "oil in journals adds less than 0.1 %, a film between faces 1 to 9 %"
        found.append(("oil", text))
    if wheel.perfect and not any(name.startswith(IMPERFECT) for name in given):
        text = (
            "a centre distance a thousandth too short makes the period 1 % longer, one too long "
            "makes it 0.3 % shorter"
        )
        found.append(("errors of the parts", text))
    if real.curve is None and lacks("spring_rate"):
        text = "a torque that falls by 1 % makes the period 0.5 % longer"
        found.append(("a spring that runs down", text))
    return found
