"""Records whose fields are attributes, in compiled kernels and in plain Python alike.

NumPy's own `numpy.record` offers this too. It searches for the name of a field in several places
at each access, which is seven times slower, and its own attributes hide fields of the same name.
"""

from operator import itemgetter
from typing import Any

import numpy as np

VECTOR = 32
"""Bytes of a vector register."""


def record_dtype(fields: dict[str, Any]) -> np.dtype:
    """Type of a record whose fields are attributes.

    Parameters
    ----------
    fields : dict
        Name of each field and its type, which may be another record, or its type and shape.

    Returns
    -------
    dtype
        Numbers lie at multiples of eight bytes, also behind a flag.
    """
    listed = [
        (name, *kind) if isinstance(kind, tuple) else (name, kind) for name, kind in fields.items()
    ]
    plain = np.dtype(listed, align=True)
    if _fills_vectors(plain):
        # rows come first, so that a vector does not lie in two lines of the cache
        plain = np.dtype(sorted(listed, key=lambda field: not _is_row(plain[field[0]])), align=True)
        offsets = [place[1] for place in (plain.fields or {}).values()]
        layout: Any = {"names": plain.names, "formats": [plain[n] for n in plain.names or ()]}
        layout |= {"offsets": offsets, "itemsize": -(-plain.itemsize // VECTOR) * VECTOR}
        plain = np.dtype(layout, align=True)
    accessors = {name: _accessor(name) for name in fields}
    return np.dtype((type("Record", (np.void,), accessors), plain))


def _is_row(kind: np.dtype) -> bool:
    """Whether a field is a row, or a record that has one."""
    return kind.subdtype is not None or any(kind[name].subdtype for name in kind.names or ())


def _fills_vectors(kind: np.dtype) -> bool:
    """Whether a record has rows, all of which are whole vectors."""
    rows = [kind[name] for name in kind.names or () if _is_row(kind[name])]
    return bool(rows) and not any(row.itemsize % VECTOR for row in rows)


def _accessor(field: str) -> property:
    def write(record: np.void, value: Any) -> None:
        record[field] = value

    return property(itemgetter(field), write)
