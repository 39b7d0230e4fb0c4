"""Readings that two encoders would give: computed, for tests and teaching."""

import numpy as np

from escapement import validate
from escapement.measurement.encoder import Encoder, check_drive, checked_zero
from escapement.measurement.fit import position
from escapement.measurement.readings import LEAST_SAMPLES, TURN, Readings
from escapement.model import FloatArray, Mechanism

_HARMONICS = range(2, 6)  # an error once a turn is that of eccentricity


def synthetic_readings(
    mechanism: Mechanism,
    *,
    seed: int,
    samples: int = 148,
    turns: float = 3.0,
    encoder: Encoder | None = None,
    noise: float = 0.0,
    input_eccentricity: float = 0.0,
    output_eccentricity: float = 0.0,
    backlash: float = 0.0,
    phase: float = 0.0,
    offset: float = 0.0,
    sense: int = 1,
    missing: float = 0.0,
) -> Readings:
    """Synthetic readings of a drive whose input turns evenly.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    seed : int
        The same seed gives the same readings.
    samples : int
        How many, >= 20.
    turns : float
        Of the input; negative ones turn it back.
    encoder : Encoder, optional
        Its linearity gives each shaft a smooth error with two to five periods a
        turn and that greatest value; its resolution rounds readings, which then
        start again each turn. Default: neither.
    noise : float
        Standard deviation of independent normal errors of the output [rad].
    input_eccentricity, output_eccentricity : float
        Amplitude of an error once a turn of the shaft [rad].
    backlash : float
        Free play of the output [rad].
    phase, offset : float
        Zeros of the encoders, as in `measure` [rad].
    sense : int
        1, or -1 for an output encoder that counts the other way.
    missing : float
        Share of the samples in which the output is not there [-], below 1.

    Returns
    -------
    Readings
        Marked as synthetic.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    check_drive(mechanism, encoder)
    start, zero = checked_zero("phase", phase), checked_zero("offset", offset)
    count = validate.integer("samples", samples, LEAST_SAMPLES, "give how many to compute")
    whole = validate.integer("seed", seed, 0, "give any whole number")
    checked = {
        name: validate.non_negative(name, value, "give an angle in rad, 0 for none")
        for name, value in (
            ("noise", noise), ("backlash", backlash),
            ("input_eccentricity", input_eccentricity),
            ("output_eccentricity", output_eccentricity),
        )
    }  # fmt: skip
    if validate.number("sense", sense) not in (1.0, -1.0):
        raise validate.fail("sense", "1 or -1", sense, "give the sense of the output encoder")
    if not 0.0 <= validate.number("missing", missing) < 1.0:
        raise validate.fail("missing", "from 0 to below 1", missing, "give a share, as 0.01")
    random = np.random.default_rng(whole)
    travel = TURN * validate.number("turns", turns)
    theta = start + np.linspace(0.0, travel, count, endpoint=False)
    phi = _with_play(position(mechanism, theta), checked["backlash"])
    bend = 0.0 if encoder is None else encoder.greatest_deviation
    angle = theta - start + _shaft(random, theta, checked["input_eccentricity"], bend)
    output = sense * (phi + _shaft(random, phi, checked["output_eccentricity"], bend)) + zero
    output += checked["noise"] * random.standard_normal(count)
    if encoder is not None:
        angle, output = _digital(angle, encoder), _digital(output, encoder)
    output[random.random(count) < missing] = np.nan
    return Readings(angle, output, synthetic=True)


def _shaft(
    random: np.random.Generator, angle: FloatArray, eccentricity: float, deviation: float
) -> FloatArray:
    """Error of a shaft: once a turn, and a smooth one of known greatest value."""
    start = random.uniform(0.0, TURN)
    weights = [random.standard_normal(2) for _ in _HARMONICS]

    def bent(at: FloatArray) -> FloatArray:
        waves = [
            a * np.cos(k * at) + b * np.sin(k * at)
            for k, (a, b) in zip(_HARMONICS, weights, strict=True)
        ]
        return np.asarray(sum(waves))

    greatest = float(np.abs(bent(np.linspace(0.0, TURN, 3600))).max())
    return eccentricity * np.sin(angle + start) + deviation / greatest * bent(angle)


def _with_play(phi: FloatArray, backlash: float) -> FloatArray:
    """Output that is pushed at either end of its free play and stays in between."""
    if backlash == 0.0:
        return phi
    half, place = 0.5 * backlash, float(phi[0])
    lagging = np.empty_like(phi)
    for i, pushed in enumerate(phi.tolist()):
        place = min(max(place, pushed - half), pushed + half)
        lagging[i] = place
    return lagging


def _digital(angle: FloatArray, encoder: Encoder) -> FloatArray:
    """Nearest count, from zero on in each turn."""
    return encoder.quantum * np.mod(np.round(angle / encoder.quantum), encoder.resolution)
