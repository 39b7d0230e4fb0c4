"""Calls of a kernel by its address, for long kernels that many others call.

The machine code of a kernel contains that of every kernel it calls, which Numba compiles
anew for each caller, and for the callers of those. With a call by address the caller
contains only the call, and the long kernel is compiled once.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numba
from numba import typeof
from numba.core import types
from numba.extending import intrinsic

from escapement.numerics.jit import in_both_forms


def by_address(
    kernel: Any, index: int, leads: Sequence[Any], given: tuple[Any, ...]
) -> tuple[Any, Callable[[int], int]]:
    """Make a call of a kernel whose address is handed over in an array of addresses.

    Parameters
    ----------
    kernel : callable
        A kernel made by `jit` that neither raises nor allocates arrays.
    index : int
        Index of its address in the array of addresses.
    leads : sequence of `known.Known`
        Values of its first argument, for each of which it is compiled; the last is that of Python.
        They take no memory, so that the caller need not know which of them the address is for.
    given : tuple of Numba types
        Types of its other arguments. A caller with other types does not compile.

    Returns
    -------
    call
        For use in kernels: call(addresses, ...) gives what kernel(lead, ...) gives, where
        `addresses` is an array of int64.
    address
        Returns the address for a lead, by its number, in this process; the first call
        compiles or loads it.
    """

    def in_python(_addresses: Any, *values: Any) -> Any:
        return kernel(leads[-1], *values)

    config: Any = numba.config
    if config.DISABLE_JIT:
        return in_python, (lambda _number: 0)
    dispatcher = getattr(kernel, "compiled", kernel)

    ready: dict[int, Any] = {}

    def compiled(number: int) -> Any:
        if number not in ready:
            arguments = (typeof(leads[number]), *given)
            dispatcher.compile(arguments)
            ready[number] = dispatcher.overloads[arguments]
        return ready[number]

    def address(number: int) -> int:
        code = compiled(number)
        return int(code.library.get_pointer_to_function(code.fndesc.llvm_func_name))

    # the address is read from the array when the call runs, since it differs between processes
    def emit(context: Any, builder: Any, full: Any, values: Any) -> Any:
        addresses, rest = values
        result, arguments = full.return_type, tuple(full.args[1])
        pointer = context.call_conv.get_function_type(result, arguments).as_pointer()
        held = context.make_array(full.args[0])(context, builder, addresses)
        location = builder.gep(held.data, [context.get_constant(types.intp, index)])
        function = builder.inttoptr(builder.load(location), pointer)
        row = [builder.extract_value(rest, k) for k in range(len(arguments))]
        return context.call_conv.call_function(builder, function, result, arguments, row)[1]

    @intrinsic
    def call(context: Any, addresses: Any, *values: Any) -> Any:
        if len(values) != len(given) or None in map(context.can_convert, values, given):
            return None
        # all leads give results of one type
        code = next(iter(ready.values()), None) or compiled(0)
        return code.signature.return_type(addresses, types.StarArgTuple.from_types(given)), emit

    return in_both_forms(call, in_python), address
