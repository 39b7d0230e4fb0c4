"""Terminal cycle of the reference engine: the fixed point of one engagement.

An engagement maps the squared driver speed at entry to that at exit. The
terminal cycle is where the two agree; a bracketing root finder gets there in
about ten engagements however slowly the motion itself converges.
"""

from typing import Any

import numpy as np
from scipy.optimize import toms748

from escapement.engines import _ivp
from escapement.model import Escapement
from escapement.motion import Motion
from escapement.status import Status


def terminal_cycle(escapement: Escapement, **settings: Any) -> tuple[Motion, float]:
    """One terminal engagement and the contraction factor of the map.

    Returns
    -------
    cycle : Motion
        One engagement from the terminal handoff speed; where there is none its
        status says why.
    contraction : float
        d(w_out)/d(w_in) at the fixed point, w = theta_dot^2 [-].
    """

    def engage(w: float) -> Motion:
        return _ivp.simulate(
            escapement, engagements=1, duration=None, initial_speed=float(np.sqrt(w)), **settings
        )

    low, scale = 0.0, 1.0 / escapement.time_unit**2
    first = engage(0.0)
    if first.status is Status.PAINLEVE:
        return first, np.nan
    if first.status is Status.STALL:
        low, first = _moving_start(engage, scale, first)
        if first.status is not Status.OK:
            return first, np.nan

    def excess(w: float) -> float:
        motion = engage(w)
        return -w if motion.status is not Status.OK else motion.handoff_velocities[0] ** 2 - w

    high = max(first.handoff_velocities[0] ** 2, scale)
    for _ in range(60):
        if excess(high) < 0.0:
            break
        low, high = high, 4.0 * high
    w = toms748(excess, low, high, xtol=1e-300, rtol=max(settings["rtol"], 1e-15), k=2)
    step = 1e-4 * w
    slope = 1.0 + (excess(w + step) - excess(w - step)) / (2.0 * step)
    return engage(w), float(slope)


def _moving_start(engage: Any, scale: float, stalled: Motion) -> tuple[float, Motion]:
    """Least of a ladder of entry speeds from which an engagement gains speed."""
    for w in scale * 4.0 ** np.arange(-6, 12):
        motion = engage(w)
        if motion.status is Status.OK and motion.handoff_velocities[0] ** 2 > w:
            return float(w), motion
    return 0.0, stalled
