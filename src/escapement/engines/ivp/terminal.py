"""Terminal cycle of the reference engine: the fixed point of one engagement.

An engagement, or with imperfect parts a pattern of them, maps the squared driver speed w at
entry to that at exit. The terminal cycle is where the two agree. A bracketing root finder finds
it in about ten engagements, even if the motion itself converges slowly. Its function is not the
difference of the two but the gain of energy, work minus load and losses: if little is lost, the
difference of the speeds has no digits left.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import toms748

from escapement.base.status import MESSAGES, Status
from escapement.dynamics.figures_of_merit import BOUNDLESS, Figures, read_figures
from escapement.dynamics.motion import Motion
from escapement.engines.ivp.simulate import simulate
from escapement.mechanisms.protocol import dwell_angle
from escapement.mechanisms.slotted import transmission_at
from escapement.model.escapement import Escapement

LONGEST_TRANSIENT = 3000
"""Greatest number of engagements of a transient that this engine integrates."""
_CLOSE = 1e-9
"""Relative distance between a falling and a stalling speed with no cycle between them."""


_Bracket = tuple[float, float]
"""Squared speeds below and above that of the terminal cycle [rad^2/s^2]."""


class _Engagement(NamedTuple):
    """One engagement, and what it adds to the squared speed [rad^2/s^2]."""

    motion: Motion
    gain: float


def terminal(escapement: Escapement, base: Figures, **settings: Any) -> Figures:
    """Figures of merit by integration; see `escapement.terminal`."""
    cycle, contraction = bracketed_cycle(escapement, **settings)
    if cycle.outcome is not Status.OK:
        return replace(base, status=cycle.outcome, message=cycle.message)

    def follow(count: int) -> Motion:
        return simulate(escapement, engagements=count, duration=None, **settings)

    speed = settings["initial_speed"]
    return read_figures(base, cycle, contraction, speed, follow, LONGEST_TRANSIENT)


def bracketed_cycle(
    escapement: Escapement, *, initial_speed: float, **settings: Any
) -> tuple[Motion, float]:
    """One terminal engagement and the contraction factor of the map.

    Returns
    -------
    cycle : Motion
        One engagement from the terminal handoff speed, or the motion that ends
        on the way there from the initial speed.
    contraction : float
        d(w_out)/d(w_in) at the fixed point [-].
    """

    def engage(w: float) -> _Engagement:
        start: dict[str, Any] = {"duration": None, "initial_speed": math.sqrt(w)}
        motion = simulate(escapement, engagements=len(escapement.scenes), **start, **settings)
        return _Engagement(motion, _gain(motion, w))

    w = initial_speed**2
    first = engage(w)
    if first.motion.outcome is not Status.OK:
        return first.motion, math.nan
    grows = first.gain > 0.0
    bracket = _bracket_above(engage, w, first.gain) if grows else _bracket_below(engage, w)
    if isinstance(bracket, Motion):
        if bracket.outcome is Status.STALL:
            bracket = _until_stall(escapement, initial_speed=initial_speed, **settings)
        return bracket, math.nan
    # only the relative tolerance matters, because w may have any size
    w = toms748(
        lambda x: engage(x).gain, *bracket, xtol=1e-300, rtol=max(settings["rtol"], 1e-15), k=2
    )
    # dw_out/dw_in = 1 + d(gain)/dw, by a central difference
    step = 1e-4 * w
    slope = 1.0 + (engage(w + step).gain - engage(w - step).gain) / (2.0 * step)
    return engage(w).motion, float(slope)


def _gain(motion: Motion, w: float) -> float:
    """The gain of the squared speed in a complete engagement, from its energy.

    (I_d + I_f g_out^2) w_out - (I_d + I_f g_in^2) w_in = 2 (work - load - losses), where
    g_out is 0 after a dwell.
    """
    escapement, mechanism = motion.escapement, motion.escapement.mechanism
    driver, follower = (escapement.referred[f"{body}_inertia"] for body in ("driver", "follower"))
    if (size := len(escapement.pairs)) > 1:
        # a pattern ends as it begins, after the handoff, and takes its impacts besides
        handoffs, scene = motion.handoffs, escapement.scene
        jumped = escapement.jump_works[handoffs.engagement % size].sum()
        work = escapement.drive_work(size * mechanism.cell_angle) + jumped
        work -= escapement.load_work(size * mechanism.follower_step)
        work -= motion.trajectory.losses.sum() + handoffs.energy.sum()
        ratio = transmission_at(scene.path, scene.edges[0])[0]
        return float(2.0 * work / (driver + follower * ratio**2))
    # Meyer's published cells end with another g than they begin with
    entry, exit_ = mechanism.breaks[0], mechanism.breaks[-1]
    path = mechanism.path
    at_entry, at_exit = (transmission_at(path, angle)[0] ** 2 for angle in (entry, exit_))
    follower_turn = mechanism.follower_angle(np.array([entry, exit_]))
    work = escapement.drive_work(mechanism.cell_angle)
    work -= (
        escapement.load_work(follower_turn[1] - follower_turn[0]) + motion.trajectory.losses.sum()
    )
    if dwell_angle(mechanism) > 0.0:
        at_exit = 0.0
    return float((2.0 * work + follower * (at_entry - at_exit) * w) / (driver + follower * at_exit))


def _bracket_above(
    engage: Callable[[float], _Engagement], low: float, gain: float
) -> _Bracket | Motion:
    """Bracket above a speed that grows, or the engagement that shows there is none.

    Trajectories do not cross, so that a motion which passes an engagement at one speed
    passes it at any higher one.
    """
    # from rest the gain is the only scale of w; the factor of 4 doubles the speed
    high = max(4.0 * low, low + 2.0 * gain)
    while True:
        trial = engage(high)
        if trial.motion.outcome is not Status.OK:
            return trial.motion
        if not trial.gain > 0.0:
            return low, high
        # no speed is terminal where a table's ratio is constant: the gain falls to rounding
        if trial.motion.escapement.scene.path.table and trial.gain < BOUNDLESS * high:
            status = Status.NO_TERMINAL
            return replace(trial.motion, status=status, message=MESSAGES[status])
        low, high = high, 4.0 * high


def _bracket_below(engage: Callable[[float], _Engagement], high: float) -> _Bracket | Motion:
    """Bracket below a speed that falls, or an engagement that shows there is none.

    The slower the driver, the greater the gain, down to the speed at which it stops
    within the engagement. If there is a loss even at that speed, the motion stops.
    """
    stopped: Motion | None = None
    stops_at, trial = 0.0, 0.5 * high
    while stopped is None or stops_at < (1.0 - _CLOSE) * high:
        found = engage(trial)
        if found.motion.outcome is Status.OK:
            if not found.gain < 0.0:
                return trial, high
            # still a loss: the terminal speed, if there is one, is lower
            high = trial
        elif found.motion.outcome is Status.STALL:
            # too slow to pass: the terminal speed, if there is one, is higher
            stops_at, stopped = trial, found.motion
        else:
            return found.motion
        trial = 0.5 * (stops_at + high)
    return stopped


def _until_stall(escapement: Escapement, **settings: Any) -> Motion:
    """The motion up to its stall, or a motion with status `stall` if that comes late."""
    for count in (50, 500):
        motion = simulate(escapement, engagements=count, duration=None, **settings)
        if motion.outcome is not Status.OK:
            return motion
    return replace(motion, status=Status.STALL, message=MESSAGES[Status.STALL])
