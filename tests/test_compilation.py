"""The decorator that compiles: its cache notices every change, and may be unwritable."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import escapement
from escapement.engines.energy import panels
from escapement.numerics import jit

pytestmark = pytest.mark.slow

PACKAGE = Path(escapement.__file__).parent
SOURCES = sorted(PACKAGE.rglob("*.py"))
DRIVE = """
import escapement as esc
inertia = esc.Inertia(3.39e-7, 5.65e-6)
timer = esc.Escapement(esc.Geneva(4), inertia, torque=0.0113, friction=0.35)
"""


def run(code, **environment):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        env=os.environ | environment,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def copy_compiling(toy):
    """The files that compile kernels, as those of package `toy`."""
    for name in (
        "numerics/compiler.py",
        "numerics/jit.py",
        "numerics/by_address.py",
        "numerics/known.py",
        "numerics/interpreted.py",
        "base/notice.py",
    ):
        (toy / name).parent.mkdir(parents=True, exist_ok=True)
        (toy / name).write_text((PACKAGE / name).read_text().replace("escapement.", "toy."))


def write_toy(folder, decorator, factor):
    """Package `toy`: kernel f in one file calls g in another, which uses a number of a third."""
    toy = folder / "toy"
    copy_compiling(toy)
    (toy / "__init__.py").touch()
    (toy / "f.py").write_text(
        f"{decorator}\nfrom toy.g import g\n\n@jit\ndef f(x):\n    return g(x)\n"
    )
    (toy / "g.py").write_text(f"{decorator}\n\n@jit\ndef g(x):\n    return {factor} * x\n")


@pytest.fixture
def cached(tmp_path):
    """Environment of a process that finds packages, and keeps its cache, in an empty folder."""
    folders = {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    return folders | {"ESCAPEMENT_COMPILE": "1"}


@pytest.fixture
def toy(tmp_path, cached):
    """The environment of `cached` with package `toy` in its folder."""
    write_toy(tmp_path, "from toy.numerics.jit import jit", 2.0)
    return cached


def test_a_stale_copy_is_what_the_bare_cache_would_serve(cached, tmp_path):
    """The reason for the decorator: if this ever fails, Numba has mended it itself."""
    bare = "import numba\n\njit = numba.njit(cache=True)"
    ours = "from toy.numerics.jit import jit"
    call = "from toy.f import f; print(f(1.0))"
    for decorator, after in ((bare, "2.0"), (ours, "3.0")):
        write_toy(tmp_path, decorator, 2.0)
        assert run(call, **cached) == "2.0"
        compiled = len(list(tmp_path.rglob("*.nbc")))
        assert compiled > 0
        assert run(call, **cached) == "2.0"
        assert len(list(tmp_path.rglob("*.nbc"))) == compiled  # the second run compiles nothing
        write_toy(tmp_path, decorator, 3.0)
        assert run(call, **cached) == after


def test_every_kernel_counts_for_the_digest(tmp_path):
    copy = tmp_path / "escapement"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__", "data"))
    whole = jit.kernel_digest(copy)
    assert whole == jit.kernel_digest(PACKAGE)
    compiled = re.compile(r"^@jit\b|\bby_address\(", re.MULTILINE)
    kernels = [path for path in SOURCES if compiled.search(path.read_text())]
    assert len(kernels) >= 8
    for path in kernels:
        target = copy / path.relative_to(PACKAGE)
        source = target.read_text()
        target.write_text(source + "\n")
        assert jit.kernel_digest(copy) != whole
        target.write_text(source)
    (copy / "plots" / "style.py").write_text("")
    assert jit.kernel_digest(copy) == whole
    # a kernel file that has another name counts too
    (copy / "numerics" / "roots.py").rename(copy / "numerics" / "zeros.py")
    assert jit.kernel_digest(copy) != whole


@pytest.mark.parametrize(
    ("file", "before", "after"),
    [
        ("dynamics/figures_of_merit.py", "RISE_BAND = 0.02", "RISE_BAND = 0.03"),
        ("model/torque_curve.py", "MOST_KNOTS = ", "MOST_KNOTS = 1 + "),
        (
            "model/scene.py",
            "    rho: float\n    mu_plus: float",
            "    mu_plus: float\n    rho: float",
        ),
    ],
)
def test_what_a_kernel_has_from_elsewhere_counts_for_the_digest(tmp_path, file, before, after):
    """Constants, and the order of the fields of its arguments."""
    copy = tmp_path / "escapement"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__", "data"))
    source = (copy / file).read_text()
    assert before in source
    (copy / file).write_text(source.replace(before, after))
    assert jit.kernel_digest(copy) != jit.kernel_digest(PACKAGE)


def test_nobody_compiles_but_the_decorator():
    for path in SOURCES:
        if path.name != "jit.py":
            source = path.read_text(encoding="utf-8")
            assert not re.search(r"\b(njit|vectorize|guvectorize|jitclass|cfunc)\b", source), path
            assert "fastmath" not in source, path


@pytest.mark.parametrize("place", ["file", "file/below", "locked"])
def test_a_folder_that_cannot_be_written_is_done_without(toy, tmp_path, place):
    if place == "locked" and hasattr(os, "geteuid") and os.geteuid() == 0:
        pytest.skip("nothing is read-only to this user")
    (tmp_path / "file").touch()
    (tmp_path / "locked").mkdir(mode=0o500)
    folder = tmp_path / place
    call = "from toy.f import f; print(f(1.0), f.py_func(2.0))"
    assert run(call, **toy | {"NUMBA_CACHE_DIR": str(folder)}) == "2.0 4.0"
    assert not list(tmp_path.rglob("*.nbi"))


@pytest.mark.parametrize(
    ("call", "reason"), [("load", "EACCES"), ("_load_data", "EIO"), ("_save_data", "ENOSPC")]
)
def test_a_cache_that_fails_costs_a_compilation_only(toy, call, reason):
    failing = f"""
