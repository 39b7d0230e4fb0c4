"""Modules that are loaded when they are first used, so that declarations load nothing."""

from collections.abc import Iterable, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

__all__ = ["ArrayLike", "FloatArray", "Lazy", "np", "offered"]


class Lazy:
    """Stands for a module until an attribute of it is used.

    Parameters
    ----------
    name : str
        Full name of the module.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        value = getattr(import_module(self._name), attribute)
        vars(self)[attribute] = value  # found without this function from then on
        return value


if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    FloatArray = NDArray[np.float64]
else:
    # importing NumPy takes longer than the rest of help
    np, ArrayLike, FloatArray = Lazy("numpy"), Any, Any


def offered(package: str, names: Sequence[str], modules: Iterable[str], name: str) -> Any:
    """The attribute `name` of a package, from the first of its modules that has it.

    For the package's own `__getattr__`: importing the package loads none of them.
    """
    if name in names:
        for module in modules:
            loaded = import_module(f"{package}.{module}")
            if hasattr(loaded, name):
                return getattr(loaded, name)
    raise AttributeError(f"module {package!r} has no attribute {name!r}")
