"""The one decorator that compiles kernels.

Numba keys its disk cache on the source file of the kernel alone. After a change of
a callee in another file it would therefore load a stale copy. Here the cache lies in
a directory named after a digest of every kernel source of the package instead, and of
all that these sources import.
"""

import contextlib
import hashlib
import os
import re
import tempfile
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any, cast

import numba
from llvmlite.binding import get_host_cpu_name
from numba.core import types
from numba.core.runtime import rtsys  # type: ignore[attr-defined]

from escapement.base.notice import notice
from escapement.numerics.compiler import KernelCompiler, PartCompiler
from escapement.numerics.interpreted import Kernel, begin_interpreted, interprets

# other modules import it from here, since `jit` decides whether this process interprets
from escapement.numerics.interpreted import in_both_forms as in_both_forms

fcntl: Any = None
with contextlib.suppress(ImportError):  # Windows has none
    import fcntl

_IMPORT = re.compile(rb"^(?:from|import) +([\w.]+)(?: +import +(\([^)]*\)|[^\n]*))?", re.MULTILINE)


def kernel_digest(package: Path) -> str:
    """Digest of all files under `package` that compile kernels, and of the files they import.

    Files that compile kernels name the `jit` or `by_address` import. A kernel is compiled with the
    values of its globals, which may be constants and types of other files, and these may have
    them from further ones; imports within functions bring no globals.

    Parameters
    ----------
    package : Path
        Root folder of the Python sources.

    Returns
    -------
    str
        16 hexadecimal digits, which differ whenever anything differs that a kernel can see.
    """
    texts = {x.relative_to(package).as_posix(): x.read_bytes() for x in package.rglob("*.py")}
    kernels = {
        name for name, text in texts.items() if b".jit import" in text or b"by_address" in text
    }
    todo = list(kernels)
    while todo:
        for name in _imported(texts[todo.pop()], package.name):
            if name in texts and name not in kernels:
                kernels.add(name)
                todo.append(name)
    digest = hashlib.sha256()
    for name in sorted(kernels):
        digest.update(name.encode() + b"\0" + texts[name])
    return digest.hexdigest()[:16]


def _imported(text: bytes, package: str) -> list[str]:
    """Files that a source with this text may import from its package at the top level."""
    found = []
    for module, names in _IMPORT.findall(text):
        root, *parts = module.decode().split(".")
        if root == package:
            found.append("/".join(parts) or "__init__")
            found += ["/".join([*parts, name]) for name in re.findall(r"\w+", names.decode())]
    return [name + end for name in found for end in (".py", "/__init__.py")]


@cache
def _cache_directory() -> str | None:
    """Folder of compiled kernels, or None where it cannot be written, as the notice will say."""
    chosen = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    usual = Path(chosen or os.path.expanduser("~/.cache"))
    try:
        folder = usual / "escapement" / kernel_digest(Path(__file__).parents[1])
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return str(folder)
    except OSError as error:
        notice.lost = f"{usual / 'escapement'} ({error.strerror})"
        return None


def _all_compiled() -> Path | None:
    """File that says that all kernels are compiled for this processor; None without a cache.

    Numba keeps kernels by the path of their source, so that each installation has its own.
    """
    folder = _cache_directory()
    config: Any = numba.config
    place = hashlib.sha256(os.fsencode(Path(__file__).resolve())).hexdigest()[:12]
    name = f"{config.CPU_NAME or get_host_cpu_name()}-{place}.complete"
    return Path(folder, name) if folder else None


def is_all_compiled() -> bool:
    """Whether `escapement compile` has compiled all kernels for this processor."""
    mark = _all_compiled()
    return mark is not None and mark.exists()


def note_all_compiled() -> None:
    """Later processes shall use compiled kernels from their start."""
    mark = _all_compiled()
    if mark is not None:
        with contextlib.suppress(OSError):
            mark.touch()


def _choose() -> None:
    """Begin with Python source where compiled kernels are missing.

    The environment variable ESCAPEMENT_COMPILE asks for compiling at once.
    """
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return
    if not os.environ.get("ESCAPEMENT_COMPILE") and not is_all_compiled():
        begin_interpreted()


@contextlib.contextmanager
def _alone(folder: str) -> Iterator[None]:
    """Keep other processes from saving into a folder at the same time, where the system can.

    Numba numbers the files of a kernel by those in its index. Two processes that saved different
    variants of a kernel at once would give both the same number, and later processes would run
    the code of one for the other.
    """
    with open(Path(folder, "lock"), "w") as file:
        if fcntl is not None:
            fcntl.flock(file, fcntl.LOCK_EX)  # until the file is closed
        yield


