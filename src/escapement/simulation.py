"""The two functions a user calls: a motion, and the terminal cycle's figures."""

import math
from dataclasses import replace
from typing import Any

from escapement import _validate
from escapement.dynamics import critical_friction
from escapement.errors import InvalidValue
from escapement.metrics import Figures, read_cycle, read_transient
from escapement.model import Escapement
from escapement.motion import Motion
from escapement.status import MESSAGES, Status

ENGINES = ("ivp",)
METHODS = ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA")
DEFAULT_ENGINE = "ivp"
DEFAULT_RTOL = {"ivp": 1e-10}
DEFAULT_ENGAGEMENTS = 20
IVP_TRANSIENT = 3000  # engagements of a transient the reference engine will integrate


def simulate(
    escapement: Escapement,
    engagements: int | None = None,
    *,
    duration: float | None = None,
    engine: str = DEFAULT_ENGINE,
    initial_speed: float = 0.0,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    max_step: float | None = None,
) -> Motion:
    """Simulate an escapement from pin entry.

    Parameters
    ----------
    escapement : Escapement
        What to simulate.
    engagements : int, optional
        Engagements to run, >= 1. Default 20, unless a duration is given.
    duration : float, optional
        Time to run instead [s], > 0.
    engine : str
        "ivp": SciPy's solve_ivp in the time domain, the reference.
    initial_speed : float
        Driver speed at pin entry [rad/s], >= 0.
    rtol : float, optional
        Relative error asked for in handoff times and speeds, in [1e-13, 1).
        Default 1e-10 for "ivp".
    atol, method, max_step : optional
        For "ivp" as in solve_ivp: absolute tolerance [rad, rad/s, J], method
        (default "DOP853") and longest step [s].

    Returns
    -------
    Motion
        Its `status` tells whether it ran to its end.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    settings = _settings(escapement, engine, rtol, atol, method, max_step, initial_speed)
    if engagements is not None and duration is not None:
        raise InvalidValue(
            "engagements and duration must not both be given, got "
            f"{engagements!r} and {duration!r}; leave one out"
        )
    if duration is None:
        count = DEFAULT_ENGAGEMENTS if engagements is None else engagements
        engagements = _validate.integer("engagements", count, 1, "give how many to run")
    else:
        duration = _validate.positive("duration", duration, "give the time to run in s")
    from escapement.engines import _ivp

    return _ivp.simulate(escapement, engagements=engagements, duration=duration, **settings)


def _settings(
    escapement: Escapement,
    engine: str,
    rtol: float | None,
    atol: float | None,
    method: str | None,
    max_step: float | None,
    initial_speed: float,
) -> dict[str, Any]:
    if not isinstance(escapement, Escapement):
        raise _validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    _validate.choice("engine", engine, ENGINES)
    tolerance = _validate.number("rtol", DEFAULT_RTOL[engine] if rtol is None else rtol)
    if not 1e-13 <= tolerance < 1.0:
        raise _validate.fail("rtol", "at least 1e-13 and below 1", rtol, "1e-10 is a good choice")
    return {
        "initial_speed": _validate.non_negative(
            "initial_speed", initial_speed, "give the driver speed at pin entry in rad/s"
        ),
        "rtol": tolerance,
        "atol": None if atol is None else _validate.non_negative("atol", atol, "leave it out"),
        "method": "DOP853" if method is None else _validate.choice("method", method, METHODS),
        "max_step": math.inf
        if max_step is None
        else _validate.positive("max_step", max_step, "give the longest step in s"),
    }


def terminal(
    escapement: Escapement,
    *,
    engine: str = DEFAULT_ENGINE,
    initial_speed: float = 0.0,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    max_step: float | None = None,
) -> Figures:
    """Figures of merit: the terminal cycle, and how the motion gets there.

    Parameters
    ----------
    escapement, engine, rtol, atol, method, max_step :
        As for `simulate`.
    initial_speed : float
        Driver speed at the first pin entry [rad/s]; only the rise and the
        settling time depend on it.

    Returns
    -------
    Figures
        With `status` NO_TERMINAL without friction, STALL when the drive cannot
        carry the load, PAINLEVE at or above the limit; NaN where there is no answer.
    """
    settings = _settings(escapement, engine, rtol, atol, method, max_step, initial_speed)
    limit = critical_friction(escapement.mechanism, escapement.inertia)
    base = Figures(critical_friction=limit)
    if escapement.friction == 0.0:
        return _without_friction(escapement, base)
    return _terminal_ivp(escapement, base, settings)


def _without_friction(escapement: Escapement, base: Figures) -> Figures:
    """No terminal speed, or none to start with."""
    gain = escapement.torque * escapement.mechanism.cell_angle
    if gain > escapement.load_torque * escapement.mechanism.follower_step:
        return replace(base, status=Status.NO_TERMINAL, message=MESSAGES[Status.NO_TERMINAL])
    return replace(base, status=Status.STALL, message=MESSAGES[Status.STALL])


def _terminal_ivp(escapement: Escapement, base: Figures, settings: dict[str, Any]) -> Figures:
    from escapement.engines import _ivp
    from escapement.engines._ivp_terminal import terminal_cycle

    initial_speed = settings.pop("initial_speed")
    cycle, contraction = terminal_cycle(escapement, **settings)
    if cycle.status is not Status.OK:
        return replace(base, status=cycle.status, message=cycle.message)
    figures = replace(read_cycle(cycle, base), contraction=contraction)
    count = _transient_length(contraction)
    if count > IVP_TRANSIENT:
        message = f"rise and settling time: the motion needs more than {IVP_TRANSIENT} engagements"
        return replace(figures, message=message)
    motion = _ivp.simulate(
        escapement, engagements=count, duration=None, initial_speed=initial_speed, **settings
    )
    if motion.status is not Status.OK:
        return replace(base, status=motion.status, message=motion.message)
    rise, settled = read_transient(motion, figures)
    return replace(figures, rise_time=rise, settling_time=settled)


def _transient_length(contraction: float) -> float:
    """Engagements after which a deviation of order one is far below the settling band."""
    return 8 + math.ceil(math.log(1e-4) / math.log(min(max(contraction, 1e-4), 1.0 - 1e-12)))
