"""Meyer's inertias against those of his own parts.

Chapter II takes driver and follower for discs of steel, 0.5 in across and 0.1 in thick, and gives
each of them about 0.5e-6 in-lbf-s^2. The tables use several times, and once 111 times as much.
"""

import math
from typing import Any

from escapement.base.units import INCH_POUND
from escapement.engines.simulate import terminal
from escapement.mechanisms import Geneva
from escapement.model.escapement import Escapement, Inertia

INERTIAS = {3: (6e-6, 10e-6), 4: (3e-6, 50e-6), 6: (3e-6, 40e-6)}
"""Driver and follower inertia really used, by slots [in-lbf-s^2] (figures 9 to 11)."""
RUNS = {3: (0.35, 0.09), 4: (0.35, 0.10), 6: (0.35, 0.14)}
"""Friction and torque [in-lbf] of rows 16, 30 and 49 of Appendix E, by slots."""
FIGURES = ("period", "rise_time", "critical_friction")


def disc_inertia(
    diameter: float = 0.5, thickness: float = 0.1, weight: float = 0.283, gravity: float = 386.0
) -> float:
    """Moment of inertia of a disc, by default of the thesis' own: 4.50e-7 [in-lbf-s^2].

    Parameters
    ----------
    diameter, thickness : float
        [in].
    weight : float
        Specific weight [lbf/in^3].
    gravity : float
        [in/s^2].
    """
    return 0.5 * math.pi * weight / gravity * (0.5 * diameter) ** 4 * thickness


def own_parts() -> list[dict[str, Any]]:
    """True figures of three runs with the inertias of the tables and with those of the disc.

    Returns
    -------
    list of dict
        `slots`, `friction` and `torque_inlbf` of each run, and under `tables` and `disc` its
        `driver_inertia`, `follower_inertia` [in-lbf-s^2], `period`, `rise_time` [s] and
        `critical_friction` [-].
    """
    disc, rows = disc_inertia(), []
    for slots, (friction, torque) in RUNS.items():
        run = {"slots": slots, "friction": friction, "torque_inlbf": torque}
        tried = {"tables": INERTIAS[slots], "disc": (disc, disc)}
        rows.append(
            run
            | {name: _run(slots, friction, torque, *inertias) for name, inertias in tried.items()}
        )
    return rows


def _run(slots: int, friction: float, torque: float, *inertias: float) -> dict[str, float]:
    inertia = Inertia(*(value * INCH_POUND for value in inertias))
    found = terminal(Escapement(Geneva(slots), inertia, torque * INCH_POUND, friction))
    named = dict(zip(("driver_inertia", "follower_inertia"), inertias, strict=True))
    return named | {name: float(getattr(found, name)) for name in FIGURES}