def _watch_cache(dispatcher: Any) -> None:
    """Announce that a kernel has to be compiled, and survive a cache that cannot be written.

    Numba's own `load_overload` imports everything that compiling needs, such as SciPy's
    linear algebra, which is a third of the time to a first result. Code that is loaded
    needs only the runtime that allocates arrays.
    """
    store, folder = dispatcher._cache, _cache_directory()
    load = getattr(store, "_load_overload", store.load_overload)  # there may be no cache
    save = store.save_overload

    def load_or_say(signature: Any, context: Any) -> Any:
        rtsys.initialize(context)
        found = None
        # if another process is writing the file, or a disk fails, the kernel is compiled
        with contextlib.suppress(OSError):
            found = load(signature, context)
        if found is None:
            notice.begin()
        return found

    def save_or_skip(signature: Any, data: Any) -> None:
        # the kernel itself is ready, so that it works without a copy on disk
        with contextlib.suppress(OSError), _alone(folder) if folder else contextlib.nullcontext():
            save(signature, data)
        notice.end()

    store.load_overload = load_or_say
    store.save_overload = save_or_skip


def _let_kernels_call(dispatcher: Any, part: Any) -> None:
    """Kernels that call `dispatcher` contain `part`.

    That is compiled once for all integers, and once for both truth values. Numba gives a constant
    of the source a type of its own, even where it only is the first value of a variable, and
    compiles a kernel that is called with it another time.
    """
    resolve, dispatcher.get_overload = part.get_call_template, part.get_overload

    def without_literals(args: Any, named: Any) -> Any:
        plain = {name: types.unliteral(kind) for name, kind in named.items()}
        return resolve(tuple(map(types.unliteral, args)), plain)

    dispatcher.get_call_template = without_literals


_TRAITS: dict[str, dict[str, Any]] = {
    "allocates": {"_nrt": True},
    "reorders": {"fastmath": {"reassoc"}},
    "inlined": {"inline": "always"},
    "merged": {"forceinline": True},
    "inner": {},
    "addressed": {"no_cpython_wrapper": True},
}
"""Options of Numba by what `jit` calls them."""
PLAIN: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False}
"""Options of all kernels."""
PLAIN |= {"no_cfunc_wrapper": True}  # nobody calls a kernel from C
PART: Any = PLAIN | {"no_cpython_wrapper": True, "pipeline_class": PartCompiler}
"""Options of a kernel that only kernels call."""


def jit(function: Any = None, **traits: bool) -> Any:
    """Compile on the first call, keep the code on disk, and release the GIL while it runs.

    Traits of a kernel, each given as True:

    allocates : the kernel makes or returns arrays. In all others references are not
        counted, which would cost two atomic operations for every array of every call,
        as much as the work of a short kernel.
    reorders : the kernel's sums may be reordered, so that they become vector code. No
        other arithmetic is ever changed.
    inlined : its code becomes part of every caller before types are inferred, so that it is not
        compiled separately.
    merged : its machine code becomes part of every caller's, for a kernel of few lines that is
        called often; handing over the numbers of a scene would take as long as its work.
    inner : only kernels call it, so it is compiled as a part of these, without an entry point for
        Python and machine code of its own.
    addressed : only kernels call it, and only by its address, so it has no entry point for Python.

    Division by zero follows IEEE 754 (`error_model="numpy"`), since kernels report
    through a status code and never raise.
    """
    if function is None:
        return partial(jit, **traits)
    options = dict(PLAIN)
    for trait in traits:
        options |= _TRAITS[trait]
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return numba.njit(**options)(function)
    dispatcher = part = numba.njit(**(PART | options))(function)
    if not traits.get("inner"):
        dispatcher = _kept(function, options)
        _watch_cache(dispatcher)
    _watch_cache(part)
    _let_kernels_call(dispatcher, part)
    return Kernel(dispatcher, function) if interprets() else dispatcher


def _kept(function: Any, options: dict[str, Any]) -> Any:
    """A kernel of which the code is kept on disk."""
    folder, config = _cache_directory(), cast(Any, numba.config)
    previous, config.CACHE_DIR = config.CACHE_DIR, folder or config.CACHE_DIR
    try:
        keep = options | {"cache": folder is not None, "pipeline_class": KernelCompiler}
        return numba.njit(**keep)(function)
    finally:
        config.CACHE_DIR = previous


_choose()
inner_jit = partial(jit, inner=True)
"""`jit` of a kernel that is called by kernels alone."""


def as_python(kernel: Any) -> Any:
    """The Python function of a kernel, for calls that are shorter than entering compiled code."""
    # if Numba is switched off, a kernel is that function itself
    return getattr(kernel, "py_func", kernel)
