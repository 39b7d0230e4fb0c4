"""The unknowns of a fit of beats: how late each pin comes, and how late each slot is struck.

A pin that enters its slot behind the follower strikes it a little later, when it has caught up; a
pin that enters ahead of the follower picks it up at once, independent of the distance. Let slot i
stand ahead of slot i - 1 by the step d_i, and let the geometry allow the step free_i until there
is an impact. Then the impact comes late by about the driver angle x_i, with

    d_i = free_i + tan(pi/n) x_i^2/2     where x_i > 0, and d_i <= free_i where x_i = 0,

because g = 0 at the entry, with the slope tan(pi/n) per radian. Beats are smooth and almost
linear in psi and x, but contain a square root of d. Therefore psi and x are fitted; the exact
maps compute the beats from the steps, so that the series need not be accurate. The steps of all
slots add up to zero, and that of the `last` slot follows from the others.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.engines.simulate import terminal
from escapement.mechanisms import Geneva
from escapement.mechanisms.pattern import follower_angle_at
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.numerics.jit import as_python

_RTOL = 1e-12
_LARGEST = 0.2  # steps beyond this share of a follower step are not tried: a pin may miss its slot
_SAME = 1e-6  # errors that differ by less are the same [rad]
_FAILED = 1e3  # residual in mean beats of a wheel that cannot run, which explains no beats
_IMPACT = 0.02  # how late each slot is struck where a fit starts [rad]


class Errors(NamedTuple):
    """Angle errors of pins, and by how much each slot is ahead of the one before [rad]."""

    pins: FloatArray
    steps: FloatArray

    @property
    def slots(self) -> FloatArray:
        """Angle errors of the slots about their mean [rad]."""
        angles = np.cumsum(self.steps)
        return np.asarray(angles - angles.mean())

    def same_as(self, other: "Errors") -> bool:
        """Whether both cause the same beats; steps that are not struck may differ."""
        steps = np.maximum(self.steps, 0.0) - np.maximum(other.steps, 0.0)
        return bool(max(np.abs(self.pins - other.pins).max(), np.abs(steps).max()) < _SAME)


class Parts:
    """The unknowns of a fit: the rate, psi of all pins but one, and x of all slots but the last.

    Parameters
    ----------
    escapement : Escapement
        The design, with a Geneva wheel; angle errors that the wheel has are ignored.
    pins, slots : bool
        Which of them may have errors.
    last : int
        Slot whose step follows from the others.
    """

    def __init__(self, escapement: Escapement, pins: bool, slots: bool, last: int = 0) -> None:
        wheel: Any = escapement.mechanism
        self.wheel: Geneva = replace(wheel, pin_angle_errors=(), slot_angle_errors=())
        self.escapement, self.last = escapement, last
        self.slope = math.tan(math.pi / wheel.slots)
        self.others = np.delete(np.arange(wheel.slots), last) if slots else np.arange(0)
        self.pin_delays = (np.eye(wheel.pins) - 1.0 / wheel.pins)[:, 1 if pins else wheel.pins :]
        self.impacts = slice(1 + self.pin_delays.shape[1], None)

    @cached_property
    def free(self) -> FloatArray:
        """free_i of each slot, the mean over its pins [rad]."""
        rows, n = self.wheel.pattern, self.wheel.slots
        angle = as_python(follower_angle_at)
        enters, leaves = np.array(
            [[angle(row, row[x]) for x in ("entry", "exit")] for row in rows]
        ).T
        gaps = enters + self.wheel.follower_step - np.roll(leaves, 1)
        return np.asarray([gaps[i::n].mean() for i in range(n)])

    @property
    def size(self) -> int:
        """How many unknowns there are."""
        return int(1 + self.pin_delays.shape[1] + self.others.size)

    def bounds(self, rate: float) -> tuple[FloatArray, FloatArray]:
        """Least and greatest values of the unknowns about a rate."""
        most = np.full(self.size, self.range[1])
        least = -most
        least[0], most[0], least[self.impacts] = 0.5 * rate, 2.0 * rate, 0.0
        largest = _LARGEST * self.wheel.follower_step
        most[self.impacts] = np.maximum(self.struck(largest), 2.0 * _IMPACT)
        return least, most

    @property
    def range(self) -> tuple[float, float]:
        """Greatest angle errors of slots and of pins with which the wheel may run [rad]."""
        return self.wheel.slots * _LARGEST * self.wheel.follower_step, 0.25 * self.wheel.cell_angle

    def struck(self, step: float) -> FloatArray:
        """x of slots with a step, all but the last; 0 where there is no impact [rad]."""
        beyond = np.maximum(step - self.free[self.others], 0.0)
        return np.asarray(np.sqrt(2.0 * beyond / self.slope))

    def errors(self, unknowns: FloatArray) -> Errors:
        """The errors that belong to unknowns."""
        steps, x = np.zeros(self.wheel.slots), unknowns[self.impacts]
        if x.size:
            steps[self.others] = self.free[self.others] + 0.5 * self.slope * x**2
            steps[self.last] = -steps[self.others].sum()
        return Errors(self.pin_delays @ unknowns[1 : self.impacts.start], steps)

    def built(self, unknowns: FloatArray) -> Escapement:
        """The escapement with these errors."""
        found = self.errors(unknowns)
        late, ahead = tuple(found.pins.tolist()), tuple(found.slots.tolist())
        wheel = replace(self.wheel, pin_angle_errors=late, slot_angle_errors=ahead)
        return replace(self.escapement, mechanism=wheel)

    def beats(self, unknowns: FloatArray) -> FloatArray | None:
        """Beats of one pattern [s], None where the wheel cannot run."""
        computed = terminal(self.built(unknowns), rtol=_RTOL).beats
        # perfect parts have one beat
        return unknowns[0] * np.resize(computed, self.wheel.pattern.size) if computed else None

    def residuals(self, unknowns: FloatArray, means: FloatArray, root: FloatArray) -> FloatArray:
        """Computed less mean beats, made independent; great where the wheel cannot run."""
        computed = self.beats(unknowns)
        if computed is None:
            return np.full(means.size, _FAILED * means.mean())
        return np.asarray(root @ (computed - means))

    def perfect(self) -> tuple[FloatArray, FloatArray]:
        """Unknowns of perfect parts, and their beats [s]."""
        unknowns = np.concatenate([[1.0], np.zeros(self.pin_delays.shape[1]), self.struck(0.0)])
        computed = self.beats(unknowns)
        if computed is None:
            raise InvalidValue(
                "escapement must have a terminal cycle, got one that has none; "
                "its message in escapement.terminal says why"
            )
        return unknowns, computed


def starts(
    escapement: Escapement, pins: bool, slots: bool, means: FloatArray
) -> Iterator[tuple[Parts, FloatArray]]:
    """Sets of unknowns from which a fit of mean beats may start, each slot being the last once.

    Beats are nearly straight functions of the unknowns where slots are struck. For pins alone they
    have a kink, without a dwell, at equal distances of pins: there each order of near and far pins
    is a start.
    """
    first = Parts(escapement, pins, slots)
    unknowns, computed = first.perfect()
    unknowns[0] = means.mean() / computed.mean()
    if not slots:
        yield first, unknowns
    for last in range(first.wheel.slots if slots else 0):
        parts, at = Parts(escapement, pins, slots, last), unknowns.copy()
        at[parts.impacts] = np.maximum(at[parts.impacts], _IMPACT)
        if (struck := parts.beats(at)) is not None:
            at[0] *= means.mean() / struck.mean()
        yield parts, at
    count, size = first.wheel.pins or 1, first.wheel.cell_angle * means.std() / means.mean()
    for nearer in product((True, False), repeat=count if first.wheel.continuous else 0):
        if not slots and 0 < sum(nearer) < count:
            apart = np.where(nearer, -1.0 / sum(nearer), 1.0 / (count - sum(nearer)))
            delay = size * np.cumsum(apart)
            yield first, np.concatenate([unknowns[:1], delay[:-1] - delay[-1]])
