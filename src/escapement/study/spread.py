"""How one parameter spreads: evenly between two ends, or normally around its nominal value."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from escapement import validate
from escapement.errors import InvalidValue
from escapement.model import FloatArray
from escapement.quantity import Quantity
from escapement.validate import known_keys

WIDTHS = ("tolerance", "relative_tolerance", "standard_deviation", "relative_standard_deviation")
"""Ways to say how wide a parameter spreads around its nominal value."""

_KEYS = ("low", "high", "log", *WIDTHS)
_EXAMPLE = "write for example { relative_tolerance = 0.05 }"
_FLAT = 1e-8  # standard deviations: over so few a normal distribution is even
_NEVER = 1e-10  # part of a normal distribution on either side that no draw reaches


@dataclass(frozen=True)
class Spread:
    """A distribution of one parameter, in the user's units.

    low, high : ends; infinite where a normal distribution has none.
    nominal, deviation : mean and standard deviation of a normal distribution; None
        for an even one.
    log : whether the logarithm is what is spread evenly.
    form : as the configuration states it.
    """

    low: float
    high: float
    form: dict[str, Any]
    nominal: float | None = None
    deviation: float | None = None
    log: bool = False

    @property
    def around(self) -> bool:
        """Whether it lies around the nominal value, wherever that is."""
        return any(key in self.form for key in WIDTHS)

    def at(self, share: FloatArray) -> FloatArray:
        """Values below which the given shares (0 to 1) of the distribution lie."""
        width = self.high - self.low
        if self.nominal is not None and self.deviation and width > _FLAT * self.deviation:
            from scipy.special import ndtr, ndtri

            below, up_to = (ndtr((end - self.nominal) / self.deviation)
                            for end in (self.low, self.high))  # fmt: skip
            inside = np.clip(below + share * (up_to - below), _NEVER, 1.0 - _NEVER)
            values = self.nominal + self.deviation * ndtri(inside)
        elif self.log:
            ratio = self.high / self.low
            if ratio < np.inf:
                values = self.low * ratio**share
            else:
                values = self.low ** (1.0 - share) * self.high**share
        else:
            values = self.low + share * width
        result: FloatArray = np.clip(values, self.low, self.high)
        return result


def parse_spread(name: str, form: Any, parameter: Quantity, nominal: float | None) -> Spread:
    """The distribution of one sampled parameter.

    Parameters
    ----------
    name : str
        Its name.
    form : mapping
        `low` and `high`, with `log` for equal ratios; or one of `tolerance` (half the
        width of an even distribution around `nominal`), `standard_deviation` (of a
        normal one, which `low` and `high` may cut off), and the same as a part of
        `nominal` with `relative_` before it.
    parameter : Quantity
        The rule its values obey.
    nominal : float or None
        The fixed value.

    Raises
    ------
    InvalidValue
        For another form, or one that reaches values which break the rule.
    """
    label = f"sample.{name}"
    if parameter.whole or parameter.fraction:
        numbers = "whole numbers" if parameter.whole else "fractions"
        raise InvalidValue(
            f"{label} must be left out, {numbers} are not drawn at random; "
            f'write {name} in [sweep], or use method = "list"'
        )
    if not isinstance(form, Mapping):
        raise validate.fail(label, "a table that says how it spreads", form, _EXAMPLE)
    known_keys(form, _KEYS, f"in {label}")
    widths = [key for key in WIDTHS if key in form]
    if len(widths) > 1:
        raise validate.fail(label, "spread in one way", " and ".join(widths), "leave one out")
    if not widths:
        return _between(label, form, parameter)
    return _around(label, form, widths[0], parameter, nominal)


def _between(label: str, form: Mapping[str, Any], parameter: Quantity) -> Spread:
    """An even distribution between two ends."""
    missing = [key for key in ("low", "high") if key not in form]
    if missing:
        raise InvalidValue(
            f"{label} lacks {' and '.join(missing)}; write {{ low = ..., high = ... }}, "
            "or a tolerance around the nominal value"
        )
    low, high = (parameter.read(f"{label}.{key}", form[key]) for key in ("low", "high"))
    plain: dict[str, Any] = {"low": low, "high": high}
    _check_order(label, low, high)
    log = validate.truth(f"{label}.log", form.get("log", False), "leave it out for even steps")
    if log:
        validate.positive(f"{label}.low", low, "a logarithmic spread cannot reach 0")
        plain["log"] = True
    return Spread(low, high, plain, log=log)


def _around(
    label: str, form: Mapping[str, Any], key: str, parameter: Quantity, nominal: float | None
) -> Spread:
    """A distribution around the nominal value, even or normal."""
    if nominal is None:
        raise InvalidValue(
            f"{label} must have a nominal value to spread around, got none; "
            f"give {parameter.label} a fixed value, or {label} low and high"
        )
    if "log" in form:
        raise validate.fail(
            f"{label}.log", f"left out with {key}", form["log"], "it goes with low and high"
        )
    width = validate.positive(f"{label}.{key}", form[key], "a parameter without one stays fixed")
    plain: dict[str, Any] = {key: width}
    if key.startswith("relative"):
        width *= nominal
        if width == 0.0:
            raise InvalidValue(
                f"{label}.{key} must be a part of a nominal value other than 0, got {nominal:g}; "
                f"give {key.removeprefix('relative_')} in its own unit"
            )
    if key.endswith("tolerance"):
        for end in ("low", "high"):
            if end in form:
                raise validate.fail(
                    f"{label}.{end}", f"left out with {key}", form[end], "give one or the other"
                )
        low = parameter.read(f"the lowest value of {label}", nominal - width)
        high = parameter.read(f"the highest value of {label}", nominal + width)
        return Spread(low, high, plain)
    ends = {"low": -np.inf, "high": np.inf}
    for end in ends:
        if end in form:
            ends[end] = plain[end] = parameter.read(f"{label}.{end}", form[end])
    _check_order(label, ends["low"], ends["high"])
    if not ends["low"] <= nominal <= ends["high"]:
        raise InvalidValue(
            f"{label} must have its nominal value between low and high, got {nominal:g}; "
            "move the end beyond it"
        )
    return Spread(ends["low"], ends["high"], plain, nominal, width)


def _check_order(label: str, low: float, high: float) -> None:
    if not low < high:
        raise validate.fail(f"{label}.high", f"greater than low = {low:g}", high, "exchange them")
