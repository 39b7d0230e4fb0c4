"""A fingerprint of all that decides what a case's results are."""

import hashlib
from functools import cache
from pathlib import Path

_SOURCES = (
    *("units.py", "quantity.py", "model.py", "scene.py", "dynamics.py", "painleve.py"),
    *("metrics.py", "motion.py", "trajectory.py"),
    *("simulation.py", "solver.py", "status.py", "text.py"),
    *("mechanisms/*.py", "engines/*/*.py"),
    *(f"study/{name}.py" for name in ("axes", "from_escapement", "parameters")),
    *(f"study/{name}.py" for name in ("parse", "plan", "plan_file", "sample", "spread")),
    *(f"study/{name}.py" for name in ("evaluate", "scenes", "shared_scenes")),
)


_ROOT = Path(__file__).parents[1]


def sources() -> list[Path]:
    """The files that results depend on, in order."""
    return sorted(path for pattern in _SOURCES for path in _ROOT.glob(pattern))


@cache
def numerics() -> str:
    """Digest of these sources; equal digests, equal results.

    A change of a mere comment changes it too: a study is rather begun anew than made
    of two kinds of numbers.
    """
    digest = hashlib.sha256()
    for path in sources():
        digest.update(path.relative_to(_ROOT).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]
