"""Encoders: their errors according to the data sheet, and synthetic readings of two of them."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.measurement.error_columns import with_backlash
from escapement.measurement.positions import position
from escapement.measurement.readings import FARTHEST, LEAST_SAMPLES, TURN, WITHIN, Readings
from escapement.mechanisms.protocol import FloatArray, Mechanism, checked

_HARMONICS = range(2, 6)  # an error that repeats once a turn is left to the eccentricity
_SAME = 1e-7  # angles as close as this are equal, but differ by the rounding of a file [rad]
_FEWEST_GAPS = 10  # fewer gaps between readings can be multiples of the smallest by chance
_OFF_GRID = 0.05  # greatest deviation from a grid, in steps
_SEVERAL = 3  # gaps of an input as different as this are not those of stops


@dataclass(frozen=True)
class Encoder:
    """An absolute angle sensor.

    Parameters
    ----------
    resolution : int
        Counts in a turn, >= 2; an angle is rounded to the nearest count.
    linearity : float
        Greatest deviation from a straight line as a share of a turn [-], >= 0 and < 0.5.

    Source: Prikhodko (2020), Table 1: 4096 and 0.3 %.
    """

    resolution: int = 4096
    linearity: float = 0.0

    def __post_init__(self) -> None:
        counts = validate.integer("resolution", self.resolution, 2, "give the counts in a turn")
        remedy = "give a share of a turn, 0.003 for 0.3 %"
        share = validate.non_negative("linearity", self.linearity, remedy)
        if share >= 0.5:
            raise validate.fail("linearity", "below 0.5", share, remedy)
        vars(self).update(resolution=counts, linearity=share)

    @property
    def quantum(self) -> float:
        """Angle of one count [rad]."""
        return TURN / self.resolution

    @property
    def greatest_deviation(self) -> float:
        """Greatest error that the linearity allows, in either direction [rad]."""
        return TURN * self.linearity


Encoders = Encoder | tuple[Encoder, Encoder]
"""One type for both shafts, or the encoders of input and output."""


def pair_of(encoder: Encoders) -> tuple[Encoder, Encoder]:
    """The encoders of input and output."""
    return (encoder, encoder) if isinstance(encoder, Encoder) else encoder


class SensorShare(NamedTuple):
    """Errors of the position function that the encoders alone can cause [rad].

    An error of the input's encoder reaches the output multiplied by the transmission g.
    All errors within a limit h are assumed to be equally likely, so the standard
    uncertainty is h/sqrt(3) (JCGM 100, 4.3.7).

    output_resolution, input_resolution, output_linearity, input_linearity : root
        mean square of each contribution over the samples.
    standard : root of the sum of their squares.
    bound : greatest error that all together can cause, at the sample where g is greatest.
    """

    output_resolution: float
    input_resolution: float
    output_linearity: float
    input_linearity: float
    standard: float
    bound: float


def sensor_share(encoder: Encoders, slope: FloatArray) -> SensorShare:
    """Contribution of the encoders at samples with the transmission `slope` [-].

    It is of first order in the input's error: terms of second order, which remain where g = 0,
    are left out.
    """
    of_input, of_output = map(_limits, pair_of(encoder))
    through = math.sqrt(float(np.mean(slope * slope)))
    rounding, deviation = (limit / math.sqrt(3.0) for limit in of_output)
    before, input_deviation = (through * limit / math.sqrt(3.0) for limit in of_input)
    parts = rounding, before, deviation, input_deviation
    steepest = float(np.abs(slope).max())
    return SensorShare(*parts, math.hypot(*parts), sum(of_output) + steepest * sum(of_input))


def _limits(encoder: Encoder) -> tuple[float, float]:
    """Greatest errors of rounding and of linearity [rad]."""
    return 0.5 * encoder.quantum, encoder.greatest_deviation


def sensor_uncertainty(encoder: Encoders, slope: FloatArray) -> FloatArray:
    """Standard uncertainty of the error at each sample, from both encoders [rad]."""
    of_input, of_output = (math.hypot(*_limits(one)) / math.sqrt(3.0) for one in pair_of(encoder))
    return np.hypot(of_output, of_input * slope)


def steps_of(
    encoder: Encoders | None, angle: FloatArray, output: FloatArray
) -> tuple[float, float]:
    """Steps of the encoders of input and output, 0 where they are unknown [rad]."""
    if encoder is not None:
        of_input, of_output = pair_of(encoder)
        return of_input.quantum, of_output.quantum
    # an input may have stopped at even steps, which then are no counts
    input_step, step = step_of(angle, _SEVERAL), step_of(output)
    if not input_step and step:
        counts = (angle - angle[0]) / step
        # an encoder like that of the output shows multiples of its step
        input_step = step if np.abs(counts - np.round(counts)).max() < _OFF_GRID else 0.0
    return input_step, step


def step_of(angle: FloatArray, several: int = 1) -> float:
    """Step of the encoder that showed these angles, 0 if they do not show it [rad].

    Only a shaft that turns unevenly shows it; its gaps must be multiples of the step, the greatest
    at least of `several` steps.
    """
    gaps = np.diff(np.unique(np.mod(angle, TURN)))
    gaps = gaps[gaps > _SAME]
    if not _FEWEST_GAPS <= gaps.size < 0.9 * angle.size:
        return 0.0
    steps = gaps / gaps.min()
    counts = np.round(steps)
    on_grid = np.abs(steps - counts).max() < _OFF_GRID and counts.max() >= several
    return float(gaps.sum() / counts.sum()) if on_grid else 0.0


def check_drive(mechanism: Any, encoder: Any) -> None:
    """Raise InvalidValue unless these are a mechanism whose follower angle is that of the driver's,
    and one or two encoders or None."""
    if checked(mechanism).pitch is not None:
        raise InvalidValue(
            f"mechanism must have slots or gears, got {mechanism.kind}, whose positions depend on "
            "the motion; fit that of the driver, as with --fit friction,torque, or measure beats"
        )
    both = encoder if isinstance(encoder, tuple) and len(encoder) == 2 else (encoder,)
    if encoder is not None and not all(isinstance(one, Encoder) for one in both):
        remedy = "give Encoder(4096, 0.003), or a pair of them for input and output"
        raise validate.fail("encoder", "an Encoder", encoder, remedy)


def checked_zeros(zeros: Any) -> tuple[float, float]:
    """Phase and offset, the zeros of two encoders [rad]."""
    if not hasattr(zeros, "__len__") or len(zeros) != 2:
        remedy = "give both angles, or leave zeros out"
        raise validate.fail("zeros", "a phase and an offset in rad", zeros, remedy)
    for name, angle in zip(("phase", "offset"), zeros, strict=True):
        if abs(validate.number(name, angle, "give an angle in rad")) > FARTHEST:
            raise validate.fail(name, WITHIN, angle, "give an angle in rad")
    return float(zeros[0]), float(zeros[1])


def synthetic_readings(
    mechanism: Mechanism, *, seed: int, samples: int = 148, turns: float = 3.0,
    encoder: Encoders | None = None, noise: float = 0.0, input_eccentricity: float = 0.0,
    output_eccentricity: float = 0.0, backlash: float = 0.0, input_backlash: float = 0.0,
    both_ways: bool = False, phase: float = 0.0, offset: float = 0.0, sense: int = 1,
    missing: float = 0.0,
) -> Readings:  # fmt: skip
    """Synthetic readings of a drive whose input turns at constant speed.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    seed : int
        The same seed gives the same readings.
    samples : int
        Number of samples, >= 20.
    turns : float
        Turns of the input; it turns backwards if they are negative.
    encoder : Encoder or (Encoder, Encoder), optional
        Of both shafts, or of input and output. Its linearity gives each shaft a smooth error with
        two to five periods a turn and the greatest value that it allows; its resolution rounds
        the readings, which then start again at zero each turn. Default: readings without errors
        of encoders.
    noise : float
        Standard deviation of independent normal errors of the output [rad].
    input_eccentricity, output_eccentricity : float
        Amplitude of an error that repeats once a turn of the shaft [rad].
    backlash, input_backlash : float
        Free play of the output, and of the input behind its encoder [rad].
    both_ways : bool
        Whether the input turns back to its first angle after `turns`, in the second half of the
        samples.
    phase, offset : float
        Zeros of the encoders, as in `measure` [rad].
    sense : int
        1, or -1 for an output encoder whose readings fall while the input's grow.
    missing : float
        Share of the samples without a reading of the output [-], below 1.

    Returns
    -------
    Readings
        They are marked as synthetic.

    Raises
    ------
    InvalidValue
        If an argument breaks its rule.
    """
    check_drive(mechanism, encoder)
    start, zero = checked_zeros((phase, offset))
    count = validate.integer("samples", samples, LEAST_SAMPLES, "give how many to compute")
    whole = validate.integer("seed", seed, 0, "give any whole number")
    sizes = {
        "noise": noise, "backlash": backlash, "input_backlash": input_backlash,
        "input_eccentricity": input_eccentricity, "output_eccentricity": output_eccentricity,
    }  # fmt: skip
    for name, size in sizes.items():
        validate.non_negative(name, size, "give an angle in rad, 0 for none")
    if validate.number("sense", sense) not in (1.0, -1.0):
        raise validate.fail("sense", "1 or -1", sense, "give the sense of the output encoder")
    if not 0.0 <= validate.number("missing", missing) < 1.0:
        raise validate.fail("missing", "from 0 to below 1", missing, "give a share, as 0.01")
    random = np.random.default_rng(whole)
    travel = TURN * validate.number("turns", turns)
    share = np.linspace(0.0, 1.0, count, endpoint=False)
    if validate.truth("both_ways", both_ways):
        share = 1.0 - np.abs(1.0 - 2.0 * share)
    theta = start + travel * share
    phi = with_backlash(position(mechanism, with_backlash(theta, input_backlash)), backlash)
    pair = None if encoder is None else pair_of(encoder)
    deviations = (0.0, 0.0) if pair is None else [one.greatest_deviation for one in pair]
    angle = theta - start + _shaft(random, theta, input_eccentricity, deviations[0])
    read = sense * (phi + _shaft(random, phi, output_eccentricity, deviations[1])) + zero
    read = read + noise * random.standard_normal(count)
    if pair is not None:
        angle, read = _digital(angle, pair[0]), _digital(read, pair[1])
    read[random.random(count) < missing] = np.nan
    return Readings(angle, read, synthetic=True)


def _shaft(
    random: np.random.Generator, angle: FloatArray, eccentricity: float, deviation: float
) -> FloatArray:
    """Error of a shaft: one that repeats once a turn, and a smooth one with a greatest value."""
    start = random.uniform(0.0, TURN)
    weights = random.standard_normal((len(_HARMONICS), 2)) @ [1.0, -1.0j]

    def bent(at: FloatArray) -> FloatArray:
        return np.real(weights @ np.exp(1j * np.multiply.outer(_HARMONICS, at)))

    greatest = float(np.abs(bent(np.linspace(0.0, TURN, 3600))).max())
    return eccentricity * np.sin(angle + start) + deviation / greatest * bent(angle)


def _digital(angle: FloatArray, encoder: Encoder) -> FloatArray:
    """Nearest count, which starts again at zero in each turn, as an angle [rad]."""
    return encoder.quantum * np.mod(np.round(angle / encoder.quantum), encoder.resolution)
