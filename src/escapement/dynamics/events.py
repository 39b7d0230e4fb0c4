"""The handoffs of a motion from pin to pin, and where the sliding of the contact reverses."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from escapement.dynamics.law import left_by_impact
from escapement.dynamics.trajectory import Events, Handoffs, NoTrajectory
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import slide_change, transmission, transmission_at
from escapement.model.escapement import Escapement
from escapement.model.scene import Scene

_NONE = np.array([np.nan])


def handoffs_of(escapement: Escapement, time: FloatArray, speed: FloatArray) -> Handoffs:
    """The handoffs at times [s], after which the driver has these speeds [rad/s]."""
    pairs, inertia = escapement.pairs, escapement.without_trains.inertia
    engagement = np.arange(1, speed.size + 1)
    # a column for each quantity that does not depend on the speed, of each engagement in turn
    rows = []
    for pair, scene in zip(pairs, escapement.scenes, strict=True):
        start = float(scene.edges[0])
        strikes = pair.kind == "strike"
        left = left_by_impact(scene) if strikes else 1.0
        ratio = transmission_at(scene.path, start)[0] if strikes else 0.0
        rows.append((start + pair.delay, left, ratio, pair.jump, pair.radius))
    start, left, ratio, jump, radius = np.array(rows).T[:, engagement % len(pairs)]
    before = speed / left
    lost = inertia.driver * before**2 - (inertia.driver + inertia.follower * ratio**2) * speed**2
    crank = escapement.mechanism.crank_radius or np.nan
    return Handoffs(
        engagement,
        time,
        engagement * escapement.mechanism.cell_angle + start,
        speed,
        kind=np.array([pair.kind for pair in pairs])[engagement % len(pairs)],
        speed_before=before,
        impulse=inertia.follower * ratio * speed,
        energy=np.where(left < 1.0, 0.5 * lost, 0.0),
        jump=jump,
        clearance_needed=np.where(jump > 0.0, crank * radius * jump, 0.0),
    )


def impacts_among(found: Handoffs) -> Handoffs:
    """The handoffs with an impact."""
    struck = found.kind == "strike"
    return Handoffs(*(getattr(found, field.name)[struck] for field in fields(Handoffs)))


def _slide_changes(scene: Scene, side: float) -> FloatArray:
    """Driver angles at which the contact point on a wall crosses the line of centres."""
    if scene.path.table:
        inside = scene.edges[1:-1]
        return np.append(inside[np.abs(transmission(scene.path, inside).u) < 1e-9], np.nan)
    entry, exit_ = scene.edges[0], scene.edges[-1]
    return np.array([slide_change(scene.path, scene.pin, side, entry, exit_)])


def slide_changes_of(motion: Any) -> Events:
    """Every instant at which the contact point crosses the line of centres."""
    trajectory, scenes = motion.trajectory, motion.escapement.scenes
    if trajectory.slide_changes is not None:
        return trajectory.slide_changes  # type: ignore[no-any-return]
    pieces = np.flatnonzero(np.diff(trajectory.engagement) == 0) + 1
    if scenes[0].path.meshed or pieces.size == 0:
        return NoTrajectory.reversals
    start = trajectory.start[pieces]
    found = motion.within(pieces, start)
    engagement, side = trajectory.engagement[pieces], trajectory.sign[pieces]
    which, delays = engagement % len(scenes), np.array([m.delay for m in motion.escapement.pairs])
    angle = found.theta - engagement * motion.escapement.mechanism.cell_angle - delays[which]
    changes = [{s: _slide_changes(scene, s) for s in (1.0, -1.0)} for scene in scenes]
    rows = [*zip(angle, side, which, strict=True)]
    here = [(np.abs(x - changes[k].get(s, _NONE)) < 1e-9).any() for x, s, k in rows]
    # at a reversal the other wall takes over, and the contact point changes, unless both are one
    both = [(np.abs(x - changes[k].get(-s, _NONE)) < 1e-9).any() for x, s, k in rows]
    kept = np.array(here) & ((side == trajectory.sign[pieces - 1]) | np.array(both))
    columns = engagement, start, found.theta, found.theta_dot
    return Events(*(column[kept] for column in columns))
