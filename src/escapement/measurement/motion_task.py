"""The problem of least squares by which a simulated motion is fitted to a run-up.

All unknowns are shares, of given numbers and of the length of the recording, and times count from
the first sample: no result depends on a unit or on when the logger's clock was started.
"""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.dynamics.motion import State
from escapement.engines import simulate as simulation
from escapement.measurement.fitted_numbers import given_numbers, with_numbers
from escapement.measurement.loggers import check_unit
from escapement.measurement.readings import Readings
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.model.numbers import numbers_of
from escapement.model.torque_curve import TorqueCurve

_SHARES = (1.0, 0.5, 2.0, 0.7, 1.4)  # the search tries to begin at these multiples of each number
_CELLS = 10_000  # where the search begins is computed from at most this many cells
_MOVING = 0.02  # below this share of the travel, noise hides the time at which an angle is reached
_STEP = 1e-4  # share of a number by which it is changed for a derivative
_SMALL = 0.01  # below this share of its given value, a number is changed by a share of this one
_LEAST = 1e-6  # least share of its given value that a number may have
_SHOWN = 10.0  # the driver turns by at least so many standard deviations of the readings
INEFFECTIVE = 1e-8
"""Length of the derivatives by a number that has no effect, which is rounding [rad]."""


@dataclass(frozen=True)
class MotionTask:
    """The problem of least squares.

    Its unknowns are the fitted numbers, divided by their given values, and the time of the release
    from the first sample that is used, divided by `span`.

    given : values of the fitted numbers, shape (m,).
    clock : time of that sample by the logger's clock [s].
    time, angle : of the samples that are used, from the first on, shape (n,) [s, rad].
    """

    escapement: Escapement
    parameters: tuple[str, ...]
    given: FloatArray
    clock: float
    time: FloatArray
    angle: FloatArray

    @property
    def span(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1])

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest unknowns: positive numbers, and a release during the recording.

        The release may also come before it, by at most the length of the recording. An efficiency
        is at most 1.
        """
        most = [
            1.0 / size if is_share(name) else math.inf
            for name, size in zip(self.parameters, self.given.tolist(), strict=True)
        ]
        return np.array([*np.full(len(most), _LEAST), -1.0]), np.array([*most, 1.0])

    def changed(self, unknowns: FloatArray) -> Escapement:
        """The escapement that belongs to the unknowns."""
        values = unknowns[: self.given.size] * self.given
        return with_numbers(self.escapement, self.parameters, values)

    def state(self, unknowns: FloatArray) -> State:
        """The motion at each sample; before the release it is the state at rest.

        Raises InvalidValue where there is no motion with these numbers.
        """
        since = self.time - unknowns[-1] * self.span
        duration = max(float(since[-1]), 1e-3 * self.span)
        motion = simulation.simulate(self.changed(unknowns), duration=duration)
        return motion.at(np.clip(since, 0.0, motion.end_time))

    def _tried(self, unknowns: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angles and speeds at each sample, 0 where there is no motion with these numbers."""
        try:
            state = self.state(unknowns)
        except InvalidValue:
            return np.zeros_like(self.time), np.zeros_like(self.time)
        return np.asarray(state.theta), np.asarray(state.theta_dot)

    def residuals(self, unknowns: FloatArray) -> FloatArray:
        """Measured less computed angle, with the encoder's zero that makes their mean 0 [rad]."""
        return centred(self.angle - self._tried(unknowns)[0])

    def slopes(self, unknowns: FloatArray) -> FloatArray:
        """Derivatives of the residuals: by the numbers from differences, by the release exactly."""
        columns, step = [], _STEP * np.maximum(unknowns, _SMALL)
        low, high = np.maximum(unknowns - step, _LEAST), np.minimum(unknowns + step, self.bounds[1])
        for index in range(len(self.parameters)):
            at = [np.where(np.arange(unknowns.size) == index, end, unknowns) for end in (low, high)]
            change = self.residuals(at[1]) - self.residuals(at[0])
            columns.append(change / (high[index] - low[index]))
        return np.column_stack([*columns, centred(self.span * self._tried(unknowns)[1])])

    def begin(self) -> FloatArray:
        """Unknowns at which the search begins: the best of several near the given numbers.

        The torque only changes the scale of time. A straight line through the measured times,
        plotted over the computed times of the same angles, therefore gives torque and release.
        """
        cells = math.ceil(float(self.angle[-1]) / self.escapement.mechanism.cell_angle) + 1
        moving = self.angle > _MOVING * self.angle[-1]
        times, is_torque = self.time[moving], np.array(self.parameters) == "torque"
        free = int(np.sum(~is_torque))
        tries, message = [], ""
        for shares in product(_SHARES[: 5 if free < 3 else 3], repeat=free):
            trial = np.ones(len(self.parameters))
            trial[~is_torque] = shares
            trial = np.minimum(trial, self.bounds[1][:-1])
            motion = simulation.simulate(self.changed(trial), min(cells, _CELLS))
            if motion.status is not Status.OK:
                message = message or motion.message
                continue
            grid = np.linspace(0.0, motion.end_time, 50 * cells)
            simulated = motion.at(grid).theta
            time = np.interp(self.angle[moving], simulated - simulated[0], grid)
            rate, start = np.polyfit(time, times, 1)
            if not rate > 0.0:
                continue
            pace = rate if is_torque.any() else 1.0
            start = start if is_torque.any() else float(np.mean(times - time))
            trial[is_torque] = pace**-2.0
            miss = float(np.square(times - start - pace * time).sum())
            tries.append((miss, *trial, start / self.span, rate))
        if not tries:
            raise InvalidValue(
                f"escapement must run to be fitted, got one that does not: {message}; change the "
                "values of parameters, at which the search begins"
            )
        *found, rate = min(tries)[1:]
        self._check_times(rate)
        return np.asarray(np.clip(found, *self.bounds))

    def _check_times(self, rate: float) -> None:
        """Raise an error if measured times are not of the order of the design's.

        rate : measured over computed time of the same angles [-].
        """
        took, turns = self.span, float(self.angle[-1]) / (2.0 * math.pi)
        text = f"{took:.3g} s for {turns:.3g} turns of the driver, which take {took / rate:.3g} s"
        curve = isinstance(self.escapement.torque, TorqueCurve)
        check_unit("time", rate, text, None if curve else numbers_of(self.escapement)["torque"])


