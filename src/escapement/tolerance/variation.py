"""First-order change of a motion with the numbers of the model.

Let w = theta_dot^2 as a function of the driver angle, and S its derivative by a number q at a
fixed angle. Between events

    dw/dtheta = f(theta, w; q),          dS/dtheta = f_w S + f_q,

where f is smooth. At an event, where Phi(theta, w; q) = 0, its angle and S change by

    theta_q = -(Phi_q + Phi_w S)/(Phi_theta + Phi_w f),
    S_behind = S_before + (f_before - f_behind) theta_q,

and an impact that leaves the share L of the speed multiplies w by L^2. The time of a stretch
changes by the integral of -S/(2 w) over the time, and by theta_q/theta_dot at its ends. Along a
known motion all of it is linear in S, so that quadratures of the equation give the derivatives to
rounding. They are taken over the time, in which a start from rest is smooth too.

Columns: one for each number, and a last one for a change of w at the start by 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from itertools import groupby
from operator import attrgetter
from typing import Any

import numpy as np

from escapement.dynamics.motion import Motion
from escapement.mechanisms.protocol import FloatArray
from escapement.numerics.gauss import CUMULATE, WEIGHTS
from escapement.tolerance.dual import slopes_of, value_of
from escapement.tolerance.dual_law import ANGLE, SPEED, Law, Point
from escapement.tolerance.time_panels import Panel, resolved


@dataclass(frozen=True)
class Boundary:
    """The event with which a piece begins, or with which the motion ends.

    piece : index of the piece that begins; their number at the end.
    time : [natural units].
    angle : theta_q, shape (columns,).
    before, behind : S on either side.
    times : derivative of the time at a fixed angle after it.
    w_before, w_behind, slope_before, slope_behind : w and dw/dtheta on either side.
    """

    piece: int
    time: float
    angle: FloatArray
    before: FloatArray
    behind: FloatArray
    times: FloatArray
    w_before: float
    w_behind: float
    slope_before: float
    slope_behind: float

    @property
    def instant(self) -> FloatArray:
        """Derivative of the time at which it happens, shape (columns,)."""
        return self.times + self.angle / np.sqrt(self.w_behind) if self.angle.any() else self.times

    @property
    def total_before(self) -> FloatArray:
        """Derivative of w just before the event."""
        return self.before + self.slope_before * self.angle

    @property
    def total_behind(self) -> FloatArray:
        """Derivative of w just after the event."""
        return self.behind + self.slope_behind * self.angle


class Variation:
    """Derivatives along a motion.

    panels, boundaries : in the order of time.
    """

    def __init__(self, motion: Motion, law: Law) -> None:
        self.motion, self.law = motion, law
        self.clock = motion.escapement.time_unit
        self.columns = len(law.names) + 1
        trajectory = motion.trajectory
        self.sides = trajectory.sign.tolist()
        self.engagements = trajectory.engagement.tolist()
        self.times = np.append(trajectory.start, motion.end_time) / self.clock
        self.panels: list[Panel] = []
        self.boundaries: list[Boundary] = []
        # from rest the angles of the first piece are counted from a start that moves
        self.start = np.zeros(len(law.names))
        self._follow()

    def pair(self, piece: int) -> int:
        """Index in the pattern of a piece's engagement."""
        return int(self.engagements[piece] % len(self.law.scenes))

    def state(self, piece: int, time: Any) -> tuple[Any, Any]:
        """Driver angle in the cell and w at times within a piece."""
        times = np.clip(np.atleast_1d(time), *self.times[piece : piece + 2]) * self.clock
        angle, speed = self.motion.trajectory.states(np.full(times.size, piece), times)
        return angle, (speed * self.clock) ** 2

    @cached_property
    def sampled(self) -> list[tuple[list[Panel], FloatArray, Point]]:
        """The panels of each piece, the times of their points, and the law there."""
        found = []
        for piece, group in groupby(self.panels, attrgetter("piece")):
            panels = list(group)
            times = np.concatenate([panel.times for panel in panels])
            found.append((panels, times, self.point(piece, times)))
        return found

    def point(self, piece: int, time: Any) -> Point:
        """The law at a time within a piece, one-sided at its ends."""
        angle, w = (x.reshape(np.shape(time)) for x in self.state(piece, time))
        angle_here, speed = self.law.state(angle, w)
        if piece == 0 and self.start.any():
            angle_here.slopes[..., :SPEED] += self.start
        signs = self.signs[piece]
        return self.law.at(self.pair(piece), self.sides[piece], angle_here, speed, *signs)

    @cached_property
    def signs(self) -> list[tuple[float, float]]:
        """The signs of the sliding speed and of g in each piece, at whose ends they may vanish."""
        found = []
        for piece, side in enumerate(self.sides):
            signs = 0.0, 0.0
            if side != 0.0 and not self.law.scenes[0].path.table:
                middle = self.times[piece : piece + 2].mean()
                angle, w = (x[0] for x in self.state(piece, middle))
                here = self.law.at(self.pair(piece), side, *self.law.state(angle, w))
                signs = float(np.sign(here.slide.value)), float(np.sign(here.pose[0].value))
            found.append(signs)
        return found

    def total(self, value: Any, s: FloatArray, moved: FloatArray, slope: float) -> FloatArray:
        """Derivative of a dual at an event whose angle moves; `slope` is dw/dtheta."""
        found = slopes_of(value, self.law.count)
        row = np.append(found[..., :SPEED], 0.0)
        change: FloatArray = (
            row + found[..., SPEED] * (s + slope * moved) + found[..., ANGLE] * moved
        )
        return change

    def _follow(self) -> None:
        s, times = np.zeros(self.columns), np.zeros(self.columns)
        s[-1] = 1.0
        with np.errstate(divide="ignore", invalid="ignore"):  # viscous drag from rest
            moved, start = self._moved(0), self.point(0, self.times[0])
            rate = start.acceleration
        w, slope = float(start.w), 2.0 * float(rate)
        if w == 0.0:
            self.start, moved = moved[:-1], np.zeros(self.columns)
        elif moved.any():
            times = -moved / np.sqrt(w)
        self.boundaries.append(Boundary(0, self.times[0], moved, s, s, times, w, w, slope, slope))
        for piece in range(len(self.sides)):
            s, times = self._along(piece, s, times)
            if piece == 0 and self.start.any():
                s, times = self._from_start(s, times)
            self.boundaries.append(self._cross(piece + 1, s, times))
            s, times = self.boundaries[-1].behind, self.boundaries[-1].times

    def _cross(self, piece: int, s: FloatArray, times: FloatArray) -> Boundary:
        """The event with which a piece begins, or with which the motion ends."""
        time = self.times[piece]
        before = self.point(piece - 1, time)
        slope, w = 2.0 * float(before.acceleration), float(before.w)
        moved = self._moved(piece)
        if (condition := self._condition(piece, before)) is not None:
            found = condition.slopes
            rising = found[ANGLE] + found[SPEED] * slope
            moved = -(np.append(found[:SPEED], 0.0) + found[SPEED] * s) / rising
        after, left = self._behind(piece, before)
        share, later = float(left), 2.0 * float(after.acceleration)
        total = share**2 * (s + slope * moved)
        total[:-1] += 2.0 * w * share * slopes_of(left, self.law.count)[:SPEED]
        behind = total - later * moved
        times = times + moved * (1.0 - 1.0 / share) / np.sqrt(w)
        ends = w, share**2 * w, slope, later
        return Boundary(piece, time, moved, s, behind, times, *ends)

    def _from_start(self, s: FloatArray, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """S and the time at a fixed angle, from those at a fixed angle from a start that moves."""
        end, moved = self.point(0, self.times[1]), np.append(self.start, 0.0)
        s = s - 2.0 * float(end.acceleration) * moved
        times = times - moved / np.sqrt(float(end.w))
        self.start = np.zeros_like(self.start)
        return s, times

    def begins(self, piece: int) -> bool:
        """Whether a piece begins an engagement; after the last one a motion ends with one."""
        engagements = self.engagements
        return piece in (0, len(engagements)) or engagements[piece] != engagements[piece - 1]

    def reverses(self, piece: int) -> bool:
        """Whether a piece begins with a pin reversal."""
        if self.begins(piece) or self.sides[piece] == 0.0:
            return False
        return bool(self.sides[piece] != self.sides[piece - 1])

    def _moved(self, piece: int) -> FloatArray:
        """theta_q at an event that is moved only by errors of parts."""
        moved, law = np.zeros(self.columns), self.law
        if not law.parts:
            return moved
        if self.begins(piece):
            angle = law.parts[self.next_pair(piece)].starts
        elif self.sides[piece] == 0.0:
            angle = law.parts[self.pair(piece)].leaves
        else:
            return moved
        moved[:-1] = slopes_of(angle, law.count)[:SPEED]
        return moved

    def next_pair(self, piece: int) -> int:
        """Index in the pattern of the engagement that a piece begins, or that follows the last."""
        if piece < len(self.engagements):
            return self.pair(piece)
        return int((self.engagements[-1] + 1) % len(self.law.scenes))

    def _behind(self, piece: int, before: Point) -> tuple[Point, Any]:
        """The law after an event, and the share of the speed that its impact leaves."""
        if not self.begins(piece):
            return self.point(piece, self.times[piece]), 1.0
        if not self.law.parts:
            end = len(self.sides)
            return (self.point(piece, self.times[piece]) if piece < end else before), 1.0
        pair = self.next_pair(piece)
        left = self.law.impact(pair)
        w, begin = value_of(left) ** 2 * before.w.value, self.law.parts[pair].starts
        state = self.law.state(value_of(begin) - value_of(self.law.parts[pair].delay), w)
        return self.law.at(pair, 1.0, *state, -1.0, 1.0), left

    def _condition(self, piece: int, before: Point) -> Any:
        """The function that is zero at the event that begins a piece; None if it does not
        move."""
        if self.reverses(piece):
            return before.contact
        if self.begins(piece) or self.sides[piece] == 0.0:
            return None
        if before.scene.path.table:
            return None
        slide = before.slide
        return slide if abs(value_of(slide)) < 1e-9 else None

    def _along(self, piece: int, s: FloatArray, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """S and the time at the end of a piece."""
        ends = self.times[piece : piece + 2]
        for start, half, w, rate, source in resolved(self.law, partial(self.point, piece), ends):
            grown = rate @ CUMULATE * half
            driven = (np.exp(-grown)[:, None] * source).T @ CUMULATE * half
            at_points = np.exp(grown)[:, None] * (s + driven.T)
            self.panels.append(Panel(piece, start, half, w, at_points))
            times = times - 0.5 * half * (WEIGHTS / w) @ at_points
            end = half * (WEIGHTS @ rate)
            s = np.exp(end) * (s + half * (WEIGHTS * np.exp(-grown)) @ source)
        return s, times
