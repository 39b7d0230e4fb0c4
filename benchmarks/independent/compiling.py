"""The decorator of this integrator's kernels.

Numba's disk cache notices changes only in the file of the kernel itself; it would keep an old copy
of a function that the kernel calls from another file. The cache is therefore in a folder whose
name is a digest of all sources.
"""

import hashlib
from pathlib import Path

from numba import config, njit

HERE = Path(__file__).resolve().parent
SOURCES = b"\0".join(path.read_bytes() for path in sorted(HERE.glob("*.py")))
FOLDER = HERE / "__pycache__" / hashlib.sha256(SOURCES).hexdigest()[:16]


def compiled(function):
    """Compile on first call, cached on disk; division by zero follows IEEE 754."""
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(FOLDER)
    try:
        return njit(cache=True, error_model="numpy", nogil=True)(function)
    finally:
        config.CACHE_DIR = previous
