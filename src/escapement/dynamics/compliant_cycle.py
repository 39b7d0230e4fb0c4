"""The cycle of a motion with compliant contact, or means over many engagements.

If the walls damp little, the pin bounces, and the number of bounces depends on the last digits of
the speed before them: the engagements then never become equal. Means over many of them, with
intervals, replace the figures of a terminal cycle.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from escapement.base.status import Status
from escapement.dynamics.batch_spread import BATCHES, batch_spread
from escapement.dynamics.compliance import STATE
from escapement.dynamics.compliant_march import MOST_TRIES, CompliantMarch, simulated
from escapement.dynamics.figures_of_merit import Figures, read_figures
from escapement.dynamics.motion import Motion

SETTLE = 60
"""A motion that does not repeat itself after so many engagements is assumed never to do so."""
SAMPLE = 120
"""Number of engagements over which means are then taken; fewer if the steps are used up."""
_NOISE = 1e-9
_LONGEST_TRANSIENT = 200


def cycle_of(
    march: CompliantMarch, base: Figures, asked: float, initial_speed: float,
    note: Callable[[Motion], str] = lambda _: "",
) -> Figures:  # fmt: skip
    """Figures of merit of a motion that a march has begun.

    Parameters
    ----------
    base : Figures
        Those that need no motion.
    asked, initial_speed : float
        Relative error asked for, and speed at the start [rad/s].
    note : callable
        What to say of an engagement, or "".
    """

    def follow(count: int) -> Motion:
        """The motion from the start."""
        begun = type(march)(march.escapement, initial_speed, asked)
        return simulated(begun, count, None, asked)

    # rounds are engagements, or those in one turn of the follower with a load that repeats in it
    tolerance, size = max(10.0 * asked, _NOISE), len(march.escapement.pairs)
    speeds: list[float] = []
    last: dict[str, float] = {}
    for count in range(SETTLE):
        motion, numbers = march.engage(size, asked)
        if motion.outcome is not Status.OK:
            return replace(base, status=motion.outcome, message=motion.message)
        # if the mechanism jams, the least speed is almost zero and says little by itself
        scales = {"velocity_min": numbers["velocity_max"]}
        changes = [abs(numbers[n] - last[n]) / scales.get(n, last[n]) for n in last]
        if last and max(changes) <= tolerance:
            passed, contraction = _repeated(march, size, asked)
            if said := note(passed):
                base = replace(base, message=said)
            given = initial_speed, follow, _LONGEST_TRANSIENT
            return read_figures(base, passed, contraction, *given)
        last = numbers
        speeds.append(numbers["handoff_velocity"])
        if count % 4 == 3 and (extrapolated := _limit(speeds[-3:])) > 0.0:
            march.hurry(extrapolated / speeds[-1])
        if march.clock["tries"][0] > 0.4 * MOST_TRIES:
            break
    return _spread(march, size, base, asked, note)


def _limit(speeds: list[float]) -> float:
    """Limit of three handoff speeds that approach it slowly as a geometric series, else 0."""
    one, two, three = (speed * speed for speed in speeds)
    ratio = (three - two) / (two - one) if two != one else 0.0
    if not 0.3 < abs(ratio) < 0.999:
        return 0.0
    return math.sqrt(max(three + (three - two) * ratio / (1.0 - ratio), 0.0))


def _repeated(march: CompliantMarch, size: int, asked: float) -> tuple[Motion, float]:
    """A round that repeats itself, and by how much it contracts a change of the speed."""
    motion, numbers = march.engage(size, asked)
    end, speed, nudge = march.state[:STATE].copy(), numbers["handoff_velocity"], 1e-3
    march.hurry(1.0 + nudge)
    moved = march.engage(size, asked)[1].get("handoff_velocity", speed)
    march.state[:] = end
    return motion, ((moved / speed) ** 2 - 1.0) / ((1.0 + nudge) ** 2 - 1.0)


def _spread(
    march: CompliantMarch, size: int, base: Figures, asked: float, note: Callable[[Motion], str]
) -> Figures:
    """Means of engagements that do not repeat themselves."""
    passed: list[tuple[Motion, dict[str, float]]] = []
    while len(passed) < SAMPLE:
        motion, numbers = march.engage(size, asked)
        if motion.outcome is not Status.OK:
            if motion.outcome is Status.NOT_CONVERGED and len(passed) >= 2 * BATCHES:
                # the steps are used up, and these engagements are enough
                break
            return replace(base, status=motion.outcome, message=motion.message)
        passed.append((motion, numbers))
    count, last = len(passed) // BATCHES * BATCHES, passed[-1][0]
    rows = [numbers for _, numbers in passed[:count]]
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    means: dict[str, Any] = {name: float(column.mean()) for name, column in columns.items()}
    spread = batch_spread(columns, size)
    share = spread.interval["period"] / means["period"]
    message = (
        f"the engagements do not repeat themselves: the period and the velocities are means over "
        f"{spread.engagements} of them, the period with a relative error of at most {share:.2g} "
        "(95 %); all other figures are those of the last engagement"
    )
    cell = last.escapement.mechanism.cell_angle
    if said := note(last):
        message = f"{message}; {said}"
    means["velocity_mean"] = cell / means["period"]
    return replace(base, **means, motion=last, spread=spread, message=message)
