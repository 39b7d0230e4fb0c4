"""`simulate` gives a motion, `terminal` the figures of merit of its terminal cycle."""

import math
from dataclasses import replace
from functools import cache
from importlib import import_module
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import check_number, quantities
from escapement.base.spoken import as_spoken
from escapement.base.status import MESSAGES, Status
from escapement.dynamics.figures_of_merit import Figures
from escapement.dynamics.law import ends_alike, is_lossless
from escapement.dynamics.motion import Motion, no_motion
from escapement.dynamics.painleve import friction_limits, painleve_message, uniqueness_note
from escapement.engines.solver import (
    DEFAULT_ENGINE,
    DEFAULT_SOLVER,
    Solver,
    choose_solver,
    solver_for,
)
from escapement.mechanisms.slotted import transmission_at
from escapement.model.escapement import Escapement, Run, once_per_escapement
from escapement.numerics.jit import as_python

LONGEST = {"energy": 10_000_000, "ivp": 10_000, "contact": 1_000_000, "two_bodies": 10_000}
"""Greatest number of engagements in a motion. They take up to a gigabyte, and seconds, or with
"ivp" a minute."""
_FOLDERS = {
    **{("energy", ""): "energy", ("ivp", ""): "ivp"},
    **{("contact", law): f"contact.{law}" for law in ("rigid", "compliant")},
    ("two_bodies", "outlines"): "two_bodies",
    ("two_bodies", "compliant outlines"): "two_bodies.compliant",
}
_SETTINGS = "simulate.settings"
_OK = Status.OK
_FULL = "the figures are those of the full spring, whose torque falls as it runs down"
_AT_START = "the figures are those of the torque at the start of the motion"
_NO_START = "the torque curve begins with no torque, which has no cycle"
ROUNDING = 1e-9
"""A speed may exceed the last one of a torque curve by this share, which rounding explains."""


