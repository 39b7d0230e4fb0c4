"""Calls of a kernel by its address, for long kernels that many others call.

The machine code of a kernel contains that of every kernel it calls, which Numba compiles
anew for each caller, and for the callers of those. With a call by address the caller
contains only the call, and the long kernel is compiled once.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numba
from numba.core import types
from numba.extending import intrinsic

from escapement.numerics.jit import in_both_forms


def by_address(
    kernel: Any, index: int, variants: Sequence[tuple[Any, ...]]
) -> tuple[Any, Callable[[int], int]]:
    """Make a call of a kernel whose address is handed over in an array of addresses.

    Parameters
    ----------
    kernel : callable
        A kernel made by `jit` that neither raises nor allocates arrays.
    index : int
        Index of its address in the array of addresses.
    variants : sequence of tuples of Numba types
        Types of its arguments, of which the first one tells the variants apart. A caller with
        other types does not compile.

    Returns
    -------
    call
        For use in kernels: call(addresses, ...) gives what kernel(...) gives, where `addresses`
        is an array of int64.
    address
        Returns the address of a variant, by its number, in this process; the first call
        compiles or loads it.
    """

    def in_python(_addresses: Any, *given: Any) -> Any:
        return kernel(*given)

    config: Any = numba.config
    if config.DISABLE_JIT:
        return in_python, (lambda _variant: 0)
    dispatcher = getattr(kernel, "compiled", kernel)

    @cache
    def compiled(arguments: tuple[Any, ...]) -> Any:
        dispatcher.compile(arguments)
        return dispatcher.overloads[arguments]

    @cache
    def address(variant: int) -> int:
        code = compiled(variants[variant])
        return int(code.library.get_pointer_to_function(code.fndesc.llvm_func_name))

    # the address is read from the array when the call runs, since it differs between processes
    def emit(context: Any, builder: Any, full: Any, values: Any) -> Any:
        addresses, given = values
        result, arguments = full.return_type, tuple(full.args[1])
        pointer = context.call_conv.get_function_type(result, arguments).as_pointer()
        held = context.make_array(full.args[0])(context, builder, addresses)
        location = builder.gep(held.data, [context.get_constant(types.intp, index)])
        function = builder.inttoptr(builder.load(location), pointer)
        row = [builder.extract_value(given, k) for k in range(len(arguments))]
        return context.call_conv.call_function(builder, function, result, arguments, row)[1]

    @intrinsic
    def call(context: Any, addresses: Any, *given: Any) -> Any:
        for arguments in variants:
            if given[0] == arguments[0] and len(given) == len(arguments):
                if None in map(context.can_convert, given, arguments):
                    return None
                row = types.StarArgTuple.from_types(arguments)
                return compiled(arguments).signature.return_type(addresses, row), emit
        return None

    return in_both_forms(call, in_python), address
