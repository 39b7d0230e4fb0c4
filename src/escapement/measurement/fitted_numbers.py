"""Numbers of an escapement that are fitted to a motion, and what all such fits have in common."""

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from escapement.base import spoken, validate
from escapement.base.errors import InvalidValue
from escapement.base.records import in_units
from escapement.base.text import words
from escapement.base.units import factor, printed
from escapement.measurement.estimate import SURE, f_test
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.model.numbers import numbers_of, with_number
from escapement.model.torque_curve import TorqueCurve
from escapement.study.plan import unit_kind

_ALIKE = 0.05  # a smaller correlation of neighbouring residuals hardly changes an interval
# a combination of unknowns with a smaller effect, relative to the strongest, is not determined
_SINGULAR = 1e-4
_INVOLVED = 0.1  # numbers with a smaller share in such a combination are not named in the message


def given_numbers(escapement: Escapement, parameters: Sequence[str]) -> FloatArray:
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


def with_numbers(escapement: Escapement, names: Sequence[str], values: FloatArray) -> Escapement:
    """The escapement with other values of some numbers."""
    for name, value in zip(names, values.tolist(), strict=True):
        escapement = with_number(escapement, name, value)
    return escapement


def check_determined(slopes: FloatArray, names: Sequence[str], least: float) -> None:
    """Raise InvalidValue if measurements do not determine each of the numbers.

    slopes : derivatives of the residuals by the numbers, divided by their given values, and by
        the time of the release, shape (n, m + 1).
    least : length of a column of a number that has no effect.
    """
    lengths = np.linalg.norm(slopes, axis=0)
    for name, length in zip(names, lengths, strict=False):
        if not length > least:
            raise InvalidValue(
                f"parameters must affect the motion, got {name!r}, which does not; leave it out"
            )
    _, sizes, directions = np.linalg.svd(slopes / lengths, full_matrices=False)
    if sizes[-1] < _SINGULAR * sizes[0]:
        shares = np.abs(directions[-1] / lengths)[: len(names)]
        involved = shares > _INVOLVED * shares.max()
        some = [name for name, part in zip(names, involved, strict=True) if part]
        raise InvalidValue(
            f"parameters must each be determined by the motion, got {', '.join(some)}, of which it "
            "shows only a combination; leave one of them out and give its value in escapement"
        )


def chance_of(rest: FloatArray, slopes: FloatArray, waves: FloatArray) -> float:
    """Probability that independent noise looks as much like some waves; NaN if unknown.

    An F test beyond what the unknowns could have fitted. `slopes` and `waves` have a column for
    each, of shapes (n, m) and (n, k).
    """
    lengths = np.linalg.norm(slopes, axis=0)
    fitted, _ = np.linalg.qr(slopes / np.where(lengths > 0.0, lengths, 1.0))
    basis, sizes, _ = np.linalg.svd(waves - fitted @ (fitted.T @ waves), full_matrices=False)
    basis = basis[:, sizes > 1e-6 * math.sqrt(rest.size)]
    rest = rest - fitted @ (fitted.T @ rest)
    explained, count = float(np.sum((basis.T @ rest) ** 2)), basis.shape[1]
    freedom = rest.size - slopes.shape[1] - count
    return f_test(explained, count, float(rest @ rest) - explained, freedom)


def contradicted(p_value: float, autocorrelation: float, samples: int) -> bool:
    """Whether residuals have what independent noise does not have."""
    return p_value < SURE or autocorrelation > max(3.3 / math.sqrt(samples), _ALIKE)


class Told(NamedTuple):
    """A fitted number, and the ends of its interval [SI]."""

    name: str
    value: float
    low: float
    high: float


def numbers_in_words(found: Iterable[Told], confidence: float) -> str:
    """The word "with" and the fitted numbers; "" if there are none."""
    parts = []
    for name, value, low, high in found:
        kind = unit_kind(name)
        unit = factor(kind, spoken.spoken())
        parts.append(
            f"{words(name)} {value / unit:.4g} ({100.0 * confidence:g} % interval "
            f"{low / unit:.4g} to {spoken.as_spoken(high, kind, 4)})"
        )
    return f" with {' and '.join(parts)}; all other numbers are as given" if parts else ""


def fitted_record(found: Iterable[Told], units: str) -> dict[str, Any]:
    """Fitted numbers with their intervals, by name, in the user's units."""
    record = {}
    for name, *numbers in found:
        kind = unit_kind(name)
        value, *ends = in_units([*map(float, numbers)], kind, units)
        record[name] = {"value": value, "interval": ends, "unit": printed(kind, units)}
    return record
