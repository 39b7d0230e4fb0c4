"""A run of many engagements by quasi-static theory.

Where the torque hardly changes within the engagements in which a disturbance dies out, the period
depends on the driver angle turned alone, and smoothly. It is sampled at some places, each by a few
engagements of the full law that begin with the terminal speed of the torque there. The series
through the samples gives all periods between the start and the stop; both of these are computed
engagement by engagement. Other places tell how far the series can be trusted.

Times the root of the torque, the period is nearly constant: without a load it is so exactly.
"""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from escapement.chebyshev import Series, interpolate, nodes
from escapement.model import Escapement, FloatArray
from escapement.motion import Motion
from escapement.simulation import simulate, terminal
from escapement.status import Status
from escapement.torque_curve import TorqueCurve

_FORGOTTEN = 1e-13
"""A disturbance is over when it has shrunk to this share."""
_LATE = 0.05
"""Share of the run before its stop that is computed one by one."""
_ORDER = 24
"""Places at which the period is sampled."""
_CHECKS = 7
"""Further places, at which the series is compared with the full law."""
_SAFETY = 4.0
"""Stated error over the greatest difference at those places."""
_NARROW = 1e-3
"""Of the torque: so closely the least one is found that keeps the timer running."""


class Timer(NamedTuple):
    """What runs down, its driver speed at the start [rad/s], and the relative error asked for."""

    escapement: Escapement
    initial_speed: float
    rtol: float | None

    @property
    def cell(self) -> float:
        """Driver angle of an engagement [rad]."""
        return float(self.escapement.mechanism.cell_angle)

    @property
    def spent(self) -> float:
        """Driver angle from which on there is no torque [rad]; infinite where there always is."""
        curve = self.escapement.curve
        if curve is None or curve.periodic or curve.torque[-1] > 0.0:
            return math.inf
        last = max(k for k, torque in enumerate(curve.torque) if torque > 0.0)
        return float(curve.angle[last + 1])

    def after(self, turned: float) -> Escapement:
        """The escapement once its driver has turned by an angle [rad]."""
        torque: Any = self.escapement.torque
        return replace(self.escapement, torque=torque - self.escapement.spring_rate * turned)

    def settled(self, turned: float, engagements: int, settle: int) -> Motion:
        """Motion on which no disturbance is left when the driver has turned by an angle [rad].

        It begins `settle` engagements earlier with the terminal speed of the torque there.
        """
        early = turned - settle * self.cell
        speed = terminal(self.after(early).held).handoff_velocity
        return simulate(
            self.after(early), settle + engagements, initial_speed=speed, rtol=self.rtol
        )

    def least_torque(self) -> float:
        """Torque below which there is no terminal cycle [N m]."""
        low, high = 0.0, self.escapement.torque_unit
        while high - low > _NARROW * self.escapement.torque_unit:
            middle = 0.5 * (low + high)
            trial = replace(self.escapement, torque=middle, spring_rate=0.0)
            runs = terminal(trial).status is Status.OK
            low, high = (low, middle) if runs else (middle, high)
        return low


class Course(NamedTuple):
    """When each engagement of a run ends, and the motion that ends the run.

    times : shape (n,) [s], beyond the goal where that was passed.
    last : the last motion, which begins at the time `shift` [s] once the driver has turned by
        `before` [rad].
    uncertainty : greatest error of a time [s]; None where every engagement was computed.
    """

    times: FloatArray
    last: Motion
    before: float
    shift: float
    uncertainty: float | None


def sampled(timer: Timer, count: int, contraction: float) -> Course | None:
    """A run of at most `count` engagements, or None where a disturbance dies out too slowly.

    Parameters
    ----------
    timer : Timer
    count : int
        Engagements.
    contraction : float
        Factor by which one engagement shrinks a disturbance at the torque of the start [-].
    """
    torque, rate, late = timer.escapement.torque, timer.escapement.spring_rate, count
    if isinstance(torque, TorqueCurve):
        # behind each of its points a disturbance dies out anew
        return None
    if rate > 0.0:
        stop = (torque - timer.least_torque()) / rate
        late = min(count, int((1.0 - _LATE) * stop / timer.cell))
        # the weaker the spring, the more slowly a disturbance may die out
        contraction = max(contraction, terminal(timer.after(late * timer.cell).held).contraction)
    if not 0.0 <= contraction < 1.0 or late < 1:
        return None
    settle = 3 + math.ceil(math.log(_FORGOTTEN) / math.log(max(contraction, 1e-100)))
    head = 2 * settle
    if 2 * head > late:
        return None

    def root(turned: FloatArray) -> FloatArray:
        """Root of the torque in the middle of an engagement."""
        return np.asarray(np.sqrt(torque - rate * (turned + 0.5 * timer.cell)))

    def scaled(turned: FloatArray) -> FloatArray:
        """Period of the engagement after an angle turned, times that root."""
        ends = [timer.settled(angle, 1, settle).handoff_times[-2:] for angle in turned.tolist()]
        return np.diff(ends)[:, 0] * root(turned)

    edges: FloatArray = timer.cell * np.array([head, late], dtype=float)
    series = Series(edges, interpolate(scaled(nodes(edges[:1], edges[1:], _ORDER)[0])[None, :]))
    places = np.asarray(np.linspace(edges[0], edges[1], _CHECKS + 2)[1:-1], dtype=float)
    apart = float(np.abs(series(places) / scaled(places) - 1.0).max())
    start = {"initial_speed": timer.initial_speed, "rtol": timer.rtol}
    first = simulate(timer.escapement, head, **start)  # type: ignore[arg-type]
    turned: FloatArray = timer.cell * np.arange(head, late, dtype=float)
    middle = first.end_time + np.cumsum(series(turned) / root(turned))
    last = timer.settled(late * timer.cell, max(count - late, 1), settle)
    shift = float(middle[-1] - last.handoff_times[settle - 1])
    times = np.concatenate([first.handoff_times, middle, last.handoff_times[settle:] + shift])
    uncertainty = _SAFETY * apart * float(middle[-1] - first.end_time)
    return Course(times, last, (late - settle) * timer.cell, shift, uncertainty)
