"""Numbers with their derivatives, which differentiate the formulas of a kernel.

A `Dual` holds values of any shape and, for each of them, the derivatives by k numbers. NumPy's
functions and Python's operators work on it, so that a formula written for numbers gives
the exact derivatives too (forward differentiation).
"""

import sys
from collections.abc import Callable
from functools import cache
from types import FunctionType, ModuleType
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin


def _power(a: Any, b: Any) -> tuple[Any, Any]:
    return b * a ** (b - 1.0), 0.0


_RULES: dict[Any, Callable[..., tuple[Any, ...]]] = {
    np.add: lambda a, b: (1.0, 1.0),
    np.subtract: lambda a, b: (1.0, -1.0),
    np.multiply: lambda a, b: (b, a),
    np.divide: lambda a, b: (1.0 / b, -a / (b * b)),
    np.power: _power,
    np.hypot: lambda a, b: (a / np.hypot(a, b), b / np.hypot(a, b)),
    np.arctan2: lambda a, b: (b / (a * a + b * b), -a / (a * a + b * b)),
    np.maximum: lambda a, b: (a >= b, a < b),
    np.copysign: lambda a, b: (np.copysign(1.0, a) * np.copysign(1.0, b), 0.0),
    np.negative: lambda a: (-1.0,),
    # at 0 the sign of zero shows from which side it is reached
    np.absolute: lambda a: (np.copysign(1.0, a),),
    np.sqrt: lambda a: (0.5 / np.sqrt(a),),
    np.exp: lambda a: (np.exp(a),),
    np.log: lambda a: (1.0 / a,),
    np.sin: lambda a: (np.cos(a),),
    np.cos: lambda a: (-np.sin(a),),
    np.arcsin: lambda a: (1.0 / np.sqrt(1.0 - a * a),),
    np.arccos: lambda a: (-1.0 / np.sqrt(1.0 - a * a),),
    np.sign: lambda a: (0.0,),
    np.floor: lambda a: (0.0,),
}
"""The derivatives of each function by its arguments."""
_COMPARED = {np.less, np.less_equal, np.greater, np.greater_equal, np.equal, np.not_equal}


class Dual(NDArrayOperatorsMixin):
    """Values with derivatives by k numbers.

    value : array of any shape.
    slopes : array of that shape with one more dimension at the end, of length k.

    A comparison is one answer for all values, so that kernels can branch on it; they must agree.
    A dual is equal to a number only if its derivatives are zero, so that a quantity that is zero
    but varies does not count as absent.
    """

    def __init__(self, value: Any, slopes: Any) -> None:
        self.value, self.slopes = np.asarray(value, dtype=float), np.asarray(slopes, dtype=float)

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        return self.value

    def __float__(self) -> float:
        return float(self.value)

    def __getitem__(self, index: Any) -> "Dual":
        return Dual(self.value[index], self.slopes[index])

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or options:
            return NotImplemented
        values = [x.value if isinstance(x, Dual) else np.asarray(x, dtype=float) for x in inputs]
        duals = [x if isinstance(x, Dual) else None for x in inputs]
        if function in _COMPARED:
            return self._agreed(function, values, duals)
        if function not in _RULES:
            return NotImplemented
        parts = _RULES[function](*values)
        result = function(*values)
        slopes: Any = 0.0
        for part, dual in zip(parts, duals, strict=True):
            if dual is not None:
                slopes = slopes + np.asarray(part)[..., None] * dual.slopes
        shape = (*np.shape(result), slopes.shape[-1])
        return Dual(result, np.broadcast_to(slopes, shape))

    def _agreed(self, function: Any, values: Any, duals: Any) -> bool:
        answers = np.asarray(function(*values))
        if function in (np.equal, np.not_equal):
            if any(dual is not None and dual.slopes.any() for dual in duals):
                return bool(function is np.not_equal)
        elif function is np.greater and values[0].ndim == 0 and values[0] == values[1]:
            # a quantity that varies around 0 is not absent
            return duals[0] is not None and bool(duals[0].slopes.any())
        if answers.all():
            return True
        if answers.any():
            raise ValueError("the values of a dual lie on both sides of a branch")
        return False

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function is not np.where:
            return NotImplemented
        condition, one, two = args
        return one if np.all(condition) else two if not np.any(condition) else NotImplemented


def value_of(x: Any) -> Any:
    """The value of a dual, or of a number."""
    return x.value if isinstance(x, Dual) else np.asarray(x, dtype=float)


def slopes_of(x: Any, count: int) -> Any:
    """Derivatives of a dual by each of `count` numbers; those of a number are zero."""
    return x.slopes if isinstance(x, Dual) else np.zeros((*np.shape(x), count))


@cache
def uncompiled(module: ModuleType) -> dict[str, Any]:
    """The contents of a module, with its kernels as Python functions that accept duals.

    So the differentiated law is the same as the one that is compiled for the engines.
    """
    found: dict[str, Any] = dict(vars(module))
    for name, value in vars(module).items():
        function = getattr(value, "py_func", None)
        if function is None:
            continue
        home = sys.modules[function.__module__]
        if home is module:
            found[name] = FunctionType(function.__code__, found, name, function.__defaults__)
        else:
            found[name] = uncompiled(home)[function.__name__]
    return found
