"""The figures of merit as dual numbers: each with its derivatives by the model's parameters."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from escapement import painleve, simulation
from escapement.mechanism import FloatArray
from escapement.mechanisms import slotted
from escapement.merits import FIGURES
from escapement.metrics import Figures
from escapement.model import Escapement
from escapement.tolerance.contraction import contraction
from escapement.tolerance.dual import Dual, uncompiled
from escapement.tolerance.extremes import extreme
from escapement.tolerance.law import ANGLE, SPEED, Law
from escapement.tolerance.variation import Variation

SHALLOW = 1e-6
"""Deviations below this share of the first one have too few digits for a derivative."""
VANISHED = 1e-9
"""If the lever of the contact force, over the crank radius, is below this at a limit of friction,
the limit is set by the lever."""
LONGEST = 2000
"""Greatest number of engagements that are followed for the rise times."""


def figures_of(
    escapement: Escapement, figures: Figures, names: tuple[str, ...], cycle_only: bool = False
) -> tuple[dict[str, Dual], str]:
    """The figures [SI] as dual numbers, and a message about those that are missing.

    Their slopes are the derivatives by the parameters in `names`.
    """
    law = Law(escapement, names)
    varied = Variation(figures.motion, law)  # type: ignore[arg-type]
    end = varied.boundaries[-1]
    # the cycle closes where S behind its last handoff is S at its start
    first = end.behind[:-1] / (1.0 - end.behind[-1])

    def closed(columns: FloatArray) -> FloatArray:
        return np.asarray(columns[..., :-1] + columns[..., -1:] * first)

    clock, torque = law.plain(law.clock()), law.plain(law.values["torque"])
    length = law.plain(law.values["crank_radius"]) if "crank_radius" in names else None
    starts = [b for b in varied.boundaries if varied.begins(b.piece)]
    instants = [Dual(b.time, closed(b.instant)) for b in starts]
    beats = [b - a for a, b in pairwise(instants)]
    found: dict[str, Any] = {"period": (instants[-1] - instants[0]) / len(beats) * clock}

    def most(quantity: Callable[[Any], Any], sign: float = 1.0) -> Dual:
        value, slopes = extreme(varied, quantity, sign)
        return Dual(value, closed(slopes))

    fastest, slowest = (np.sqrt(most(lambda p: p.w, s)) / clock for s in (1.0, -1.0))
    handoff = np.sqrt(Dual(end.w_behind, closed(end.total_behind)))
    found |= {
        "velocity_max": fastest,
        "velocity_min": slowest,
        "velocity_mean": escapement.mechanism.cell_angle / found["period"],
        "velocity_average_published": 0.5 * (fastest + slowest),
        "handoff_velocity": handoff / clock,
        "contraction": contraction(varied, first),
        "acceleration_max": most(lambda p: abs(p.acceleration)) / clock**2.0,
        "follower_acceleration_max": most(lambda p: abs(p.follower_acceleration)) / clock**2.0,
        "contact_moment_max": most(lambda p: abs(p.moment)) * torque,
    }
    if length is not None:
        found["contact_force_max"] = most(lambda p: abs(p.force)) * torque / length
    reversals = [b for b in varied.boundaries if varied.reverses(b.piece)]
    if reversals:
        last = int(np.argmax(figures.reversal_angles))
        found["last_reversal_angle"] = Dual(
            figures.last_reversal_angle, closed(reversals[last].angle)
        )
    if law.parts:
        ordered = sorted(beats, key=float)
        found["beat_error"] = (ordered[-1] - ordered[0]) * clock
        found["blow_max"] = max((_blow(varied, b, closed) for b in starts[1:]), key=float) * torque
    if cycle_only:
        return found, ""
    for name in ("critical_friction", "uniqueness_friction"):
        limit = _limit(escapement, getattr(figures, name), names, name.startswith("u"))
        if limit is not None:
            found[name] = limit
    if "critical_friction" in found:
        found["jam_margin"] = 1.0 - law.plain(law.values["friction"]) / found["critical_friction"]
    rises, note = _rises(escapement, figures, law, found["handoff_velocity"], clock)
    order = [name for name in FIGURES if name in found or name in rises]
    return {name: (found | rises)[name] for name in order}, note


def _blow(varied: Variation, boundary: Any, closed: Any) -> Dual:
    """Energy lost in the blow at a handoff, in natural units."""
    law, meeting = varied.law, varied.next_meeting(boundary.piece)
    left = law.plain(law.blow(meeting)) if law.parts[meeting].strikes else None
    if left is None:
        return Dual(0.0, np.zeros(len(law.names)))
    scene = law.scenes[meeting]
    ratio = law.plain(uncompiled(slotted)["pose_at"](scene.path, scene.edges[0])[0])
    w = Dual(boundary.w_before, closed(boundary.total_before))
    rho = law.plain(scene.rho)
    lost: Dual = 0.5 * w * (rho - (rho + ratio * ratio) * left * left)
    return lost


def _limit(
    escapement: Escapement, limit: float, names: tuple[str, ...], before: bool
) -> Dual | None:
    """A Painleve limit, or None if it has no derivatives.

    At this friction either the least margin J h of one half of the engagement vanishes, or the
    lever h of the contact force. `before` chooses the half before dead centre.
    """
    from scipy.optimize import brentq

    if not 0.0 < limit < math.inf or "friction" not in names:
        return None
    law = Law(replace(escapement, friction=limit), names)
    margin, lever = (uncompiled(painleve)[name] for name in ("margin", "least_lever"))
    best: tuple[float, Any] = (math.inf, None)
    for place, scene in enumerate(law.scenes):
        edges = law.escapement.scenes[place].edges
        low, high = (edges[0], 0.0) if before else (0.0, edges[-1])

        def rising(angle: float, scene: Any = scene) -> float:
            return float(margin(law.seeded(angle, ANGLE), scene).slopes[ANGLE])

        grid = np.linspace(low, high, 2001)
        least = [float(painleve.margin(x, law.escapement.scenes[place])) for x in grid]
        k = int(np.argmin(least))
        low, high = grid[max(k - 1, 0)], grid[min(k + 1, 2000)]
        angle = grid[k]
        if rising(low) < 0.0 < rising(high):
            angle = brentq(rising, low, high, xtol=1e-15)
        if least[k] < best[0]:
            best = least[k], margin(law.seeded(angle, ANGLE), scene)
        own = lever(scene, law.exit_of(place))
        if abs(float(own)) < min(best[0], VANISHED):
            best = float(own), own
    found = best[1].slopes[:SPEED]
    friction = names.index("friction")
    slopes = -found / found[friction]
    slopes[friction] = 0.0
    return Dual(limit, slopes)


def _rises(
    escapement: Escapement, figures: Figures, law: Law, handoff: Dual, clock: Dual
) -> tuple[dict[str, Dual], str]:
    """`rise_time_63` and `rise_time_98`, and "done" or the reason why they are missing."""
    late = figures.rise_time_98
    if not late > 0.0:
        return {}, "there are no rise times here, so they have no derivatives"
    count = len(escapement.meetings)
    long = simulation.simulate(escapement, duration=late * (1.0 + 1e-9))
    wanted = count * (1 + long.handoff_times.size // count)
    if wanted > LONGEST:
        return {}, f"the rise times take more than {LONGEST} engagements: no derivatives"
    motion = simulation.simulate(escapement, wanted)
    varied = Variation(motion, law)
    rounds = [b for b in varied.boundaries[1:] if varied.begins(b.piece)][count - 1 :: count]
    deviations, times = [abs(handoff)], [0.0 * clock]
    for boundary in rounds:
        speed = np.sqrt(Dual(boundary.w_behind, boundary.total_behind[:-1])) / clock
        deviations.append(abs(speed - handoff))
        times.append(Dual(boundary.time, boundary.instant[:-1]) * clock)
    shares = [d / deviations[0] for d in deviations]
    depth = [-np.log(x) for x in shares if float(x) > SHALLOW]
    found = {}
    for name, level in (("rise_time_63", 1.0), ("rise_time_98", -math.log(0.02))):
        k = next((k for k, d in enumerate(depth) if float(d) >= level), 0)
        if k:
            share = (level - depth[k - 1]) / (depth[k] - depth[k - 1])
            found[name] = times[k - 1] + share * (times[k] - times[k - 1])
    if len(found) < 2:
        return found, "the speed settles within one cycle, so rise times have no derivatives"
    return found, "done"
