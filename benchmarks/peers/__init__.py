"""Solvers of other packages, for the package's benchmark.

They are optional: `pip install -e ".[bench]"` installs heyoka and CyRK.
"""

from collections.abc import Iterator
from functools import partial
from importlib import import_module
from importlib.util import find_spec

from escapement.benchmark.problems import MeasuredSolver

HEYOKA, CYRK = "heyoka", "CyRK"
PEERS = (HEYOKA, CYRK)
"""Names under which they are imported."""


def installed_peers() -> list[str]:
    """Those of `PEERS` that can be imported here."""
    return [name for name in PEERS if find_spec(name) is not None]


def peer_solvers() -> Iterator[MeasuredSolver]:
    """The solvers of all peers that are installed."""
    if HEYOKA in installed_peers():
        module = import_module("peers.with_heyoka")
        yield MeasuredSolver(HEYOKA, HEYOKA, "Taylor", "LLVM", -4, -15, module.prepare)
        name = f"{HEYOKA} over the angle"
        yield MeasuredSolver(name, HEYOKA, "Taylor, angle", "LLVM", -4, -15, module.prepare_angle)
    if CYRK in installed_peers():
        module = import_module("peers.with_cyrk")
        for method in module.METHODS:
            prepare = partial(module.prepare, method=method)
            yield MeasuredSolver(f"{CYRK} {method}", CYRK, method, "C++", -4, -15, prepare)
