"""A study as a Dataset of xarray, which this module alone imports."""

from typing import Any

import xarray
from xarray.backends import BackendArray
from xarray.core import indexing

from escapement.study.stored import Stored


class _Lazy(BackendArray):
    """Gives xarray slices of a stored array."""

    def __init__(self, stored: Stored) -> None:
        self.stored, self.shape, self.dtype = stored, stored.shape, stored.dtype

    def __getitem__(self, key: Any) -> Any:
        get, support = self.stored.__getitem__, indexing.IndexingSupport.BASIC
        return indexing.explicit_indexing_adapter(key, self.shape, support, get)


def dataset(study: Any) -> xarray.Dataset:
    """A `Study` as xarray opens its file."""
    found = {}
    for name, values in study.columns.items():
        along, attributes = study.described(name)
        found[name] = xarray.Variable(along, _lazily(values), attributes)
    results = {name: found.pop(name) for name in study.results}
    return xarray.Dataset(results, found, study.root)


def _lazily(values: Any) -> Any:
    if not isinstance(values, Stored):
        return values
    lazy: Any = indexing.LazilyIndexedArray(_Lazy(values))
    return indexing.CopyOnWriteArray(lazy)
