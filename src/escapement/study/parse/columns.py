"""Columns of values in the user's units: axes, and the distributions of a sample.

With each come plain JSON from which the same column can be made again.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement.base import units, validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Quantity
from escapement.base.validate import known_keys
from escapement.mechanisms.protocol import FloatArray
from escapement.model.friction_pairs import friction_range

NEVER = 1e-10
"""Share of a normal distribution at either side that no draw reaches."""
_ENDS = ("low", "high")
_BESIDE = {
    "": (*_ENDS, "log"),
    "tolerance": (),
    "relative_tolerance": (),
    "standard_deviation": _ENDS,
    "relative_standard_deviation": _ENDS,
    "log_standard_deviation": _ENDS,
}
"""Keys of a distribution besides that of its width; a distribution without a width has ends."""
WIDTHS = frozenset(_BESIDE) - {""}
"""Keys of a distribution that lies around the nominal value."""
MOST_VALUES = 10_000_000

Column = tuple[NDArray[Any], Any]
"""Values of a parameter, and plain JSON from which the same values can be made again."""


def axis_values(form: Any, parameter: Quantity) -> Column:
    """Values of one axis and its form as plain JSON.

    Parameters
    ----------
    form : number, text with a unit, sequence, one-dimensional array or mapping
        A mapping holds `start`, `stop` and `num`, and may hold `log`: true for equal
        ratios instead of equal differences. Of a coefficient of friction, `pair` instead of both
        ends names a range of `model.friction_pairs`.
    parameter : Quantity
        The rule every value obeys.

    Returns
    -------
    values : ndarray, shape (n,), float64 or (whole numbers) int64
        In the units of the form.
    plain : list or dict
        The same axis as JSON can hold it.

    Raises
    ------
    InvalidValue
        For an empty axis, or a value that is not a number or breaks the rule.
    """
    if isinstance(form, Mapping):
        return _even_values(form, parameter)
    name = parameter.name
    if type(form) is np.ndarray and form.ndim == 1 and form.size and form.dtype.kind in "fiu":
        values = parameter.read_all(name, form.astype(float))
        return values, values.tolist()
    # asanyarray keeps a mask, whose values become None and are refused one by one
    items = form if isinstance(form, list | tuple) else np.asanyarray(form).tolist()
    if not isinstance(items, list | tuple):
        items = [items]
    if not items:
        raise InvalidValue(f"{name} must have at least one value, got an empty axis; give a list")
    numbers = [parameter.read(f"{name}[{i}]", item) for i, item in enumerate(items)]
    values = parameter.read_all(name, np.array(numbers, dtype=float))
    return values, values.tolist()


def _even_values(form: Mapping[str, Any], parameter: Quantity) -> Column:
    """Values at equal differences, or with `log` at equal ratios."""
    name = parameter.name
    if "pair" in form and name.endswith("friction"):
        known_keys(form, ("pair", "num", "log"), f"in axis {name} with a pair")
        pair = friction_range(f"{name}.pair", str(form["pair"]))
        rest = {key: value for key, value in form.items() if key != "pair"}
        form = {"start": pair.low, "stop": pair.high} | rest
    known_keys(form, ("start", "stop", "num", "log"), f"in axis {name}")
    start, stop = (parameter.read(f"{name}.{end}", form.get(end)) for end in ("start", "stop"))
    fewest = 1 if start == stop else 2
    remedy = "give the number of values, both ends included"
    num = validate.integer(f"{name}.num", form.get("num"), fewest, remedy, MOST_VALUES)
    plain = {"start": start, "stop": stop, "num": num}
    if not validate.truth(f"{name}.log", form.get("log", False)):
        return parameter.read_all(name, np.linspace(start, stop, num)), plain
    for end in ("start", "stop"):
        validate.positive(f"{name}.{end}", plain[end], "a logarithmic axis cannot reach 0")
    values = np.geomspace(start, stop, num)
    if parameter.whole:
        # geomspace misses powers of two by a rounding error
        nearest = np.rint(values)
        values = np.where(np.isclose(values, nearest, rtol=1e-12), nearest, values)
    return parameter.read_all(name, values), plain | {"log": True}


def drawn_values(
    form: Any, parameter: Quantity, nominal: float | None, share: FloatArray
) -> NDArray[Any]:
    """Values below which the given shares of a distribution lie, of which some may break a rule."""
    return _distributed(form, parameter, nominal, share)[0]


def drawn_within(
    form: Any, parameter: Quantity, nominal: float | None, share: FloatArray
) -> Column:
    """Values below which the given shares (0 to 1) of a distribution lie, and its form."""
    values, plain = _distributed(form, parameter, nominal, share)
    cut = replace(parameter, remedy="cut its distribution off with low or high")
    return cut.read_all(f"sample.{parameter.name}", values), plain


def _distributed(
    form: Any, parameter: Quantity, nominal: float | None, share: FloatArray
) -> Column:
    """As `drawn_within`, without the check of the values."""
    label = f"sample.{parameter.name}"
    if parameter.whole or parameter.fraction:
        raise InvalidValue(
            f"{label} must be left out, whole numbers and fractions cannot be drawn at random; "
            f'write {parameter.name} in [sweep], or use method = "list"'
        )
    if isinstance(form, str) and parameter.name.endswith("friction"):
        pair = friction_range(label, form)
        form = {"low": pair.low, "high": pair.high}
    if not isinstance(form, Mapping):
        remedy = "write for example { relative_tolerance = 0.05 }"
        raise validate.fail(label, "a table that says how it varies", form, remedy)
    known_keys(form, (*_BESIDE[""], *WIDTHS), f"in {label}")
    width = next((key for key in _BESIDE if key in form), "")
    known_keys(form, (width, *_BESIDE[width]), f"in {label} with {width or 'two ends'}")
    if width:
        return _around(form, width, parameter, nominal, share)
    return _between(form, parameter, share)


def _between(form: Mapping[str, Any], parameter: Quantity, share: FloatArray) -> Column:
    """A uniform distribution between two ends, or one whose logarithm is uniform."""
    label = f"sample.{parameter.name}"
    low, high = (parameter.read(f"{label}.{end}", form.get(end)) for end in _ENDS)
    if not low < high:
        raise validate.fail(f"{label}.high", f"greater than low = {low:g}", high, "exchange them")
    plain = {"low": low, "high": high}
    if not validate.truth(f"{label}.log", form.get("log", False)):
        return np.clip(low + share * (high - low), low, high), plain
    validate.positive(f"{label}.low", low, "a logarithmic spread cannot reach 0")
    return np.clip(low * (high / low) ** share, low, high), plain | {"log": True}


def _around(
    form: Mapping[str, Any], key: str, parameter: Quantity, nominal: float | None, share: FloatArray
) -> Column:
    """A distribution around the nominal value, uniform or normal."""
    label = f"sample.{parameter.name}"
    if nominal is None:
        raise InvalidValue(
            f"{label} must have a nominal value to spread around, got none; "
            f"give {parameter.label} a fixed value, or {label} low and high"
        )
    log, remedy = key.startswith("log"), "a parameter without one stays fixed"
    relative = key.startswith("relative")
    kind = "ratio" if relative or log else parameter.unit
    given = units.measured(f"{label}.{key}", form[key], kind, parameter.system, remedy)
    given = validate.positive(f"{label}.{key}", given, remedy)
    width = given * nominal if relative else given
    if width == 0.0:
        raise InvalidValue(
            f"{label}.{key} must be a part of a nominal value other than 0, got 0; "
            f"give {key.removeprefix('relative_')} in its own unit"
        )
    if key.endswith("tolerance"):
        low = parameter.read(f"the lowest value of {label}", nominal - width)
        high = parameter.read(f"the highest value of {label}", nominal + width)
        return np.clip(low + share * (high - low), low, high), {key: given}
    ends = {end: parameter.read(f"{label}.{end}", form[end]) for end in _ENDS if end in form}
    low, high = ends.get("low", -np.inf), ends.get("high", np.inf)
    if not low <= nominal <= high:
        raise InvalidValue(
            f"{label} must have its nominal value between low and high, got {nominal:g}; "
            "move the end beyond it"
        )
    from scipy.special import ndtr, ndtri

    if log:
        with np.errstate(divide="ignore", invalid="ignore"):
            nominal, low, high = np.log([nominal, max(low, 0.0), high])
        validate.positive(
            f"the nominal value of {label}", float(np.exp(nominal)), "it has a logarithm"
        )
        width = given
    # truncnorm has the same distribution, but other bits than files of the same seed hold
    below, up_to = (ndtr((end - nominal) / width) for end in (low, high))
    # a share of exactly 0 or 1 would be infinitely far away
    inside = np.clip(below + share * (up_to - below), NEVER, 1.0 - NEVER)
    values = np.clip(nominal + width * ndtri(inside), low, high)
    return np.exp(values) if log else values, {key: given} | ends
