"""Solvers of other packages, for the package's benchmark.

They are optional: `pip install -e ".[bench]"` installs heyoka.
"""

from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec

from escapement.benchmark.problems import MeasuredSolver


def peer_solvers() -> Iterator[MeasuredSolver]:
    """Both solvers by heyoka, if it is installed."""
    if find_spec("heyoka"):
        module = import_module("peers.with_heyoka")
        for name, method, prepare in (
            ("heyoka", "Taylor", module.prepare),
            ("heyoka over the angle", "Taylor, angle", module.prepare_angle),
        ):
            yield MeasuredSolver(name, "heyoka", method, "LLVM", -4, -15, prepare)