def task_of(readings: Readings, escapement: Escapement, parameters: tuple[str, ...]) -> MotionTask:
    """The problem for these readings, or InvalidValue."""
    if not isinstance(readings, Readings) or readings.time is None:
        remedy = "give read_readings(path, time='time')"
        raise validate.fail("readings", "Readings with times", readings, remedy)
    given = given_numbers(escapement, parameters)
    time, angle = _used(readings)
    clock = float(time[0])
    return MotionTask(escapement, parameters, given, clock, time - clock, angle)


def _used(readings: Readings) -> tuple[FloatArray, FloatArray]:
    """Times, and angles that grow from 0, from the last sample at rest on."""
    known = np.isfinite(readings.input)
    time, angle = np.asarray(readings.time)[known], readings.counted_input[known]
    # an encoder may count against the driver, which never turns back
    angle = (angle - angle[0]) * (1.0 if angle[-1] > angle[0] else -1.0)
    first = max(int(np.argmax(angle != 0.0)) - 1, 0)
    # the scatter of steps is that of the readings where the driver stands or turns evenly
    travel, scatter = float(np.ptp(angle)), float(np.diff(angle).std()) / math.sqrt(2.0)
    if travel < _SHOWN * scatter:
        raise InvalidValue(
            "readings must show a driver that turns, got angles that scatter by about "
            f"{math.degrees(scatter):.3g} degrees within {math.degrees(travel):.3g}; "
            "check the columns and the unit of the angles"
        )
    return time[first:], angle[first:]


def centred(values: FloatArray) -> FloatArray:
    """Values less their mean."""
    return np.asarray(values - values.mean())


def is_share(name: str) -> bool:
    """Whether a number of the escapement is at most 1."""
    return name.endswith("efficiency")
