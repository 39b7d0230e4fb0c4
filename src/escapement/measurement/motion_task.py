"""The problem of least squares by which a simulated motion is fitted to a measured one.

Readings tell the driver's angle at given times, beats the times of given angles, those of the
handoffs, where it is many times as fast as in between. So the residuals of beats are times.

All unknowns are shares, of given numbers and of the length of the recording, and times count from
the first sample: no result depends on a unit or on when a clock was started.
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import product

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.engines import simulate as simulation
from escapement.measurement.loggers import check_unit
from escapement.measurement.readings import Readings
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.model.numbers import numbers_of, with_number
from escapement.model.torque_curve import TorqueCurve

_SHARES = (1.0, 0.5, 2.0, 0.7, 1.4)  # the search tries to begin at these multiples of each number
_CELLS = 10_000  # where the search begins is computed from at most this many cells
_MOVING = 0.02  # below this share of the travel, noise hides the time at which an angle is reached
_LEAST = 1e-6  # least share of its given value that a number may have
_SHOWN = 10.0  # the driver turns by at least so many standard deviations of the readings
_FEWEST = 12  # beats of a run-up
_INEFFECTIVE = 1e-8  # length of the derivatives by a number that has no effect [rad]
_LATE = 1e-6  # share of a beat by which such a number moves one
# a combination of unknowns with a smaller effect, relative to the strongest, is not determined
_SINGULAR = 1e-4
_INVOLVED = 0.1  # numbers with a smaller share in such a combination are not named in the message


@dataclass(frozen=True)
class MotionTask:
    """The problem of least squares.

    Its unknowns are the fitted numbers, divided by their given values, and the time of the release
    since two `span`s before the first sample that is used, divided by `span`: it is never near 0,
    since the steps of derivatives are shares of the unknowns.

    given : values of the fitted numbers, shape (m,).
    clock : time of that sample by the logger's clock [s].
    time, angle : of the samples that are used, from the first on, shape (n,) [s, rad].
    beats : index of the handoff that each sample is, shape (n,); None of readings.
    """

    escapement: Escapement
    parameters: tuple[str, ...]
    given: FloatArray
    clock: float
    time: FloatArray
    angle: FloatArray
    beats: np.ndarray | None = None

    @property
    def span(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1])

    @property
    def most(self) -> FloatArray:
        """Greatest fitted numbers, of which an efficiency is at most 1, shape (m,)."""
        shares = [name.endswith("efficiency") for name in self.parameters]
        return np.where(shares, 1.0, np.inf)

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest unknowns: positive numbers, and a release during the recording.

        The release may also come before it, by at most the length of the recording.
        """
        least = np.full(self.given.size, _LEAST)
        return np.append(least, 1.0), np.append(self.most / self.given, 3.0)

    def released(self, unknowns: FloatArray) -> float:
        """Time of the release from the first sample [s]."""
        return (float(unknowns[-1]) - 2.0) * self.span

    def changed(self, unknowns: FloatArray) -> Escapement:
        """The escapement that belongs to the unknowns."""
        found, values = self.escapement, unknowns[: self.given.size] * self.given
        for name, value in zip(self.parameters, values.tolist(), strict=True):
            found = with_number(found, name, value)
        return found

    def residuals(self, unknowns: FloatArray) -> FloatArray:
        """Measured less computed.

        Of readings these are angles, with the encoder's zero that makes their mean 0 [rad], and
        of beats times [s]. Where no motion has these numbers, nothing is computed.
        """
        since = self.time - self.released(unknowns)
        apart = self.angle if self.beats is None else since
        with suppress(InvalidValue):
            if self.beats is None:
                duration = max(float(since[-1]), 1e-3 * self.span)
                motion = simulation.simulate(self.changed(unknowns), duration=duration)
                # before the release it is at rest
                apart = self.angle - motion.at(np.clip(since, 0.0, motion.end_time)).theta
            else:
                motion = simulation.simulate(self.changed(unknowns), int(self.beats[-1]) + 1)
                if motion.handoff_times.size > self.beats[-1]:
                    apart = since - motion.handoff_times[self.beats]
        return np.asarray(apart if self.beats is not None else apart - apart.mean())

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
            tries.append((miss, *trial, 2.0 + start / self.span, rate))
        if not tries:
            raise InvalidValue(
                f"escapement must run to be fitted, got one that does not: {message}; change the "
                "values of parameters, at which the search begins"
            )
        *found, rate = min(tries)[1:]
        took, turns = self.span, float(np.ptp(self.angle)) / (2.0 * math.pi)
        text = f"{took:.3g} s for {turns:.3g} turns of the driver, which take {took / rate:.3g} s"
        curve = isinstance(self.escapement.torque, TorqueCurve)
        torque = None if curve else numbers_of(self.escapement)["torque"]
        check_unit("time" if self.beats is None else "beats", rate, text, torque)
        return np.asarray(np.clip(found, *self.bounds))

    def check_determined(self, slopes: FloatArray) -> None:
        """Raise InvalidValue if the measurement does not determine each of the numbers."""
        lengths = np.linalg.norm(slopes, axis=0)
        least = _INEFFECTIVE
        if self.beats is not None:
            least = _LATE * self.span / int(np.ptp(self.beats)) * math.sqrt(self.beats.size)
        for name, length in zip(self.parameters, lengths, strict=False):
            if not length > least:
                raise InvalidValue(
                    f"parameters must affect the motion, got {name!r}, which does not; leave it out"
                )
        _, sizes, directions = np.linalg.svd(slopes / lengths, full_matrices=False)
        if sizes[-1] < _SINGULAR * sizes[0]:
            shares = np.abs(directions[-1] / lengths)[:-1]
            some = np.array(self.parameters)[shares > _INVOLVED * shares.max()]
            raise InvalidValue(
                f"parameters must each be determined by the motion, got {', '.join(some)}, of "
                "which it shows only a combination; leave one of them out and give its value in "
                "escapement"
            )


