"""Kernels that answer as plain Python first, and are compiled when that pays.

Compiling all kernels takes minutes, while one motion takes a tenth of a second in plain Python.
A process that finds no compiled kernels on disk therefore begins with the Python source of its
kernels. It changes over to compiled code, once and for all kernels,
- when `compile_from_now_on` is called, by work that consists of many cases,
- when kernels have called kernels `PATIENCE` times in Python,
- when a kernel does what only compiled code can, such as a division by zero that gives infinity.
In the last two cases the call that was running is repeated from its start. The arrays among its
arguments are first set back to what they held, since kernels write into them.
"""

import functools
import threading
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numba.core.registry import cpu_target
from numba.extending import typeof_impl

from escapement.base.notice import notice

PATIENCE = 2_000_000
"""Calls of kernels by kernels in Python after which a process compiles: some seconds.

Calls are counted, and no time is taken, so that a busy machine does the same as a quiet one.
"""

_REFUSED = (ArithmeticError, ValueError)
"""What Python raises for arithmetic that compiled code answers with infinity or NaN."""


class _Patience(Exception):
    """The calls in Python are used up."""


class _Process:
    """Whether this process still interprets, and how much it has."""

    def __init__(self) -> None:
        self.interprets = self.compiles = False
        self.calls = 0
        self.fills: list[Callable[[], None]] = []


class _Thread(threading.local):
    """Whether this thread is within a kernel."""

    inside = False


_process, _thread = _Process(), _Thread()


def begin_interpreted() -> None:
    """Kernels run as Python source until compiling pays, unless it was asked for already."""
    _process.interprets = not _process.compiles


def interprets() -> bool:
    """Whether kernels run as Python source."""
    return _process.interprets


def compile_from_now_on() -> None:
    """Compile each kernel at its next call, since many calls will follow."""
    while _process.fills:
        _process.fills.pop()()
    _process.interprets, _process.compiles = False, True


def when_compiled(fill: Callable[[], None]) -> None:
    """Call a function as soon as kernels are compiled, which may be at once."""
    if _process.interprets:
        _process.fills.append(fill)
    else:
        fill()


class Kernel:
    """A kernel in both forms: Python source, and compiled.

    compiled : what Numba made of it, which other compiled kernels call.
    py_func : the Python function.
    """

    def __init__(self, compiled: Any, py_func: Any) -> None:
        self.compiled, self.py_func = compiled, py_func
        # Numba inlines by this attribute of what a kernel calls. Without it a kernel that shares
        # the references of its caller would be compiled alone, and free memory of others.
        self.targetoptions = getattr(compiled, "targetoptions", {})
        functools.update_wrapper(self, py_func)

    def __call__(self, *given: Any, **named: Any) -> Any:
        if not _process.interprets:
            return self.compiled(*given, **named)
        if not _thread.inside:
            return self._first(given, named)
        _process.calls += 1
        if _process.calls > PATIENCE:
            raise _Patience
        return self.py_func(*given, **named)

    def _first(self, given: tuple[Any, ...], named: dict[str, Any]) -> Any:
        """Answer a call that comes from outside all kernels."""
        notice.interpret()
        arrays = list(_arrays((*given, *named.values())))
        before = [array.copy() for array in arrays]
        _thread.inside = True
        try:
            with np.errstate(all="ignore"):
                return self.py_func(*given, **named)
        except (_Patience, *_REFUSED):
            for array, values in zip(arrays, before, strict=True):
                array[...] = values
        finally:
            _thread.inside = False
        compile_from_now_on()
        return self.compiled(*given, **named)


def in_both_forms(intrinsic: Any, py_func: Callable[..., Any]) -> Any:
    """An intrinsic of Numba, and what it does as a Python function, as one kernel."""
    config: Any = numba.config
    if config.DISABLE_JIT:
        return py_func
    return Kernel(intrinsic, py_func) if interprets() else intrinsic


def _arrays(given: Any) -> Any:
    """The arrays among arguments that can be written, within tuples too."""
    for value in given:
        if isinstance(value, tuple):
            yield from _arrays(value)
        elif isinstance(value, np.ndarray) and value.flags.writeable:
            yield value


@typeof_impl.register(Kernel)
def _type_of_kernel(kernel: Kernel, _purpose: Any) -> Any:
    """Compiled kernels that name this one call its compiled form."""
    return cpu_target.typing_context.resolve_value_type(kernel.compiled)
