"""Who takes part: the package's engines, SciPy's methods, and the peers installed here.

A contestant turns a problem and a tolerance into a function that runs it once. What a
user who repeats runs would pay once (building, compiling) belongs to the preparation and
the first call; everything else to the run.
"""

from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import NamedTuple

from escapement.benchmark import own_engines
from escapement.benchmark.problems import Problem
from escapement.model import FloatArray

Answer = tuple[FloatArray, FloatArray]
Prepare = Callable[[Problem, float], Callable[[], Answer]]

ENERGY, IVP = "energy", "ivp"
HEYOKA, CYRK = "heyoka", "CyRK"
PEERS = (HEYOKA, CYRK)
"""Optional: import names of the packages of the `bench` extra."""

_LOOSEST = {"solve_ivp": -3, ENERGY: -4, IVP: -4, HEYOKA: -4, CYRK: -4}
_TIGHTEST = {"solve_ivp": -13, ENERGY: -13, IVP: -12, HEYOKA: -15, CYRK: -15}


class Contestant(NamedTuple):
    """A solver with a name.

    name : unique.
    family : "energy", "ivp", "solve_ivp", "heyoka" or "CyRK".
    method, language : where a family has several.
    prepare : makes a run of a problem at a tolerance.
    """

    name: str
    family: str
    method: str
    language: str
    prepare: Prepare

    @property
    def tolerances(self) -> list[float]:
        """From loose to tight, as far as the solver accepts them."""
        return [10.0**k for k in range(_LOOSEST[self.family], _TIGHTEST[self.family] - 1, -1)]


def contestants() -> Iterator[Contestant]:
    """All that are installed."""
    for engine in (ENERGY, IVP):
        prepare = partial(own_engines.prepare, engine=engine)
        yield Contestant(engine, engine, "", "Numba", prepare)
    yield from _scipy()
    if HEYOKA in installed_peers():
        module = import_module("escapement.benchmark._with_heyoka")
        yield Contestant(HEYOKA, HEYOKA, "Taylor", "LLVM", module.prepare)
        name = f"{HEYOKA} over the angle"
        yield Contestant(name, HEYOKA, "Taylor, angle", "LLVM", module.prepare_angle)
    if CYRK in installed_peers():
        module = import_module("escapement.benchmark._with_cyrk")
        for method in module.METHODS:
            prepare = partial(module.prepare, method=method)
            yield Contestant(f"{CYRK} {method}", CYRK, method, "C++", prepare)


def installed_peers() -> list[str]:
    """Those of `PEERS` that can be imported here."""
    return [name for name in PEERS if find_spec(name) is not None]


def _scipy() -> Iterator[Contestant]:
    module = import_module("escapement.benchmark.scipy_solvers")
    for method in module.METHODS:
        for language in ("Python", "Numba"):
            prepare = partial(module.prepare, method=method, language=language)
            name = f"solve_ivp {method} {language}"
            yield Contestant(name, "solve_ivp", method, language, prepare)
