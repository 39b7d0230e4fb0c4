"""Long kernels that many others call, compiled once.

A kernel's machine code holds all it calls, compiled anew in every caller and in the callers
of that. Of a call by address it holds the call alone.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numba
from numba.core import types
from numba.extending import intrinsic


def by_address(
    kernel: Any, place: int, arguments: tuple[Any, ...]
) -> tuple[Any, Callable[[], int]]:
    """A call of a kernel whose address comes in a tuple of such.

    Parameters
    ----------
    kernel : dispatcher
        Made by `jit`. It must neither raise nor make arrays.
    place : int
        Where in the tuple its address stands.
    arguments : tuple of Numba types
        Of its arguments; a caller whose own differ does not compile.

    Returns
    -------
    call
        For kernels: call(addresses, ...) is kernel(...).
    address
        The kernel's in this process; it is compiled, or loaded, when first asked for.
    """
    config: Any = numba.config
    if config.DISABLE_JIT:
        return (lambda _addresses, *given: kernel(*given)), (lambda: 0)
    accepted = arguments

    @cache
    def compiled() -> Any:
        kernel.compile(accepted)
        return kernel.overloads[accepted]

    @cache
    def address() -> int:
        code = compiled()
        return int(code.library.get_pointer_to_function(code.fndesc.llvm_func_name))

    def emit(context: Any, builder: Any, full: Any, values: Any) -> Any:
        addresses, given = values
        result = full.return_type
        pointer = context.call_conv.get_function_type(result, accepted).as_pointer()
        function = builder.inttoptr(builder.extract_value(addresses, place), pointer)
        row = [builder.extract_value(given, k) for k in range(len(accepted))]
        return context.call_conv.call_function(builder, function, result, accepted, row)[1]

    @intrinsic
    def call(context: Any, addresses: Any, *given: Any) -> Any:
        if len(given) != len(accepted) or None in map(context.can_convert, given, accepted):
            return None
        row = types.StarArgTuple.from_types(accepted)
        return compiled().signature.return_type(addresses, row), emit

    return call, address
