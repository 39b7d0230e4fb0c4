"""The figures of merit as dual numbers: each with its derivatives by the model's parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace
from itertools import cycle, pairwise
from typing import Any

import numpy as np

from escapement.dynamics import painleve
from escapement.dynamics.figure_table import FIGURES
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines import simulate as simulation
from escapement.mechanisms import slotted
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.tolerance.contraction import contraction
from escapement.tolerance.dual import Dual, uncompiled
from escapement.tolerance.dual_law import ANGLE, SPEED, Law
from escapement.tolerance.extremes import extreme
from escapement.tolerance.variation import Variation

SHALLOW = 1e-6
"""Deviations below this share of the first one have too few digits for a derivative."""
NEARBY = 1e-6
"""The angle at which a limit of friction is met is known to better than this [rad]."""
ROUNDING = 1e-12
"""Beats that differ by less than this share are equal."""
LONGEST = 2000
"""Greatest number of engagements that are followed for the rise times."""
LIMITS = {"critical_friction", "uniqueness_friction", "jam_margin"}
"""Figures that depend on friction and geometry, not on the motion."""


def figures_of(
    escapement: Escapement,
    figures: Figures,
    names: tuple[str, ...],
    wanted: Collection[str] = tuple(FIGURES),
) -> tuple[dict[str, Dual], str]:
    """The figures [SI] as dual numbers, and a message about those that are missing.

    Their slopes are the derivatives by the parameters in `names`. Figures that take long are
    computed only if they are `wanted`.
    """
    law = Law(escapement, names)
    varied = Variation(figures.motion, law)  # type: ignore[arg-type]
    end = varied.boundaries[-1]
    # the cycle closes where S behind its last handoff is S at its start
    first = end.behind[:-1] / (1.0 - end.behind[-1])

    def closed(columns: FloatArray) -> FloatArray:
        return np.asarray(columns[..., :-1] + columns[..., -1:] * first)

    clock, torque = law.plain(law.clock()), law.plain(law.values["torque"])
    length = law.plain(law.values["crank_radius"])
    starts = [b for b in varied.boundaries if varied.begins(b.piece)]
    instants = [Dual(b.time, closed(b.instant)) for b in starts]
    beats = [b - a for a, b in pairwise(instants)]
    found: dict[str, Any] = {"period": (instants[-1] - instants[0]) / len(beats) * clock}

    def most(quantity: Callable[[Any], Any], sign: float = 1.0) -> Dual:
        value, slopes = extreme(varied, quantity, sign)
        return Dual(value, closed(slopes))

    def speed(sign: float) -> Any:
        return np.sqrt(most(lambda p: p.w, sign)) / clock

    found["velocity_mean"] = escapement.mechanism.cell_angle / found["period"]
    handoffs: list[Any] = [
        np.sqrt(Dual(b.w_behind, closed(b.total_behind))) / clock for b in starts[1:]
    ]
    found["handoff_velocity"] = handoffs[-1]
    slow: dict[str, Callable[[], Any]] = {
        "velocity_max": lambda: speed(1.0),
        "velocity_min": lambda: speed(-1.0),
        "velocity_average_published": lambda: 0.5 * (speed(1.0) + speed(-1.0)),
        "contraction": lambda: contraction(varied, first),
        "acceleration_max": lambda: most(lambda p: abs(p.acceleration)) / clock**2.0,
        "follower_acceleration_max": lambda: (
            most(lambda p: abs(p.follower_acceleration)) / clock**2.0
        ),
        "contact_moment_max": lambda: most(lambda p: abs(p.moment)) * torque,
    }
    if float(length) > 0.0:
        slow["contact_force_max"] = lambda: most(lambda p: abs(p.force)) * torque / length
    found |= {name: make() for name, make in slow.items() if name in wanted}
    reversals = [b for b in varied.boundaries if varied.reverses(b.piece)]
    if reversals:
        last = int(np.argmax(figures.reversal_angles))
        found["last_reversal_angle"] = Dual(
            figures.last_reversal_angle, closed(reversals[last].angle)
        )
    if law.parts:
        ordered = sorted(beats, key=float)
        found["beat_error"] = _difference(ordered[0], ordered[-1]) * clock
        found["blow_max"] = (
            max((_impact(varied, b, closed) for b in starts[1:]), key=float) * torque
        )
    found |= limits_of(escapement, figures, names) if LIMITS & {*wanted} else {}
    note = ""
    if {*wanted} & {"rise_time_63", "rise_time_98"}:
        rises, note = _rises(escapement, figures, law, handoffs, clock)
        found |= rises
    return {name: found[name] for name in FIGURES if name in found}, note


def _difference(least: Dual, most: Dual) -> Dual:
    """The difference of two times, 0 where they are equal but for rounding."""
    found: Dual = most - least
    return found if float(found) > ROUNDING * float(most) else 0.0 * found


def limits_of(escapement: Escapement, figures: Figures, names: tuple[str, ...]) -> dict[str, Dual]:
    """The limits of friction and the margin to jamming, as duals by the numbers."""
    law, found = Law(escapement, names), {}
    for name in ("critical_friction", "uniqueness_friction"):
        limit = _limit(escapement, getattr(figures, name), names, name.startswith("u"))
        if limit is not None:
            found[name] = limit
    if "critical_friction" in found:
        found["jam_margin"] = 1.0 - law.plain(law.values["friction"]) / found["critical_friction"]
    return found


def _impact(varied: Variation, boundary: Any, closed: Any) -> Dual:
    """Energy lost in the impact at a handoff, in natural units."""
    law, pair = varied.law, varied.next_pair(boundary.piece)
    left = law.plain(law.impact(pair)) if law.parts[pair].strikes else None
    if left is None:
        return Dual(0.0, np.zeros(len(law.names)))
    scene = law.scenes[pair]
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

    if not 0.0 < limit < math.inf or escapement.scene.path.table:
        return None
    law = Law(
        replace(escapement, friction=limit), (*(n for n in names if n != "friction"), "friction")
    )
    margin, lever = (uncompiled(painleve)[name] for name in ("margin", "least_lever"))
    found = []
    for index, scene in enumerate(law.escapement.scenes):
        ends = (scene.edges[0], 0.0) if before else (0.0, scene.edges[-1])
        found.append((*painleve.friction_limit(scene, *ends), ends, index))
    _least, angle, (low, high), index = min(found)
    scene = law.scenes[index]

    def rising(angle: float) -> float:
        return float(margin(law.seeded(angle, ANGLE), scene).slopes[ANGLE])

    if math.isnan(angle):
        vanishing = lever(scene, law.exit_of(index))
    else:
        low, high = max(angle - NEARBY, low), min(angle + NEARBY, high)
        if rising(low) < 0.0 < rising(high):
            angle = brentq(rising, low, high, xtol=1e-15)
        vanishing = margin(law.seeded(angle, ANGLE), scene)
    moved = vanishing.slopes[:SPEED]
    slopes = dict(zip(law.names, -moved / moved[-1], strict=True)) | {"friction": 0.0}
    return Dual(limit, np.array([slopes[name] for name in names]))


def _rises(
    escapement: Escapement, figures: Figures, law: Law, ends: list[Dual], clock: Dual
) -> tuple[dict[str, Dual], str]:
    """`rise_time_63` and `rise_time_98`, and "done" or the reason why they are missing.

    `ends` has the speeds at the handoffs of the terminal cycle.
    """
    slow = figures.rise_time_98
    if not slow > 0.0:
        return {}, "there are no rise times here, so they have no derivatives"
    long = simulation.simulate(escapement, duration=slow * (1.0 + 1e-9))
    wanted = 1 + long.handoff_times.size
    if wanted > LONGEST:
        return {}, f"the rise times take more than {LONGEST} engagements: no derivatives"
    motion = simulation.simulate(escapement, wanted)
    varied = Variation(motion, law)
    handoffs = [b for b in varied.boundaries[1:] if varied.begins(b.piece)]
    deviations, times = [abs(ends[-1])], [0.0 * clock]
    for boundary, terminal in zip(handoffs, cycle(ends), strict=False):
        speed = np.sqrt(Dual(boundary.w_behind, boundary.total_behind[:-1])) / clock
        deviations.append(abs(speed - terminal))
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
