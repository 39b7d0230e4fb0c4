"""An axis of a study: a list, one number, or start, stop and num."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement import validate
from escapement.errors import InvalidValue
from escapement.quantity import Quantity
from escapement.validate import known_keys

MOST_VALUES = 10_000_000
_EVEN = ("start", "stop", "num", "log")


def axis_values(name: str, form: Any, parameter: Quantity) -> tuple[NDArray[Any], Any]:
    """Values of one axis and its form as plain JSON.

    Parameters
    ----------
    name : str
        Name of the axis.
    form : number, sequence, one-dimensional array or mapping
        A mapping holds `start`, `stop` and `num`, and may hold `log`: true for
        equal ratios instead of equal differences. Fractions in a sequence may be
        text, "1/2", where the parameter takes them.
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
        For an empty axis, or a value that is no number or breaks the rule.
    """
    if isinstance(form, Mapping):
        return _even_values(name, form, parameter)
    if parameter.fraction and isinstance(form, list | tuple):
        form = [
            parameter.read(f"{name}[{i}]", x) if isinstance(x, str) else x
            for i, x in enumerate(form)
        ]
    values = parameter.read_all(name, _flat(name, form))
    if values.size == 0:
        raise InvalidValue(f"{name} must have at least one value, got an empty axis; give a list")
    if values.size > MOST_VALUES:
        raise _too_long(name, values.size)
    return values, values.tolist()


def _flat(name: str, form: Any) -> NDArray[np.float64]:
    """A list, tuple, array or single number as a one-dimensional float array."""
    if isinstance(form, list | tuple):
        return np.array([validate.number(f"{name}[{i}]", x) for i, x in enumerate(form)])
    if isinstance(form, str | bytes | bool) or form is None:
        raise _not_an_axis(name, form)
    if np.ma.is_masked(form):
        raise validate.fail(name, "free of masked values", form, "give those that count alone")
    try:
        array = np.asarray(form)
    except ValueError:
        raise _not_an_axis(name, form) from None
    if array.dtype.kind == "O" and array.ndim == 1:
        return _flat(name, array.tolist())
    if array.ndim > 1:
        raise validate.fail(
            name, "one-dimensional", f"shape {array.shape}", "give a flat list of values"
        )
    if array.dtype.kind not in "iuf":
        raise _not_an_axis(name, form)
    return np.array(array, dtype=float, ndmin=1)


def _even_values(
    name: str, form: Mapping[str, Any], parameter: Quantity
) -> tuple[NDArray[Any], dict[str, Any]]:
    """Values at equal differences, or with `log` at equal ratios."""
    known_keys(form, _EVEN, f"in axis {name}")
    missing = [key for key in _EVEN[:3] if key not in form]
    if missing:
        raise InvalidValue(
            f"axis {name} lacks {' and '.join(missing)}; "
            "write { start = ..., stop = ..., num = ... }"
        )
    start = parameter.read(f"{name}.start", form["start"])
    stop = parameter.read(f"{name}.stop", form["stop"])
    num = validate.integer(f"{name}.num", form["num"], 1, "give the number of values")
    if num > MOST_VALUES:
        raise _too_long(name, num)
    if num == 1 and stop != start:
        raise validate.fail(
            f"{name}.num", "at least 2 where start and stop differ", num, "give [start] alone"
        )
    log = validate.truth(f"{name}.log", form.get("log", False), "leave it out for even steps")
    plain = {"start": start, "stop": stop, "num": num}
    if not log:
        return parameter.read_all(name, np.linspace(start, stop, num)), plain
    for key in ("start", "stop"):
        validate.positive(f"{name}.{key}", plain[key], "a logarithmic axis cannot reach 0")
    values = np.geomspace(start, stop, num)
    if parameter.whole:
        nearest = np.rint(values)
        values = np.where(np.isclose(values, nearest, rtol=1e-12), nearest, values)
    return parameter.read_all(name, values), plain | {"log": True}


def _not_an_axis(name: str, form: Any) -> InvalidValue:
    return validate.fail(
        name,
        "a list of numbers, one number, or start, stop and num",
        form,
        "give for example [0.2, 0.3]",
    )


def _too_long(name: str, size: int) -> InvalidValue:
    return InvalidValue(
        f"{name} must have at most {MOST_VALUES} values, got {size}; split the study"
    )
