"""Named tuples that kernels hand on by their address.

A large named tuple takes a kernel longer to hand on, number by number, than much of its work does,
and takes longer to compile.
"""

from typing import Any

from numba import types
from numba.core import cgutils as _cgutils
from numba.core import imputils as _imputils
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, register_model

from escapement.numerics.jit import in_both_forms

cgutils: Any = _cgutils
imputils: Any = _imputils


class HeldType(types.Type):
    """The type of the address of a named tuple in kernels."""

    def __init__(self, record: Any) -> None:
        self.record = record
        super().__init__(name=f"Held({record})")


@register_model(HeldType)
class _Address(models.PrimitiveModel):
    def __init__(self, manager: Any, held: HeldType) -> None:
        pointer = manager.lookup(held.record).get_value_type().as_pointer()
        super().__init__(manager, held, pointer)  # type: ignore[no-untyped-call]


@infer_getattr
class _Field(AttributeTemplate):
    key = HeldType

    def generic_resolve(self, held: Any, name: str) -> Any:  # type: ignore[override]
        """The type of a field."""
        fields = held.record.fields
        return held.record[fields.index(name)] if name in fields else None


@lower_getattr_generic(HeldType)  # type: ignore[no-untyped-call, untyped-decorator]
def _read(context: Any, builder: Any, held: Any, address: Any, name: str) -> Any:
    index = held.record.fields.index(name)
    value = builder.load(cgutils.gep_inbounds(builder, address, 0, index))
    return imputils.impl_ret_borrowed(context, builder, held.record[index], value)


@intrinsic
def _compiled(_context: Any, record: Any) -> Any:
    def emit(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        return cgutils.alloca_once_value(builder, values[0])

    return HeldType(record)(record), emit


held = in_both_forms(_compiled, lambda record: record)
"""held(record) is the address of a copy of a named tuple, from which its fields are read.

The copy ends with the kernel that makes it. It keeps no array alive, so that in a kernel that
allocates, the tuple must be an argument of this kernel.
"""
