"""A motion as the page plays it: polynomials in time that are within 1e-10 of the exact motion.

Within a piece everything is analytic in time. Each piece is cut until polynomials through
Chebyshev points follow the states; both its ends are among the points, so that jumps stay jumps.
"""

import base64
from typing import Any

import numpy as np

from escapement.base import validate
from escapement.base.text import plain
from escapement.dynamics.figure_table import FIGURES
from escapement.dynamics.figures_of_merit import Figures
from escapement.dynamics.motion import Motion
from escapement.dynamics.painleve import painleve_limit
from escapement.engines import simulate as simulation
from escapement.explorer.bodies import bodies_of
from escapement.mechanisms.protocol import FloatArray

DEGREE = 16
"""Degree of the polynomials, the same as in `polynomial.js`."""
COLUMNS = ("theta", "theta_dot", "phi", "phi_dot", "contact_moment")
"""Columns of a motion that are played, in this order."""
MOST_SPANS = 20_000
"""A browser does not draw more spans."""
FINE = {"contact": np.array([1e-8, 1e-7, 1e-8, 1e-7, 1e-4])}
"""Greatest error of the polynomials, as a share of each column's greatest value, by engine."""
_DEEPEST = 12  # halvings of a piece
_NOISE = 0.5
_POINTS = -np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)
_TO_LAST = np.linalg.inv(np.polynomial.chebyshev.chebvander(_POINTS, DEGREE))[-2:]


def played(motion: Motion, figures: Figures | None = None) -> dict[str, Any]:
    """A motion, its events, figures and bodies as types that JSON has.

    Parameters
    ----------
    motion : Motion
        A motion of any engine, or one read from a file.
    figures : Figures, optional
        Figures of its terminal cycle. Default: no figures are shown.

    Raises
    ------
    InvalidValue
        If the motion has more than 20 000 spans, which a browser would not draw.
    """
    mechanism = motion.escapement.mechanism
    drawn = bodies_of(mechanism)
    start, speed = float(mechanism.breaks[0]), 0.0
    spans = {"start": _packed([]), "stop": _packed([]), "side": [], "engagement": []}
    values = np.empty((0, len(COLUMNS), DEGREE + 1))
    if motion.end_time > 0.0:
        pieces, first, last, values = _spans(motion)
        spans = {"start": _packed(first), "stop": _packed(last)}
        spans["side"] = motion.trajectory.sign[pieces].astype(int).tolist()
        spans["engagement"] = motion.trajectory.engagement[pieces].tolist()
        speed = float(values[0, 1, 0])
    record = {
        "status": motion.status.label,
        "message": motion.message,
        "engine": motion.engine,
        "end_time": motion.end_time,
        "initial_speed": speed,
        "handoff_times": motion.handoff_times,
        "handoff_velocities": motion.handoff_velocities,
        "entry": start,
        "cell": mechanism.cell_angle,
        "events": _events(motion),
        "spans": spans | {"values": _packed(values)},
        "figures": {} if figures is None else _figures(motion, figures),
        "design": {
            "friction": motion.escapement.friction,
            "spring_rate": motion.escapement.spring_rate,
            "crank_radius": mechanism.crank_radius,
        },
        "drawn": drawn,
    }
    record["touching"] = touching = mechanism.pitch is not None
    record["meshed"] = not (mechanism.slots or touching)
    found: dict[str, Any] = plain(record)
    return found


def _spans(motion: Motion) -> tuple[np.ndarray, FloatArray, FloatArray, FloatArray]:
    """Pieces, starts and stops of the spans, and values (span, column, point)."""
    begin = motion.trajectory.start
    ends = np.append(begin[1:], motion.end_time)
    pieces = np.flatnonzero(ends > begin)
    low, high = begin[pieces], ends[pieces]
    found: list[tuple[np.ndarray, FloatArray, FloatArray, FloatArray]] = []
    fine = FINE.get(motion.engine, 1e-10)
    scale, before = np.full(len(COLUMNS), 1e-300), np.full((pieces.size, len(COLUMNS)), np.inf)
    for depth in range(_DEEPEST + 1):
        times = low[:, None] + 0.5 * (high - low)[:, None] * (1.0 + _POINTS)
        times[:, -1] = high
        state = motion.within(np.broadcast_to(pieces[:, None], times.shape), times)
        values = np.stack([getattr(state, name) for name in COLUMNS], axis=1)
        if depth == 0:
            scale = np.maximum(np.abs(values).max(axis=(0, 2)), scale)
        rest = np.abs(values @ _TO_LAST.T).sum(axis=2)
        # an error that a halving hardly reduces is the noise of the engine
        rough = ((rest > fine * scale) & ((rest < _NOISE * before) | (depth < 4))).any(axis=1)
        rough &= depth < _DEEPEST
        found.append((pieces[~rough], low[~rough], high[~rough], values[~rough]))
        if sum(one[0].size for one in found) + 2 * rough.sum() > MOST_SPANS:
            raise validate.fail(
                "motion", f"of at most {MOST_SPANS} spans to be played", "more",
                "play fewer engagements",
            )  # fmt: skip
        if not rough.any():
            break
        middle = 0.5 * (low[rough] + high[rough])
        low, high = np.append(low[rough], middle), np.append(middle, high[rough])
        pieces, before = np.tile(pieces[rough], 2), np.tile(rest[rough], (2, 1))
    columns = [np.concatenate(parts) for parts in zip(*found, strict=True)]
    order = np.lexsort((columns[1], columns[0]))
    pieces, low, high, values = (column[order] for column in columns)
    return pieces, low, high, values


def _events(motion: Motion) -> list[dict[str, Any]]:
    """Kinds and times of all events, ascending in time."""
    if not motion.end_time > 0.0:
        return []
    extrema = motion.extrema
    kinds = {
        "handoff": motion.handoff_times,
        "reversal": motion.reversals.time,
        "maximum": extrema.time[extrema.maximum.astype(bool)],
        "minimum": extrema.time[~extrema.maximum.astype(bool)],
        "slide change": motion.slide_changes.time,
        "blow": motion.impacts.time,
    }
    if motion.status.failed:
        kinds["stop"] = np.array([motion.end_time])
    rows = [{"kind": kind, "time": float(time)} for kind, times in kinds.items() for time in times]
    return sorted(rows, key=lambda row: float(row["time"]))


def _figures(motion: Motion, figures: Figures) -> dict[str, Any]:
    """Figures of merit, their status, and the angle at which an ideal pin jams first."""
    escapement = motion.escapement
    every = {name: getattr(figures, name) for name in FIGURES}
    # JSON has no infinity
    found: dict[str, Any] = {k: "Infinity" if v == np.inf else v for k, v in every.items()}
    found |= {"status": figures.status.label, "message": figures.message}
    mechanism = escapement.mechanism
    if mechanism.slots and not mechanism.contact_radius:
        inertia = escapement.without_trains.inertia
        rho, (entry, *_, exit_) = inertia.driver / inertia.follower, mechanism.breaks
        # the limit is the same on both sides of dead centre, and it is met behind it
        found["critical_angle"] = abs(float(painleve_limit(mechanism.path, rho, entry, exit_)[1]))
    return found


def cycle_of(motion: Motion) -> Figures:
    """Figures of the terminal cycle of a motion's escapement."""
    speed = float(motion.at(0.0).theta_dot) if motion.end_time > 0.0 else 0.0
    return simulation.terminal(motion.escapement, initial_speed=speed)


def _packed(values: Any) -> str:
    """Doubles as text: exact, and shorter than their digits."""
    return base64.b64encode(np.ascontiguousarray(values, "<f8").tobytes()).decode()
