"""Rigid bodies beyond the Painleve limit: a jam stops the driver, which starts again from rest.

Where the force would change to the wall behind the pin and J_- is not positive there, or where
J_- falls to zero while that wall carries the force, no rigid motion exists. The rule is the
behaviour of compliant walls in the limit of great stiffness: the pin wedges, all kinetic energy
is lost at once, and the driver starts from rest with the front wall. While the pin wedges both
bodies are stopped by any force that arises. A barrel then still drives through its train, and the
train of a load drives the follower, so that J_- is that of this direction of the powers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from escapement.base import validate
from escapement.base.text import Shown
from escapement.dynamics.painleve import first_beyond, friction_limits, margin
from escapement.dynamics.state_table import ROWS, LawTable, tabulate
from escapement.dynamics.train_losses import is_lossy, scene_in_flow
from escapement.model.escapement import Escapement
from escapement.numerics.jit import as_python

_MOST = 200
_RTOL = 1e-11
_BEFORE, _ALMOST = 1e-7, 1e-3
"""Shares of the angle up to where J_- vanishes: before it the integration ends; X vanishes there
as well, and a change of its sign in the last share of the angle is rounding."""
_CLOSE, _NEAR, _FAR = 1.2, 0.05, 0.03
"""Below this multiple of the limit the first error is expected, above it the second [-]."""
_WEDGED = 2.0
"""The flow of power, see `dynamics.train_losses`, in which a pin wedges."""
_SAME = 1e-9
"""Cycles whose handoff speeds agree to this share count as one [-]."""


@dataclass(frozen=True, repr=False)
class JamCycle(Shown):
    """The terminal cycle by the rule.

    period [s]; handoff_velocity, velocity_max [rad/s].
    jam_angles : driver angles from dead centre at which it jams [rad].
    error : expected relative error of the period [-].
    message : the reason for this error.
    """

    _units: ClassVar[dict[str, str]] = {
        **{"period": "s", "handoff_velocity": "rad/s", "velocity_max": "rad/s"},
        "jam_angles": "rad",
    }

    period: float
    handoff_velocity: float
    velocity_max: float
    jam_angles: tuple[float, ...]
    error: float
    message: str


class _JamsPassed(NamedTuple):
    """An engagement in natural units."""

    time: float
    speed: float
    top: float
    jams: list[float]


def jam_rule(escapement: Escapement) -> JamCycle:
    """Terminal cycle of rigid bodies beyond the Painleve limit, by the rule for jams.

    It is an approximation: with growing stiffness compliant walls approach it slowly, and just
    above the limit the smallest change decides whether the mechanism jams. Compliant contact
    (`stiffness`, `damping`) gives the motion without this rule.

    Parameters
    ----------
    escapement : Escapement
        A slotted mechanism with perfect parts, without clearance and stiffness, whose friction is
        at or above its limit, `critical_friction`.

    Returns
    -------
    JamCycle
        Its `error` is that of the period: the greatest one found with four slots, compared with
        walls of stiffness 1e7 and 1e8 torque/r^2.

    Raises
    ------
    InvalidValue
        Below the limit, for other mechanisms, with a torque that changes, and if the motion does
        not reach a cycle.
    """
    if escapement.mechanism.pitch is not None:
        rule, named = "one with slots for the rule for jams", escapement.mechanism.kind
        raise validate.fail("mechanism", rule, named, "leave the rule out")
    limit = friction_limits(escapement)[0]
    if escapement.friction < limit:
        rule, remedy = f"at least the limit {limit:.6g}", "below it, use terminal, which is exact"
        raise validate.fail("friction", rule, escapement.friction, remedy)
    wheel: Any = escapement.mechanism
    for name, value in (
        ("clearance", wheel.clearance), ("stiffness", escapement.stiffness),
    ):  # fmt: skip
        if value != 0.0:
            raise validate.fail(name, "0 for the rule for jams", value, "leave it out")
    if len(escapement.scenes) > 1 or escapement.curve is not None:
        remedy = "leave out the errors of parts, the spring rate, or the curve of torque or load"
        rule = "without part errors, and with engagements that are all alike"
        raise validate.fail("escapement", rule, wheel, remedy)
    speed, clock = 0.0, escapement.time_unit
    for _ in range(_MOST):
        passed = _engage(escapement.scene, speed)
        if abs(passed.speed - speed) <= _SAME * passed.speed:
            break
        speed = passed.speed
    else:
        remedy = "use compliant contact"
        raise validate.fail(
            "friction", "one at which engagements repeat", escapement.friction, remedy
        )
    close = escapement.friction < _CLOSE * limit
    error = _NEAR if close else _FAR
    near = "just above" if close else "well above"
    message = (
        f"friction is {near} the limit {limit:.6g}: "
        f"the relative error of the period is about {error:g}"
    )
    top = passed.top / clock
    return JamCycle(
        passed.time * clock, passed.speed / clock, top, tuple(passed.jams), error, message
    )


def _at(scene: Any, theta: float, speed: float, side: float) -> tuple[float, float]:
    """Driver acceleration and X."""
    found = np.empty((ROWS, 1))
    tabulate(scene, np.array([theta]), *np.zeros((2, 1)), np.array([speed * speed]), side, found)
    law = LawTable(*found)
    return float(law.rate[0]), float(law.pressing[0])


def _wedging(scene: Any) -> Any:
    """The scene of a pin that wedges: it jams where `margin`, J_- by its lever, is not positive."""
    return scene_in_flow(scene, _WEDGED) if as_python(is_lossy)(scene) else scene


def _greatest(found: Any, row: int) -> float:
    """Greatest value of a row of a solution whose last event is an extremum of it."""
    peaks = found.y_events[-1].reshape(-1, found.y.shape[0])
    return float(np.append(peaks[:, row], found.y[row]).max())


def _engage(scene: Any, speed: float) -> _JamsPassed:
    """One engagement from a driver speed at pin entry, and the dwell behind it."""
    theta, end = float(scene.edges[0]), float(scene.edges[-1])
    time, top, jams = 0.0, speed, []
    while theta < end:
        theta, speed, spent, most = _push(scene, theta, speed, end)
        time, top = time + spent, max(top, most)
        if theta >= end:
            break
        if margin(theta, _wedging(scene)) > 0.0:
            theta, speed, spent, most, jammed = _hold(scene, theta, speed, end)
            time, top = time + spent, max(top, most)
            if not jammed:
                continue
        jams.append(theta)
        speed = 0.0
    if scene.dwell > 0.0:
        theta, speed, spent, most = _push(scene, end, speed, end + scene.dwell, 0.0)
        time, top = time + spent, max(top, most)
    return _JamsPassed(time, speed, top, jams)


def _push(
    scene: Any, theta: float, speed: float, end: float, side: float = 1.0
) -> tuple[float, float, float, float]:
    """Angle, speed, time and top speed up to a reversal or the end, on the front wall."""
    from scipy.integrate import solve_ivp

    def slope(_t: float, y: Any) -> list[float]:
        return [y[1], _at(scene, y[0], y[1], side)[0]]

    def arrives(_t: float, y: Any) -> float:
        return float(y[0] - end)

    def reverses(_t: float, y: Any) -> float:
        return _at(scene, y[0], y[1], 1.0)[1] if side else 1.0

    def peaks(_t: float, y: Any) -> float:
        return _at(scene, y[0], y[1], side)[0]

    arrives.terminal = reverses.terminal = True  # type: ignore[attr-defined]
    reverses.direction = -1.0  # type: ignore[attr-defined]
    found = solve_ivp(
        slope, (0.0, 1e3), [theta, speed], "DOP853", events=[arrives, reverses, peaks],
        rtol=_RTOL, atol=_RTOL,
    )  # fmt: skip
    if found.status != 1:
        raise validate.fail(
            "escapement", "one that moves", theta, "the drive cannot carry the load"
        )
    last = found.y[:, -1]
    at = end if found.t_events[0].size else float(last[0])
    return at, float(last[1]), float(found.t[-1]), _greatest(found, 1)


def _hold(
    scene: Any, theta: float, speed: float, end: float
) -> tuple[float, float, float, float, bool]:
    """Angle, speed, time and top speed up to the front wall, a jam or the end, on the wall behind
    the pin, and whether it jams.
    """
    from scipy.integrate import solve_ivp

    lost = float(first_beyond(_wedging(scene), theta, end))
    jams = lost == lost
    goal = lost if jams else end

    def slope(x: float, y: Any) -> list[float]:
        now = max(float(y[0]), 1e-12) ** 0.5
        return [2.0 * _at(scene, x, now, -1.0)[0], 1.0 / now]

    def turns(x: float, y: Any) -> float:
        return _at(scene, x, max(float(y[0]), 0.0) ** 0.5, -1.0)[1]

    def peaks(x: float, y: Any) -> float:
        return _at(scene, x, max(float(y[0]), 0.0) ** 0.5, -1.0)[0]

    turns.terminal, turns.direction = True, 1.0  # type: ignore[attr-defined]
    # where J vanishes the acceleration is unbounded, but the speed is finite
    last = goal - _BEFORE * (goal - theta) if jams else goal
    found = solve_ivp(
        slope, (theta, last), [speed**2, 0.0], "Radau", events=[turns, peaks], rtol=1e-9, atol=1e-12
    )
    reached = found.status == 0 or goal - found.t[-1] <= _ALMOST * (goal - theta)
    jammed = reached and jams
    at, top = goal if reached else float(found.t[-1]), _greatest(found, 0)
    now = float(max(found.y[0, -1], 0.0) ** 0.5)
    return at, now, float(found.y[1, -1]), float(max(top, 0.0) ** 0.5), jammed
