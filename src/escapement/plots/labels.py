"""Axis labels: names and units as they are customarily printed.

Data carry units in the spelling of UDUNITS ("rad s-1", "in lbf s2"); a figure
prints "rad/s" and "in·lbf·s²", and picks a prefix that keeps numbers short.
"""

import re
import textwrap

import numpy as np
from numpy.typing import ArrayLike

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PREFIXED = {"s": ("s", "ms", "µs", "ns"), "N m": ("N·m", "mN·m", "µN·m", "nN·m")}
_LINE = 34  # characters of a label that fit beside one panel


def print_unit(unit: str) -> str:
    """A unit in UDUNITS spelling as printed: "rad s-1" becomes "rad/s".

    "1" and the empty string, a pure number, become the empty string.
    """
    above: list[str] = []
    below: list[str] = []
    for factor in unit.split():
        match = re.fullmatch(r"([^\d\-]+)(-?\d+)?", factor)
        if match is None:
            if factor != "1":
                above.append(factor)
            continue
        symbol, power = match[1], int(match[2] or 1)
        raised = "" if abs(power) == 1 else str(abs(power)).translate(_SUPERSCRIPTS)
        (above if power > 0 else below).append(symbol + raised)
    text = "·".join(above)
    return "/".join([text or "1", *below]) if below else text


def label(name: str, unit: str = "", line: int = _LINE) -> str:
    """Text of an axis: name with a capital, its printed unit in brackets.

    line : characters after which it goes on below.
    """
    whole = unit.replace(" ", "~")
    text = name[:1].upper() + name[1:] + (f" ({whole})" if unit else "")
    return textwrap.fill(text, line).replace("~", " ")


def scaled(unit: str, values: ArrayLike) -> tuple[float, str]:
    """Factor and printed unit that bring times and moments to readable numbers.

    Parameters
    ----------
    unit : str
        UDUNITS spelling; seconds and N m get a prefix, the rest stays.
    values : array_like
        What will be plotted; NaN are ignored.

    Returns
    -------
    float, str
        Multiply by the factor to get values in the printed unit.
    """
    names = _PREFIXED.get(unit)
    sizes = np.abs(np.asarray(values, dtype=float))
    finite = sizes[np.isfinite(sizes)]
    largest = float(finite.max()) if finite.size else 0.0
    if names is None or largest <= 0.0:
        return 1.0, print_unit(unit)
    steps = min(max(int(np.ceil(-np.log10(largest) / 3.0)), 0), len(names) - 1)
    return 1000.0**steps, names[steps]


def superscript(power: int) -> str:
    """A whole number as an exponent."""
    return str(power).translate(_SUPERSCRIPTS)


def number_text(value: float) -> str:
    """A number to four figures, its power of ten written out."""
    mantissa, _, power = f"{value:.4g}".partition("e")
    return f"{mantissa}×10{superscript(int(power))}" if power else mantissa


def quantity(name: str, value: float, unit: str) -> str:
    """A parameter and its value in running text: "torque = 0.1 in·lbf"."""
    printed = print_unit(unit)
    return f"{name} = {number_text(value)}" + (f" {printed}" if printed else "")
