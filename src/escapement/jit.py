"""The one decorator that compiles kernels.

Numba keys its disk cache on the source file of the kernel alone, so a changed
callee in another file would leave a stale copy behind. The cache therefore
lives in a directory named after a digest of every kernel source of the package.
"""

import contextlib
import hashlib
import os
import sys
import tempfile
from functools import cache, partial
from pathlib import Path
from typing import Any

import numba
from numba.core.runtime import rtsys


def kernel_digest(package: Path) -> str:
    """Digest of all files under `package` that hold a kernel, or call one by address.

    Parameters
    ----------
    package : Path
        Root folder of the Python sources.

    Returns
    -------
    str
        16 hexadecimal digits; differs whenever any kernel source differs.
    """
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        text = path.read_bytes()
        if b".jit import" in text or b"by_address" in text:
            digest.update(path.relative_to(package).as_posix().encode() + b"\0" + text)
    return digest.hexdigest()[:16]


def _user_cache() -> Path:
    if "NUMBA_CACHE_DIR" in os.environ:
        return Path(os.environ["NUMBA_CACHE_DIR"])
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))


@cache
def _cache_directory() -> str | None:
    """Folder for compiled kernels, or None where nothing can be written."""
    try:
        folder = _user_cache() / "escapement" / kernel_digest(Path(__file__).parent)
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return str(folder)
    except (OSError, RuntimeError):
        return None


@cache
def _say_that_it_compiles() -> None:
    """Tell who sits at a terminal why nothing happens, once a process."""
    with contextlib.suppress(AttributeError, OSError, ValueError):  # no stderr, or a closed one
        if sys.stderr.isatty():
            print(
                "escapement: compiling for this machine, once; it takes up to a minute",
                file=sys.stderr,
            )


def _watch_cache(dispatcher: Any) -> None:
    """Say that a kernel has to be compiled; keep it in memory when no copy can be saved.

    `load_overload` would import all that compiling takes, SciPy's linear algebra included, a
    third of the time to a first result. Machine code needs the runtime that makes arrays alone.
    """
    store = dispatcher._cache
    load, save = store._load_overload, store.save_overload

    def load_or_say(signature: Any, context: Any) -> Any:
        rtsys.initialize(context)
        found = None
        # another process may be writing it, or a disk fail: then it is compiled
        with contextlib.suppress(OSError):
            found = load(signature, context)
        if found is None:
            _say_that_it_compiles()
        return found

    def save_or_skip(signature: Any, data: Any) -> None:
        # a cache is a convenience: the kernel itself is ready
        with contextlib.suppress(OSError):
            save(signature, data)

    store.load_overload = load_or_say
    store.save_overload = save_or_skip


def jit(
    function: Any = None,
    *,
    allocates: bool = False,
    reorders: bool = False,
    inlined: bool = False,
    inner: bool = False,
) -> Any:
    """Compile on first call, cached on disk, GIL released.

    A kernel that makes or returns arrays must say that it `allocates`. All others are
    spared the counting of references: two atomic operations for every array of every
    call, as much as the work of a short kernel. No arithmetic is changed, but for a
    kernel that says that it `reorders` its sums: they become vector code. A kernel that is
    `inlined` costs no call where it is called, and as much compiling again. One that is
    `inner` is called by kernels alone and has no entrance for Python, whose compiling takes
    a fifth of all.

    Division by zero follows IEEE 754 (`error_model="numpy"`): kernels report
    through a status code and never raise.
    """
    if function is None:
        return partial(jit, allocates=allocates, reorders=reorders, inlined=inlined, inner=inner)
    folder = _cache_directory()
    config: Any = numba.config
    options: Any = {"nogil": True, "error_model": "numpy", "_nrt": allocates}
    if reorders:
        options["fastmath"] = {"reassoc"}
    if inlined:
        options["forceinline"] = True
    if inner:
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    if folder is None or config.DISABLE_JIT:
        return numba.njit(**options)(function)
    previous = config.CACHE_DIR
    config.CACHE_DIR = folder
    try:
        dispatcher = numba.njit(cache=True, **options)(function)
    finally:
        config.CACHE_DIR = previous
    _watch_cache(dispatcher)
    return dispatcher


inner_jit = partial(jit, inner=True)
"""`jit` of a kernel that is called by kernels alone."""
