"""Small checks, each raising one line: argument, rule, value received, remedy."""

import contextlib
import difflib
import math
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from importlib import import_module
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any

from escapement.base.errors import InvalidValue, MissingPackage

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray


def fail(name: str, rule: str, value: Any, remedy: str) -> InvalidValue:
    """The error for `name` breaking `rule`; the caller raises it."""
    shown = " ".join(repr(value).split())
    if len(shown) > 80:
        shown = shown[:77] + "..."
    return InvalidValue(f"{name} must be {rule}, got {shown}; {remedy}")


def number(name: str, value: Any, remedy: str = "give a finite real number") -> float:
    """`value` as a finite float."""
    if type(value) is float and math.isfinite(value):  # nearly always: the rest takes a microsecond
        return value
    real = isinstance(value, Real) and not isinstance(value, bool)
    with contextlib.suppress(OverflowError):  # a whole number may be too great for a double
        if real and math.isfinite(value):
            return float(value)
    raise fail(name, "a finite number", value, remedy)


def positive(name: str, value: Any, remedy: str) -> float:
    """`value` as a finite float greater than zero."""
    if (result := number(name, value, remedy)) > 0.0:
        return result
    raise fail(name, "greater than 0", value, remedy)


def non_negative(name: str, value: Any, remedy: str) -> float:
    """`value` as a finite float of at least zero."""
    if (result := number(name, value, remedy)) >= 0.0:
        return result
    raise fail(name, "at least 0", value, remedy)


def numbers(name: str, values: Any, remedy: str) -> "NDArray[float64]":
    """`values` as an array of finite doubles."""
    import numpy as np

    try:
        result = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise fail(name, "real numbers", values, remedy) from None
    if not np.isfinite(result).all():
        raise fail(name, "finite", values, remedy)
    return result


def integer(name: str, value: Any, minimum: int, remedy: str, maximum: float | None = None) -> int:
    """`value` as an int of at least `minimum`, and at most `maximum` where there is one."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < minimum:
        raise fail(name, f"a whole number of at least {minimum}", value, remedy)
    if maximum is not None and int(value) > maximum:
        raise fail(name, f"a whole number of at most {maximum}", value, remedy)
    return int(value)


def truth(name: str, value: Any, remedy: str = "give a truth value") -> bool:
    """`value` as a bool, Python's or NumPy's; numbers are refused."""
    if type(value).__name__ in ("bool", "bool_"):  # NumPy has one of its own
        return bool(value)
    raise fail(name, "true or false", value, remedy)


def rational(name: str, value: Any, remedy: str, maximum: float = math.inf) -> Fraction:
    """`value` as a fraction from 0 to `maximum` with a denominator of at most 1000.

    Text such as "1/2" counts, and so does a double that rounds such a fraction.
    """
    rule = "a rational number of at least 0, its denominator at most 1000"
    try:
        exact = Fraction(value if type(value) is not bool else "")
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        raise fail(name, rule, value, remedy) from None
    # 0.333... stands for 1/3, which no double is
    result = exact.limit_denominator(1000)
    if result < 0 or abs(result - exact) > Fraction(1, 10**12) * (1 + result):
        raise fail(name, rule, value, remedy)
    if result > maximum:
        raise fail(name, f"at most {maximum:g}", str(result), remedy)
    return result


def choice(name: str, value: Any, allowed: Sequence[str]) -> str:
    """`value` as one of `allowed`, else an error naming the nearest."""
    if isinstance(value, str) and value in allowed:
        return str(value)
    # what was typed may be close to one of them
    remedy = nearest(value, allowed, f"for example {allowed[0]!r}")
    raise fail(name, "one of " + ", ".join(allowed), value, remedy)


def nearest(value: Any, allowed: Iterable[str], otherwise: str = "", least: float = 0.6) -> str:
    """A remedy: the closest of `allowed` to what was typed, or `otherwise` where none is close.

    least : the likeness from which one is close, from 0 to 1.
    """
    known = [*allowed]
    close = difflib.get_close_matches(str(value), known, n=1, cutoff=least)
    return f"did you mean {close[0]!r}?" if close else otherwise or f"known are {', '.join(known)}"


def known_keys(
    table: Mapping[str, Any],
    known: Iterable[str],
    where: str,
    elsewhere: Mapping[str, str] | None = None,
) -> None:
    """Raise InvalidValue for the first key of `table` that is not `known`.

    Parameters
    ----------
    table : Mapping
        What the user wrote.
    known : iterable of str
        The keys this place has.
    where : str
        The place, as the message names it: "in [solver]".
    elsewhere : Mapping, optional
        Keys of other places and how to write them there.
    """
    allowed = tuple(known)
    for key in table:
        if key not in allowed:
            home = (elsewhere or {}).get(key)
            remedy = nearest(key, allowed) if home is None else f"it belongs in {home}"
            raise InvalidValue(f"unknown key {str(key)!r} {where}; {remedy}")


def package(name: str, what: str, extra: str = "data") -> Any:
    """The module `name` of an extra, which `what` needs."""
    try:
        return import_module(name)
    except ModuleNotFoundError:
        raise MissingPackage(
            f"{what} needs {name}, which is not installed; "
            f"install it in a clone of the repository with: pip install '.[{extra}]'"
        ) from None
