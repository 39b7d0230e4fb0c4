"""Named tuples of which some fields differ from another one: `_replace` for kernels."""

from typing import Any

from numba.core import types
from numba.core.imputils import impl_ret_borrowed
from numba.extending import intrinsic

from escapement.numerics.jit import in_both_forms
from escapement.numerics.known import Known, KnownType


def _in_python(record: Any, *given: Any) -> Any:
    pairs = zip(given[::2], given[1::2], strict=True)
    fields = {name: value for name, value in pairs if not isinstance(getattr(record, name), Known)}
    return record._replace(**fields)


@intrinsic(prefer_literal=True)
def _compiled(_context: Any, record: Any, *given: Any) -> Any:
    row = types.StarArgTuple.from_types(given)
    places = [record.fields.index(name.literal_value) for name in given[::2]]

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        made, changes = values
        for k, place in enumerate(places):
            if not isinstance(record[place], KnownType):
                value = builder.extract_value(changes, 2 * k + 1)
                value = context.cast(builder, value, row[2 * k + 1], record[place])
                made = builder.insert_value(made, value, place)
        return impl_ret_borrowed(context, builder, signature.return_type, made)

    return record(record, row), emit


altered = in_both_forms(_compiled, _in_python)
"""altered(record, "name", value, ..) is a named tuple with other values of the named fields.

A field that holds a `Known` number keeps it.
"""
