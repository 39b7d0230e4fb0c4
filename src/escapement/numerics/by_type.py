"""Kernels that belong to the class of a named tuple, as methods belong to an object."""

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from escapement.numerics.jit import PART


def kernel_of_case(name: str) -> Callable[..., Any]:
    """A kernel that calls the one with this name of the class of its first argument.

    That argument is a named tuple. Each class of named tuples has a kernel of its own, which is
    found when the caller is compiled.
    """

    def call(case: Any, *given: Any) -> Any:
        return getattr(type(case), name)(case, *given)

    @overload(call, strict=False, jit_options=PART)
    def _choose(case: Any, *given: Any) -> Callable[..., Any]:
        kernel = getattr(case.instance_class, name)

        def chosen(case: Any, *given: Any) -> Any:
            return kernel(case, *given)

        return chosen

    vars(call)["py_func"] = call  # as of any kernel; see `jit.as_python`
    return call


def give_kernels(owner: type, **kernels: Any) -> None:
    """Make kernels those of a class of named tuples, by their names."""
    for name, kernel in kernels.items():
        setattr(owner, name, kernel)