def simulate(
    escapement: Escapement,
    engagements: int | None = None,
    *,
    duration: float | None = None,
    engine: str | None = None,
    initial_speed: float = 0.0,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    max_step: float | None = None,
    solver: Solver | None = None,
) -> Motion:
    """Simulate an escapement from pin entry.

    Parameters
    ----------
    escapement : Escapement
        The escapement.
    engagements : int, optional
        Engagements to run, from 1 to ten million, with "ivp" and "two_bodies" to ten thousand and
        with "contact" to a million.
        Default 20, unless a duration is given.
    duration : float, optional
        Time to run instead [s], > 0 and of no more engagements than that.
    engine : str, optional
        "energy" (driver-angle domain, fast), "ivp" (SciPy's solve_ivp in the time domain, the
        reference), "contact" (clearance and compliant contact) or "two_bodies" (outlines). By
        default the scene chooses: "two_bodies" where both bodies have outlines, "contact" where it
        has clearance or stiffness, else "energy".
    initial_speed : float
        Driver speed at pin entry [rad/s], >= 0.
    rtol : float, optional
        Relative error asked for in handoff times and speeds, in [1e-13, 1).
        Default 1e-12 for "energy", 1e-10 for the others.
    atol, method, max_step : optional
        For "ivp" only, as in solve_ivp: absolute tolerance [rad, rad/s, J], method
        (default "DOP853") and longest step [s].
    solver : Solver, optional
        Engine and tolerances as one value, in place of `engine` to `max_step`.

    Returns
    -------
    Motion
        Its `status` says whether it ran to its end. It is STALL if the drive cannot overcome load
        and losses, and SPENT if the spring is spent and nothing moves; `end_time` is then the time
        of the stop. Where nothing drives the mechanism, since the spring is spent or the torque
        does not exceed that of the driver's bearing, bodies that hardly move count as at rest: at
        a pin entry once their kinetic energy is at most that of a driver with a thousandth of the
        speed sqrt(torque/I_f), with viscous drag anywhere. It is NOT_CONVERGED if the steps that
        an engine takes at most are used up; the message then says how far it got.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    solver = choose_solver(solver, engine, rtol, atol, method, max_step)
    engine, settings = _settings(escapement, solver, initial_speed)
    if engagements is not None and duration is not None:
        raise InvalidValue(
            "engagements and duration must not both be given, got "
            f"{engagements!r} and {duration!r}; leave one out"
        )
    if duration is None:
        wanted, most = engagements, LONGEST[engine]
        if type(wanted) is not int or not 1 <= wanted <= most:
            count = quantities(Run)["engagements"]
            wanted = count.default if wanted is None else wanted
            engagements = validate.integer("engagements", wanted, 1, count.remedy, most)
    else:
        duration = check_number(Run, "duration", duration)
    if misfit := escapement.mechanism.misfit:
        return no_motion(escapement, engine, settings["rtol"], misfit)
    run = _engine(engine, escapement.contact, "simulate")
    motion: Motion = run(escapement, engagements=engagements, duration=duration, **settings)
    drive = escapement.drive_curve
    if drive is not None and drive.speed:
        parts = [
            initial_speed,
            *(part.extrema.theta_dot.max(initial=0.0) for part in motion.parts()),
        ]
        fastest = max(*parts, motion.handoff_velocities.max(initial=0.0))
        if why := _too_fast(drive.speed[-1], fastest):
            motion = replace(motion, status=Status.INVALID, message=why)
    outcome, note = motion.outcome, uniqueness_note(escapement)
    if note or escapement.notes or outcome is not _OK:
        note = note if outcome is not Status.PAINLEVE else ""
        motion.add_notes(_stalled(escapement, outcome), note, escapement.notes)
    return motion


def _stalled(escapement: Escapement, status: Status) -> str:
    """What to know of a motor that stops, or ""."""
    if status is not Status.STALL or escapement.no_load_speed is None:
        return ""
    passed = escapement.scene.barrel_efficiency * escapement.torque_unit
    return f"at rest the motor gives the driver {as_spoken(passed, 'torque')}, which is its most"


@cache
def _engine(name: str, contact: str, task: str) -> Any:
    """Function "simulate" or "terminal" of an engine, which is imported on first use."""
    module = import_module(f"escapement.engines.{_FOLDERS[name, contact]}.{task}")
    return getattr(module, task)


def _settings(
    escapement: Escapement, solver: Solver, initial_speed: float
) -> tuple[str, dict[str, Any]]:
    """The engine, and keyword arguments that both of its functions take."""
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    # the usual start, from rest, needs no check; its settings are kept for the next call
    rests = type(initial_speed) is float and initial_speed == 0.0
    kept = escapement.kept if rests and solver is DEFAULT_SOLVER else {}
    if _SETTINGS not in kept:
        solver = solver_for(escapement.contact, solver)
        speed = 0.0 if rests else check_number(Run, "initial_speed", initial_speed)
        settings = {**solver.arguments, "initial_speed": speed}
        engine = solver.engine or DEFAULT_ENGINE
        kept[_SETTINGS] = engine, settings
    found: tuple[str, dict[str, Any]] = kept[_SETTINGS]
    return found


def terminal(
    escapement: Escapement,
    *,
    engine: str | None = None,
    initial_speed: float = 0.0,
    rtol: float | None = None,
    atol: float | None = None,
    method: str | None = None,
    max_step: float | None = None,
    solver: Solver | None = None,
) -> Figures:
    """Figures of merit: the terminal cycle, and how the motion gets there.

    Parameters
    ----------
    escapement, engine, rtol, atol, method, max_step, solver :
        As for `simulate`.
    initial_speed : float
        Driver speed at the first pin entry [rad/s]: rise and settling time depend on it,
        and with a load whether the drive gets past where it would stall from rest.

    Returns
    -------
    Figures
        Their `status` is NO_TERMINAL where no loss grows with the speed, STALL when the drive
        cannot carry the load, PAINLEVE at or above the limit. A figure that does not exist is NaN.
        For a spring that runs down they belong to its full torque, and for a torque curve to its
        first torque, as the message says.
    """
    solver = choose_solver(solver, engine, rtol, atol, method, max_step)
    engine, settings = _settings(escapement, solver, initial_speed)
    found = _terminal(escapement, engine, settings)
    if escapement.notes or found.outcome is not _OK:
        found.add_notes(_stalled(escapement, found.outcome), escapement.notes)
    return found


def _terminal(escapement: Escapement, engine: str, settings: dict[str, Any]) -> Figures:
    """As `terminal`, without notes on settings that have no effect or are not given."""
    if misfit := escapement.mechanism.misfit:
        return Figures(status=Status.INVALID, message=misfit)
    base, curve = limits(escapement), escapement.curve
    if curve is not None and not escapement.torque_cells:
        if curve.at_rest[0] == 0.0:
            return replace(base, status=Status.STALL, message=_NO_START)
        found = _terminal(escapement.held, engine, settings)
        found.add_notes(_FULL if escapement.spring_rate else _AT_START)
        return found
    found = _terminal_cycle(escapement.whole_round, engine, settings, base)
    drive, fastest = escapement.drive_curve, max(found.velocity_max, settings["initial_speed"])
    if drive is not None and drive.speed:
        endless = found.outcome is Status.NO_TERMINAL
        if why := _too_fast(drive.speed[-1], math.inf if endless else fastest):
            return replace(base, status=Status.INVALID, message=why)
    return found


def _too_fast(last: float, fastest: float) -> str:
    """Why a motion leaves a torque curve that ends at the speed `last`, or ""."""
    if not fastest > last * (1.0 + ROUNDING):
        return ""
    reached = as_spoken(fastest, "speed") if fastest < math.inf else "any speed"
    return (
        f"the driver reaches {reached}, and the torque curve ends at {as_spoken(last, 'speed')} of "
        "the driver: give its torque at higher speeds"
    )


def _terminal_cycle(
    escapement: Escapement, engine: str, settings: dict[str, Any], base: Figures
) -> Figures:
    """As `_terminal`, where the torque repeats in the `pairs` of the escapement."""
    # the limit is decided before anything is integrated
    contact = escapement.contact
    if not escapement.stiffness and (message := painleve_message(escapement)):
        return replace(base, status=Status.PAINLEVE, message=message)
    if why := _undriven(escapement):
        return replace(base, status=Status.STALL, message=why)
    if not contact and _is_lossless(escapement) and _ends_alike(escapement):
        # every engagement gains the same energy, so that one tells whether all stop, or none
        # is steady
        round_ = {"engagements": len(escapement.pairs), "duration": None}
        one = _engine(engine, "", "simulate")(escapement, **round_, **settings)
        status, message = one.outcome, one.message
        if status is Status.OK:
            mechanism = escapement.mechanism
            # what trains without inertias pass on is constant
            scene, held = escapement.scene, escapement.driver_bearing_torque
            step, size = mechanism.follower_step, len(escapement.pairs)
            mean = escapement.drive_work(size * mechanism.cell_angle) / size / mechanism.cell_angle
            pull = scene.barrel_efficiency * mean - held
            lost = escapement.referred["load_torque"] * (1.0 / scene.load_train_efficiency - 1.0)
            load = escapement.load_work(size * step) - escapement.jump_works.sum()
            carries = pull * size * mechanism.cell_angle > load + lost * size * step
            status = Status.NO_TERMINAL if carries else Status.STALL
            message = MESSAGES[status]
        return replace(base, status=status, message=message)
    figures: Figures = _engine(engine, contact, "terminal")(escapement, base, **settings)
    figures.add_notes(uniqueness_note(escapement))
    return figures


@once_per_escapement
def _is_lossless(escapement: Escapement) -> bool:
    """Whether neither a loss nor an impact grows with the speed."""
    struck = any(pair.kind == "strike" for pair in escapement.pairs)
    return not struck and bool(is_lossless(escapement.scene))


def _undriven(escapement: Escapement) -> str:
    """Why a constant torque drives nothing, or ""."""
    scene, held = escapement.scene, escapement.driver_bearing_torque
    if scene.barrel_efficiency > scene.bearing:
        return ""
    reaches = scene.barrel_efficiency * escapement.torque_unit
    return (
        "nothing drives the mechanism: the torque that reaches the driver, "
        f"{as_spoken(reaches, 'torque')}, does not exceed that of its bearing, "
        f"{as_spoken(held, 'torque')}"
    )


@once_per_escapement
def limits(escapement: Escapement) -> Figures:
    """The figures that belong to an escapement whether it moves or not."""
    if escapement.mechanism.pitch is not None:
        return Figures()
    critical, uniqueness = friction_limits(escapement)
    margin = 1.0 - escapement.friction / critical if critical > 0.0 else -math.inf
    return Figures(critical_friction=critical, uniqueness_friction=uniqueness, jam_margin=margin)


def _ends_alike(escapement: Escapement) -> bool:
    """Whether the reduced inertia is the same at pin entry and exit."""
    path, breaks = escapement.mechanism.path, escapement.mechanism.breaks
    entry, exit_ = (transmission_at(path, angle)[0] for angle in (breaks[0], breaks[-1]))
    return bool(as_python(ends_alike)(entry, exit_, escapement.scene.rho))
