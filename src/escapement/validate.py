"""Small checks, each raising one line: argument, rule, value received, remedy."""

import math
import operator
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from escapement.errors import InvalidValue

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray


def fail(name: str, rule: str, value: Any, remedy: str) -> InvalidValue:
    """The error for `name` breaking `rule`; the caller raises it."""
    try:
        shown = " ".join(repr(value).split())
    except ValueError:  # more digits than Python writes out
        shown = f"a number of {value.bit_length()} bits"
    if len(shown) > 80:
        shown = shown[:77] + "..."
    return InvalidValue(f"{name} must be {rule}, got {shown}; {remedy}")


def number(name: str, value: Any, remedy: str = "give a finite real number") -> float:
    """`value` as a finite float; of an array only one without dimensions will do."""
    if type(value) is float and math.isfinite(value):
        return value
    rule = "a finite number"
    if isinstance(value, bool | str | bytes | complex) or not _is_plain(value, "iuf"):
        raise fail(name, rule, value, remedy)
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        raise fail(name, rule, value, remedy) from None
    if not math.isfinite(result):
        raise fail(name, rule, value, remedy)
    return result


def _is_plain(value: Any, kinds: str) -> bool:
    """Whether a NumPy value is a single one of these kinds; others are not its business."""
    dtype = getattr(value, "dtype", None)
    if dtype is None:
        return True
    single = not getattr(value, "ndim", 0) and not getattr(value, "mask", False)
    return single and getattr(dtype, "kind", "") in kinds


def positive(name: str, value: Any, remedy: str) -> float:
    """`value` as a finite float greater than zero."""
    result = number(name, value, remedy)
    if not result > 0.0:
        raise fail(name, "greater than 0", value, remedy)
    return result


def non_negative(name: str, value: Any, remedy: str) -> float:
    """`value` as a finite float of at least zero."""
    result = number(name, value, remedy)
    if not result >= 0.0:
        raise fail(name, "at least 0", value, remedy)
    return result


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


def integer(name: str, value: Any, minimum: int, remedy: str, maximum: int | None = None) -> int:
    """`value` as an int of at least `minimum`, and at most `maximum` where there is one."""
    if type(value) is int and value >= minimum and (maximum is None or value <= maximum):
        return value
    rule = f"a whole number of at least {minimum}"
    if isinstance(value, bool) or not _is_plain(value, "iu"):
        raise fail(name, rule, value, remedy)
    try:
        result = operator.index(value)
    except TypeError:
        raise fail(name, rule, value, remedy) from None
    if result < minimum:
        raise fail(name, rule, value, remedy)
    if maximum is not None and result > maximum:
        raise fail(name, f"a whole number of at most {maximum}", value, remedy)
    return result


def truth(name: str, value: Any, remedy: str = "give a truth value") -> bool:
    """`value` as a bool, Python's or a single one of NumPy's; numbers are none."""
    if isinstance(value, bool) or (hasattr(value, "dtype") and _is_plain(value, "b")):
        return bool(value)
    raise fail(name, "true or false", value, remedy)


def rational(name: str, value: Any, remedy: str, maximum: float = math.inf) -> Fraction:
    """`value` as a fraction from 0 to `maximum` with a denominator of at most 1000.

    Text such as "1/2" counts, and so does a double that rounds such a fraction.
    """
    rule = "a rational number of at least 0, its denominator at most 1000"
    try:
        if isinstance(value, bool) or not _is_plain(value, "iufU"):
            raise TypeError
        exact = Fraction(value.item() if hasattr(value, "item") else value)
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        raise fail(name, rule, value, remedy) from None
    result = exact.limit_denominator(1000)
    if result < 0 or abs(result - exact) > Fraction(1, 10**12) * (1 + result):
        raise fail(name, rule, value, remedy)
    if result > maximum:
        raise fail(name, f"at most {maximum:g}", str(result), remedy)
    return result


def choice(name: str, value: Any, allowed: tuple[str, ...]) -> str:
    """`value` as one of `allowed`, else an error naming the nearest."""
    if isinstance(value, str) and value in allowed:
        return str(value)
    raise fail(name, "one of " + ", ".join(allowed), value, nearest(value, allowed))


def nearest(value: Any, allowed: tuple[str, ...]) -> str:
    """A remedy: the closest of `allowed` to what was typed."""
    return _close(value, allowed) or f"for example {allowed[0]!r}"


def did_you_mean(name: str, known: tuple[str, ...]) -> str:
    """A remedy for a name that there is none of: the closest that is known, or all of them."""
    return _close(name, known) or f"known are {', '.join(known)}"


def _close(value: Any, allowed: tuple[str, ...]) -> str:
    import difflib

    close = difflib.get_close_matches(str(value), allowed, n=1, cutoff=0.5)
    return f"did you mean {close[0]!r}?" if close else ""


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
            remedy = did_you_mean(str(key), allowed) if home is None else f"it belongs in {home}"
            raise InvalidValue(f"unknown key {str(key)!r} {where}; {remedy}")
