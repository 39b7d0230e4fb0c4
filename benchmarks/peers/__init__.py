"""Solvers of other packages, for the package's benchmark.

They are optional: `pip install -e ".[bench]"` installs heyoka.
"""

from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec

from escapement.benchmark.problems import MeasuredSolver

PEERS = ("heyoka",)
"""Names under which they are imported."""


def installed_peers() -> list[str]:
    """Those of `PEERS` that can be imported here."""
    return [name for name in PEERS if find_spec(name) is not None]


def peer_solvers() -> Iterator[MeasuredSolver]:
    """The solvers of all peers that are installed."""
    if installed_peers():
        module = import_module("peers.with_heyoka")
        for name, method, prepare in (
            ("heyoka", "Taylor", module.prepare),
            ("heyoka over the angle", "Taylor, angle", module.prepare_angle),
        ):
            yield MeasuredSolver(name, "heyoka", method, "LLVM", -4, -15, prepare)
