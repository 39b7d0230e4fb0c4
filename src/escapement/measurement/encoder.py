"""Encoders: what their data sheet says of their errors, and checks of what they are given."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from escapement import validate
from escapement.measurement.readings import FARTHEST, TURN, WITHIN
from escapement.model import FloatArray, is_mechanism


@dataclass(frozen=True)
class Encoder:
    """An absolute angle sensor, one of its kind on each shaft.

    Parameters
    ----------
    resolution : int
        Counts a turn, >= 2; an angle is rounded to the next one.
    linearity : float
        Greatest deviation from a straight line as a share of a turn [-], >= 0.

    Source: Prikhodko (2020), Table 1: 4096 and 0.3 %.
    """

    resolution: int = 4096
    linearity: float = 0.0

    def __post_init__(self) -> None:
        counts = validate.integer("resolution", self.resolution, 2, "give the counts of a turn")
        share = validate.non_negative(
            "linearity", self.linearity, "give a share of a turn, 0.003 for 0.3 %"
        )
        if share >= 0.5:
            raise validate.fail(
                "linearity", "below 0.5", share, "give a share of a turn, 0.003 for 0.3 %"
            )
        object.__setattr__(self, "resolution", counts)
        object.__setattr__(self, "linearity", share)

    @property
    def quantum(self) -> float:
        """Angle of one count [rad]."""
        return TURN / self.resolution

    @property
    def greatest_deviation(self) -> float:
        """Angle the linearity allows, to either side [rad]."""
        return TURN * self.linearity


class SensorShare(NamedTuple):
    """Errors of the position function that the encoders alone explain [rad].

    An input encoder's error reaches the output multiplied by the transmission g.
    Within its limits every error is taken to be as likely as any other, so a limit
    of h has the standard uncertainty h/sqrt(3) (JCGM 100, 4.3.7).

    output_resolution, input_resolution, output_linearity, input_linearity : root
        mean square of each contribution over the samples.
    standard : all four together.
    bound : greatest error they can make at the sample where g is greatest.
    """

    output_resolution: float
    input_resolution: float
    output_linearity: float
    input_linearity: float
    standard: float
    bound: float


def sensor_share(encoder: Encoder, slope: FloatArray) -> SensorShare:
    """Contribution of the encoders at samples with the transmission `slope` [-].

    To first order in the input's error: through a stop, where g = 0, the second
    order remains and is left out.
    """
    limits = 0.5 * encoder.quantum, encoder.greatest_deviation
    through = math.sqrt(float(np.mean(slope * slope)))
    one, other = (limit / math.sqrt(3.0) for limit in limits)
    parts = one, one * through, other, other * through
    steepest = float(np.abs(slope).max())
    return SensorShare(*parts, math.hypot(*parts), (1.0 + steepest) * sum(limits))


def sensor_uncertainty(encoder: Encoder, slope: FloatArray) -> FloatArray:
    """Standard uncertainty of the error at each sample, both encoders [rad]."""
    one = math.hypot(0.5 * encoder.quantum, encoder.greatest_deviation) / math.sqrt(3.0)
    return one * np.hypot(1.0, slope)


def check_drive(mechanism: Any, encoder: Any) -> None:
    """Refuse what is no mechanism, and what is no encoder and not None."""
    if not is_mechanism(mechanism):
        raise validate.fail("mechanism", "a mechanism", mechanism, "give for example Geneva(4)")
    if encoder is not None and not isinstance(encoder, Encoder):
        raise validate.fail("encoder", "an Encoder", encoder, "give Encoder(4096, 0.003)")


def checked_zero(name: str, angle: Any) -> float:
    """Zero of an encoder [rad]."""
    remedy = "give an angle in rad"
    value = validate.number(name, angle, remedy)
    if abs(value) > FARTHEST:
        raise validate.fail(name, WITHIN, angle, remedy)
    return value
