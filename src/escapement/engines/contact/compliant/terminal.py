"""`terminal` with compliant contact: the cycle that repeats, or means over many engagements.

If the walls damp little, the pin bounces, and the number of bounces depends on the last digits of
the speed before them: the engagements then never become equal. Means over many of them, with
intervals, replace the figures of a terminal cycle.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from escapement.base.status import MESSAGES, Status
from escapement.dynamics.batch_spread import BATCHES, batch_spread
from escapement.dynamics.figures_of_merit import Figures, cycle_figures, read_figures
from escapement.dynamics.impacts import jams
from escapement.dynamics.law import is_lossless
from escapement.dynamics.motion import Motion
from escapement.dynamics.painleve import friction_limits
from escapement.dynamics.train_losses import is_lossy
from escapement.engines.contact.compliant.law import STATE
from escapement.engines.contact.compliant.simulate import MOST_TRIES, March, simulate
from escapement.model.escapement import Escapement
from escapement.numerics.jit import as_python

SETTLE = 60
"""A motion that does not repeat itself after so many engagements is assumed never to do so."""
SAMPLE = 120
"""Number of engagements over which means are then taken; fewer if the steps are used up."""
_NOISE = 1e-9
_LONGEST_TRANSIENT = 200


class _PassedRound(NamedTuple):
    """One round: its motion, and the numbers by which rounds are compared."""

    motion: Motion
    numbers: dict[str, float]


class _Cycle:
    """Rounds one after the other: engagements, or the engagements in one turn of the follower with
    a load that repeats in a turn.
    """

    def __init__(self, escapement: Escapement, speed: float, rtol: float) -> None:
        self.march, self.asked = March(escapement, speed, rtol), rtol
        self.size = len(escapement.pairs)

    def engage(self) -> _PassedRound:
        """Pass one round."""
        march = self.march
        march.set_back()
        motion = march.motion(*march.go(self.size), self.asked)
        if motion.outcome is not Status.OK:
            return _PassedRound(motion, {})
        found = cycle_figures(motion)
        names = ("period", "velocity_max", "velocity_min", "handoff_velocity")
        return _PassedRound(motion, {name: found[name] for name in names})

    def hurry(self, factor: float) -> None:
        """Multiply both speeds."""
        self.march.state[2:4] *= factor


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit with compliant contact; see `escapement.terminal`."""
    cycle = _Cycle(escapement, initial_speed, rtol)
    # between walls that yield a body may turn back, and then any train with an efficiency loses
    scene = escapement.scene
    lossless = is_lossless(scene) and scene.dwell == 0.0 and not as_python(is_lossy)(scene)
    joint = cycle.march.joint
    if lossless and joint.damping == 0.0 and not joint.hertz:
        status = Status.NO_TERMINAL
        return replace(base, status=status, message=MESSAGES[status])
    tolerance = max(10.0 * rtol, _NOISE)
    speeds: list[float] = []
    last: dict[str, float] = {}
    for count in range(SETTLE):
        passed = cycle.engage()
        if passed.motion.outcome is not Status.OK:
            return replace(base, status=passed.motion.outcome, message=passed.motion.message)
        numbers = passed.numbers
        # if the mechanism jams, the least speed is almost zero and says little by itself
        scales = {"velocity_min": numbers["velocity_max"]}
        changes = [abs(numbers[n] - last[n]) / scales.get(n, last[n]) for n in last]
        if last and max(changes) <= tolerance:
            return _repeated(escapement, cycle, base, initial_speed, rtol)
        last = numbers
        speeds.append(numbers["handoff_velocity"])
        if count % 4 == 3 and (extrapolated := _limit(speeds[-3:])) > 0.0:
            cycle.hurry(extrapolated / speeds[-1])
        if cycle.march.clock["tries"][0] > 0.4 * MOST_TRIES:
            break
    return _spread(cycle, base)


def _limit(speeds: list[float]) -> float:
    """Limit of three handoff speeds that approach it slowly as a geometric series, else 0."""
    one, two, three = (speed * speed for speed in speeds)
    ratio = (three - two) / (two - one) if two != one else 0.0
    if not 0.3 < abs(ratio) < 0.999:
        return 0.0
    return math.sqrt(max(three + (three - two) * ratio / (1.0 - ratio), 0.0))


def _repeated(
    escapement: Escapement, cycle: _Cycle, base: Figures, initial_speed: float, rtol: float
) -> Figures:
    """Figures of a cycle that repeats itself, and of the transient before it."""
    passed = cycle.engage()
    end = cycle.march.state[:STATE].copy()
    speed = passed.numbers["handoff_velocity"]
    nudge = 1e-3
    cycle.hurry(1.0 + nudge)
    moved = cycle.engage().numbers.get("handoff_velocity", speed)
    cycle.march.state[:] = end
    contraction = ((moved / speed) ** 2 - 1.0) / ((1.0 + nudge) ** 2 - 1.0)
    settings: dict[str, Any] = {"initial_speed": initial_speed, "rtol": rtol}

    def follow(count: int) -> Motion:
        return simulate(escapement, engagements=count, duration=None, **settings)

    if note := _jam_note(passed.motion):
        base = replace(base, message=note)
    return read_figures(base, passed.motion, contraction, initial_speed, follow, _LONGEST_TRANSIENT)


def _spread(cycle: _Cycle, base: Figures) -> Figures:
    """Means of engagements that do not repeat themselves."""
    passed: list[_PassedRound] = []
    while len(passed) < SAMPLE:
        one = cycle.engage()
        if one.motion.outcome is not Status.OK:
            if one.motion.outcome is Status.NOT_CONVERGED and len(passed) >= 2 * BATCHES:
                # the steps are used up, and these engagements are enough
                break
            return replace(base, status=one.motion.outcome, message=one.motion.message)
        passed.append(one)
    count, last = len(passed) // BATCHES * BATCHES, passed[-1].motion
    rows = [one.numbers for one in passed[:count]]
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    means: dict[str, Any] = {name: float(column.mean()) for name, column in columns.items()}
    spread = batch_spread(columns, cycle.size)
    share = spread.interval["period"] / means["period"]
    message = (
        f"the engagements do not repeat themselves: the period and the velocities are means over "
        f"{spread.engagements} of them, the period with a relative error of at most {share:.2g} "
        "(95 %); all other figures are those of the last engagement"
    )
    cell = last.escapement.mechanism.cell_angle
    if note := _jam_note(last):
        message = f"{message}; {note}"
    means["velocity_mean"] = cell / means["period"]
    return replace(base, **means, motion=last, spread=spread, message=message)


def _jam_note(motion: Motion) -> str:
    """Where, and for how long, an engagement beyond the Painleve limit jams; "" below it."""
    escapement, limit = motion.escapement, friction_limits(motion.escapement)[0]
    if escapement.friction < limit:
        return ""
    above = f"friction {escapement.friction:g} is above the Painleve limit {limit:.6g}"
    found = jams(motion)
    angles = [f"{angle:.2f}" for angle in np.degrees(found.angle)]
    if not angles:
        return f"{above}, but it does not jam"
    return (
        f"{above}: the mechanism jams {', '.join(angles)} degrees from dead centre for "
        f"{found.duration.sum():.2g} s in all"
    )
