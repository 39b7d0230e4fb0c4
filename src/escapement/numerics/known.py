"""Numbers whose value is part of their type, so that kernels are compiled without them.

A field of a named tuple that holds a `Known` number takes no memory in compiled code, and what is
decided by such numbers alone is decided when a kernel is compiled. A kernel is compiled once
for each set of known fields that it meets. In Python a `Known` is an ordinary float.
"""

from collections.abc import Callable
from inspect import signature
from typing import Any

from numba import types
from numba.core.datamodel import models
from numba.core.imputils import lower_constant
from numba.core.typeconv.castgraph import Conversion
from numba.extending import lower_cast, overload, register_model, typeof_impl

from escapement.numerics.jit import PART


class Known(float):
    """A number that all values of its type share."""


class KnownType(types.Type):
    """The type of a `Known` number in kernels."""

    def __init__(self, value: float) -> None:
        self.value = value
        super().__init__(name=f"Known({value!r})")

    def can_convert_to(self, _context: Any, other: Any) -> Any:
        """It is a float wherever one is wanted."""
        return Conversion.safe if other == types.float64 else None


@typeof_impl.register(Known)
def _type_of(value: Known, _context: Any) -> KnownType:
    return KnownType(float(value))


@register_model(KnownType)
class _Nothing(models.StructModel):
    def __init__(self, manager: Any, known: KnownType) -> None:
        super().__init__(manager, known, [])  # type: ignore[no-untyped-call]


@lower_constant(KnownType)  # type: ignore[no-untyped-call, untyped-decorator]
def _as_constant(context: Any, _builder: Any, known: KnownType, _value: Any) -> Any:
    return context.get_constant_undef(known)


@lower_cast(KnownType, types.float64)  # type: ignore[no-untyped-call, untyped-decorator]
def _as_float(context: Any, _builder: Any, known: KnownType, to: Any, _value: Any) -> Any:
    return context.get_constant(to, known.value)


def knows(scene_type: Any, field: str) -> bool:
    """Whether a field of a named tuple of this Numba type is a `Known` number."""
    return isinstance(scene_type[scene_type.fields.index(field)], KnownType)


def where_known(field: str, short: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator of a kernel that is `short` for named tuples of which a field is known.

    The named tuple is the argument `scene` of both.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        position = list(signature(function).parameters).index("scene")

        @overload(function, strict=False, jit_options=PART)
        def _choose(*given: Any) -> Callable[..., Any]:
            return short if knows(given[position], field) else function

        # as of any kernel; see `jit.as_python`
        vars(function)["py_func"] = function
        return function

    return decorate
