"""Comparing readings with a mechanism's position function."""

from os import PathLike

import numpy as np

from escapement import validate
from escapement.errors import InvalidValue
from escapement.measurement._checks import check_drive, checked_zero
from escapement.measurement._csv import read_readings
from escapement.measurement._fit import fit
from escapement.measurement._result import Measurement
from escapement.measurement.classes import class_count
from escapement.measurement.encoder import Encoder
from escapement.measurement.readings import TURN, Readings, wraps
from escapement.model import Mechanism


def measure(
    readings: Readings | str | PathLike[str],
    mechanism: Mechanism,
    *,
    bins: int | str = "sturges",
    confidence: float = 0.99,
    encoder: Encoder | None = None,
    zeros: tuple[float, float] | None = None,
) -> Measurement:
    """Compare readings of encoders with a mechanism's position function.

    Parameters
    ----------
    readings : Readings or path
        Angles of input and output, or a CSV file of them in degrees unless its
        header says otherwise (`read_readings` knows more).
    mechanism : Mechanism
        Geometry, for example `Geneva(slots=4)`.
    bins : int or str
        Number of classes, >= 4, or a rule: "sturges", "scott",
        "freedman-diaconis" or "square-root".
    confidence : float
        Of the intervals, in (0, 1).
    encoder : Encoder, optional
        Data sheet of the encoders, both alike: adds what they explain.
    zeros : (float, float), optional
        Phase and offset where they are known [rad]: driver angle from dead centre
        at which the input reads zero, and reading of the output at follower angle
        zero. Default: fitted, which makes the mean error zero.

    Returns
    -------
    Measurement
        The fit at once; statistics when they are asked for.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, or the errors are all the same.
    MissingInput, InputFileError
        When the file is not there, or cannot be understood.

    Source: Prikhodko (2020), section 3.
    """
    check_drive(mechanism, encoder)
    share = validate.number("confidence", confidence, "give a share, as 0.99")
    if not 0.0 < share < 1.0:
        raise validate.fail("confidence", "between 0 and 1", confidence, "give a share, as 0.99")
    known = None if zeros is None else _checked_zeros(zeros)
    if not isinstance(readings, Readings | str | PathLike):
        raise validate.fail(
            "readings", "Readings or a path", readings, "give Readings(input, output) in rad"
        )
    taken = readings if isinstance(readings, Readings) else read_readings(readings)
    # turns are counted before samples without an output are left out: their input tells
    angle, output = taken.counted_input[taken.complete], taken.output[taken.complete]
    found = fit(mechanism, angle, output, wraps(output), known)
    first = np.flatnonzero(np.isfinite(taken.input))[0]
    turns = round(float(taken.input[first] - taken.counted_input[first]) / TURN)
    if known is not None and turns != 0:
        # a first reading of nearly a turn may be jitter below zero, or just that
        other = angle + turns * TURN
        standing = fit(mechanism, other, output, wraps(output), known)
        if standing.errors @ standing.errors < found.errors @ found.errors:
            angle, found = other, standing
    # rounding alone is no measurement
    if not np.ptp(found.errors) > 1e-13 * max(1.0, float(np.abs(output).max())):
        raise InvalidValue(
            "readings must differ from theory in some way, got theory itself; give measured ones"
        )
    count = class_count(found.errors, bins)
    return Measurement(mechanism, taken, encoder, share, count, angle, output, found)


def _checked_zeros(zeros: tuple[float, float]) -> tuple[float, float]:
    try:
        phase, offset = zeros
    except (TypeError, ValueError):
        raise validate.fail(
            "zeros", "a phase and an offset in rad", zeros, "give both, or leave it out"
        ) from None
    return checked_zero("phase", phase), checked_zero("offset", offset)