import errno
from numba.core import caching
def fail(*_):
    raise OSError(errno.{reason}, "no")
caching.IndexDataCacheFile.{call} = fail
"""
    use = "from toy.f import f\nprint(f(1.0))"
    if call != "_save_data":
        assert run(use, **toy) == "2.0"  # a copy to fail on
    assert run(failing + use, **toy) == "2.0"


def test_one_process_at_a_time_saves_kernels(toy):
    """Numba's index of a kernel would else lead to the code of another process."""
    pytest.importorskip("fcntl")
    code = """
import fcntl, os, pathlib
from numba.core import caching
save = caching.IndexDataCacheFile.save
def look(*given):
    (lock,) = pathlib.Path(os.environ["NUMBA_CACHE_DIR"]).rglob("lock")
    with open(lock) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            print("free")
        except BlockingIOError:
            print("held")
    return save(*given)
caching.IndexDataCacheFile.save = look
from toy.f import f
f(1.0)
"""
    assert run(code, **toy) == "held"  # that of f, of which g is a part


ANNOUNCED = """
import io, multiprocessing, sys
sys.stderr = io.StringIO()
def call():
    from toy.f import f
    f(1.0), f(1)
    sys.stdout.write(sys.stderr.getvalue())
    sys.stdout.flush()
{call}
"""


def announced(environment, call="call()"):
    code = ANNOUNCED.format(call=call)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        env=os.environ | {"ESCAPEMENT_QUIET": ""} | environment,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    return done.stdout.decode()


def test_compiling_is_announced_in_one_line(toy, tmp_path):
    """But not for code of the cache; where there can be no cache, its folder is named."""
    line = "escapement: compiling for this machine, once; it takes a minute or two\n"
    assert announced(toy) == line
    assert announced(toy) == ""
    (tmp_path / "file").touch()
    lost = (
        "escapement: compiling for this machine, at each run: compiled code cannot be kept in "
        f"{tmp_path / 'file' / 'escapement'} (Not a directory); set NUMBA_CACHE_DIR to a folder "
        "that can be written; it takes a minute or two"
    )
    for place in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        there = {"NUMBA_CACHE_DIR": "", "XDG_CACHE_HOME": "", place: str(tmp_path / "file")}
        told = announced(toy | there).splitlines()
        inner = "file/.cache/" if place == "HOME" else "file/"
        assert told == [lost.replace("file/", inner)]


def test_the_cache_is_kept_where_it_was_asked_for(toy, tmp_path):
    call = "from toy.f import f; import numba; print(f(1.0), numba.config.CACHE_DIR)"
    assert run(call, **toy) == f"2.0 {tmp_path / 'cache'}"
    (folder,) = (tmp_path / "cache" / "escapement").iterdir()
    assert re.fullmatch(r"[0-9a-f]{16}", folder.name)
    assert list(folder.rglob("*.nbi"))


def test_a_field_of_a_record_hides_no_attribute_of_it():
    """Uncompiled, a field that is named like an attribute of NumPy's records could not be read."""
    records = {name: x for name, x in vars(panels).items() if isinstance(x, np.dtype) and x.names}
    assert {"PANEL", "SOLUTION", "WORKSPACE", "END"} <= records.keys()
    hidden = [
        name for record in records.values() for name in record.names if hasattr(np.record, name)
    ]
    assert not hidden


def test_importing_costs_nothing():
    heavy = {"numba", "scipy", "matplotlib", "h5py", "numpy", "argparse"}
    code = "import sys; import escapement; print(*sys.modules)"
    assert not heavy & set(run(code).split())
    code = "import sys; import escapement as esc; esc.Geneva; print(*sys.modules)"
    assert not {"scipy.integrate", "matplotlib", "h5py"} & set(run(code).split())


def test_building_a_model_compiles_nothing(tmp_path):
    cache = tmp_path / "cache"
    code = DRIVE + "print(timer.scene.rho, timer.mechanism.motion_ratio)"
    assert run(code, NUMBA_CACHE_DIR=str(cache)) == "0.06 1.0"
    assert not list(cache.rglob("*.nb?"))


def test_the_fast_engine_does_without_scipy():
    code = """
import sys
motion = esc.simulate(timer)
motion.at(0.1)
esc.terminal(timer)
# Numba looks at the version in the top package; what takes time is below it
print(len(motion.handoff_times), *{"scipy.integrate", "scipy.linalg"} & set(sys.modules))
"""
    assert run(DRIVE + code) == "20"