def task_of(measured: Readings, escapement: Escapement, parameters: Sequence[str]) -> MotionTask:
    """The problem for these readings or beats, or InvalidValue."""
    names = tuple(parameters)
    if not isinstance(measured, Readings) or measured.time is None:
        remedy = "give read_readings(path, time='time')"
        raise validate.fail("readings", "Readings with times", measured, remedy)
    given, beats = _given(escapement, names), None
    if measured.half_widths is None:
        time, angle = _used(measured)
    else:
        kind, pitch = escapement.mechanism.kind, escapement.mechanism.pitch
        if pitch is not None:
            rule = "with pins, whose beats are handoffs"
            remedy = "fit readings of the driver's angle"
            raise validate.fail("escapement", rule, f"a {kind}, whose beats are blows", remedy)
        beats, time = measured.beats, measured.heard
        if beats.size < max(_FEWEST, 3 * (len(names) + 1)):
            raise InvalidValue(
                f"beats must be {_FEWEST} or more in a run-up, got {beats.size}; record longer"
            )
        angle = measured.input[beats] * escapement.mechanism.cell_angle
    clock = float(time[0])
    since = time - clock
    return MotionTask(escapement, names, given, clock, time=since, angle=angle, beats=beats)


def _given(escapement: Escapement, parameters: tuple[str, ...]) -> FloatArray:
    """Values of the numbers at which a search begins, or InvalidValue."""
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    numbers = numbers_of(escapement)
    if isinstance(escapement.torque, TorqueCurve):
        del numbers["torque"]
    for name in parameters:
        if name not in numbers:
            remedy = validate.nearest(name, numbers, f"for example {', '.join([*numbers][:4])}")
            raise validate.fail("parameters", "numbers of the escapement", name, remedy)
        if not numbers[name] > 0.0:
            remedy = "give an estimate, at which the search begins"
            raise validate.fail(name, "above 0 to be fitted", numbers[name], remedy)
    if len({*parameters}) < len(parameters):
        raise validate.fail("parameters", "different numbers", parameters, "name each once")
    return np.array([numbers[name] for name in parameters], float)


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
