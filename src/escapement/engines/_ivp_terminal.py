"""Terminal cycle of the reference engine: the fixed point of one engagement.

An engagement maps the squared driver speed at entry to that at exit. The
terminal cycle is where the two agree; a bracketing root finder gets there in
about ten engagements however slowly the motion itself converges.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import toms748

from escapement.engines import _ivp
from escapement.metrics import Figures, read_cycle, read_transient
from escapement.model import Escapement
from escapement.motion import Motion
from escapement.status import Status

LONGEST_TRANSIENT = 3000
"""Engagements of a transient this engine will integrate."""


def terminal(escapement: Escapement, base: Figures, **settings: Any) -> Figures:
    """Figures of merit by integration; see `escapement.terminal`."""
    cycle, contraction = terminal_cycle(escapement, **settings)
    if cycle.status is not Status.OK:
        return replace(base, status=cycle.status, message=cycle.message)
    figures = replace(read_cycle(cycle, base), contraction=contraction)
    count = _transient_length(contraction)
    if count > LONGEST_TRANSIENT:
        message = (
            "rise and settling time are not given: the motion needs more than "
            f"{LONGEST_TRANSIENT} engagements, too many for engine 'ivp'"
        )
        return replace(figures, message=message)
    motion = _ivp.simulate(escapement, engagements=count, duration=None, **settings)
    rise, settled = read_transient(motion, figures)
    return replace(figures, rise_time=rise, settling_time=settled)


def _transient_length(contraction: float) -> int:
    """Engagements after which a deviation of order one is far below the settling band."""
    rate = math.log(min(max(contraction, 1e-4), 1.0 - 1e-12))
    return 8 + math.ceil(math.log(1e-4) / rate)


def terminal_cycle(
    escapement: Escapement, *, initial_speed: float, **settings: Any
) -> tuple[Motion, float]:
    """One terminal engagement and the contraction factor of the map.

    Returns
    -------
    cycle : Motion
        One engagement from the terminal handoff speed, or the engagement that
        stalls on the way there from the initial speed.
    contraction : float
        d(w_out)/d(w_in) at the fixed point, w = theta_dot^2 [-].
    """

    def engage(w: float) -> Motion:
        return _ivp.simulate(
            escapement, engagements=1, duration=None, initial_speed=float(np.sqrt(w)), **settings
        )

    def gain(motion: Motion, w: float) -> float:
        return motion.handoff_velocities[0] ** 2 - w

    def gain_from(w: float) -> float:
        return gain(engage(w), w)

    w = initial_speed**2
    motion = engage(w)
    if motion.status is not Status.OK:
        return motion, np.nan
    # trajectories do not cross, so the sign of the gain tells the side of the fixed point
    rising = gain(motion, w) > 0.0
    low = high = w
    factor = 4.0 if rising else 0.5
    w = max(w, motion.handoff_velocities[0] ** 2) if rising else w * factor
    while True:
        motion = engage(w)
        if motion.status is not Status.OK:
            return motion, np.nan
        if (gain(motion, w) > 0.0) != rising:
            break
        low, high = (w, high) if rising else (low, w)
        w *= factor
    low, high = (low, w) if rising else (w, high)
    w = toms748(gain_from, low, high, xtol=1e-300, rtol=max(settings["rtol"], 1e-15), k=2)
    step = 1e-4 * w
    slope = 1.0 + (gain_from(w + step) - gain_from(w - step)) / (2.0 * step)
    return engage(w), float(slope)
